/* The k nearest distinct positions of points. */
#include "preprocess/cloud/neighbours.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* Consecutive points along the Morton curve that share a search by radius. */
#define GROUP 16u
/* Greatest distance from the first point of a group, in k-th neighbour distances of the point
 * before. */
#define GROUP_SIZE 1.8
/* How far the shared search reaches beyond the group, in the same unit. */
#define GROUP_REACH 1.18
/* If a group has more candidates than this, its points are searched one by one. */
#define GROUP_CANDIDATES 512u
/* Extra points asked of the tree: the point itself, and one farther point that proves the list
 * complete. */
#define EXTRA 2u
/* Greatest relative error of the tree's float distances, without the rounding of points. */
#define FLOAT_ERROR 1e-5

/* Most candidates that are ranked by counting, and how many are counted at once. */
#define CHOICES 96u
#define RANKS 12u
/* First guess for a point's k-th neighbour distance, in that of the point before. */
#define LIKELY_REACH 1.15

/* Marks a point at the same position as the point before. */
#define AT_REPEATED (STP_LOCALE_NONE - 1)

typedef struct search {
    const stp_cloud *cloud;
    const stp_locale *locale;
    unsigned k;
    double last; /* k-th neighbour distance of the point before; 0: unknown */
    const uint32_t *places;
    uint32_t *lists;
    stp_cloud_point *points;
} search;

/* The points near a group, in double: all within `radius` of the centre. */
typedef struct surroundings {
    vec3s centre; /* of the group, in the tree's coordinates */
    double radius;
    size_t count;
    uint32_t place[GROUP_CANDIDATES], source[GROUP_CANDIDATES];
    double x[GROUP_CANDIDATES], y[GROUP_CANDIDATES], z[GROUP_CANDIDATES];
} surroundings;

/* Stores a point's list. If points outside the locale may be as near, makes an exact list first. */
static void finish_point(search *s, uint32_t i, stp_nearest_list *list)
{
    uint32_t place = s->places[i];
    if (!stp_nearest_list_full(list) ||
        !stp_locale_holds(s->locale, s->cloud->points[place].position,
                          sqrt(list->squared[list->count - 1])))
        stp_box_tree_nearest(s->cloud, place, list);
    for (size_t n = 0; s->lists && n < s->k; n++)
        s->lists[(size_t)i * s->k + n] = n < list->count ? list->place[n] : STP_NEIGHBOUR_NONE;
    double last = list->count ? list->squared[list->count - 1] : 0.0;
    s->points[i].spacing = list->count ? (float)sqrt(last * M_PI / (double)list->count) : 0.0f;
    s->last = stp_nearest_list_full(list) ? sqrt(last) : 0.0;
}

/* Measures candidates in double and keeps the nearest. */
static void list_fill(stp_nearest_list *list, const stp_locale *l, uint32_t at,
                      const uint32_t *candidates, size_t count)
{
    const stp_cloud_point *points = l->cloud->points;
    stp_dvec3 p = points[l->places[at]].position;
    list->count = 0;
    for (size_t i = 0; i < count && candidates[i] != STP_KD_TREE_NONE; i++) {
        uint32_t place = l->places[candidates[i]];
        stp_dvec3 d = stp_dvec3_sub(points[place].position, p);
        double squared = stp_dvec3_dot(d, d);
        if (squared > 0.0)
            stp_nearest_list_insert(list, squared, place, points[place].source);
    }
}

static stp_status no_memory(stp_error *err)
{
    return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the neighbour search");
}

/* Searches the list of the locale's point `at` alone. If a point that was left out may be as near
 * as the last one, looks at all points that near. */
static stp_status list_find(stp_nearest_list *list, const search *s, uint32_t at, stp_error *err)
{
    const stp_locale *l = s->locale;
    uint32_t found[STP_NEIGHBOURS_LIMIT + EXTRA];
    float squared[STP_NEIGHBOURS_LIMIT + EXTRA];
    size_t asked = s->k + EXTRA;
    const float *point = l->points + 3 * (size_t)at;
    if (!stp_kd_tree_nearest(l->tree, point, asked, found, squared))
        return no_memory(err);
    list_fill(list, l, at, found, asked);
    if (found[asked - 1] == STP_KD_TREE_NONE || !stp_nearest_list_full(list))
        return STP_OK;
    double last = sqrt(list->squared[list->count - 1]);
    if (last < (1.0 - FLOAT_ERROR) * sqrt((double)squared[asked - 1]) - l->slack)
        return STP_OK;
    double reach = (1.0 + FLOAT_ERROR) * last + l->slack;
    size_t count = 0;
    if (!stp_kd_tree_within(l->tree, point, (float)(reach * reach), l->within, &count))
        return no_memory(err);
    list_fill(list, l, at, l->within, count);
    return STP_OK;
}

static vec3s tree_point(const stp_locale *l, uint32_t at)
{
    const float *p = l->points + 3 * (size_t)at;
    return (vec3s){{p[0], p[1], p[2]}};
}

/* Finds the points around some of the locale's points; none if there are too many. */
static stp_status surroundings_find(surroundings *around, const search *s, const uint32_t *ats,
                                    unsigned at_count, stp_error *err)
{
    const stp_locale *l = s->locale;
    vec3s low = tree_point(l, ats[0]), high = low;
    double size = 0.0;
    size_t count = 0;
    for (unsigned i = 1; i < at_count; i++) {
        low = glms_vec3_minv(low, tree_point(l, ats[i]));
        high = glms_vec3_maxv(high, tree_point(l, ats[i]));
    }
    around->centre = glms_vec3_scale(glms_vec3_add(low, high), 0.5f);
    around->count = 0;
    for (unsigned i = 0; i < at_count; i++)
        size = stp_max(size, (double)glms_vec3_distance(around->centre, tree_point(l, ats[i])));
    around->radius = size + GROUP_REACH * s->last;
    if (!stp_kd_tree_within(l->tree, around->centre.raw, (float)(around->radius * around->radius),
                            l->within, &count))
        return no_memory(err);
    if (count > GROUP_CANDIDATES)
        return STP_OK;
    for (size_t i = 0; i < count; i++) {
        around->place[i] = l->places[l->within[i]];
        const stp_cloud_point *p = &l->cloud->points[around->place[i]];
        around->x[i] = p->position.x;
        around->y[i] = p->position.y;
        around->z[i] = p->position.z;
        around->source[i] = p->source;
    }
    around->count = count;
    return STP_OK;
}

