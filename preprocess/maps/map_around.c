/* Finds the points around a part of a surface. */
#include "preprocess/maps/map_around.h"

#include "base/memory.h"
#include "preprocess/cloud/box_tree.h"

#include <stdlib.h>

typedef struct search {
    const stp_cloud *cloud;
    const uint32_t *places;
    uint32_t count, at; /* at: the next place that the walk has not passed */
    stp_dbox box;
    uint32_t *found;
    size_t found_count, capacity;
    stp_status status;
    stp_error *err;
} search;

static bool reaches(void *context, const stp_dbox *box)
{
    const search *s = context;
    return stp_dbox_meet(&s->box, box);
}

static bool visit(void *context, uint64_t begin, uint64_t end)
{
    search *s = context;
    for (uint32_t i = (uint32_t)begin; i < end; i++) {
        const stp_cloud_point *p = &s->cloud->points[i];
        while (s->at < s->count && s->places[s->at] < i)
            s->at++;
        if ((s->at < s->count && s->places[s->at] == i) || !stp_has_normal(p) ||
            stp_dbox_distance_squared(&s->box, p->position) > 0.0)
            continue;
        s->status = stp_grow(&s->found, &s->capacity, s->found_count + 1, sizeof *s->found,
                             "points", s->err);
        if (s->status != STP_OK)
            return false;
        s->found[s->found_count++] = i;
    }
    return true;
}

stp_status stp_places_around(const stp_cloud *cloud, const uint32_t *places, uint32_t count,
                             const stp_dbox *box, uint32_t **out, uint32_t *out_count,
                             stp_error *err)
{
    search s = {.cloud = cloud,
                .places = places,
                .count = count,
                .box = *box,
                .status = STP_OK,
                .err = err};
    stp_box_tree_walk(cloud, reaches, visit, &s);
    if (s.status != STP_OK) {
        free(s.found);
        return s.status;
    }
    *out = s.found;
    *out_count = (uint32_t)s.found_count;
    return STP_OK;
}
