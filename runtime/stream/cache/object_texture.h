/* The Object Texture: the GPU's memory for samples and patches, and which ranges of it are in use.
 *
 * One buffer holds samples (runtime/stream/texels.h), one patches, one a record for each slot, and
 * the last one what codes stand for. Each frame rewrites the records of the blocks that it draws.
 * Shaders fetch all as texels. Source: Mar08, "Object Texture". Threads: the render thread. */
#ifndef STP_RUNTIME_STREAM_CACHE_OBJECT_TEXTURE_H
#define STP_RUNTIME_STREAM_CACHE_OBJECT_TEXTURE_H

#include "formats/chunk/block/block.h"
#include "runtime/cut/level_choice.h"
#include "runtime/gl/lazy_buffer.h"
#include "runtime/stream/cache/range_pool.h"
#include "runtime/stream/texels.h"

#include <epoxy/gl.h>

#define STP_OBJECT_TEXTURE_PATCH_TEXELS (sizeof(stp_gpu_patch) / 16)

enum { STP_OBJECT_TEXTURES = 3 }; /* besides that of the codes */

typedef struct stp_object_texture {
    stp_lazy_buffer samples, patches, chunks;
    GLuint codes;
    GLuint textures[STP_OBJECT_TEXTURES + 1]; /* samples, patches, chunks; codes */
    GLuint empty_array;                       /* a vertex array with nothing */
    stp_range_pool sample_ranges, patch_ranges;
    uint32_t slot_capacity; /* in blocks */
} stp_object_texture;

/* The place of a block. */
typedef struct stp_placement {
    stp_range texels, patches;
} stp_placement;

/* The most texels that a texture may have: samples take some (texels.h), a patch
 * STP_OBJECT_TEXTURE_PATCH_TEXELS. */
uint32_t stp_object_texture_texels(void);

/* software: see stp_lazy_buffer_create. Errors: GL (no memory), OUT_OF_MEMORY. */
stp_status stp_object_texture_create(stp_object_texture *out, uint32_t texel_capacity,
                                     uint32_t patch_capacity, uint32_t slot_capacity, bool software,
                                     stp_error *err);
void stp_object_texture_destroy(stp_object_texture *texture);

/* Finds room for a place of so many texels and patches, placement->...count; false if there is
 * none. Errors: OUT_OF_MEMORY. */
bool stp_object_texture_place(stp_object_texture *texture, stp_placement *placement,
                              stp_status *status, stp_error *err);
/* Fails if the GPU lacked memory for something that was copied. Errors: GL. */
stp_status stp_object_texture_check(const stp_object_texture *texture, stp_error *err);
/* Bytes of the Object Texture that a place takes. */
uint64_t stp_placement_bytes(const stp_placement *placement);
/* Gives back all but the first texels of a place. */
void stp_object_texture_trim(stp_object_texture *texture, stp_placement *placement,
                             uint32_t texels);
void stp_object_texture_release(stp_object_texture *texture, const stp_placement *placement);

/* Fill out[chunk->patch_count] with a decoded block's patches, in the GPU's form, but for `first`,
 * and in the CPU's. shapes: the shapes of STP_PATCH_SHAPES that the headers name; patches of other
 * shapes are drawn as samples. */
void stp_gpu_patches_fill(stp_gpu_patch *out, const stp_chunk *chunk, uint32_t slot,
                          unsigned shapes);
void stp_mirror_patches_fill(stp_mirror_patch *out, const stp_chunk *chunk,
                             const stp_placement *placement, unsigned shapes);
/* Where the patches are in memory that holds a place's samples, then its patches: bytes. */
uint64_t stp_placement_patches(const stp_placement *placement);
/* Writes a decoded block to such memory, as the GPU has it, and its patches to `patches`, too.
 * Returns how many texels of the place its samples need. */
uint32_t stp_placement_write(const stp_placement *placement, uint8_t *memory,
                             stp_gpu_patch *patches, const stp_chunk *chunk, uint32_t slot,
                             unsigned shapes);
/* What the codes of the file stand for. */
void stp_gpu_codes_fill(stp_gpu_code out[STP_GPU_CODES]);

#endif
