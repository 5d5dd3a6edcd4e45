/* The k nearest distinct positions of every point, cell by cell with a halo. */
#include "preprocess/neighbours.h"

#include "base/memory.h"
#include "preprocess/flann_shim.h"

#include <float.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Points, following each other along the Morton curve, that share a search by radius. */
#define GROUP 16u
/* How far they lie from the first at most, in distances of the k-th neighbour of the one before. */
#define GROUP_SIZE 1.8
/* Reach of that search beyond the group, in distances of the k-th neighbour of the one before. */
#define GROUP_REACH 1.18
/* Groups among more points than this are searched point by point. */
#define GROUP_CANDIDATES 512u
/* Asked of the tree beyond k: the point itself, and one farther by which the list is known to be
 * complete. */
#define EXTRA 2u
/* No float distance of the tree is off by more than this part, but for the rounding of points. */
#define FLOAT_ERROR 1e-5

/* Candidates among which a point's nearest are found by counting, and for how many at once. */
#define CHOICES 96u
#define RANKS 12u
/* Where a point's k-th neighbour is looked for first, in distances of that of the point before. */
#define LIKELY_REACH 1.15

/* The halo for points that the first was too narrow for, in widths of that. */
#define WIDE_HALO 4.0
/* Points from which on a tree of the wider halo pays. */
#define REST_MIN 256u

typedef struct search {
    stp_cloud *cloud;
    stp_neighbours *out;
    const stp_progress *progress;
    atomic_uint_fast64_t done_count;
} search;

/* Neighbours found, nearest first, ties by source. */
typedef struct nearest_list {
    unsigned capacity, count;
    double squared[STP_NEIGHBOURS_LIMIT];
    uint32_t index[STP_NEIGHBOURS_LIMIT]; /* places in the cloud */
} nearest_list;

/* Points of a cell whose halo was too narrow for them. */
typedef struct unfinished {
    uint32_t *points; /* places in the cloud */
    size_t count;
} unfinished;

/* Distinct positions of a cell and its halo. */
typedef struct locale {
    uint32_t *index; /* places in the cloud */
    size_t count, capacity;
    size_t home_begin, home_end; /* the cell's own */
    double halo;
    float *points; /* 3 each, about the middle of all */
    double slack;  /* twice what a distance is off by for rounding points to floats */
    stp_kd_tree *tree;
    uint32_t *within; /* room for a search by radius */
    double last;      /* distance of the k-th neighbour of the point before, 0 where not known */
} locale;

/* What lies near a group, in double: all there is within `radius` of the centre. */
typedef struct surroundings {
    vec3s centre; /* of the group, as the tree's points */
    double radius;
    size_t count;
    uint32_t index[GROUP_CANDIDATES];
    double x[GROUP_CANDIDATES], y[GROUP_CANDIDATES], z[GROUP_CANDIDATES];
} surroundings;

static void list_insert(nearest_list *list, const stp_cloud *cloud, double squared, uint32_t index)
{
    unsigned at = list->count;
    const stp_cloud_point *points = cloud->points;
    while (at > 0 && (squared < list->squared[at - 1] ||
                      (squared == list->squared[at - 1] &&
                       points[index].source < points[list->index[at - 1]].source)))
        at--;
    if (at == list->capacity)
        return;
    if (list->count < list->capacity)
        list->count++;
    for (unsigned i = list->count - 1; i > at; i--) {
        list->squared[i] = list->squared[i - 1];
        list->index[i] = list->index[i - 1];
    }
    list->squared[at] = squared;
    list->index[at] = index;
}

static bool same_position(const stp_cloud_point *a, const stp_cloud_point *b)
{
    return a->position.x == b->position.x && a->position.y == b->position.y &&
           a->position.z == b->position.z;
}

static double box_distance_squared(const stp_dbox *box, stp_dvec3 p)
{
    double dx = stp_max(0.0, stp_max(box->min.x - p.x, p.x - box->max.x));
    double dy = stp_max(0.0, stp_max(box->min.y - p.y, p.y - box->max.y));
    double dz = stp_max(0.0, stp_max(box->min.z - p.z, p.z - box->max.z));
    return dx * dx + dy * dy + dz * dz;
}

static bool boxes_near(const stp_dbox *a, const stp_dbox *b, double distance)
{
    return a->min.x - distance <= b->max.x && b->min.x - distance <= a->max.x &&
           a->min.y - distance <= b->max.y && b->min.y - distance <= a->max.y &&
           a->min.z - distance <= b->max.z && b->min.z - distance <= a->max.z;
}

