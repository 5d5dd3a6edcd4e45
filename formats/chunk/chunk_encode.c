/* Encodes a chunk as payload bytes, and fills its directory entry. */
#include "base/memory.h"
#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/patch.h"

#include <inttypes.h>
#include <stdlib.h>

static stp_status check_chunk(const stp_chunk *chunk, uint32_t counts[STP_LEVEL_COUNT],
                              stp_error *err)
{
    if (chunk->patch_count == 0 || chunk->patch_count > STP_CHUNK_PATCHES_LIMIT)
        return stp_error_set(err, STP_LIMIT, "a chunk of %" PRIu32 " patches: use 1 to %u",
                             chunk->patch_count, STP_CHUNK_PATCHES_LIMIT);
    if (chunk->finest_level != 0)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "a chunk without level 0 to be written");
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        counts[l] = chunk->level_begin[l][chunk->patch_count];
        if (counts[l] > STP_CHUNK_SAMPLES_LIMIT)
            return stp_error_set(err, STP_LIMIT,
                                 "a chunk of %" PRIu32 " samples at level %d: use at most %u",
                                 counts[l], l, STP_CHUNK_SAMPLES_LIMIT);
        for (uint32_t i = 0; i < chunk->patch_count; i++)
            if (chunk->level_begin[l][i + 1] - chunk->level_begin[l][i] !=
                chunk->patches[i].counts[l])
                return stp_error_set(err, STP_INVALID_ARGUMENT,
                                     "level_begin of patch %" PRIu32 ", level %d, contradicts its "
                                     "count",
                                     i, l);
    }
    stp_error inner = {0};
    if (stp_patches_check(chunk->patches, chunk->patch_count, counts, STP_CHUNK_CHILDREN_LIMIT,
                          &inner) != STP_OK ||
        stp_patches_check_kinds(chunk, &inner) != STP_OK)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "a chunk cannot be written: %s",
                             inner.message);
    return STP_OK;
}

/* ---- what the directory says ---- */

static float round_up(double value)
{
    float rounded = (float)value;
    return (double)rounded < value ? nextafterf(rounded, INFINITY) : rounded;
}

static float round_down(double value)
{
    return -round_up(-value);
}

static float greater(float a, double b)
{
    return fmaxf(a, round_up(b));
}

static void widen_box(stp_chunk_entry *entry, const stp_patch *patch)
{
    stp_sample centre = {
        .position = {patch->bound_centre[0], patch->bound_centre[1], patch->bound_centre[2]}};
    stp_dvec3 p = stp_sample_position(&centre, patch);
    double r = stp_radius_decode(patch->bound_radius, patch->exponent);
    const double low[3] = {p.x - r, p.y - r, p.z - r};
    const double high[3] = {p.x + r, p.y + r, p.z + r};
    for (int i = 0; i < 3; i++) {
        entry->box_min.raw[i] = fminf(entry->box_min.raw[i], round_down(low[i]));
        entry->box_max.raw[i] = fmaxf(entry->box_max.raw[i], round_up(high[i]));
    }
}

static void widen_errors(stp_chunk_entry *entry, const stp_patch *patch)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        entry->error[l] =
            greater(entry->error[l], stp_error_decode(patch->error[l], patch->exponent));
        entry->tangential_error[l] =
            greater(entry->tangential_error[l],
                    stp_error_decode(patch->tangential_error[l], patch->exponent));
        entry->colour_error[l] = fmaxf(entry->colour_error[l], (float)patch->colour_error[l]);
    }
}

/* Least and greatest radius of all samples of all levels. */
static void find_radii(stp_chunk_entry *entry, const stp_chunk *chunk)
{
    entry->radius_min = INFINITY;
    entry->radius_max = 0.0f;
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        for (uint32_t i = 0; i < chunk->patch_count; i++) {
            uint8_t least = 255;
            uint8_t most = 0;
            for (uint32_t k = chunk->level_begin[l][i]; k < chunk->level_begin[l][i + 1]; k++) {
                uint8_t code = chunk->samples[l][k].radius;
                least = code < least ? code : least;
                most = code > most ? code : most;
            }
            int exponent = chunk->patches[i].exponent;
            float low = round_down(stp_radius_decode(least, exponent));
            entry->radius_min = fminf(entry->radius_min, low);
            entry->radius_max = greater(entry->radius_max, stp_radius_decode(most, exponent));
        }
    }
}

/* The chunk's cone: around the mean of the patches' axes, wide enough for all their cones. */
static void find_cone(stp_chunk_entry *entry, const stp_chunk *chunk)
{
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    double angle = 0.0;
    for (uint32_t i = 0; i < chunk->patch_count; i++)
        sum = stp_dvec3_add(sum,
                            stp_dvec3_from_float(stp_normal_decode(chunk->patches[i].cone_axis)));
    sum = stp_dvec3_normalize(sum);
    entry->cone_axis = stp_dvec3_to_float(sum);
    stp_dvec3 axis = stp_dvec3_normalize(stp_dvec3_from_float(entry->cone_axis));
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        const stp_patch *patch = &chunk->patches[i];
        stp_dvec3 other =
            stp_dvec3_normalize(stp_dvec3_from_float(stp_normal_decode(patch->cone_axis)));
        double off =
            atan2(stp_dvec3_length(stp_dvec3_cross(axis, other)), stp_dvec3_dot(axis, other));
        angle = fmax(angle, off + stp_cone_angle_decode(patch->cone_angle));
    }
    if (stp_dvec3_length(sum) == 0.0) {
        entry->cone_axis = (vec3s){{0.0f, 0.0f, 1.0f}};
        angle = M_PI;
    }
    /* A float axis is a unit vector to 1e-7; the margin covers that and decoding in float. */
    entry->cone_angle = round_up(fmin(angle + 1e-6, M_PI));
}

static void describe(stp_chunk_entry *entry, const stp_chunk *chunk)
{
    entry->patch_count = chunk->patch_count;
    unsigned closed = STP_PATCH_CLOSED;
    entry->flags = chunk->linked ? STP_CHUNK_LINKED : 0;
    entry->box_min = (vec3s){{INFINITY, INFINITY, INFINITY}};
    entry->box_max = (vec3s){{-INFINITY, -INFINITY, -INFINITY}};
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        entry->sample_count[l] = chunk->level_begin[l][chunk->patch_count];
        entry->error[l] = entry->tangential_error[l] = entry->colour_error[l] = 0.0f;
    }
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        widen_box(entry, &chunk->patches[i]);
        widen_errors(entry, &chunk->patches[i]);
        entry->flags |= chunk->patches[i].flags & STP_PATCH_TWO_SIDED;
        closed &= chunk->patches[i].flags;
    }
    entry->flags |= closed ? STP_CHUNK_CLOSED : 0;
    find_radii(entry, chunk);
    find_cone(entry, chunk);
}

stp_status stp_chunk_encode(const stp_chunk *chunk, stp_codec codec, void **payload,
                            stp_chunk_entry *entry, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes bytes = {0};
    stp_chunk_entry described = *entry;
    uint32_t counts[STP_LEVEL_COUNT];
    STP_TRY(check_chunk(chunk, counts, err));
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        size_t begin = bytes.size;
        STP_TRY(stp_segment_encode(chunk, s, codec, &bytes, err));
        described.segment_end[s] = (uint32_t)bytes.size;
        described.segment_hash[s] = stp_hash(bytes.data + begin, bytes.size - begin);
    }
    described.codec = (uint8_t)codec;
    describe(&described, chunk);
    *entry = described;
    *payload = bytes.data;
    bytes.data = NULL;
done:
    free(bytes.data);
    return status;
}
