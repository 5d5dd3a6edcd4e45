/* Divides the memory given to a scene. Everything that grows with a model is allotted here once, so
 * the budget is never exceeded.
 *
 * GPU: the Object Texture (samples, patches, one record for each block) and the upload ring, but
 * not the pyramids of pictures. CPU: a copy of the patches on the GPU, the decoders' working
 * memory, the directory, tables of blocks; the rest is for payloads. Threads: any (pure function).
 */
#ifndef STP_RUNTIME_STREAM_BUDGET_H
#define STP_RUNTIME_STREAM_BUDGET_H

#include "runtime/cut/scene.h"

typedef struct stp_budget {
    uint32_t sample_capacity, patch_capacity, slot_capacity;
    uint64_t ring_bytes;
    uint64_t payload_bytes;
    unsigned decoder_count;
    uint64_t gpu_bytes, cpu_bytes; /* totals */
} stp_budget;

#define STP_BUDGET_DEFAULT_BYTES (UINT64_C(1) << 30)

/* gpu_bytes, cpu_bytes: 0 for the default. decoders: the wanted number. software: the driver draws
 * on the CPU. Errors: LIMIT (not even two blocks fit; the message says how much would be enough).
 */
stp_status stp_budget_plan(stp_budget *out, const stp_scene *scene, uint64_t gpu_bytes,
                           uint64_t cpu_bytes, unsigned decoders, bool software, stp_error *err);

#endif
