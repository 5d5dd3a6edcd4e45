/* The k nearest distinct positions of points. */
#include "preprocess/cloud/neighbours.h"

#include "base/ahead.h"
#include "base/memory.h"
#include "base/wide.h"
#include "preprocess/cloud/box_tree.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

/* Consecutive points along the Morton curve that share candidates. */
#define GROUP 16u
/* Greatest distance from the first point of a group, in k-th neighbour distances of the point
 * before. */
#define GROUP_SIZE 2.0
/* How far candidates reach beyond the group's box, in the same unit. A point that asks alone looks
 * that many times as far each time, until FLANN is asked. */
#define GROUP_REACH 1.4
#define FARTHER 1.6
#define TRIES 5
/* Most candidates. */
#define CANDIDATES (STP_RUNS_NEAR * STP_RUN_POINTS)
/* Extra points asked of the tree: the point itself, and one farther point that proves the list
 * complete. */
#define EXTRA 2u
/* Greatest relative error of the tree's float distances, without the rounding of points. */
#define FLOAT_ERROR 1e-5

/* Most points that are ranked by counting, and how many are counted at once. */
#define CHOICES 96u
#define RANKS 8u
/* First guess for a point's k-th neighbour distance, in that of the point before. */
#define LIKELY_REACH 1.15

/* Marks a point at the same position as the point before. */
#define AT_REPEATED (STP_LOCALE_NONE - 1)

/* A run's points in lanes, and a bit for each. */
typedef float run_floats __attribute__((vector_size(4 * STP_RUN_POINTS)));
typedef float run_of_floats __attribute__((vector_size(4 * STP_RUN_POINTS), aligned(4), may_alias));
typedef int32_t run_bits __attribute__((vector_size(4 * STP_RUN_POINTS)));
typedef uint64_t run_words __attribute__((vector_size(4 * STP_RUN_POINTS)));
typedef double run_of_doubles
    __attribute__((vector_size(8 * STP_RUN_POINTS), aligned(8), may_alias));
typedef uint16_t run_numbers __attribute__((vector_size(2 * STP_RUN_POINTS)));

static const run_bits each_bit = {1, 2, 4, 8, 16, 32, 64, 128};

typedef int32_t key_lanes __attribute__((vector_size(4 * RANKS)));

/* By bits: the numbers of the points whose bits are set, in order, and how many there are. So
 * points are picked without a branch for each. */
typedef struct run_picks {
    run_numbers numbers[1u << STP_RUN_POINTS];
    uint8_t counts[1u << STP_RUN_POINTS];
} run_picks;

typedef struct search {
    const stp_cloud *cloud;
    stp_locale *locale;
    unsigned k;
    const uint64_t *places;
    uint64_t *lists;
    stp_cloud_point *points;
    run_picks picks;
} search;

static void picks_fill(run_picks *picks)
{
    for (unsigned bits = 0; bits < 1u << STP_RUN_POINTS; bits++)
        for (unsigned i = 0; i < STP_RUN_POINTS; i++)
            if (bits >> i & 1)
                picks->numbers[bits][picks->counts[bits]++] = (uint16_t)i;
}

/* Appends the numbers of the points whose bits are set; `first` is that of the run's first point.
 * There must be room for a run. Returns how many there are now. */
static inline unsigned add_picks(const run_picks *picks, const run_bits *set, unsigned first,
                                 uint16_t *picked, unsigned count)
{
    const run_words words = (run_words)*set;
    const uint64_t both = words[0] | words[1] | words[2] | words[3];
    const uint8_t bits = (uint8_t)(both | both >> 32);
    const run_numbers numbers = picks->numbers[bits] + (uint16_t)first;
    memcpy(picked + count, &numbers, sizeof numbers);
    return count + picks->counts[bits];
}

/* The points near a group: all within `reach` of its box, and more. */
typedef struct surroundings {
    stp_dvec3 centre;
    double size, reach;        /* of the box: half its diagonal */
    unsigned count;            /* a multiple of STP_RUN_POINTS, filled up by points at infinity */
    uint32_t ats[CANDIDATES];  /* in the locale */
    float axes[3][CANDIDATES]; /* less centre */
} surroundings;

