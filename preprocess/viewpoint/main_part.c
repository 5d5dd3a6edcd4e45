/* Floods voxels. */
#include "preprocess/viewpoint/main_part.h"

#include "base/memory.h"

#include <stdlib.h>

#define TIMES 4.0
#define SPECK_TIMES 40.0
#define SPECK_SHARE 0.1
#define SPECK_POINTS 256.0

typedef struct flood {
    const stp_space *space;
    uint8_t *seen;
    uint32_t *stack;
    uint32_t depth;
} flood;

static void visit(flood *f, size_t voxel)
{
    if (f->seen[voxel] || f->space->count[voxel] == 0)
        return;
    f->seen[voxel] = 1;
    f->stack[f->depth++] = (uint32_t)voxel;
}

/* Floods from a voxel; low, high: the voxels that were reached. Returns their points. */
static double take_part(flood *f, size_t from, int low[3], int high[3])
{
    const stp_space *s = f->space;
    const size_t wide = (size_t)s->size[0], deep = (size_t)s->size[1];
    double points = 0.0;
    for (visit(f, from); f->depth > 0;) {
        const size_t voxel = f->stack[--f->depth];
        const int at[3] = {(int)(voxel % wide), (int)(voxel / wide % deep),
                           (int)(voxel / (wide * deep))};
        points += s->count[voxel];
        for (int axis = 0; axis < 3; axis++) {
            low[axis] = at[axis] < low[axis] ? at[axis] : low[axis];
            high[axis] = at[axis] > high[axis] ? at[axis] : high[axis];
        }
        for (int n = 0; n < 27; n++) {
            const int x = at[0] + n % 3 - 1, y = at[1] + n / 3 % 3 - 1, z = at[2] + n / 9 - 1;
            if (x >= 0 && y >= 0 && z >= 0 && x < s->size[0] && y < s->size[1] && z < s->size[2])
                visit(f, stp_space_at(s, x, y, z));
        }
    }
    return points;
}

static stp_dbox box_of(const stp_space *s, const int low[3], const int high[3])
{
    const stp_dvec3 a = {low[0], low[1], low[2]}, b = {high[0] + 1, high[1] + 1, high[2] + 1};
    return (stp_dbox){stp_dvec3_add(s->origin, stp_dvec3_scale(a, s->side)),
                      stp_dvec3_add(s->origin, stp_dvec3_scale(b, s->side))};
}

stp_status stp_main_part_find(stp_main_part *out, const stp_space *space, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t voxels = (size_t)space->size[0] * (size_t)space->size[1] * (size_t)space->size[2];
    double most = 0.0, all = 0.0;
    flood f = {.space = space};
    STP_TRY(stp_alloc(&f.seen, voxels, sizeof *f.seen, "voxels", err));
    STP_TRY(stp_alloc(&f.stack, voxels, sizeof *f.stack, "voxels", err));
    *out = (stp_main_part){.box = space->box, .share = 1.0};
    for (size_t i = 0; i < voxels; i++) {
        int low[3] = {INT32_MAX, INT32_MAX, INT32_MAX}, high[3] = {0, 0, 0};
        if (f.seen[i] || space->count[i] == 0)
            continue;
        const double points = take_part(&f, i, low, high);
        all += points;
        if (points > most) {
            most = points;
            out->box = box_of(space, low, high);
        }
    }
    out->points = most;
    out->share = all > 0.0 ? most / all : 1.0;
done:
    free(f.seen);
    free(f.stack);
    return status;
}

static bool is_so_small(const stp_main_part *part, const stp_dbox *all, double times)
{
    const bool enough = part->share >= STP_MAIN_NEARLY_ALL ||
                        (part->share >= SPECK_SHARE && part->points >= SPECK_POINTS);
    const double own = stp_dvec3_length(stp_dvec3_sub(part->box.max, part->box.min));
    return enough && own > 0.0 && stp_dvec3_length(stp_dvec3_sub(all->max, all->min)) > times * own;
}

bool stp_main_part_is_small(const stp_main_part *part, const stp_dbox *all)
{
    return is_so_small(part, all, TIMES);
}

bool stp_main_part_stands_out(const stp_main_part *part, const stp_dbox *all)
{
    return is_so_small(part, all, part->share >= STP_MAIN_NEARLY_ALL ? TIMES : SPECK_TIMES);
}
