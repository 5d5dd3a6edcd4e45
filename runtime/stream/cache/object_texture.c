/* Manages the GPU's memory for samples and patches. */
#include "runtime/stream/cache/object_texture.h"

#include "base/memory.h"
#include "runtime/gl/gl_context.h"

#include <stdlib.h>
#include <string.h>

static stp_lazy_buffer create_buffer(uint64_t bytes, bool software)
{
    stp_lazy_buffer buffer;
    if (!stp_lazy_buffer_create(&buffer, bytes, software))
        stp_lazy_buffer_create_pages(&buffer, bytes);
    return buffer;
}

uint32_t stp_object_texture_texels(void)
{
    GLint limit = 0;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
    return (uint32_t)limit - STP_TEXELS_SPARE;
}

static void create_textures(stp_object_texture *t)
{
    static const GLenum formats[STP_OBJECT_TEXTURES + 1] = {GL_RG32UI, GL_RGBA32UI, GL_RGBA32UI,
                                                            GL_RGBA32F};
    stp_gpu_code codes[STP_GPU_CODES];
    stp_gpu_codes_fill(codes);
    glCreateBuffers(1, &t->codes);
    glNamedBufferStorage(t->codes, sizeof codes, codes, 0);
    const GLuint buffers[STP_OBJECT_TEXTURES + 1] = {t->samples.name, t->patches.name,
                                                     t->chunks.name, t->codes};
    glCreateTextures(GL_TEXTURE_BUFFER, STP_OBJECT_TEXTURES + 1, t->textures);
    for (int i = 0; i <= STP_OBJECT_TEXTURES; i++)
        glTextureBuffer(t->textures[i], formats[i], buffers[i]);
}

stp_status stp_object_texture_create(stp_object_texture *out, uint32_t texel_capacity,
                                     uint32_t patch_capacity, uint32_t slot_capacity, bool software,
                                     stp_error *err)
{
    stp_object_texture t = {.slot_capacity = slot_capacity};
    t.sample_ranges.capacity = texel_capacity;
    t.patch_ranges.capacity = patch_capacity;
    t.samples =
        create_buffer(((uint64_t)texel_capacity + STP_TEXELS_SPARE) * STP_TEXEL_BYTES, software);
    t.patches = create_buffer((uint64_t)patch_capacity * sizeof(stp_gpu_patch), software);
    t.chunks = create_buffer((uint64_t)slot_capacity * sizeof(stp_gpu_chunk), software);
    stp_lazy_buffer_fill(&t.chunks, 0, (uint64_t)slot_capacity * sizeof(stp_gpu_chunk));
    create_textures(&t);
    glCreateVertexArrays(1, &t.empty_array);
    stp_status status = stp_gl_check("making the Object Texture", err);
    if (status == STP_OK)
        *out = t;
    else
        stp_object_texture_destroy(&t);
    return status;
}

void stp_object_texture_destroy(stp_object_texture *t)
{
    stp_lazy_buffer *const buffers[3] = {&t->samples, &t->patches, &t->chunks};
    if (t->samples.name != 0) {
        glDeleteVertexArrays(1, &t->empty_array);
        glDeleteTextures(STP_OBJECT_TEXTURES + 1, t->textures);
        glDeleteBuffers(1, &t->codes);
    }
    for (int i = 0; i < 3; i++)
        stp_lazy_buffer_destroy(buffers[i]);
    stp_range_pool_destroy(&t->sample_ranges);
    stp_range_pool_destroy(&t->patch_ranges);
    *t = (stp_object_texture){0};
}

bool stp_object_texture_place(stp_object_texture *t, stp_placement *placement, stp_status *status,
                              stp_error *err)
{
    stp_placement p;
    if (!stp_range_pool_take(&t->sample_ranges, placement->texels.count, &p.texels, status, err))
        return false;
    if (!stp_range_pool_take(&t->patch_ranges, placement->patches.count, &p.patches, status, err)) {
        stp_range_pool_give(&t->sample_ranges, p.texels);
        return false;
    }
    *placement = p;
    return true;
}

stp_status stp_object_texture_check(const stp_object_texture *t, stp_error *err)
{
    if (t->samples.lacks_memory || t->patches.lacks_memory || t->chunks.lacks_memory)
        return stp_error_set(err, STP_GL,
                             "the GPU has no memory left for samples: give a smaller --gpu-memory");
    return STP_OK;
}

uint64_t stp_placement_bytes(const stp_placement *placement)
{
    return placement->texels.count * (uint64_t)STP_TEXEL_BYTES +
           placement->patches.count * (uint64_t)sizeof(stp_gpu_patch);
}

void stp_object_texture_release(stp_object_texture *t, const stp_placement *placement)
{
    stp_range_pool_give(&t->sample_ranges, placement->texels);
    stp_range_pool_give(&t->patch_ranges, placement->patches);
}

void stp_object_texture_trim(stp_object_texture *t, stp_placement *placement, uint32_t texels)
{
    stp_range_pool_trim(&t->sample_ranges, &placement->texels, texels);
}