/* Equal positions follow each other in a cell, since they share a Morton code and ties are sorted.
 */
static bool repeats(const stp_cloud *cloud, const stp_cell *cell, uint32_t i)
{
    return i > cell->begin && same_position(&cloud->points[i], &cloud->points[i - 1]);
}

static stp_status locale_gather(locale *l, const stp_cloud *cloud, const stp_cell *home,
                                double halo, stp_error *err)
{
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        const stp_cell *cell = &cloud->cells[c];
        if (!boxes_near(&cell->box, &home->box, halo))
            continue;
        stp_status status = stp_grow(&l->index, &l->capacity, l->count + cell->end - cell->begin,
                                     sizeof *l->index, "neighbours", err);
        if (status != STP_OK)
            return status;
        if (cell == home)
            l->home_begin = l->count;
        for (uint32_t i = cell->begin; i < cell->end; i++)
            if (!repeats(cloud, cell, i) &&
                (cell == home ||
                 box_distance_squared(&home->box, cloud->points[i].position) <= halo * halo))
                l->index[l->count++] = i;
        if (cell == home)
            l->home_end = l->count;
    }
    return STP_OK;
}

static stp_status locale_plant(locale *l, const stp_cloud *cloud, stp_error *err)
{
    stp_status status = STP_OK;
    stp_dbox bounds = stp_dbox_empty();
    for (size_t i = 0; i < l->count; i++)
        stp_dbox_add(&bounds, cloud->points[l->index[i]].position);
    stp_dvec3 origin = stp_dvec3_scale(stp_dvec3_add(bounds.min, bounds.max), 0.5);
    l->slack = ldexp(stp_dvec3_length(stp_dvec3_sub(bounds.max, bounds.min)), -23);
    STP_TRY(stp_alloc(&l->points, 3 * l->count, sizeof *l->points, "neighbours", err));
    STP_TRY(stp_alloc(&l->within, l->count, sizeof *l->within, "neighbours", err));
    for (size_t i = 0; i < l->count; i++) {
        stp_dvec3 d = stp_dvec3_sub(cloud->points[l->index[i]].position, origin);
        l->points[3 * i] = (float)d.x;
        l->points[3 * i + 1] = (float)d.y;
        l->points[3 * i + 2] = (float)d.z;
    }
    l->tree = stp_kd_tree_create(l->points, l->count);
    if (!l->tree)
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the neighbour search");
done:
    return status;
}

static void locale_clear(locale *l)
{
    stp_kd_tree_destroy(l->tree);
    free(l->index);
    free(l->points);
    free(l->within);
}

/* Every cell the ball of the k-th distance meets, point by point: rare, and exact. */
static void search_everywhere(const stp_cloud *cloud, uint32_t self, nearest_list *list)
{
    stp_dvec3 p = cloud->points[self].position;
    bool full = list->count > 0 && list->count == list->capacity;
    double reach = full ? list->squared[list->count - 1] : INFINITY;
    list->count = 0;
    for (uint32_t c = 0; c < cloud->cell_count; c++) {
        const stp_cell *cell = &cloud->cells[c];
        if (box_distance_squared(&cell->box, p) > reach)
            continue;
        for (uint32_t i = cell->begin; i < cell->end; i++) {
            stp_dvec3 d = stp_dvec3_sub(cloud->points[i].position, p);
            double squared = stp_dvec3_dot(d, d);
            if (squared == 0.0 || squared > reach || repeats(cloud, cell, i))
                continue;
            list_insert(list, cloud, squared, i);
            if (list->count == list->capacity)
                reach = list->squared[list->count - 1];
        }
    }
}

static bool inside_halo(const stp_cell *cell, stp_dvec3 p, double halo, double distance)
{
    const stp_dbox *b = &cell->box;
    double room = stp_min(
        stp_min(p.x - b->min.x, b->max.x - p.x),
        stp_min(stp_min(p.y - b->min.y, b->max.y - p.y), stp_min(p.z - b->min.z, b->max.z - p.z)));
    return distance <= room + halo;
}

