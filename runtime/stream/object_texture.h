/* The Object Texture: the GPU's memory of samples and patches, and the ranges of it in use.
 *
 * One buffer of 16-byte samples that shaders fetch texels of and that is also a vertex buffer; for
 * each sample the index of its patch; the patches; the resident chunks, rewritten each frame.
 * Source: Mar08, "Object Texture". Threads: the render thread. */
#ifndef STP_RUNTIME_STREAM_OBJECT_TEXTURE_H
#define STP_RUNTIME_STREAM_OBJECT_TEXTURE_H

#include "formats/chunk/chunk_file.h"
#include "runtime/gl/gpu_layout.h"
#include "runtime/stream/range_pool.h"

#include <epoxy/gl.h>

/* A sample with its patch; a patch. */
#define STP_OBJECT_TEXTURE_SAMPLE_BYTES (16 + 4)
#define STP_OBJECT_TEXTURE_PATCH_BYTES sizeof(stp_gpu_patch)

enum { STP_OBJECT_TEXTURES = 4 };

typedef struct stp_object_texture {
    GLuint samples, patch_of_sample, patches, chunks; /* buffers */
    GLuint textures[STP_OBJECT_TEXTURES]; /* of samples, patches, chunks, patches of samples */
    GLuint sample_array, empty_array;     /* vertex arrays: of samples; of nothing */
    stp_range_pool sample_ranges, patch_ranges;
    uint32_t slot_capacity; /* chunks */
} stp_object_texture;

/* Where a chunk stands. level_begin: absolute index of each level's first sample. */
typedef struct stp_placement {
    stp_range samples, patches;
    uint32_t level_begin[STP_LEVEL_COUNT];
} stp_placement;

/* Errors: GL (no memory, or more samples than a texture may have), OUT_OF_MEMORY. */
stp_status stp_object_texture_create(stp_object_texture *out, uint32_t sample_capacity,
                                     uint32_t patch_capacity, uint32_t slot_capacity,
                                     stp_error *err);
void stp_object_texture_destroy(stp_object_texture *texture);

/* Finds room for a chunk's levels >= finest_level. False: no room. Errors: OUT_OF_MEMORY. */
bool stp_object_texture_place(stp_object_texture *texture, const stp_chunk_entry *entry,
                              int finest_level, stp_placement *out, stp_status *status,
                              stp_error *err);
void stp_object_texture_release(stp_object_texture *texture, const stp_placement *placement);

/* Turns a chunk's patches into the GPU's: into out[chunk->patch_count]. shapes: of STP_PATCH_SHAPES
 * those that the headers speak of; other patches are drawn as samples. */
void stp_gpu_patches_fill(stp_gpu_patch *out, const stp_chunk *chunk,
                          const stp_placement *placement, uint32_t slot, unsigned shapes);

#endif
