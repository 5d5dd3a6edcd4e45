/* Cuts the points of touched leaves, old and new, into new leaves, and makes items of them. */
#include "preprocess/append/append_job.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_cells.h"

#include <stdlib.h>
#include <string.h>

/* An old radius shrinks only by more than a code: else it would change by rounding alone. */
#define SHRINK 0.957

/* Points that stay, ordered by the leaf that they join; within it in Morton order. */
typedef struct ordering {
    stp_append *a;
    uint32_t *ends; /* by leaf; the last is of points that join none */
    uint32_t *next; /* likewise: place of the next point */
    stp_cloud sorted;
} ordering;

static uint32_t slot_of(const stp_append *a, uint32_t i)
{
    const uint32_t leaf = a->leaf_of[a->job.cloud.points[i].source];
    return leaf == STP_LEAF_FREE ? a->leaf_count : leaf;
}

static void count_slots(const ordering *o)
{
    const stp_cloud *cloud = &o->a->job.cloud;
    uint32_t sum = 0;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (slot_of(o->a, i) != STP_LEAF_CONTEXT)
            o->ends[slot_of(o->a, i)]++;
    for (uint32_t s = 0; s <= o->a->leaf_count; s++) {
        o->next[s] = sum;
        sum += o->ends[s];
        o->ends[s] = sum;
    }
}

/* Moves the points that stay to a cloud of their own. */
static stp_status order(ordering *o, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud *cloud = &o->a->job.cloud;
    stp_cloud *to = &o->sorted;
    const uint32_t count = o->ends[o->a->leaf_count];
    STP_TRY(stp_cloud_create(to, 0, count, cloud->spill, err));
    STP_TRY(stp_spill_alloc(to->spill, &to->sheets, count, sizeof *to->sheets, "sheets", err));
    STP_TRY(stp_spill_alloc(to->spill, &to->marks, count, sizeof *to->marks, "marks", err));
    to->count = count;
    to->box = cloud->box;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        if (slot_of(o->a, i) == STP_LEAF_CONTEXT)
            continue;
        const uint32_t at = o->next[slot_of(o->a, i)]++;
        to->points[at] = cloud->points[i];
        to->sheets[at] = cloud->sheets[i];
        to->marks[at] = cloud->marks[i];
    }
done:
    return status;
}

/* Where a run of points that join no leaf ends: it is no wider than `side`. */
static uint32_t free_end(const stp_cloud *cloud, uint32_t begin, uint32_t end, double side)
{
    stp_dbox box = stp_dbox_empty();
    for (uint32_t i = begin; i < end; i++) {
        stp_dbox_add(&box, cloud->points[i].position);
        if (i > begin && stp_dbox_side(&box) > side)
            return i;
    }
    return end;
}

/* How wide a leaf of the points that join none may be: as the model's leaves on average, or as full
 * leaves of a surface of these points, which may be sparser than the model's. */
static double free_side(const stp_append *a, uint32_t begin, uint32_t end)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < a->leaf_count; i++) {
        const stp_dbox box = stp_chunk_entry_box(stp_append_leaf(a, i));
        sum += stp_dbox_side(&box);
    }
    const stp_dbox box = stp_points_box(a->job.cloud.points + begin, end - begin);
    const double leaves = fmax(1.0, (double)(end - begin) / STP_CELL_POINTS);
    return fmax(sum / a->leaf_count, stp_dbox_side(&box) / sqrt(leaves));
}

/* Cuts each leaf's points into cells. */
static stp_status cut_leaves(const ordering *o, stp_error *err)
{
    stp_status status = STP_OK;
    stp_append *a = o->a;
    stp_cloud *cloud = &a->job.cloud;
    const double side = free_side(a, o->ends[a->leaf_count - 1], o->ends[a->leaf_count]);
    for (uint32_t s = 0, begin = 0; s <= a->leaf_count; s++)
        while (begin < o->ends[s]) {
            const uint32_t end =
                s < a->leaf_count ? o->ends[s] : free_end(cloud, begin, o->ends[s], side);
            STP_TRY(stp_cloud_cut(cloud, begin, end, err));
            begin = end;
        }
done:
    return status;
}

stp_status stp_append_cut(stp_append *a, stp_error *err)
{
    stp_status status = STP_OK;
    ordering o = {.a = a};
    STP_TRY(stp_alloc(&o.ends, (size_t)a->leaf_count + 1, sizeof *o.ends, "chunks", err));
    STP_TRY(stp_alloc(&o.next, (size_t)a->leaf_count + 1, sizeof *o.next, "chunks", err));
    count_slots(&o);
    STP_TRY(order(&o, err));
    stp_cloud_clear(&a->job.cloud);
    a->job.cloud = o.sorted;
    o.sorted = (stp_cloud){0};
    STP_TRY(cut_leaves(&o, err));
done:
    stp_cloud_clear(&o.sorted);
    free(o.ends);
    free(o.next);
    return status;
}

/* ---- items ---- */

/* The item of an old point is its sample, but for a radius that new neighbours make less. */
static void restore(stp_item *item, const stp_old_point *old, double lambda)
{
    if (item->disc.radius > SHRINK * old->radius) {
        const double spacing = old->radius / lambda;
        item->disc.radius = item->disc.reach = item->disc.bound = old->radius;
        item->area = spacing * spacing;
    }
    item->loose = 0.0;
    item->exponent = old->exponent;
    item->intensity = old->intensity;
    item->class_id = old->class_id;
    item->flags = old->flags;
    memcpy(item->normal, old->normal, sizeof item->normal);
    item->disc.normal = old->flags & STP_SAMPLE_HAS_NORMAL
                            ? stp_dvec3_from_float(stp_normal_decode(old->normal))
                            : (stp_dvec3){0.0, 0.0, 0.0};
}

void stp_append_items(const stp_append *a, stp_item *items, uint32_t begin, uint32_t count,
                      const stp_point_item_params *params)
{
    const stp_cloud *cloud = &a->job.cloud;
    stp_point_items_make(items, cloud, begin, begin + count, params);
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t source = cloud->points[begin + i].source;
        if (source >= a->read_count)
            restore(&items[i], &a->old[source - a->read_count], params->lambda);
    }
}
