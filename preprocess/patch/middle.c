/* Puts patches into the middles of their lattices. */
#include "preprocess/patch/middle.h"

#include "formats/chunk/sample/patch.h"

/* Whether all samples of a patch fit its lattice if its centre lies `middle` steps from the origin
 * along each axis. */
static bool fits(const stp_patch *patch, const stp_patch_samples *samples, int32_t middle)
{
    for (int level = 0; level < STP_LEVEL_COUNT; level++)
        for (unsigned i = 0; i < patch->counts[level]; i++)
            for (int axis = 0; axis < 3; axis++) {
                const int32_t at = samples->level[level][i].position[axis] + middle -
                                   (int32_t)patch->bound_centre[axis];
                if (at < 0 || at > UINT16_MAX)
                    return false;
            }
    return true;
}

void stp_patch_centre(stp_patch *patch, stp_patch_samples *samples)
{
    int32_t middle = STP_PATCH_MIDDLE;
    while (middle <= UINT16_MAX && !fits(patch, samples, middle))
        middle *= 2;
    for (int axis = 0; middle <= UINT16_MAX && axis < 3; axis++) {
        const int32_t way = middle - patch->bound_centre[axis];
        patch->origin[axis] -= way;
        patch->bound_centre[axis] = (uint16_t)middle;
        for (int level = 0; level < STP_LEVEL_COUNT; level++)
            for (unsigned i = 0; i < patch->counts[level]; i++)
                samples->level[level][i].position[axis] =
                    (uint16_t)(samples->level[level][i].position[axis] + way);
    }
}
