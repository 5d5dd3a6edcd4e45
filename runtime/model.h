/* A chunk file opened for drawing: its directory in memory and a ball around it.
 * Threads: read-only after opening, so any. */
#ifndef STP_RUNTIME_MODEL_H
#define STP_RUNTIME_MODEL_H

#include "formats/chunk/chunk_file.h"
#include "runtime/camera.h"

typedef struct stp_model {
    stp_chunk_file *file;
    const stp_chunk_file_info *info;
    stp_chunk_entry *entries; /* by chunk id */
    stp_ball ball;
} stp_model;

/* Reads the directory, no chunk. Errors: those of stp_chunk_file_open and stp_chunk_file_entry. */
stp_status stp_model_open(stp_model **out, const char *path, stp_error *err);
/* The same with what stp_chunk_file_open_at takes for addresses. */
stp_status stp_model_open_at(stp_model **out, const char *path,
                             const stp_byte_source_params *params, stp_error *err);
void stp_model_close(stp_model **model);

/* Bytes of samples and patches that all chunks need on the GPU. */
uint64_t stp_model_gpu_bytes(const stp_model *model);

#endif
