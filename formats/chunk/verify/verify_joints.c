/* Numbers and sums the vertices at which strips continue each other. */
#include "formats/chunk/verify/verify_joints.h"

#include "formats/chunk/layout.h"

#include <string.h>

uint64_t stp_joint_number(const stp_sample *sample, const stp_patch *patch, stp_dvec3 origin)
{
    uint8_t bytes[3 * sizeof(double) + STP_SAMPLE_BYTES];
    stp_sample like = *sample;
    stp_dvec3 at = stp_dvec3_add(origin, stp_sample_position(sample, patch));
    const double world[3] = {at.x + 0.0, at.y + 0.0, at.z + 0.0}; /* one zero only */
    memset(like.position, 0, sizeof like.position);
    like.radius = 0;
    memcpy(bytes, world, sizeof world);
    stp_sample_write(&like, bytes + sizeof world);
    return stp_hash(bytes, sizeof bytes);
}

uint64_t stp_verify_joints(const stp_chunk *chunk, stp_dvec3 origin)
{
    uint64_t sum = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        const stp_sample *samples = chunk->samples[0] + chunk->level_begin[0][p];
        if (patch->flags & STP_PATCH_CONTINUED)
            sum += stp_joint_number(&samples[patch->counts[0] - 1], patch, origin);
        if (patch->flags & STP_PATCH_CONTINUES)
            sum -= stp_joint_number(&samples[0], patch, origin);
    }
    return sum;
}