/* A position of the locale. */
static stp_dvec3 position_of(const stp_locale *l, uint32_t at)
{
    return (stp_dvec3){l->axes[0][at], l->axes[1][at], l->axes[2][at]};
}

/* Stores the list of the point at p. If points outside the locale may be as near, makes an exact
 * list first. */
static void finish_point(search *s, uint32_t i, stp_dvec3 p, stp_nearest_list *list)
{
    if (!stp_nearest_list_full(list) ||
        !stp_locale_holds(s->locale, p, sqrt(list->squared[list->count - 1])))
        stp_box_tree_nearest(s->cloud, s->places[i], list);
    for (size_t n = 0; s->lists && n < s->k; n++)
        s->lists[(size_t)i * s->k + n] = n < list->count ? list->place[n] : STP_PLACE_NONE;
    double last = list->count ? list->squared[list->count - 1] : 0.0;
    s->points[i].spacing = list->count ? (float)sqrt(last * M_PI / (double)list->count) : 0.0f;
    s->locale->spread = stp_nearest_list_full(list) ? sqrt(last) : 0.0;
}

/* Measures candidates in double and keeps the nearest. */
static void list_fill(stp_nearest_list *list, const stp_locale *l, uint32_t at,
                      const uint32_t *candidates, size_t count)
{
    const stp_cloud_point *points = l->cloud->points;
    stp_dvec3 p = points[l->places[at]].position;
    list->count = 0;
    for (size_t i = 0; i < count && candidates[i] != STP_KD_TREE_NONE; i++) {
        const uint64_t place = l->places[candidates[i]];
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
    stp_locale *l = s->locale;
    uint32_t found[STP_NEIGHBOURS_LIMIT + EXTRA];
    float squared[STP_NEIGHBOURS_LIMIT + EXTRA];
    size_t asked = s->k + EXTRA;
    if (stp_locale_plant(l, err) != STP_OK)
        return STP_OUT_OF_MEMORY;
    const float *point = l->points + 3 * (size_t)at;
    if (!stp_kd_tree_nearest(l->tree, point, asked, found, squared))
        return no_memory(err);
    list_fill(list, l, at, found, asked);
    if (found[asked - 1] == STP_KD_TREE_NONE || !stp_nearest_list_full(list))
        return STP_OK;
    double last = sqrt(list->squared[list->count - 1]);
    const double slack = stp_locale_slack(stp_locale_point(l, at), last);
    if (last < (1.0 - FLOAT_ERROR) * sqrt((double)squared[asked - 1]) - slack)
        return STP_OK;
    double reach = (1.0 + FLOAT_ERROR) * last + slack;
    size_t count = 0;
    if (!stp_kd_tree_within(l->tree, point, (float)(reach * reach), l->within, &count))
        return no_memory(err);
    list_fill(list, l, at, l->within, count);
    return STP_OK;
}

/* Copies a run's points. */
STP_WIDE
static void take_run(surroundings *around, const stp_locale *l, uint32_t run)
{
    const size_t from = (size_t)run * STP_RUN_POINTS, to = around->count;
    const double centre[3] = {around->centre.x, around->centre.y, around->centre.z};
    for (unsigned i = 0; i < STP_RUN_POINTS; i++)
        around->ats[to + i] = (uint32_t)from + i;
    for (int a = 0; a < 3; a++) {
        const run_of_doubles *places = (const run_of_doubles *)(l->axes[a] + from);
        const run_floats less = __builtin_convertvector(*places - centre[a], run_floats);
        memcpy(around->axes[a] + to, &less, sizeof less);
    }
    around->count += STP_RUN_POINTS;
}

/* One coordinate of a run of points, from `first` on. */
#define RUN_AT(around, axis, first) (*(const run_of_floats *)((around)->axes[axis] + (first)))

/* Keeps the points that are within half[] of the centre along each axis. */
STP_WIDE
static void keep_inside(surroundings *around, const float half[3], const run_picks *picks)
{
    const run_floats none = {0.0f};
    const run_floats most[3] = {half[0] - none, half[1] - none, half[2] - none};
    uint16_t kept[CANDIDATES + STP_RUN_POINTS];
    unsigned count = 0;
    for (unsigned first = 0; first < around->count; first += STP_RUN_POINTS) {
        const run_floats x = RUN_AT(around, 0, first), y = RUN_AT(around, 1, first);
        const run_floats z = RUN_AT(around, 2, first);
        const run_bits inside = (run_bits)(x <= most[0]) & (run_bits)(x >= -most[0]) &
                                (run_bits)(y <= most[1]) & (run_bits)(y >= -most[1]) &
                                (run_bits)(z <= most[2]) & (run_bits)(z >= -most[2]) & each_bit;
        count = add_picks(picks, &inside, first, kept, count);
    }
    for (unsigned i = 0; i < count; i++) {
        around->ats[i] = around->ats[kept[i]];
        for (int a = 0; a < 3; a++)
            around->axes[a][i] = around->axes[a][kept[i]];
    }
    for (; count % STP_RUN_POINTS; count++)
        around->axes[0][count] = NAN; /* near nothing, even if squares are beyond all floats */
    around->count = count;
}

/* Finds the points around some of the locale's points; none if there are too many. */
static void surroundings_find(surroundings *around, const search *s, const uint32_t *ats,
                              unsigned at_count, double reach)
{
    const stp_locale *l = s->locale;
    vec3s low = stp_locale_point(l, ats[0]), high = low;
    uint32_t runs[STP_RUNS_NEAR];
    for (unsigned i = 1; i < at_count; i++) {
        low = glms_vec3_minv(low, stp_locale_point(l, ats[i]));
        high = glms_vec3_maxv(high, stp_locale_point(l, ats[i]));
    }
    const vec3s half = glms_vec3_scale(glms_vec3_sub(high, low), 0.5f);
    around->centre = stp_dvec3_add(l->origin, stp_dvec3_from_float(glms_vec3_add(low, half)));
    const vec3s farthest = glms_vec3_maxv(glms_vec3_abs(low), glms_vec3_abs(high));
    /* the centre is rounded, too: far from zero, by as much as points are apart */
    const double slack =
        stp_locale_slack(farthest, reach) + 0x1p-52 * stp_dvec3_length(around->centre);
    around->size = (double)glms_vec3_norm(half) + slack;
    around->reach = reach;
    around->count = 0;
    const float wider = (float)(reach + FLOAT_ERROR * (reach + around->size) + slack);
    const unsigned count = stp_run_tree_near(&l->runs, low.raw, high.raw, wider, runs);
    for (unsigned i = 0; i < count && count <= STP_RUNS_NEAR; i++)
        take_run(around, l, runs[i]);
    keep_inside(around, glms_vec3_adds(half, wider).raw, &s->picks);
}

/* The candidates for the nearest of one point: their numbers in the surroundings. squared: of the
 * distances of all points of the surroundings, in floats. */
typedef struct choice {
    unsigned count;
    uint16_t numbers[CANDIDATES + STP_RUN_POINTS];
    float squared[CANDIDATES];
} choice;

/* Finds the candidates whose squared distance from p, less the centre, is at most `most` in floats.
 */
STP_WIDE
static void pick(choice *c, const surroundings *around, const float p[3], float most,
                 const run_picks *picks)
{
    const run_floats limit = most - (run_floats){0.0f};
    unsigned count = 0;
    for (unsigned first = 0; first < around->count; first += STP_RUN_POINTS) {
        const run_floats x = RUN_AT(around, 0, first) - p[0];
        const run_floats y = RUN_AT(around, 1, first) - p[1];
        const run_floats z = RUN_AT(around, 2, first) - p[2];
        const run_floats squared = x * x + y * y + z * z;
        const run_bits near = (run_bits)(squared <= limit) & each_bit;
        memcpy(c->squared + first, &squared, sizeof squared);
        count = add_picks(picks, &near, first, c->numbers, count);
    }
    c->count = count;
}

/* What squared distances, of at most limit, may be off by in floats. Each float is off by 2^-24 of
 * itself, and no coordinate is greater than size + limit. */
static float squared_error(const surroundings *around, double limit)
{
    return (float)(0x1p-22 * (1.0 + FLOAT_ERROR) * limit * (around->size + 3.0 * limit)) + FLT_MIN;
}

/* Counts, for each of `count` keys, how many are less. There must be room for a multiple of RANKS.
 */
STP_WIDE
static void count_less(const int32_t *keys, unsigned count, int32_t *ranks)
{
    for (unsigned first = 0; first < count; first += RANKS) {
        key_lanes own, sums = {0};
        memcpy(&own, keys + first, sizeof own);
#pragma GCC unroll 4
        for (unsigned i = 0; i < count; i++)
            sums -= keys[i] < own; /* a lane is -1 where that holds */
        memcpy(ranks + first, &sums, sizeof sums);
    }
}

/* Sorts the candidates by counting nearer ones, without branches: sets nearest[] to the point
 * itself and the k nearest others. False if floats may not tell who they are, or in which order. */
static bool choice_rank(const choice *c, unsigned k, float limit_squared, float error,
                        uint16_t nearest[CHOICES])
{
    int32_t keys[CHOICES], ranks[CHOICES]; /* floats, whose bits sort like integers */
    float sorted[CHOICES + 1] = {0.0f};    /* where floats tie, 0 is left */
    unsigned unsure = 0;
    if (c->count <= k || c->count > CHOICES)
        return false;
    for (unsigned i = 0; i < c->count; i++)
        memcpy(&keys[i], &c->squared[c->numbers[i]], sizeof *keys);
    count_less(keys, c->count, ranks);
    sorted[c->count] = INFINITY;
    for (unsigned i = 0; i < c->count; i++) {
        memcpy(&sorted[ranks[i]], &keys[i], sizeof *sorted);
        nearest[ranks[i]] = c->numbers[i];
    }
    for (unsigned i = 0; i < k + 1; i++)
        unsure |= sorted[i + 1] - sorted[i] > 2.0f * error ? 0u : 1u;
    return !unsure && sorted[k] + error <= limit_squared;
}

/* Measures the candidates in double, and keeps the nearest. False if fewer than k lie within
 * `limit` of p. */
static bool choice_insert(const choice *c, const search *s, const surroundings *around, stp_dvec3 p,
                          double limit, stp_nearest_list *list)
{
    const stp_locale *l = s->locale;
    unsigned within = 0;
    list->count = 0;
    for (unsigned i = 0; i < c->count; i++) {
        const uint32_t at = around->ats[c->numbers[i]];
        const double x = l->axes[0][at] - p.x, y = l->axes[1][at] - p.y, z = l->axes[2][at] - p.z;
        const double squared = x * x + y * y + z * z;
        if (!(squared <= limit * limit && squared > 0.0))
            continue;
        const uint64_t place = l->places[at];
        stp_nearest_list_insert(list, squared, place, s->cloud->points[place].source);
        within++;
    }
    return within >= s->k;
}

/* Makes the list of the point at p from the candidates within `limit`. False: nearer points may lie
 * farther away. */
static bool list_choose_within(stp_nearest_list *list, const search *s, const surroundings *around,
                               stp_dvec3 p, double limit)
{
    const stp_locale *l = s->locale;
    const stp_dvec3 less = stp_dvec3_sub(p, around->centre);
    const float point[3] = {(float)less.x, (float)less.y, (float)less.z};
    const double wider = limit + FLOAT_ERROR * (limit + around->size);
    const float error = squared_error(around, wider);
    const float most = (float)((1.0 + FLOAT_ERROR) * wider * wider) + FLT_MIN;
    uint16_t nearest[CHOICES];
    choice c;
    pick(&c, around, point, most, &s->picks);
    if (c.count <= s->k)
        return false;
    if (!choice_rank(&c, s->k, (float)(limit * limit), error, nearest))
        return choice_insert(&c, s, around, p, limit, list);
    for (unsigned i = 0; i < s->k; i++)
        list->place[i] = l->places[around->ats[nearest[i + 1]]];
    const uint32_t at = around->ats[nearest[s->k]];
    const double x = l->axes[0][at] - p.x, y = l->axes[1][at] - p.y, z = l->axes[2][at] - p.z;
    list->squared[s->k - 1] = x * x + y * y + z * z;
    list->count = s->k;
    return true;
}

/* Makes the list of the locale's point `at` from its group's surroundings: its places, and the last
 * squared distance. False: nearer points may lie outside. */
static bool list_choose(stp_nearest_list *list, const search *s, const surroundings *around,
                        uint32_t at)
{
    const stp_locale *l = s->locale;
    const stp_dvec3 p = position_of(l, at);
    const double likely = stp_min(LIKELY_REACH * s->locale->spread, around->reach);
    return list_choose_within(list, s, around, p, likely) ||
           list_choose_within(list, s, around, p, around->reach);
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
        if (g->count > 0 && (double)glms_vec3_distance(stp_locale_point(l, g->ats[0]),
                                                       stp_locale_point(l, ats[i])) >
                                GROUP_SIZE * s->locale->spread)
            break;
        g->members[g->count] = i;
        g->ats[g->count++] = ats[i];
    }
    return i;
}