static void fill_errors(stp_mirror_patch *out, const stp_patch *patch)
{
    const uint8_t *of[2] = {patch->error, patch->tangential_error};
    for (int kind = 0; kind < 2; kind++) {
        out->vertex_error[kind] = (float)stp_error_decode(of[kind][3], patch->exponent);
        out->finest_error[kind] = (float)stp_error_decode(of[kind][0], patch->exponent);
    }
    for (int level = 1; level <= 2; level++)
        for (int q = 0; q < STP_PATCH_QUARTERS; q++) {
            float *errors = out->quarter_error[2 - level][0];
            errors[q] =
                (float)stp_error_decode(patch->quarter_error[level - 1][q], patch->exponent);
            errors[STP_PATCH_QUARTERS + q] = (float)stp_error_decode(
                patch->quarter_tangential_error[level - 1][q], patch->exponent);
        }
}

/* The cosine of a cone's angle; -1 if the cone holds all directions. */
static float cone_cos(uint8_t code)
{
    const double angle = stp_cone_angle_decode(code);
    return angle >= 3.14159 ? -1.0f : (float)cos(angle);
}

static stp_mirror_patch mirror_patch(const stp_patch *patch)
{
    double step = ldexp(1.0, patch->exponent);
    vec3s axis = stp_normal_decode(patch->cone_axis);
    stp_mirror_patch out = {
        .step = (float)step,
        .bound_radius = (float)stp_radius_decode(patch->bound_radius, patch->exponent),
        .cone_axis = {axis.x, axis.y, axis.z},
        .cone_cos = cone_cos(patch->cone_angle),
    };
    for (int i = 0; i < 3; i++) {
        out.origin[i] = (float)(patch->origin[i] * step);
        out.bound_centre[i] = (float)((patch->origin[i] + (double)patch->bound_centre[i]) * step);
    }
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        out.radius[l] = (float)stp_radius_decode(patch->radius[l], patch->exponent);
        out.colour_error[l] = patch->colour_error[l];
    }
    fill_errors(&out, patch);
    return out;
}

static uint8_t flags_of(const stp_patch *patch, unsigned shapes)
{
    const unsigned others = STP_GPU_PATCH_APART - 1 - STP_PATCH_SHAPES;
    return (uint8_t)(patch->flags & (shapes | others));
}

void stp_mirror_patches_fill(stp_mirror_patch *out, const stp_chunk *chunk,
                             const stp_placement *placement, unsigned shapes)
{
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        out[i] = mirror_patch(&chunk->patches[i]);
        out[i].flags = flags_of(&chunk->patches[i], shapes);
        out[i].finest = (uint8_t)stp_texels_finest(chunk, i);
        out[i].number = placement->patches.begin + i;
        memcpy(out[i].count, chunk->patches[i].counts, sizeof out[i].count);
    }
}

static stp_gpu_patch gpu_patch(const stp_patch *patch)
{
    const float step = (float)ldexp(1.0, patch->exponent);
    uint32_t bits;
    memcpy(&bits, &step, sizeof bits);
    stp_gpu_patch out = {
        .step = (uint8_t)(bits >> 23),
        .cone_angle = patch->cone_angle,
        .vertex_error = {patch->error[3], patch->tangential_error[3]},
        .bound_radius = patch->bound_radius,
        .radius = {patch->radius[3], patch->radius[2]},
        .colour_error = patch->colour_error[3],
        .count = (uint8_t)(patch->counts[0] - 1),
    };
    memcpy(out.origin, patch->origin, sizeof out.origin);
    memcpy(out.cone_axis, patch->cone_axis, sizeof out.cone_axis);
    return out;
}

void stp_gpu_patches_fill(stp_gpu_patch *out, const stp_chunk *chunk, uint32_t slot,
                          unsigned shapes)
{
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        out[i] = gpu_patch(&chunk->patches[i]);
        out[i].flags = flags_of(&chunk->patches[i], shapes);
        if (stp_texels_apart(chunk, i))
            out[i].flags |= STP_GPU_PATCH_APART;
        out[i].count |= (uint8_t)(stp_texels_finest(chunk, i) << STP_GPU_PATCH_FINEST_SHIFT);
        for (int k = 0; k < 3; k++)
            out[i].slot[k] = (uint8_t)(slot >> 8 * k);
    }
}

uint64_t stp_placement_patches(const stp_placement *placement)
{
    return (uint64_t)placement->texels.count * STP_TEXEL_BYTES;
}

uint32_t stp_placement_write(const stp_placement *placement, uint8_t *memory,
                             stp_gpu_patch *patches, const stp_chunk *chunk, uint32_t slot,
                             unsigned shapes)
{
    uint64_t *texels = (uint64_t *)(void *)memory;
    uint32_t at = 0;
    stp_gpu_patches_fill(patches, chunk, slot, shapes);
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        patches[i].first = placement->texels.begin + at;
        at += stp_texels_write(texels + at, chunk, i);
    }
    memcpy(memory + stp_placement_patches(placement), patches,
           chunk->patch_count * sizeof *patches);
    return at;
}

void stp_gpu_codes_fill(stp_gpu_code out[STP_GPU_CODES])
{
    for (int i = 0; i < STP_GPU_CODES; i++)
        out[i] = (stp_gpu_code){.error = (float)stp_error_decode((uint8_t)i, 0),
                                .radius = (float)stp_radius_decode((uint8_t)i, 0),
                                .cone_cos = cone_cos((uint8_t)i)};
}