/* Takes the list, or notes the point if others that are as near may lie outside the halo. */
static void finish_point(search *s, const stp_cell *cell, double halo, uint32_t self,
                         nearest_list *list, unfinished *rest)
{
    stp_cloud *cloud = s->cloud;
    size_t k = s->out->k;
    stp_cloud_point *point = &cloud->points[self];
    if (list->count == 0 || list->count < k ||
        !inside_halo(cell, point->position, halo, sqrt(list->squared[list->count - 1]))) {
        if (rest) {
            rest->points[rest->count++] = self;
            return;
        }
        search_everywhere(cloud, self, list);
    }
    uint32_t *out = s->out->indices + (size_t)self * k;
    for (size_t i = 0; i < k; i++)
        out[i] = i < list->count ? list->index[i] : STP_NEIGHBOUR_NONE;
    double last = list->count ? list->squared[list->count - 1] : 0.0;
    point->spacing = list->count ? (float)sqrt(last * M_PI / (double)list->count) : 0.0f;
}

/* Measures candidates in double and keeps the nearest. */
static void list_fill(nearest_list *list, const stp_cloud *cloud, const locale *l, uint32_t self,
                      const uint32_t *candidates, size_t count)
{
    stp_dvec3 p = cloud->points[self].position;
    list->count = 0;
    for (size_t i = 0; i < count && candidates[i] != STP_KD_TREE_NONE; i++) {
        uint32_t index = l->index[candidates[i]];
        stp_dvec3 d = stp_dvec3_sub(cloud->points[index].position, p);
        double squared = stp_dvec3_dot(d, d);
        if (squared > 0.0)
            list_insert(list, cloud, squared, index);
    }
}

/* The list of the locale's point `at`, searched for it alone. Where a point that was left out may
 * be as near as the last one, all points that near are looked at. */
static stp_status list_find(nearest_list *list, const search *s, const locale *l, size_t at,
                            stp_error *err)
{
    uint32_t found[STP_NEIGHBOURS_LIMIT + EXTRA];
    float squared[STP_NEIGHBOURS_LIMIT + EXTRA];
    size_t asked = s->out->k + EXTRA;
    if (!stp_kd_tree_nearest(l->tree, l->points + 3 * at, asked, found, squared))
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the neighbour search");
    list_fill(list, s->cloud, l, l->index[at], found, asked);
    if (found[asked - 1] == STP_KD_TREE_NONE || list->count == 0 || list->count < list->capacity)
        return STP_OK;
    double last = sqrt(list->squared[list->count - 1]);
    if (last < (1.0 - FLOAT_ERROR) * sqrt((double)squared[asked - 1]) - l->slack)
        return STP_OK;
    double reach = (1.0 + FLOAT_ERROR) * last + l->slack;
    size_t count = 0;
    if (!stp_kd_tree_within(l->tree, l->points + 3 * at, (float)(reach * reach), l->within, &count))
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the neighbour search");
    list_fill(list, s->cloud, l, l->index[at], l->within, count);
    return STP_OK;
}

static vec3s tree_point(const locale *l, size_t at)
{
    return (vec3s){{l->points[3 * at], l->points[3 * at + 1], l->points[3 * at + 2]}};
}

/* Looks around the locale's points [begin, end); none where there are too many. */
static stp_status surroundings_find(surroundings *around, const stp_cloud *cloud, const locale *l,
                                    size_t begin, size_t end, stp_error *err)
{
    vec3s low = tree_point(l, begin), high = low;
    double size = 0.0;
    size_t count = 0;
    for (size_t at = begin + 1; at < end; at++) {
        low = glms_vec3_minv(low, tree_point(l, at));
        high = glms_vec3_maxv(high, tree_point(l, at));
    }
    around->centre = glms_vec3_scale(glms_vec3_add(low, high), 0.5f);
    around->count = 0;
    for (size_t at = begin; at < end; at++)
        size = stp_max(size, (double)glms_vec3_distance(around->centre, tree_point(l, at)));
    around->radius = size + GROUP_REACH * l->last;
    if (!stp_kd_tree_within(l->tree, around->centre.raw, (float)(around->radius * around->radius),
                            l->within, &count))
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the neighbour search");
    if (count > GROUP_CANDIDATES)
        return STP_OK;
    for (size_t i = 0; i < count; i++) {
        around->index[i] = l->index[l->within[i]];
        stp_dvec3 p = cloud->points[around->index[i]].position;
        around->x[i] = p.x;
        around->y[i] = p.y;
        around->z[i] = p.z;
    }
    around->count = count;
    return STP_OK;
}

