/* Cuts an ordered list of patches into leaf chunks. */
#include "preprocess/tree/leaf_cut.h"

#include "base/memory.h"
#include "preprocess/patch/patch_build.h"

#include <stdlib.h>

/* The lattices of a leaf differ by at most this many octaves, and the leaf is at most
 * 2^LEAF_OCTAVES of its finest steps wide. */
#define LEAF_OCTAVES 28

typedef struct runs {
    stp_leaf_run *list;
    size_t count, capacity;
} runs;

static bool fits(const stp_leaf_extent *e)
{
    return stp_dbox_side(&e->box) <= ldexp(1.0, e->finest + LEAF_OCTAVES) &&
           e->coarsest - e->finest <= LEAF_OCTAVES;
}

static stp_leaf_extent join(stp_leaf_extent a, stp_leaf_extent b)
{
    stp_dbox_join(&a.box, &b.box);
    a.finest = b.finest < a.finest ? b.finest : a.finest;
    a.coarsest = b.coarsest > a.coarsest ? b.coarsest : a.coarsest;
    return a;
}

/* The origin is a multiple of twice the coarsest lattice, near the middle. */
static stp_status add_run(runs *out, uint32_t begin, uint32_t end, const stp_leaf_extent *e,
                          stp_error *err)
{
    stp_status status = STP_OK;
    const double unit = ldexp(1.0, e->coarsest + 1), side = stp_dbox_side(&e->box);
    const stp_dvec3 middle = stp_dbox_middle(&e->box);
    const double grain = side > unit ? ldexp(1.0, stp_floor_log2(side) + 1) : unit;
    STP_TRY(stp_grow(&out->list, &out->capacity, out->count + 1, sizeof *out->list, "chunks", err));
    out->list[out->count++] = (stp_leaf_run){.begin = begin,
                                             .end = end,
                                             .middle = middle,
                                             .origin = {nearbyint(middle.x / grain) * grain,
                                                        nearbyint(middle.y / grain) * grain,
                                                        nearbyint(middle.z / grain) * grain}};
done:
    return status;
}

stp_status stp_leaf_cut(stp_leaf_run **out, uint32_t *count, uint32_t patch_count,
                        stp_extent_of *extent_of, const void *context, stp_error *err)
{
    stp_status status = STP_OK;
    runs found = {0};
    stp_leaf_extent all = {0};
    uint32_t begin = 0;
    for (uint32_t i = 0; i < patch_count; i++) {
        const stp_leaf_extent own = extent_of(context, i);
        stp_leaf_extent more = i > begin ? join(all, own) : own;
        if (i > begin && (i - begin == STP_LEAF_PATCHES || !fits(&more))) {
            STP_TRY(add_run(&found, begin, i, &all, err));
            begin = i;
            more = own;
        }
        all = more;
    }
    if (patch_count > begin)
        STP_TRY(add_run(&found, begin, patch_count, &all, err));
    *out = found.list;
    *count = (uint32_t)found.count;
    found.list = NULL;
done:
    free(found.list);
    return status;
}
