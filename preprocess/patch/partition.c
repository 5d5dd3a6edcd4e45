/* Orders points so that patches, and the groups inside them, are runs of neighbours. */
#include "preprocess/patch/partition.h"

#include "base/wide.h"
#include "preprocess/patch/pieces.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Sets larger than this are split by position alone. */
#define NORMAL_SPLIT_COUNT 512u
/* Places whose normals differ by more than this on an axis do not share a patch. */
#define NORMAL_EXTENT 1.1f
/* A set of more than two sheets with fewer points per sheet, on average, is a thicket. */
#define THICKET_POINTS 8u
/* How much a unit of normal counts, in box diagonals, when groups inside a patch are made. */
#define NORMAL_WEIGHT 0.5f

/* The sets that are halved: runs of `order`. */
typedef struct sets {
    const stp_place *places;
    uint32_t *order, *ends;
    uint64_t *keys; /* of a set while it is halved */
    uint32_t most;  /* of a patch */
    uint32_t run_count;
} sets;

static float key_of(const sets *s, uint32_t index, int axis)
{
    return s->places[index].key[axis];
}

/* A place's key on an axis as an integer of the same order, followed by its index. No two are
 * equal. */
static uint64_t packed_key(const sets *s, uint32_t index, int axis)
{
    float key = key_of(s, index, axis) + 0.0f; /* -0 becomes 0 */
    uint32_t bits;
    memcpy(&bits, &key, sizeof bits);
    bits ^= bits >> 31 ? UINT32_MAX : 1u << 31;
    return (uint64_t)bits << 32 | index;
}

static void swap_keys(uint64_t *a, uint64_t *b)
{
    uint64_t t = *a;
    *a = *b;
    *b = t;
}

static void swap(uint32_t *a, uint32_t *b)
{
    uint32_t t = *a;
    *a = *b;
    *b = t;
}

/* Quickselect: moves the n least keys to the front. */
static void select_keys(uint64_t *keys, uint32_t count, uint32_t n)
{
    uint32_t low = 0;
    uint32_t high = count;
    while (high - low > 1 && n > low && n < high) {
        uint32_t middle = low + (high - low) / 2;
        /* median of three as the pivot, moved to the end */
        if (keys[middle] < keys[low])
            swap_keys(&keys[middle], &keys[low]);
        if (keys[high - 1] < keys[low])
            swap_keys(&keys[high - 1], &keys[low]);
        if (keys[middle] < keys[high - 1])
            swap_keys(&keys[middle], &keys[high - 1]);
        uint64_t pivot = keys[high - 1];
        uint32_t store = low;
        for (uint32_t i = low; i < high - 1; i++) { /* no branch: which side is a coin toss */
            uint64_t key = keys[i];
            keys[i] = keys[store];
            keys[store] = key;
            store += key < pivot;
        }
        swap_keys(&keys[store], &keys[high - 1]);
        if (n <= store)
            high = store;
        else
            low = store + 1;
    }
}

/* Moves the places with the n least keys on the axis to the front. */
static void select_first(sets *s, uint32_t *order, uint32_t count, uint32_t n, int axis)
{
    for (uint32_t i = 0; i < count; i++)
        s->keys[i] = packed_key(s, order[i], axis);
    select_keys(s->keys, count, n);
    for (uint32_t i = 0; i < count; i++)
        order[i] = (uint32_t)s->keys[i];
}

/* A place's numbers, which are taken together: the keys are the first. */
#define LANES 8
typedef float lanes __attribute__((vector_size(4 * LANES)));
typedef int32_t bits __attribute__((vector_size(4 * LANES)));
_Static_assert(sizeof(stp_place) == sizeof(lanes), "a place fills the lanes");

/* The extents along the six axes. */
STP_WIDE
static void extents(const stp_place *places, const uint32_t *order, uint32_t count, float low[6],
                    float high[6])
{
    lanes least = (lanes){0} + INFINITY, most = -least;
    for (uint32_t i = 0; i < count; i++) {
        lanes key;
        memcpy(&key, &places[order[i]], sizeof key);
        const bits below = key<least, above = key> most;
        least = (lanes)((below & (bits)key) | (~below & (bits)least));
        most = (lanes)((above & (bits)key) | (~above & (bits)most));
    }
    memcpy(low, &least, 6 * sizeof *low);
    memcpy(high, &most, 6 * sizeof *high);
}

