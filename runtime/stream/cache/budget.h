/* Divides the memory given to a scene. Everything that grows with a model is allotted here once, so
 * the budget is never exceeded.
 *
 * GPU: the Object Texture (samples, patches, one record for each block) and the upload ring, but
 * not the pyramids of pictures. CPU: a copy of the patches on the GPU, the decoders' working
 * memory, the directory, tables of blocks; the rest is for payloads. Threads: any (pure function).
 */
#ifndef STP_RUNTIME_STREAM_CACHE_BUDGET_H
#define STP_RUNTIME_STREAM_CACHE_BUDGET_H

#include "runtime/cut/scene.h"

typedef struct stp_budget {
    uint32_t texel_capacity, patch_capacity, slot_capacity;
    uint64_t ring_bytes;
    uint64_t payload_bytes;
    unsigned decoder_count;
    uint64_t gpu_bytes, cpu_bytes; /* totals */
} stp_budget;

#define STP_BUDGET_DEFAULT_BYTES (UINT64_C(1) << 30)

/* What there is to divide. */
typedef struct stp_budget_limits {
    uint64_t gpu_bytes, cpu_bytes; /* 0: the default */
    uint32_t texels;   /* the most that a texture of this OpenGL has (stp_object_texture_texels) */
    unsigned decoders; /* the wanted number */
    bool software;     /* the driver draws on the CPU */
} stp_budget_limits;

/* Errors: LIMIT (not even two blocks fit; the message says how much would be enough), GL (the same
 * of a texture). */
stp_status stp_budget_plan(stp_budget *out, const stp_scene *scene, const stp_budget_limits *limits,
                           stp_error *err);

#endif