/* What of a group's surroundings may be among the nearest of a point. */
typedef struct choice {
    unsigned count;
    int32_t keys[CHOICES]; /* squared distances as floats, whose bits keep their order */
    uint16_t places[CHOICES];
} choice;

/* Squared distances of all surroundings, and which are within the limit; false: too many. */
static bool choice_filter(choice *c, const surroundings *around, stp_dvec3 p, double limit,
                          double *squared)
{
    int32_t keys[GROUP_CANDIDATES];
    uint16_t places[GROUP_CANDIDATES];
    unsigned count = 0;
    for (size_t i = 0; i < around->count; i++) {
        double dx = around->x[i] - p.x, dy = around->y[i] - p.y, dz = around->z[i] - p.z;
        squared[i] = dx * dx + dy * dy + dz * dz;
    }
    for (size_t i = 0; i < around->count; i++) {
        float rounded = (float)squared[i];
        memcpy(&keys[count], &rounded, sizeof rounded);
        places[count] = (uint16_t)i;
        count += (squared[i] <= limit) & (squared[i] > 0.0);
    }
    if (count > CHOICES)
        return false;
    c->count = count;
    memcpy(c->keys, keys, count * sizeof *keys);
    memcpy(c->places, places, count * sizeof *places);
    return true;
}

/* Sorts by counting how many are nearer, which takes no branches; false where floats tie. */
static bool choice_rank(const choice *c, nearest_list *list, const surroundings *around,
                        const double *squared)
{
    int32_t keys[CHOICES];
    uint64_t filled = 0;
    unsigned placed = 0;
    memcpy(keys, c->keys, c->count * sizeof *keys);
    for (unsigned i = c->count; i % RANKS; i++)
        keys[i] = INT32_MAX;
    for (unsigned first = 0; first < c->count; first += RANKS) {
        int32_t ranks[RANKS] = {0};
        for (unsigned i = 0; i < c->count; i++)
            for (unsigned r = 0; r < RANKS; r++)
                ranks[r] += c->keys[i] < keys[first + r];
        for (unsigned r = 0; r < RANKS && first + r < c->count; r++) {
            unsigned rank = (unsigned)ranks[r];
            if (rank >= list->capacity)
                continue;
            list->squared[rank] = squared[c->places[first + r]];
            list->index[rank] = around->index[c->places[first + r]];
            filled |= (uint64_t)1 << rank;
            placed++;
        }
    }
    list->count = list->capacity;
    return placed == list->capacity && __builtin_popcountll(filled) == (int)list->capacity;
}

/* The list of the locale's point `at` out of its group's surroundings. False: nearer ones may lie
 * outside. */
static bool list_choose(nearest_list *list, const stp_cloud *cloud, const locale *l,
                        const surroundings *around, size_t at)
{
    double squared[GROUP_CANDIDATES];
    choice c;
    stp_dvec3 p = cloud->points[l->index[at]].position;
    double likely = LIKELY_REACH * l->last;
    if (!choice_filter(&c, around, p, likely * likely, squared) || c.count < list->capacity ||
        !choice_rank(&c, list, around, squared)) {
        list->count = 0;
        for (size_t i = 0; i < around->count; i++)
            if (squared[i] > 0.0)
                list_insert(list, cloud, squared[i], around->index[i]);
    }
    if (list->count == 0 || list->count < list->capacity)
        return false;
    double off = (double)glms_vec3_distance(around->centre, tree_point(l, at));
    double room = (1.0 - FLOAT_ERROR) * around->radius - (1.0 + FLOAT_ERROR) * off;
    return sqrt(list->squared[list->count - 1]) < room - l->slack;
}

/* End of the group that begins here: points no farther from its first than the k-th neighbour. */
static size_t group_end(const locale *l, size_t begin)
{
    size_t end = begin + 1;
    while (end < l->home_end && end - begin < GROUP &&
           (double)glms_vec3_distance(tree_point(l, begin), tree_point(l, end)) <=
               GROUP_SIZE * l->last)
        end++;
    return end;
}