/* Makes the list of a point that its group does not answer: looks farther, then asks FLANN. */
static stp_status find_alone(stp_nearest_list *list, const search *s, uint32_t at, stp_error *err)
{
    double reach = s->locale->spread;
    for (int i = 0; i < TRIES; i++) {
        surroundings around;
        reach *= FARTHER;
        surroundings_find(&around, s, &at, 1, reach);
        if (list_choose(list, s, &around, at))
            return STP_OK;
    }
    return list_find(list, s, at, err);
}

static stp_status find_group(search *s, const group *g, stp_error *err)
{
    stp_status status = STP_OK;
    surroundings around;
    stp_nearest_list list;
    list.capacity = s->k;
    for (int a = 0; a < 3; a++) { /* the two lines of most groups */
        stp_ask_ahead(s->locale->axes[a], sizeof *s->locale->axes[a], g->ats[0]);
        stp_ask_ahead(s->locale->axes[a], sizeof *s->locale->axes[a], g->ats[0] + STP_RUN_POINTS);
    }
    surroundings_find(&around, s, g->ats, g->count, GROUP_REACH * s->locale->spread);
    for (unsigned i = 0; i < g->count; i++) {
        if (!list_choose(&list, s, &around, g->ats[i]))
            STP_TRY(find_alone(&list, s, g->ats[i], err));
        finish_point(s, g->members[i], position_of(s->locale, g->ats[i]), &list);
    }
done:
    return status;
}

