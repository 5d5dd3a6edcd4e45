/* Reads the records of a LAS or LAZ file, one after the other, and decodes them to points.
 *
 * What a LAS file, and a tile of an EPT set, have in common. How many bits colours and intensities
 * have is the caller's to decide (las_depth.h): a set has one answer, a tile would have many.
 * Memory: bounded. Threads: one at a time per stream. */
#ifndef STP_FORMATS_SCAN_LAS_LAS_STREAM_H
#define STP_FORMATS_SCAN_LAS_LAS_STREAM_H

#include "formats/scan/las/las_depth.h"
#include "formats/scan/las/las_header.h"
#include "formats/scan/las/las_records.h"
#include "formats/scan/las/laz/laz_team.h"
#include "formats/scan/scan.h"

typedef struct stp_las_stream {
    stp_source source;
    stp_las_header header; /* point_count is what is read: less than in the file, if a region
                              chooses nodes of a COPC */
    stp_las_records records;
    stp_laz_team *laz;       /* NULL: not compressed */
    unsigned char *unpacked; /* records that laz unpacked */
    size_t block_points;     /* most records at once */
    uint64_t next;           /* point */
} stp_las_stream;

typedef struct stp_las_stream_params {
    const char *path;               /* must outlive the stream, as all here must */
    const char *name;               /* for messages; NULL: the path */
    const stp_scan_region *region;  /* NULL: all points */
    struct stp_file_mirror *mirror; /* of the file at `path`; NULL: all bytes are there */
    bool salvage;                   /* the file may be cut */
    bool all_fields;                /* also of layered LAZ: those that only attributes need */
    stp_pool *pool;                 /* unpacks chunks side by side (laz_team.h); NULL: none */
} stp_las_stream_params;

/* *las must be zero, with a descriptor of -1. Close it even after a failure. Errors: those of
 * stp_las_reader; INVALID_ARGUMENT (a resolution, but no octree). */
stp_status stp_las_stream_open(stp_las_stream *las, const stp_las_stream_params *params,
                               stp_error *err);
/* Continues at this point. Errors: CORRUPT, IO, OUT_OF_MEMORY. */
stp_status stp_las_stream_seek(stp_las_stream *las, uint64_t point, stp_error *err);
/* Gives the next count <= block_points records, valid until the next call; the file has so many.
 * Errors: as seek. */
stp_status stp_las_stream_next(stp_las_stream *las, size_t count, const unsigned char **records,
                               stp_error *err);
void stp_las_stream_close(stp_las_stream *las);

/* Decodes count records. Colours stay zero if depth has none, or if the point format has none.
 * Withheld points are rejects, unless keep_withheld. */
void stp_las_decode(const stp_las_header *header, const stp_las_depth *depth, bool keep_withheld,
                    const unsigned char *records, stp_point *points, size_t count);

#endif