/* The candidates, from a group's surroundings, for the nearest of one point. */
typedef struct choice {
    unsigned count;
    int32_t keys[CHOICES]; /* squared distances as floats, whose bits sort like integers */
    uint16_t places[CHOICES];
} choice;

/* Computes all squared distances and picks those within the limit. False: too many. */
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

/* Sorts by counting nearer ones, without branches. False if floats tie. */
static bool choice_rank(const choice *c, stp_nearest_list *list, const surroundings *around,
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
            list->place[rank] = around->place[c->places[first + r]];
            list->source[rank] = around->source[c->places[first + r]];
            filled |= (uint64_t)1 << rank;
            placed++;
        }
    }
    list->count = list->capacity;
    return placed == list->capacity && __builtin_popcountll(filled) == (int)list->capacity;
}

/* Makes the list of the locale's point `at` from its group's surroundings. False: nearer points may
 * lie outside. */
static bool list_choose(stp_nearest_list *list, const search *s, const surroundings *around,
                        uint32_t at)
{
    const stp_locale *l = s->locale;
    double squared[GROUP_CANDIDATES];
    choice c;
    stp_dvec3 p = s->cloud->points[l->places[at]].position;
    double likely = LIKELY_REACH * s->last;
    if (!choice_filter(&c, around, p, likely * likely, squared) || c.count < list->capacity ||
        !choice_rank(&c, list, around, squared)) {
        list->count = 0;
        for (size_t i = 0; i < around->count; i++)
            if (squared[i] > 0.0)
                stp_nearest_list_insert(list, squared[i], around->place[i], around->source[i]);
    }
    if (!stp_nearest_list_full(list))
        return false;
    double off = (double)glms_vec3_distance(around->centre, tree_point(l, at));
    double room = (1.0 - FLOAT_ERROR) * around->radius - (1.0 + FLOAT_ERROR) * off;
    return sqrt(list->squared[list->count - 1]) < room - l->slack;
}

/* Points that share a search. */
typedef struct group {
    unsigned count;
    uint32_t members[GROUP], ats[GROUP]; /* their numbers among the points, and in the locale */
} group;

/* Gathers the group that begins at point i: the points that follow, no farther from it than
 * GROUP_SIZE. Returns where the next group begins. */
static uint32_t group_gather(group *g, const search *s, const uint32_t *ats, uint32_t i,
                             uint32_t count)
{
    const stp_locale *l = s->locale;
    g->count = 0;
    for (; i < count && g->count < GROUP; i++) {
        if (ats[i] == STP_LOCALE_NONE || ats[i] == AT_REPEATED)
            continue;
        if (g->count > 0 &&
            (double)glms_vec3_distance(tree_point(l, g->ats[0]), tree_point(l, ats[i])) >
                GROUP_SIZE * s->last)
            break;
        g->members[g->count] = i;
        g->ats[g->count++] = ats[i];
    }
    return i;
}

static stp_status find_group(search *s, const group *g, stp_error *err)
{
    stp_status status = STP_OK;
    surroundings around;
    stp_nearest_list list;
    list.capacity = s->k;
    STP_TRY(surroundings_find(&around, s, g->ats, g->count, err));
    for (unsigned i = 0; i < g->count; i++) {
        if (!list_choose(&list, s, &around, g->ats[i]))
            STP_TRY(list_find(&list, s, g->ats[i], err));
        finish_point(s, g->members[i], &list);
    }
done:
    return status;
}

/* Searches points outside the locale exactly. Points at one position share a list. */
static void find_others(search *s, const uint32_t *ats, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        stp_nearest_list list = {.capacity = s->k};
        if (ats[i] == STP_LOCALE_NONE)
            finish_point(s, i, &list);
        if (ats[i] != AT_REPEATED)
            continue;
        s->points[i].spacing = s->points[i - 1].spacing;
        uint32_t *own = s->lists ? s->lists + (size_t)i * s->k : NULL;
        if (own)
            memcpy(own, own - s->k, s->k * sizeof *own);
    }
}

stp_status stp_neighbours_find(const stp_locale *locale, unsigned k, const uint32_t *places,
                               uint32_t count, uint32_t *lists, stp_cloud_point *points,
                               stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *ats = NULL;
    size_t from = 0;
    search s = {
        .cloud = locale->cloud, .locale = locale, .k = k, .places = places, .points = points};
    s.lists = lists;
    STP_TRY(stp_alloc(&ats, count, sizeof *ats, "neighbours", err));
    for (uint32_t i = 0; i < count; i++) {
        bool follows = i > 0 && places[i] == places[i - 1] + 1;
        ats[i] = follows && stp_cloud_repeats(s.cloud, places[i])
                     ? AT_REPEATED
                     : stp_locale_find(locale, places[i], &from);
    }
    for (uint32_t i = 0; i < count;) {
        group g;
        i = group_gather(&g, &s, ats, i, count);
        if (g.count > 0)
            STP_TRY(find_group(&s, &g, err));
    }
    find_others(&s, ats, count);
done:
    free(ats);
    return status;
}