/* Searches the whole cloud for the first point's list: the next ones are guessed from it. */
static void find_first(search *s, const group *g)
{
    stp_nearest_list list = {.capacity = s->k};
    finish_point(s, g->members[0], position_of(s->locale, g->ats[0]), &list);
}

/* Searches points outside the locale exactly. Points at one position share a list. */
static void find_others(search *s, const uint32_t *ats, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        stp_nearest_list list = {.capacity = s->k};
        if (ats[i] == STP_LOCALE_NONE)
            finish_point(s, i, s->cloud->points[s->places[i]].position, &list);
        if (ats[i] != AT_REPEATED)
            continue;
        s->points[i].spacing = s->points[i - 1].spacing;
        uint64_t *own = s->lists ? s->lists + (size_t)i * s->k : NULL;
        if (own)
            memcpy(own, own - s->k, s->k * sizeof *own);
    }
}

stp_status stp_neighbours_find(stp_locale *locale, unsigned k, const uint64_t *places,
                               uint32_t count, uint64_t *lists, stp_cloud_point *points,
                               stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *ats = NULL;
    size_t from = 0;
    search s = {
        .cloud = locale->cloud, .locale = locale, .k = k, .places = places, .points = points};
    s.lists = lists;
    picks_fill(&s.picks);
    STP_TRY(stp_alloc_unset(&ats, count, sizeof *ats, "neighbours", err));
    for (uint32_t i = 0; i < count; i++) {
        const bool follows = i > 0 && places[i] == places[i - 1] + 1;
        ats[i] = stp_locale_find(locale, places[i], &from);
        if (ats[i] == STP_LOCALE_NONE && follows && stp_cloud_repeats(s.cloud, places[i]))
            ats[i] = AT_REPEATED;
    }
    for (uint32_t i = 0; i < count;) {
        group g;
        i = group_gather(&g, &s, ats, i, count);
        if (g.count == 1 && locale->spread == 0.0)
            find_first(&s, &g);
        else if (g.count > 0)
            STP_TRY(find_group(&s, &g, err));
    }
    find_others(&s, ats, count);
done:
    free(ats);
    return status;
}
