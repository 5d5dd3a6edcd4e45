/* The files of an Entwine Point Tile set, in a folder or on a web server.
 *
 *     ept.json
 *     ept-hierarchy/D-X-Y-Z.json
 *     ept-data/D-X-Y-Z.laz (or .bin, .zst)
 *
 * Names are made of a node's numbers, never of what a file says, so none leads out of the folder. A
 * tile of a server is copied to a nameless file while it is read. Threads: any. */
#ifndef STP_FORMATS_SCAN_OCTREE_EPT_FILES_H
#define STP_FORMATS_SCAN_OCTREE_EPT_FILES_H

#include "formats/chunk/byte_source.h"
#include "formats/scan/octree/octree.h"
#include "formats/scan/remote/mirror.h"

#include <cjson/cJSON.h>

typedef struct stp_ept_files {
    const char *path;     /* of ept.json; borrowed */
    size_t folder_length; /* of path, with its last slash */
    size_t name_length;   /* of path without a query, which every file of the set gets as well */
    const stp_byte_source_params *web; /* borrowed; NULL: the defaults */
} stp_ept_files;

/* A tile that may be opened by its path. Zero is closed. */
typedef struct stp_ept_tile_file {
    char *path, *name;       /* name: for messages */
    stp_file_mirror *mirror; /* NULL: path is a file */
} stp_ept_tile_file;

/* Whether a path or an address, with or without a query, ends in ept.json. */
bool stp_ept_is_named(const char *path);
stp_ept_files stp_ept_files_of(const char *path, const stp_byte_source_params *web);
/* Reads ept.json (key NULL) or a file of the hierarchy. *name, if name is not NULL, is set to the
 * file's name for messages; free it, also after a failure. Errors: NOT_FOUND, IO, FORMAT,
 * OUT_OF_MEMORY. */
stp_status stp_ept_files_json(const stp_ept_files *files, const stp_octree_key *key, cJSON **out,
                              char **name, stp_error *err);
/* Finds a tile, and copies it if it is on a server. Closes what was open in *file. ending: ".laz".
 * Errors: NOT_FOUND, IO, OUT_OF_MEMORY. */
stp_status stp_ept_files_tile(const stp_ept_files *files, stp_octree_key key, const char *ending,
                              stp_ept_tile_file *file, stp_error *err);
void stp_ept_tile_file_close(stp_ept_tile_file *file);

#endif
