/* Exports the points and shapes of a chunk file: a level of the leaf chunks, 0 unless another is
 * chosen. Threads: one per file. */
#ifndef STP_TOOLS_FILE_EXPORT_FILE_H
#define STP_TOOLS_FILE_EXPORT_FILE_H

#include "base/progress.h"
#include "formats/chunk/chunk_file.h"
#include "tools/file/export_filter.h"

typedef struct export_params {
    const char *output; /* appears whole or not at all */
    bool force;         /* replace an existing file */
    export_choice choice;
    const stp_progress *progress;
} export_params;

/* *left_out: samples that stand in for lost points. Errors: EMPTY (all points are lost, or none is
 * chosen), those of export_filter_make, of reading chunks and of writing. */
stp_status export_file(stp_chunk_file *file, const export_params *params, uint64_t *left_out,
                       stp_error *err);

#endif
