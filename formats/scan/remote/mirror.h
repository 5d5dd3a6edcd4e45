/* A file on a web server, copied to a nameless file as far as it is needed, so that readers that
 * take a path can read it.
 *
 * The nameless file is as long as the file on the server. Blocks that nobody asked for are holes in
 * it: they take no room and read as zeros, so ask first (stp_mirror_need). A killed run leaves
 * nothing. Memory: one block. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_REMOTE_MIRROR_H
#define STP_FORMATS_SCAN_REMOTE_MIRROR_H

#include "formats/chunk/byte_source.h"

/* What is fetched at once, at least. */
#define STP_MIRROR_BLOCK_BYTES ((uint64_t)1 << 18)
#define STP_MIRROR_PATH_BYTES 40u

typedef struct stp_file_mirror stp_file_mirror;

typedef struct stp_mirror_params {
    const char *folder;                /* of the nameless file; NULL: $TMPDIR, else /tmp */
    const stp_byte_source_params *web; /* NULL: the defaults */
} stp_mirror_params;

/* Asks the server for the file's size. Errors: those of stp_byte_source_open; IO (no file can be
 * made in the folder). */
stp_status stp_mirror_open(stp_file_mirror **out, const char *address,
                           const stp_mirror_params *params, stp_error *err);
void stp_mirror_close(stp_file_mirror **mirror);

/* The nameless file's path, for this process, until close. */
const char *stp_mirror_path(const stp_file_mirror *mirror);
/* The address, fit to be printed. */
const char *stp_mirror_name(const stp_file_mirror *mirror);
uint64_t stp_mirror_size(const stp_file_mirror *mirror);
/* Bytes fetched so far. */
uint64_t stp_mirror_fetched(const stp_file_mirror *mirror);
/* Fetches what is not there yet of [begin, end), as far as the file reaches. Errors: those of
 * stp_byte_source_read, IO (the folder is full). */
stp_status stp_mirror_need(stp_file_mirror *mirror, uint64_t begin, uint64_t end, stp_error *err);

#endif
