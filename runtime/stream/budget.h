/* How the memory given to a scene is parted. Everything that grows with a model is allotted here
 * once, so that no budget is ever passed.
 *
 * GPU: the Object Texture (samples, patches, a record a chunk) and the upload ring; the pictures'
 * own pyramid is not part of it. CPU: the mirror of the patches on the GPU, what decoders work in,
 * the directory, and the rest for payloads. Threads: any (pure function). */
#ifndef STP_RUNTIME_STREAM_BUDGET_H
#define STP_RUNTIME_STREAM_BUDGET_H

#include "runtime/cut/scene.h"

typedef struct stp_budget {
    uint32_t sample_capacity, patch_capacity, slot_capacity;
    uint64_t ring_bytes;
    uint64_t payload_bytes;
    unsigned decoder_count;
    uint64_t gpu_bytes, cpu_bytes; /* what all of it comes to */
} stp_budget;

#define STP_BUDGET_DEFAULT_BYTES (UINT64_C(1) << 30)

/* gpu_bytes, cpu_bytes: 0 for the default. decoders: how many would be good. Errors: LIMIT (not
 * even two chunks fit; says what would do). */
stp_status stp_budget_plan(stp_budget *out, const stp_scene *scene, uint64_t gpu_bytes,
                           uint64_t cpu_bytes, unsigned decoders, stp_error *err);

#endif
