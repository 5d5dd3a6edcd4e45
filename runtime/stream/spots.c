/* Lists where the samples of wide patches lie. */
#include "runtime/stream/spots.h"

#include "base/memory.h"

/* A patch is wide if its bound is so many times as large as its samples. Neighbours on a surface
 * have bounds of some 4. */
#define WIDE_RADII 12.0f

/* Steps of a spot along an axis. A sample is less than a step away from its spot. */
#define STEPS 256.0f

static bool is_wide(const stp_mirror_patch *patch)
{
    return (patch->flags & STP_PATCH_SHAPES) == 0 && patch->finest == 0 &&
           patch->bound_radius > WIDE_RADII * patch->radius[0];
}

static stp_spot spot_of(const stp_sample *sample, const stp_patch *stored,
                        const stp_mirror_patch *patch)
{
    const stp_dvec3 place = stp_sample_position(sample, stored);
    const double at[3] = {place.x, place.y, place.z};
    stp_spot spot;
    for (int k = 0; k < 3; k++) {
        const double share =
            0.5 + 0.5 * (at[k] - (double)patch->bound_centre[k]) / (double)patch->bound_radius;
        const double code = STEPS * share;
        spot.at[k] = (uint8_t)fmin(fmax(code, 0.0), STEPS - 1.0);
    }
    return spot;
}

stp_status stp_spots_list(stp_spot **out, stp_mirror_patch *patches, const stp_chunk *chunk,
                          stp_error *err)
{
    stp_status status = STP_OK;
    const size_t room = (size_t)STP_SPOTS_A_PATCH * chunk->patch_count;
    size_t count = 0;
    if (chunk->finest_level != 0 || stp_chunk_is_squares(chunk))
        return STP_OK;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const size_t next = count + patches[p].count[0];
        if (!is_wide(&patches[p]) || next > room || next > UINT16_MAX)
            continue;
        patches[p].spots = (uint16_t)(count + 1);
        count = next;
    }
    if (count == 0)
        return STP_OK;
    STP_TRY(stp_alloc(out, count, sizeof **out, "spots", err));
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = 0; patches[p].spots != 0 && i < patches[p].count[0]; i++)
            (*out)[patches[p].spots - 1 + i] = spot_of(
                &chunk->samples[0][chunk->level_begin[0][p] + i], &chunk->patches[p], &patches[p]);
done:
    return status;
}

void stp_spot_offset(const stp_spot *spot, float bound_radius, float offset[3])
{
    for (int k = 0; k < 3; k++)
        offset[k] = bound_radius * (2.0f / STEPS * ((float)spot->at[k] + 0.5f) - 1.0f);
}

float stp_spot_reach(float bound_radius, float radius)
{
    return radius + 2.0f / STEPS * bound_radius;
}
