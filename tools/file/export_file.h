/* Exports the points and shapes of a chunk file as PLY: level 0 of the leaf chunks. Threads: one
 * per file. */
#ifndef STP_TOOLS_FILE_EXPORT_FILE_H
#define STP_TOOLS_FILE_EXPORT_FILE_H

#include "base/progress.h"
#include "formats/chunk/chunk_file.h"

typedef struct export_params {
    const char *output; /* appears whole or not at all */
    bool force;         /* replace an existing file */
    const stp_progress *progress;
} export_params;

/* *left_out: samples that stand in for lost points. Errors: EMPTY (all points are lost), those of
 * reading chunks and of writing PLY. */
stp_status export_file(stp_chunk_file *file, const export_params *params, uint64_t *left_out,
                       stp_error *err);

#endif
