/* Reads the points of one tile of an Entwine Point Tile set after the other.
 *
 * A tile is a LAZ file, or records of the set's schema, plain or in a frame of zstd. How many bits
 * colours and intensities have is decided once for the set (las_depth.h). Memory: bounded. Threads:
 * one at a time per reader. */
#ifndef STP_FORMATS_SCAN_OCTREE_EPT_TILE_H
#define STP_FORMATS_SCAN_OCTREE_EPT_TILE_H

#include "formats/scan/las/las_stream.h"
#include "formats/scan/octree/ept_files.h"
#include "formats/scan/octree/ept_header.h"
#include "formats/scan/octree/octree_walk.h"

/* Set header, files and all_fields; the descriptors of las.source and source to -1; the rest zero.
 */
typedef struct stp_ept_tile {
    const stp_ept_header *header;
    const stp_ept_files *files;
    stp_ept_tile_file file;
    stp_las_stream las;
    stp_source source;        /* of records */
    struct ZSTD_DCtx_s *zstd; /* NULL until it is needed */
    bool frame_ended;
    unsigned char *records;    /* unpacked */
    size_t block_points;       /* most points at once */
    uint64_t left;             /* points of the tile */
    const unsigned char *read; /* records of the points read last */
    size_t read_bytes;         /* of a record */
    bool all_fields;           /* read also those that only attributes need */
} stp_ept_tile;

/* Goes to the begin of a node's tile. Close the tile even after a failure. Errors: NOT_FOUND, IO,
 * CORRUPT (another number of points than the node has, other fields than the schema), those of
 * LAS, OUT_OF_MEMORY. */
stp_status stp_ept_tile_open(stp_ept_tile *tile, const stp_octree_node *node, stp_error *err);
/* Reads up to min(capacity, block_points) points; *count 0 at the tile's end. Looks at their
 * colours and intensities, if seen is not NULL. Errors: IO, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_ept_tile_read(stp_ept_tile *tile, const stp_las_depth *depth, stp_point *points,
                             size_t capacity, size_t *count, stp_las_seen *seen, stp_error *err);
void stp_ept_tile_close(stp_ept_tile *tile);

#endif