static int longest(const float low[6], const float high[6], int first, int last)
{
    int best = first;
    for (int axis = first + 1; axis < last; axis++)
        if (high[axis] - low[axis] > high[best] - low[best])
            best = axis;
    return best;
}

/* The axis along which a set inside a patch is halved: of positions, or of normals scaled by the
 * diagonal. */
static int group_axis(const sets *s, const uint32_t *order, uint32_t count)
{
    float low[6], high[6];
    extents(s->places, order, count, low, high);
    float diagonal = 0.0f;
    for (int axis = 0; axis < 3; axis++)
        diagonal += (high[axis] - low[axis]) * (high[axis] - low[axis]);
    diagonal = sqrtf(diagonal);
    int p = longest(low, high, 0, 3);
    int n = longest(low, high, 3, 6);
    return (high[n] - low[n]) * diagonal * NORMAL_WEIGHT > high[p] - low[p] ? n : p;
}

/* Orders the groups of one level: bounds[0, group_count] are their ends. */
static void order_groups(sets *s, uint32_t *order, const uint32_t *bounds, uint32_t group_count)
{
    if (group_count < 2)
        return;
    uint32_t half = group_count / 2;
    uint32_t count = bounds[group_count] - bounds[0];
    uint32_t at = bounds[half] - bounds[0];
    select_first(s, order, count, at, group_axis(s, order, count));
    order_groups(s, order, bounds, half);
    order_groups(s, order + at, bounds + half, group_count - half);
}

/* Orders the samples below one level-1 sample along an axis of their surface. The file stores a
 * sample's difference from a guess by the samples before. In this order the file need not store on
 * which side of the guess the sample lies. */
static void order_family(const sets *s, uint32_t *order, uint32_t count)
{
    float normal[3] = {0.0f, 0.0f, 0.0f};
    int main_axis = 0;
    uint64_t keys[4];
    for (uint32_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++)
            normal[axis] += key_of(s, order[i], 3 + axis);
    for (int axis = 1; axis < 3; axis++)
        if (fabsf(normal[axis]) > fabsf(normal[main_axis]))
            main_axis = axis;
    for (uint32_t i = 0; i < count; i++) {
        keys[i] = packed_key(s, order[i], (main_axis + 1) % 3);
        for (uint32_t j = i; j > 0 && keys[j] < keys[j - 1]; j--)
            swap_keys(&keys[j], &keys[j - 1]);
    }
    for (uint32_t i = 0; i < count; i++)
        order[i] = (uint32_t)keys[i];
}

/* Orders a patch, coarse levels first. Groups end at level-0 samples. */
static void order_patch(sets *s, uint32_t *order, uint32_t count)
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
    order_groups(s, order, coarse, counts[2]);
    for (unsigned j = 0; j < counts[2]; j++) {
        unsigned begin = stp_level_children_begin(j, counts[2], counts[1]);
        unsigned end = stp_level_children_begin(j + 1, counts[2], counts[1]);
        order_groups(s, order + first[begin], first + begin, end - begin);
    }
    for (unsigned j = 0; j < counts[1]; j++)
        order_family(s, order + first[j], first[j + 1] - first[j]);
}

/* Moves the places below the limit to the front. Returns their number. */
static uint32_t gather(const sets *s, uint32_t *order, uint32_t count, int axis, float limit)
{
    uint32_t front = 0;
    for (uint32_t i = 0; i < count; i++)
        if (key_of(s, order[i], axis) < limit)
            swap(&order[i], &order[front++]);
    return front;
}

/* Moves the places of the least sheet number to the front. Returns their number; count if there is
 * only one sheet. */
