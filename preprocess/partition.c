/* Orders points so that patches, and the groups inside them, are runs of neighbours. */
#include "preprocess/partition.h"

#include "preprocess/pieces.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* Sets larger than this are split by position alone. */
#define NORMAL_SPLIT_COUNT 512u
/* Normals that differ by more than this on an axis do not share a patch. */
#define NORMAL_EXTENT 1.1f
/* Fewer points a sheet, on average, are a thicket; of two sheets never. */
#define THICKET_POINTS 4u
/* How far apart, in box diagonals, a normal's unit counts when groups inside a patch are made. */
#define NORMAL_WEIGHT 0.5f

static float key_of(const stp_place *p, int axis)
{
    return p->key[axis];
}

static bool before(const stp_place *a, const stp_place *b, int axis)
{
    float ka = key_of(a, axis);
    float kb = key_of(b, axis);
    return ka < kb || (ka == kb && a->index < b->index);
}

static void swap(stp_place *a, stp_place *b)
{
    stp_place t = *a;
    *a = *b;
    *b = t;
}

/* Quickselect: afterwards the first n places are those with the n least keys. */
static void select_first(stp_place *places, uint32_t count, uint32_t n, int axis)
{
    uint32_t low = 0;
    uint32_t high = count;
    while (high - low > 1 && n > low && n < high) {
        uint32_t middle = low + (high - low) / 2;
        /* median of three as the pivot, moved to the end */
        if (before(&places[middle], &places[low], axis))
            swap(&places[middle], &places[low]);
        if (before(&places[high - 1], &places[low], axis))
            swap(&places[high - 1], &places[low]);
        if (before(&places[middle], &places[high - 1], axis))
            swap(&places[middle], &places[high - 1]);
        stp_place pivot = places[high - 1];
        uint32_t store = low;
        for (uint32_t i = low; i < high - 1; i++)
            if (before(&places[i], &pivot, axis))
                swap(&places[i], &places[store++]);
        swap(&places[store], &places[high - 1]);
        if (n <= store)
            high = store;
        else
            low = store + 1;
    }
}

static void extents(const stp_place *places, uint32_t count, float low[6], float high[6])
{
    for (int axis = 0; axis < 6; axis++) {
        low[axis] = INFINITY;
        high[axis] = -INFINITY;
    }
    for (uint32_t i = 0; i < count; i++) {
        for (int axis = 0; axis < 6; axis++) {
            float key = key_of(&places[i], axis);
            low[axis] = key < low[axis] ? key : low[axis];
            high[axis] = key > high[axis] ? key : high[axis];
        }
    }
}

static int longest(const float low[6], const float high[6], int first, int last)
{
    int best = first;
    for (int axis = first + 1; axis < last; axis++)
        if (high[axis] - low[axis] > high[best] - low[best])
            best = axis;
    return best;
}

/* Axis along which a set inside a patch is halved: positions, or normals scaled by the diagonal. */
static int group_axis(const stp_place *places, uint32_t count)
{
    float low[6], high[6];
    extents(places, count, low, high);
    float diagonal = 0.0f;
    for (int axis = 0; axis < 3; axis++)
        diagonal += (high[axis] - low[axis]) * (high[axis] - low[axis]);
    diagonal = sqrtf(diagonal);
    int p = longest(low, high, 0, 3);
    int n = longest(low, high, 3, 6);
    return (high[n] - low[n]) * diagonal * NORMAL_WEIGHT > high[p] - low[p] ? n : p;
}

/* Orders one patch: ends[0, n) are the ends of the groups of some level among its places. */
static void order_groups(stp_place *places, const uint32_t *bounds, uint32_t group_count)
{
    if (group_count < 2)
        return;
    uint32_t half = group_count / 2;
    uint32_t count = bounds[group_count] - bounds[0];
    uint32_t at = bounds[half] - bounds[0];
    select_first(places, count, at, group_axis(places, count));
    order_groups(places, bounds, half);
    order_groups(places + at, bounds + half, group_count - half);
}

/* Orders the samples under one of level 1 along an axis of their surface: the file stores what is
 * left of a guess from those before, and it need not store on which side it is. */
static void order_family(stp_place *places, uint32_t count)
{
    float normal[3] = {0.0f, 0.0f, 0.0f};
    int main_axis = 0;
    for (uint32_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++)
            normal[axis] += key_of(&places[i], 3 + axis);
    for (int axis = 1; axis < 3; axis++)
        if (fabsf(normal[axis]) > fabsf(normal[main_axis]))
            main_axis = axis;
    int along = (main_axis + 1) % 3;
    for (uint32_t i = 1; i < count; i++)
        for (uint32_t j = i; j > 0 && before(&places[j], &places[j - 1], along); j--)
            swap(&places[j], &places[j - 1]);
}

