/* Reads and writes patches and samples of the raw codec: their fields in order, little-endian. */
#include "formats/chunk/layout.h"

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