static stp_status find_group(search *s, const stp_cell *cell, locale *l, size_t begin, size_t end,
                             unfinished *rest, stp_error *err)
{
    stp_status status = STP_OK;
    surroundings around;
    nearest_list list;
    list.capacity = s->out->k;
    STP_TRY(surroundings_find(&around, s->cloud, l, begin, end, err));
    for (size_t at = begin; at < end; at++) {
        if (!list_choose(&list, s->cloud, l, &around, at))
            STP_TRY(list_find(&list, s, l, at, err));
        bool full = list.count > 0 && list.count == list.capacity;
        l->last = full ? sqrt(list.squared[list.count - 1]) : 0.0;
        finish_point(s, cell, l->halo, l->index[at], &list, rest);
    }
done:
    return status;
}

/* Points at one position share a list. */
static void copy_repeats(search *s, const stp_cell *cell)
{
    size_t k = s->out->k;
    for (uint32_t i = cell->begin; i < cell->end; i++) {
        if (!repeats(s->cloud, cell, i))
            continue;
        memcpy(s->out->indices + i * k, s->out->indices + (i - 1) * k, k * sizeof *s->out->indices);
        s->cloud->points[i].spacing = s->cloud->points[i - 1].spacing;
    }
}

/* About four sample spacings of a surface that fills the cell's box with its points. */
static double halo_width(const stp_cell *cell)
{
    double diagonal = stp_dvec3_length(stp_dvec3_sub(cell->box.max, cell->box.min));
    return 3.0 * diagonal / sqrt((double)(cell->end - cell->begin));
}

/* The points that the first halo was too narrow for. Of many, a wider one: in a volume, such as
 * leaves, neighbours lie farther than on a surface of as many points. */
static stp_status find_rest(search *s, const stp_cell *cell, const locale *narrow,
                            const unfinished *rest, stp_error *err)
{
    stp_status status = STP_OK;
    locale wide = {.halo = WIDE_HALO * narrow->halo};
    nearest_list list;
    const locale *l = narrow;
    list.capacity = s->out->k;
    if (rest->count >= REST_MIN) {
        STP_TRY(locale_gather(&wide, s->cloud, cell, wide.halo, err));
        STP_TRY(locale_plant(&wide, s->cloud, err));
        l = &wide;
    }
    size_t at = l->home_begin;
    for (size_t i = 0; i < rest->count; i++) {
        while (l->index[at] != rest->points[i]) /* both go up */
            at++;
        STP_TRY(list_find(&list, s, l, at, err));
        finish_point(s, cell, l->halo, rest->points[i], &list, NULL);
    }
done:
    locale_clear(&wide);
    return status;
}

static stp_status find_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    search *s = context;
    const stp_cell *cell = &s->cloud->cells[index];
    locale l = {.halo = halo_width(cell)};
    unfinished rest = {0};
    (void)worker;
    STP_TRY(
        stp_alloc(&rest.points, cell->end - cell->begin, sizeof *rest.points, "neighbours", err));
    STP_TRY(locale_gather(&l, s->cloud, cell, l.halo, err));
    STP_TRY(locale_plant(&l, s->cloud, err));
    for (size_t at = l.home_begin, end; at < l.home_end; at = end) {
        end = group_end(&l, at);
        STP_TRY(find_group(s, cell, &l, at, end, &rest, err));
    }
    STP_TRY(find_rest(s, cell, &l, &rest, err));
    copy_repeats(s, cell);
    uint64_t done = atomic_fetch_add(&s->done_count, cell->end - cell->begin);
    status = stp_progress_update(s->progress, "neighbours", done + cell->end - cell->begin,
                                 s->cloud->count, err);
done:
    free(rest.points);
    locale_clear(&l);
    return status;
}

stp_status stp_neighbours_find(stp_neighbours *out, stp_cloud *cloud, unsigned k, stp_pool *pool,
                               const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    stp_neighbours result = {.k = k, .spill = cloud->spill};
    if (k < 3 || k > STP_NEIGHBOURS_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%u neighbours: give 3 to %d", k,
                             STP_NEIGHBOURS_LIMIT);
    STP_TRY(stp_spill_alloc(result.spill, &result.indices, (size_t)cloud->count * k,
                            sizeof *result.indices, "neighbours", err));
    search s = {.cloud = cloud, .out = &result, .progress = progress};
    STP_TRY(stp_cloud_run(cloud, pool, cloud->cell_count, find_cell, &s, err));
    *out = result;
    result.indices = NULL;
done:
    stp_spill_free(result.spill, result.indices);
    return status;
}

void stp_neighbours_clear(stp_neighbours *neighbours)
{
    stp_spill_free(neighbours->spill, neighbours->indices);
    *neighbours = (stp_neighbours){0};
}