/* Ends of the level's groups in terms of level-0 samples, and ordering, coarse to fine. */
static void order_patch(stp_place *places, uint32_t count)
{
    unsigned counts[STP_LEVEL_COUNT] = {count};
    for (int level = 1; level < STP_LEVEL_COUNT; level++)
        counts[level] = stp_level_count_above(counts[level - 1]);
    uint32_t coarse[STP_PATCH_SAMPLES + 1];
    uint32_t first[STP_PATCH_SAMPLES + 1]; /* first level-0 sample of each level-1 sample */
    for (unsigned j = 0; j <= counts[1]; j++)
        first[j] = stp_level_children_begin(j, counts[1], counts[0]);
    for (unsigned j = 0; j <= counts[2]; j++)
        coarse[j] = first[stp_level_children_begin(j, counts[2], counts[1])];
    order_groups(places, coarse, counts[2]);
    for (unsigned j = 0; j < counts[2]; j++) {
        unsigned begin = stp_level_children_begin(j, counts[2], counts[1]);
        unsigned end = stp_level_children_begin(j + 1, counts[2], counts[1]);
        order_groups(places + first[begin], first + begin, end - begin);
    }
    for (unsigned j = 0; j < counts[1]; j++)
        order_family(places + first[j], first[j + 1] - first[j]);
}

/* Moves the places for which the predicate holds to the front; returns their number. */
static uint32_t gather(stp_place *places, uint32_t count, int axis, float limit)
{
    uint32_t front = 0;
    for (uint32_t i = 0; i < count; i++)
        if (key_of(&places[i], axis) < limit)
            swap(&places[i], &places[front++]);
    return front;
}

/* Places of the least sheet number to the front; 0 or count if there is one sheet only. */
static uint32_t gather_sheet(stp_place *places, uint32_t count)
{
    uint32_t least = UINT32_MAX;
    for (uint32_t i = 0; i < count; i++)
        least = places[i].sheet < least ? places[i].sheet : least;
    uint32_t front = 0;
    for (uint32_t i = 0; i < count; i++)
        if (places[i].sheet == least)
            swap(&places[i], &places[front++]);
    return front;
}

static int compare_sheets(const void *a, const void *b)
{
    uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
    return p < q ? -1 : p > q;
}

static bool one_sheet(const stp_place *places, uint32_t count)
{
    uint32_t differ = 0;
    for (uint32_t i = 1; i < count; i++)
        differ |= places[i].sheet ^ places[0].sheet;
    return differ == 0;
}

/* So many crumbs of surface that patches of a sample or two would keep nothing apart. */
static bool are_crumbs(uint32_t parts, uint32_t count)
{
    return parts > 2 && parts * THICKET_POINTS > count;
}

static bool is_thicket(const stp_place *places, uint32_t count)
{
    uint32_t sheets[NORMAL_SPLIT_COUNT];
    uint32_t distinct = 1;
    for (uint32_t i = 0; i < count; i++)
        sheets[i] = places[i].sheet;
    // cppcheck-suppress uninitvar ; the count that are sorted have been set
    qsort(sheets, count, sizeof *sheets, compare_sheets);
    for (uint32_t i = 1; i < count; i++)
        distinct += sheets[i] != sheets[i - 1];
    return are_crumbs(distinct, count);
}

/* Places of the first piece to the front; 0 if there is one only, or nothing but crumbs. */
static uint32_t gather_piece(stp_place *places, uint32_t count)
{
    uint8_t piece[STP_PATCH_SAMPLES];
    unsigned pieces = stp_pieces_number(places, count, piece);
    if (pieces == 1 || are_crumbs(pieces, count))
        return 0;
    uint32_t front = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (piece[i] == 0) {
            uint8_t other = piece[front];
            piece[front] = 0;
            piece[i] = other;
            swap(&places[i], &places[front++]);
        }
    }
    return front;
}

typedef struct runs {
    uint32_t *ends;
    uint32_t count;
} runs;

static void split(stp_place *places, uint32_t offset, uint32_t count, runs *out)
{
    float low[6], high[6];
    uint32_t at = 0;
    extents(places, count, low, high);
    if (count <= NORMAL_SPLIT_COUNT && count > 1) {
        int axis = longest(low, high, 3, 6);
        if (high[axis] - low[axis] > NORMAL_EXTENT)
            at = gather(places, count, axis, 0.5f * (low[axis] + high[axis]));
        if ((at == 0 || at == count) && !one_sheet(places, count) && !is_thicket(places, count))
            at = gather_sheet(places, count);
        if (at == count)
            at = 0;
    }
    if (at == 0 && count > STP_PATCH_SAMPLES) {
        uint32_t patches = (count + STP_PATCH_SAMPLES - 1) / STP_PATCH_SAMPLES;
        uint32_t half = patches / 2;
        /* full patches in large sets, even ones where a set does not fill its last */
        at = patches > 8 ? half * STP_PATCH_SAMPLES : (uint32_t)((uint64_t)count * half / patches);
        select_first(places, count, at, longest(low, high, 0, 3));
    }
    if (at == 0 && count > 1)
        at = gather_piece(places, count);
    if (at == 0) {
        order_patch(places, count);
        out->ends[out->count++] = offset + count;
        return;
    }
    split(places, offset, at, out);
    split(places + at, offset + at, count - at, out);
}

/* ends is written through runs: NOLINTNEXTLINE(readability-non-const-parameter) */
uint32_t stp_partition(stp_place *places, uint32_t count, uint32_t *ends)
{
    runs out = {.ends = ends};
    if (count > 0)
        split(places, 0, count, &out);
    return out.count;
}
