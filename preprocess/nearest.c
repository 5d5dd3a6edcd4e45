/* Exact nearest neighbours among points that lie in Morton order. */
#include "preprocess/nearest.h"

#include "base/memory.h"

#include <float.h>
#include <stdlib.h>

#define RUN STP_NEAREST_RUN
/* Runs on both sides of a run's own that are looked at first: they mostly hold the neighbours. */
#define FIRST_RUNS 2u
/* Deepest walk: one pending sibling a level. */
#define STACK_LIMIT 64

typedef struct box {
    float min[3], max[3];
} box;

/* Coordinates of eight points, relative to the tree's origin. */
typedef struct run {
    float at[3][RUN];
} run;

/* A node still to be looked at. */
typedef struct pending {
    size_t node;
    float gap; /* squared distance to the home run */
} pending;

struct stp_nearest {
    const stp_cloud *cloud;
    const uint32_t *indices;
    size_t count;
    size_t run_count;
    size_t leaf_count; /* a power of two; node i has children 2 i and 2 i + 1, the root is 1 */
    run *runs;
    box *boxes;
    double slack; /* no float distance is off by more */
};

void stp_nearest_insert(stp_nearest_list *list, const stp_cloud *cloud, double squared,
                        uint32_t index)
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

static box box_of_run(const run *r, size_t count)
{
    box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int axis = 0; axis < 3; axis++) {
        for (size_t i = 0; i < count; i++) {
            float v = r->at[axis][i];
            b.min[axis] = v < b.min[axis] ? v : b.min[axis];
            b.max[axis] = v > b.max[axis] ? v : b.max[axis];
        }
    }
    return b;
}

static box box_join(const box *a, const box *b)
{
    box out = *a;
    for (int axis = 0; axis < 3; axis++) {
        out.min[axis] = b->min[axis] < a->min[axis] ? b->min[axis] : a->min[axis];
        out.max[axis] = b->max[axis] > a->max[axis] ? b->max[axis] : a->max[axis];
    }
    return out;
}

/* Squared distance of two boxes; infinite if one is empty. */
static float box_gap(const box *a, const box *b)
{
    float sum = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        float below = a->min[axis] - b->max[axis];
        float above = b->min[axis] - a->max[axis];
        float gap = below > above ? below : above;
        gap = gap > 0.0f ? gap : 0.0f;
        sum += gap * gap;
    }
    return sum;
}

static size_t run_length(const stp_nearest *tree, size_t r)
{
    size_t left = tree->count - r * RUN;
    return left < RUN ? left : RUN;
}

/* Local floats; places behind the last point are infinitely far. */
static void fill_run(stp_nearest *tree, size_t r, stp_dvec3 origin)
{
    size_t length = run_length(tree, r);
    for (size_t i = 0; i < RUN; i++) {
        vec3s p = {{INFINITY, INFINITY, INFINITY}};
        if (i < length)
            p = stp_dvec3_to_float(
                stp_dvec3_sub(tree->cloud->points[tree->indices[r * RUN + i]].position, origin));
        for (int axis = 0; axis < 3; axis++)
            tree->runs[r].at[axis][i] = p.raw[axis];
    }
}

static void fill(stp_nearest *tree)
{
    stp_dbox bounds = stp_dbox_empty();
    for (size_t i = 0; i < tree->count; i++)
        stp_dbox_add(&bounds, tree->cloud->points[tree->indices[i]].position);
    stp_dvec3 origin = stp_dvec3_scale(stp_dvec3_add(bounds.min, bounds.max), 0.5);
    double size = stp_dvec3_length(stp_dvec3_sub(bounds.max, bounds.min));
    tree->slack = ldexp(size, -21); /* eight times what rounding two points to floats can do */
    for (size_t r = 0; r < tree->leaf_count; r++) {
        size_t length = 0;
        if (r < tree->run_count) {
            fill_run(tree, r, origin);
            length = run_length(tree, r);
        }
        tree->boxes[tree->leaf_count + r] = box_of_run(&tree->runs[length ? r : 0], length);
    }
    for (size_t i = tree->leaf_count - 1; i > 0; i--)
        tree->boxes[i] = box_join(&tree->boxes[2 * i], &tree->boxes[2 * i + 1]);
}

stp_status stp_nearest_create(stp_nearest **out, const stp_cloud *cloud, const uint32_t *indices,
                              size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_nearest *tree = NULL;
    STP_TRY(stp_alloc(&tree, 1, sizeof *tree, "neighbour search", err));
    tree->cloud = cloud;
    tree->indices = indices;
    tree->count = count;
    tree->run_count = (count + RUN - 1) / RUN;
    tree->leaf_count = 1;
    while (tree->leaf_count < tree->run_count)
        tree->leaf_count *= 2;
    STP_TRY(stp_alloc(&tree->runs, tree->run_count, sizeof *tree->runs, "neighbour search", err));
    STP_TRY(stp_alloc(&tree->boxes, 2 * tree->leaf_count, sizeof *tree->boxes, "neighbour search",
                      err));
    fill(tree);
    *out = tree;
    tree = NULL;
done:
    stp_nearest_destroy(&tree);
    return status;
}