static uint32_t gather_sheet(const sets *s, uint32_t *order, uint32_t count)
{
    uint32_t least = UINT32_MAX;
    for (uint32_t i = 0; i < count; i++)
        least = s->places[order[i]].sheet < least ? s->places[order[i]].sheet : least;
    uint32_t front = 0;
    for (uint32_t i = 0; i < count; i++)
        if (s->places[order[i]].sheet == least)
            swap(&order[i], &order[front++]);
    return front;
}

static int compare_sheets(const void *a, const void *b)
{
    uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
    return p < q ? -1 : p > q;
}

static bool one_sheet(const sets *s, const uint32_t *order, uint32_t count)
{
    uint32_t differ = 0;
    for (uint32_t i = 1; i < count; i++)
        differ |= s->places[order[i]].sheet ^ s->places[order[0]].sheet;
    return differ == 0;
}

/* Whether the surface is in so many crumbs that patches of a sample or two would separate nothing.
 */
static bool are_crumbs(uint32_t parts, uint32_t count)
{
    return parts > 2 && parts * THICKET_POINTS > count;
}

static bool is_thicket(const sets *s, const uint32_t *order, uint32_t count)
{
    uint32_t sheets[NORMAL_SPLIT_COUNT];
    uint32_t distinct = 1;
    for (uint32_t i = 0; i < count; i++)
        sheets[i] = s->places[order[i]].sheet;
    // cppcheck-suppress uninitvar ; the count that are sorted have been set
    qsort(sheets, count, sizeof *sheets, compare_sheets);
    for (uint32_t i = 1; i < count; i++)
        distinct += sheets[i] != sheets[i - 1];
    return !(sheets[count - 1] & STP_SHEET_APART) && are_crumbs(distinct, count);
}

/* Moves the places of the first piece to the front. Returns their number; 0 if there is only one
 * piece, or only crumbs. */
static uint32_t gather_piece(const sets *s, uint32_t *order, uint32_t count)
{
    uint64_t first = 0;
    unsigned pieces = stp_pieces_count(s->places, order, count, &first);
    if (pieces == 1 || are_crumbs(pieces, count))
        return 0;
    uint32_t front = 0;
    for (uint32_t i = 0; i < count; i++)
        if (first >> i & 1)
            swap(&order[i], &order[front++]);
    return front;
}

/* Moves the places that are split off to the front. Returns their number; 0: the set is one patch.
 */
static uint32_t split_at(sets *s, uint32_t *order, uint32_t count)
{
    bool small = count <= NORMAL_SPLIT_COUNT;
    float low[6], high[6];
    uint32_t at = 0;
    extents(s->places, order, count, low, high);
    if (small && count > 1) {
        int axis = longest(low, high, 3, 6);
        if (high[axis] - low[axis] > NORMAL_EXTENT)
            at = gather(s, order, count, axis, 0.5f * (low[axis] + high[axis]));
        if ((at == 0 || at == count) && !one_sheet(s, order, count) && !is_thicket(s, order, count))
            at = gather_sheet(s, order, count);
        if (at == count)
            at = 0;
    }
    if (at == 0 && s->most > 0 && count > s->most) {
        uint32_t patches = (count + s->most - 1) / s->most;
        uint32_t half = patches / 2;
        /* large sets: full patches; small sets: patches of even size */
        at = patches > 8 ? half * s->most : (uint32_t)((uint64_t)count * half / patches);
        select_first(s, order, count, at, longest(low, high, 0, 3));
    }
    return at == 0 && count > 1 ? gather_piece(s, order, count) : at;
}

static void split(sets *s, uint32_t *order, uint32_t count)
{
    uint32_t at = split_at(s, order, count);
    if (at == 0) {
        order_patch(s, order, count);
        s->ends[s->run_count++] = (uint32_t)(order - s->order) + count;
        return;
    }
    split(s, order, at);
    split(s, order + at, count - at);
}

uint32_t stp_partition(const stp_place *places, uint32_t count, uint32_t most, uint32_t *order,
                       uint64_t *scratch, uint32_t *ends)
{
    sets s = {.places = places, .order = order, .most = most};
    s.ends = ends;
    s.keys = scratch;
    for (uint32_t i = 0; i < count; i++)
        order[i] = i;
    if (count > 0)
        split(&s, order, count);
    return s.run_count;
}
