/* Reads and writes patches and samples of the raw codec: their fields in order, little-endian. */
#include "formats/chunk/codec/raw.h"

#include "formats/chunk/codec/part.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/patch.h"

#include <string.h>

void stp_patch_write(const stp_patch *patch, uint8_t *bytes)
{
    for (int i = 0; i < 3; i++) {
        stp_put_u32(bytes + 4 * i, (uint32_t)patch->origin[i]);
        stp_put_u16(bytes + 36 + 2 * i, patch->bound_centre[i]);
    }
    stp_put_u16(bytes + 12, (uint16_t)patch->exponent);
    bytes[14] = patch->child;
    bytes[15] = patch->cone_angle;
    memcpy(bytes + 16, patch->counts, STP_LEVEL_COUNT);
    memcpy(bytes + 20, patch->error, STP_LEVEL_COUNT);
    memcpy(bytes + 24, patch->tangential_error, STP_LEVEL_COUNT);
    memcpy(bytes + 28, patch->colour_error, STP_LEVEL_COUNT);
    memcpy(bytes + 32, patch->radius, STP_LEVEL_COUNT);
    bytes[42] = patch->bound_radius;
    memcpy(bytes + 43, patch->cone_axis, 3);
    bytes[46] = patch->flags;
    bytes[47] = 0;
    memcpy(bytes + 48, patch->quarter_error, sizeof patch->quarter_error);
    memcpy(bytes + 56, patch->quarter_tangential_error, sizeof patch->quarter_tangential_error);
}

void stp_patch_read(const uint8_t *bytes, stp_patch *out)
{
    for (int i = 0; i < 3; i++) {
        out->origin[i] = (int32_t)stp_get_u32(bytes + 4 * i);
        out->bound_centre[i] = stp_get_u16(bytes + 36 + 2 * i);
    }
    out->exponent = (int16_t)stp_get_u16(bytes + 12);
    out->child = bytes[14];
    out->cone_angle = bytes[15];
    memcpy(out->counts, bytes + 16, STP_LEVEL_COUNT);
    memcpy(out->error, bytes + 20, STP_LEVEL_COUNT);
    memcpy(out->tangential_error, bytes + 24, STP_LEVEL_COUNT);
    memcpy(out->colour_error, bytes + 28, STP_LEVEL_COUNT);
    memcpy(out->radius, bytes + 32, STP_LEVEL_COUNT);
    out->bound_radius = bytes[42];
    memcpy(out->cone_axis, bytes + 43, 3);
    out->flags = bytes[46];
    memcpy(out->quarter_error, bytes + 48, sizeof out->quarter_error);
    memcpy(out->quarter_tangential_error, bytes + 56, sizeof out->quarter_tangential_error);
}

void stp_sample_write(const stp_sample *sample, uint8_t *bytes)
{
    for (int i = 0; i < 3; i++)
        stp_put_u16(bytes + 2 * i, sample->position[i]);
    bytes[6] = sample->radius;
    bytes[7] = sample->flags;
    memcpy(bytes + 8, sample->normal, 3);
    bytes[11] = sample->class_id;
    memcpy(bytes + 12, sample->rgb, 3);
    bytes[15] = sample->intensity;
}

void stp_sample_read(const uint8_t *bytes, stp_sample *out)
{
    for (int i = 0; i < 3; i++)
        out->position[i] = stp_get_u16(bytes + 2 * i);
    out->radius = bytes[6];
    out->flags = bytes[7];
    memcpy(out->normal, bytes + 8, 3);
    out->class_id = bytes[11];
    memcpy(out->rgb, bytes + 12, 3);
    out->intensity = bytes[15];
}

static uint32_t level_count(const stp_chunk *chunk, int level)
{
    return chunk->level_begin[level][chunk->patch_count];
}

static size_t patch_bytes(const stp_chunk *chunk)
{
    return STP_PATCH_BYTES + (chunk->linked ? STP_LINK_BYTES : 0);
}

stp_status stp_raw_patches_encode(const stp_chunk *chunk, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t bytes[STP_PATCH_BYTES + STP_LINK_BYTES];
    for (uint32_t i = 0; i < chunk->patch_count && status == STP_OK; i++) {
        stp_patch_write(&chunk->patches[i], bytes);
        stp_put_u16(bytes + STP_PATCH_BYTES, chunk->patches[i].first_below);
        status = stp_bytes_append(out, bytes, patch_bytes(chunk), err);
    }
    return status;
}

stp_status stp_raw_patches_decode(stp_cursor *c, uint32_t child_count, stp_chunk *chunk,
                                  stp_shares *shares, stp_error *err)
{
    const size_t bytes = patch_bytes(chunk);
    if (c->left / bytes < chunk->patch_count)
        return stp_error_set(err, STP_CORRUPT, "it ends within its patches");
    for (uint32_t i = 0; i < chunk->patch_count; i++, stp_cursor_skip(c, bytes)) {
        stp_patch_read(c->bytes, &chunk->patches[i]);
        chunk->patches[i].first_below = chunk->linked ? stp_get_u16(c->bytes + STP_PATCH_BYTES) : 0;
    }
    if (shares)
        shares->bytes[STP_SHARE_PATCHES] += chunk->patch_count * bytes;
    return stp_patches_take(chunk, child_count, err);
}

stp_status stp_raw_encode(const stp_chunk *chunk, int segment, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t bytes[STP_SAMPLE_BYTES];
    if (segment == 0)
        STP_TRY(stp_raw_patches_encode(chunk, out, err));
    for (int l = stp_segment_coarsest(segment); l >= stp_segment_finest(segment); l--) {
        for (uint32_t i = 0; i < level_count(chunk, l); i++) {
            stp_sample_write(&chunk->samples[l][i], bytes);
            STP_TRY(stp_bytes_append(out, bytes, STP_SAMPLE_BYTES, err));
        }
    }
done:
    return status;
}

stp_status stp_raw_decode(const uint8_t *bytes, size_t size, int segment, uint32_t child_count,
                          stp_chunk *chunk, stp_shares *shares, stp_error *err)
{
    stp_cursor c = {bytes, size};
    size_t needed = segment == 0 ? chunk->patch_count * patch_bytes(chunk) : 0;
    for (int l = stp_segment_coarsest(segment); l >= stp_segment_finest(segment); l--)
        needed += (size_t)level_count(chunk, l) * STP_SAMPLE_BYTES;
    if (size != needed)
        return stp_error_set(err, STP_CORRUPT, "it has %zu bytes, expected %zu", size, needed);
    if (segment == 0) {
        stp_status status = stp_raw_patches_decode(&c, child_count, chunk, shares, err);
        if (status != STP_OK)
            return status;
    }
    if (shares)
        stp_shares_add_raw(shares, c.left);
    for (int l = stp_segment_coarsest(segment); l >= stp_segment_finest(segment); l--)
        for (uint32_t i = 0; i < level_count(chunk, l); i++, stp_cursor_skip(&c, STP_SAMPLE_BYTES))
            stp_sample_read(c.bytes, &chunk->samples[l][i]);
    return STP_OK;
}