void stp_nearest_destroy(stp_nearest **tree)
{
    if (!*tree)
        return;
    free((*tree)->boxes);
    free((*tree)->runs);
    free(*tree);
    *tree = NULL;
}

/* Squared float distance beyond which no point can enter the list: with s the slack,
 * (r + s)^2 <= 1.001 r^2 + 1001 s^2. */
static float limit_of(const stp_nearest *tree, const stp_nearest_list *list)
{
    if (list->count < list->capacity)
        return FLT_MAX;
    double worst = list->squared[list->count - 1];
    return (float)(1.001 * worst + 1002.0 * tree->slack * tree->slack);
}

/* Offers a run's points to the list of the point at `self`. */
static void scan_run(const stp_nearest *tree, size_t r, const run *home, size_t self,
                     stp_dvec3 position, stp_nearest_list *list)
{
    const run *other = &tree->runs[r];
    float squared[RUN];
    float x = home->at[0][self], y = home->at[1][self], z = home->at[2][self];
    for (size_t i = 0; i < RUN; i++) {
        float dx = other->at[0][i] - x;
        float dy = other->at[1][i] - y;
        float dz = other->at[2][i] - z;
        squared[i] = dx * dx + dy * dy + dz * dz;
    }
    float limit = limit_of(tree, list);
    unsigned near = 0; /* bit i: point i may be among the nearest */
    for (unsigned i = 0; i < RUN; i++)
        near |= (squared[i] <= limit ? 1u : 0u) << i;
    for (; near; near &= near - 1) {
        size_t i = (size_t)__builtin_ctz(near);
        if (squared[i] > limit)
            continue;
        uint32_t index = tree->indices[r * RUN + i];
        stp_dvec3 d = stp_dvec3_sub(tree->cloud->points[index].position, position);
        double exact = stp_dvec3_dot(d, d);
        if (exact > 0.0) {
            stp_nearest_insert(list, tree->cloud, exact, index);
            limit = limit_of(tree, list);
        }
    }
}

/* gap: squared distance of the two runs' boxes. */
static void scan_run_for_all(const stp_nearest *tree, size_t r, float gap, size_t home,
                             size_t length, stp_nearest_list *lists)
{
    for (size_t i = 0; i < length; i++) {
        if (gap > limit_of(tree, &lists[i]))
            continue;
        stp_dvec3 position = tree->cloud->points[tree->indices[home * RUN + i]].position;
        scan_run(tree, r, &tree->runs[home], i, position, &lists[i]);
    }
}

static float limit_of_all(const stp_nearest *tree, size_t length, const stp_nearest_list *lists)
{
    float limit = 0.0f;
    for (size_t i = 0; i < length; i++) {
        float own = limit_of(tree, &lists[i]);
        limit = own > limit ? own : limit;
    }
    return limit;
}

/* Every run in reach of the home run's lists but those from first to last, nearer subtrees first.
 */
static void walk(const stp_nearest *tree, size_t home, size_t first, size_t last,
                 stp_nearest_list *lists)
{
    const box *around = &tree->boxes[tree->leaf_count + home];
    size_t length = run_length(tree, home);
    float limit = limit_of_all(tree, length, lists);
    pending stack[STACK_LIMIT] = {{1, 0.0f}};
    int depth = 1;
    while (depth > 0) {
        pending at = stack[--depth];
        if (at.gap > limit)
            continue;
        if (at.node < tree->leaf_count) {
            pending a = {2 * at.node, box_gap(&tree->boxes[2 * at.node], around)};
            pending b = {2 * at.node + 1, box_gap(&tree->boxes[2 * at.node + 1], around)};
            stack[depth++] = a.gap <= b.gap ? b : a;
            stack[depth++] = a.gap <= b.gap ? a : b;
            continue;
        }
        size_t r = at.node - tree->leaf_count;
        if (r >= tree->run_count || (r >= first && r <= last))
            continue;
        scan_run_for_all(tree, r, at.gap, home, length, lists);
        limit = limit_of_all(tree, length, lists);
    }
}

void stp_nearest_run(const stp_nearest *tree, size_t home, stp_nearest_list lists[STP_NEAREST_RUN])
{
    size_t length = run_length(tree, home);
    size_t first = home > FIRST_RUNS ? home - FIRST_RUNS : 0;
    size_t last = home + FIRST_RUNS < tree->run_count ? home + FIRST_RUNS : tree->run_count - 1;
    for (size_t i = 0; i < length; i++)
        lists[i].count = 0;
    scan_run_for_all(tree, home, 0.0f, home, length, lists);
    for (size_t r = first; r <= last; r++)
        if (r != home)
            scan_run_for_all(tree, r, 0.0f, home, length, lists);
    walk(tree, home, first, last, lists);
}
