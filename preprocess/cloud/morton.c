/* Points along the Morton curve of their bounding cube. */
#include "preprocess/cloud/morton.h"

#include "base/memory.h"
#include "base/prefix_sum.h"

#include <stdlib.h>
#include <string.h>

#define BLOCK 65536u
#define CODE_BITS (3 * STP_MORTON_BITS)
/* Points are parted in place by digits of 6 bits: 4 grid cells per axis. Each part that is being
 * filled keeps a page in memory, so more parts at a time exceed a small memory limit. */
#define PART_BITS 6
#define PART_COUNT (1u << PART_BITS)
/* Memory is asked for what a part receives after so many more points. */
#define MOVES_AHEAD 8u
/* Parts up to this size are sorted by keys outside the point array. */
#define KEYED_POINTS 131072u
/* Digits of the radix sort of keys. */
#define DIGIT_BITS 11
#define DIGIT_COUNT 2048u
/* Parts up to this size: a comparison sort is faster. */
#define SMALL_PART 256u
/* Up to this many keys: insertion is faster still. */
#define FEW_KEYS 32u

typedef struct key {
    uint64_t code;
    uint32_t index; /* of the point before sorting */
} key;

/* The sort order of points: by code, or by source. */
typedef struct order {
    stp_morton_grid grid;
    bool by_source;
} order;

/* A worker's scratch memory for KEYED_POINTS points. */
typedef struct room {
    key *keys, *other;
    stp_cloud_point *sorted;
    stp_spill *spill; /* where the points lie */
} room;

typedef struct boxing {
    const stp_cloud_point *points;
    uint64_t count;
    stp_dbox *boxes; /* of each block */
    stp_spill *spill;
} boxing;

typedef struct sorter {
    stp_cloud_point *points;
    uint64_t count;
    order order;
    uint32_t (*histograms)[PART_COUNT]; /* of each block */
    uint64_t begin[PART_COUNT + 1];     /* of the parts */
    room *rooms;                        /* by worker */
    stp_spill *spill;
} sorter;

/* Spreads 21 bits: puts two zeros between neighbouring bits. */
static uint64_t spread(uint64_t v)
{
    v &= 0x1fffff;
    v = (v | v << 32) & 0x1f00000000ffff;
    v = (v | v << 16) & 0x1f0000ff0000ff;
    v = (v | v << 8) & 0x100f00f00f00f00f;
    v = (v | v << 4) & 0x10c30c30c30c30c3;
    return (v | v << 2) & 0x1249249249249249;
}

static uint64_t grid_coordinate(double value, double origin, double scale)
{
    double cell = (value - origin) * scale;
    double last = (double)((1 << STP_MORTON_BITS) - 1);
    return (uint64_t)(cell > 0.0 ? stp_min(cell, last) : 0.0); /* NaN (endless box) gives 0 */
}

uint64_t stp_morton_code(const stp_morton_grid *grid, stp_dvec3 p)
{
    return spread(grid_coordinate(p.x, grid->low.x, grid->scale)) |
           spread(grid_coordinate(p.y, grid->low.y, grid->scale)) << 1 |
           spread(grid_coordinate(p.z, grid->low.z, grid->scale)) << 2;
}

static int compare_places(const void *a, const void *b)
{
    const stp_morton_place *x = a, *y = b;
    if (x->code != y->code)
        return x->code < y->code ? -1 : 1;
    return x->index < y->index ? -1 : x->index > y->index;
}

void stp_morton_order(stp_morton_place *places, uint32_t count)
{
    if (count > 0)
        qsort(places, count, sizeof *places, compare_places);
}

stp_morton_grid stp_morton_grid_of(const stp_dbox *box)
{
    stp_dvec3 size = stp_dvec3_sub(box->max, box->min);
    double side = fmax(size.x, fmax(size.y, size.z));
    double scale = side > 0.0 ? (double)(1 << STP_MORTON_BITS) / side : 0.0;
    return (stp_morton_grid){box->min, isfinite(scale) ? scale : 0.0};
}

static uint64_t code_of(const order *o, const stp_cloud_point *p)
{
    return o->by_source ? p->source : stp_morton_code(&o->grid, p->position);
}

static uint32_t part_of(const order *o, const stp_cloud_point *p, unsigned shift)
{
    return (uint32_t)(code_of(o, p) >> shift) & (PART_COUNT - 1);
}

/* Turns counts into the parts' begins. */
static void place_parts(uint64_t begin[PART_COUNT + 1])
{
    uint64_t sum = 0;
    for (uint32_t part = 0; part <= PART_COUNT; part++) {
        uint64_t here = part < PART_COUNT ? begin[part] : 0;
        begin[part] = sum;
        sum += here;
    }
}

/* Moves every point to its part, in place. Each swap brings one point to its place (McIlroy, Bostic
 * and McIlroy 1993). */
static void move_to_parts(stp_cloud_point *points, const order *o, unsigned shift,
                          const uint64_t begin[PART_COUNT + 1], stp_spill *spill)
{
    uint64_t next[PART_COUNT], moved = 0;
    memcpy(next, begin, sizeof next);
    for (uint32_t part = 0; part < PART_COUNT; part++) {
        while (next[part] < begin[part + 1]) {
            stp_cloud_point moving = points[next[part]];
            for (uint32_t to = part_of(o, &moving, shift); to != part;
                 to = part_of(o, &moving, shift)) {
                stp_cloud_point there = points[next[to]];
                points[next[to]++] = moving;
                __builtin_prefetch(&points[next[to]] + MOVES_AHEAD, 1);
                moving = there;
                stp_cloud_step(spill, moved++);
            }
            points[next[part]++] = moving;
        }
    }
}

static int compare_keys(const void *a, const void *b)
{
    const key *p = a;
    const key *q = b;
    return p->code < q->code ? -1 : p->code > q->code;
}

/* Sorts by the digit of bits from `shift` on, stably. */
static void sort_digit(const key *from, key *to, uint32_t count, unsigned shift)
{
    size_t place[DIGIT_COUNT] = {0};
    for (uint32_t i = 0; i < count; i++)
        place[from[i].code >> shift & (DIGIT_COUNT - 1)]++;
    (void)stp_prefix_sum(place, DIGIT_COUNT);
    for (uint32_t i = 0; i < count; i++)
        to[place[from[i].code >> shift & (DIGIT_COUNT - 1)]++] = from[i];
}

static void insertion_sort(key *keys, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        const key moving = keys[i];
        uint32_t at = i;
        for (; at > 0 && moving.code < keys[at - 1].code; at--)
            keys[at] = keys[at - 1];
        keys[at] = moving;
    }
}

/* Sorts by two digits from bit `top` down, on which few keys are equal, then those by the bits
 * below. Bits from `top` on are equal. */
static void sort_keys(key *keys, key *other, uint32_t count, unsigned top)
{
    const unsigned low = top > 2 * DIGIT_BITS ? top - 2 * DIGIT_BITS : 0;
    if (count <= FEW_KEYS) {
        insertion_sort(keys, count);
        return;
    }
    if (count <= SMALL_PART) {
        qsort(keys, count, sizeof *keys, compare_keys);
        return;
    }
    sort_digit(keys, other, count, low);
    sort_digit(other, keys, count, low + DIGIT_BITS);
    for (uint32_t begin = 0, end; begin < count && low > 0; begin = end) {
        for (end = begin + 1; end < count && keys[end].code >> low == keys[begin].code >> low;
             end++)
            ;
        sort_keys(keys + begin, other, end - begin, low);
    }
}

static int compare_points(const void *a, const void *b)
{
    const stp_cloud_point *p = a;
    const stp_cloud_point *q = b;
    if (p->position.x != q->position.x)
        return p->position.x < q->position.x ? -1 : 1;
    if (p->position.y != q->position.y)
        return p->position.y < q->position.y ? -1 : 1;
    if (p->position.z != q->position.z)
        return p->position.z < q->position.z ? -1 : 1;
    return p->source < q->source ? -1 : p->source > q->source;
}

static void sort_range(stp_cloud_point *points, uint64_t count, const order *o, unsigned top,
                       const room *r);

/* Sorts points with equal codes. */
static void sort_ties(stp_cloud_point *points, uint64_t count, const room *r)
{
    if (count <= STP_CELL_POINTS) {
        qsort(points, count, sizeof *points, compare_points);
        return;
    }
    stp_dbox box = stp_dbox_empty();
    for (uint64_t i = 0; i < count; i++) {
        stp_cloud_step(r->spill, i);
        stp_dbox_add(&box, points[i].position);
    }
    order own = {.grid = stp_morton_grid_of(&box)};
    own.by_source = own.grid.scale == 0.0;
    sort_range(points, count, &own, CODE_BITS, r);
}

/* Sorts by keys in the worker's scratch memory, then sorts ties. */
static void sort_keyed(stp_cloud_point *points, uint32_t count, const order *o, unsigned top,
                       const room *r)
{
    for (uint32_t i = 0; i < count; i++)
        r->keys[i] = (key){code_of(o, &points[i]), i};
    sort_keys(r->keys, r->other, count, top);
    for (uint32_t i = 0; i < count; i++)
        r->sorted[i] = points[r->keys[i].index];
    memcpy(points, r->sorted, count * sizeof *points);
    uint32_t pile = 0, pile_end = 0; /* at most one run of ties is larger than a cell */
    for (uint32_t begin = 0, end; begin < count && !o->by_source; begin = end) {
        for (end = begin + 1; end < count && r->keys[end].code == r->keys[begin].code; end++)
            ;
        if (end - begin > STP_CELL_POINTS)
            pile = begin, pile_end = end;
        else if (end - begin > 1)
            sort_ties(points + begin, end - begin, r);
    }
    if (pile_end > pile)
        sort_ties(points + pile, pile_end - pile, r); /* last: it uses the same scratch */
}

_Static_assert(KEYED_POINTS < 2 * (STP_CELL_POINTS + 1), "two piles");

/* Sorts points whose codes are equal from bit `top` on. */
static void sort_range(stp_cloud_point *points, uint64_t count, const order *o, unsigned top,
                       const room *r)
{
    if (count < 2)
        return;
    stp_spill_relieve(r->spill);
    if (count <= KEYED_POINTS) {
        sort_keyed(points, (uint32_t)count, o, top, r);
        return;
    }
    if (top == 0) {
        sort_ties(points, count, r);
        return;
    }
    uint64_t begin[PART_COUNT + 1] = {0};
    unsigned shift = top > PART_BITS ? top - PART_BITS : 0;
    for (uint64_t i = 0; i < count; i++) {
        stp_cloud_step(r->spill, i);
        begin[part_of(o, &points[i], shift)]++;
    }
    place_parts(begin);
    move_to_parts(points, o, shift, begin, r->spill);
    for (uint32_t part = 0; part < PART_COUNT; part++)
        sort_range(points + begin[part], begin[part + 1] - begin[part], o, shift, r);
}

static uint32_t block_count(uint64_t count)
{
    return (uint32_t)((count + BLOCK - 1) / BLOCK);
}

static uint64_t block_end(uint64_t count, uint64_t begin)
{
    return count - begin < BLOCK ? count : begin + BLOCK;
}

static stp_status find_box(void *context, size_t block, unsigned worker, stp_error *err)
{
    const boxing *b = context;
    const uint64_t begin = (uint64_t)block * BLOCK;
    stp_spill_relieve(b->spill);
    (void)worker;
    (void)err;
    b->boxes[block] = stp_points_box(b->points + begin, block_end(b->count, begin) - begin);
    return STP_OK;
}

stp_status stp_morton_box(stp_dbox *box, const stp_cloud_point *points, uint64_t count,
                          stp_spill *spill, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    boxing b = {.points = points, .count = count, .spill = spill};
    STP_TRY(stp_alloc(&b.boxes, block_count(count), sizeof *b.boxes, "boxes", err));
    STP_TRY(stp_pool_run(pool, block_count(count), find_box, &b, err));
    *box = stp_dbox_empty();
    for (uint32_t block = 0; block < block_count(count); block++)
        stp_dbox_join(box, &b.boxes[block]);
done:
    free(b.boxes);
    return status;
}

static stp_status count_parts(void *context, size_t block, unsigned worker, stp_error *err)
{
    sorter *s = context;
    const uint64_t begin = (uint64_t)block * BLOCK;
    stp_spill_relieve(s->spill);
    (void)worker;
    (void)err;
    for (uint64_t i = begin; i < block_end(s->count, begin); i++)
        s->histograms[block][part_of(&s->order, &s->points[i], CODE_BITS - PART_BITS)]++;
    return STP_OK;
}

static stp_status make_room(room *r, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&r->keys, KEYED_POINTS, sizeof *r->keys, "sort keys", err));
    STP_TRY(stp_alloc(&r->other, KEYED_POINTS, sizeof *r->other, "sort keys", err));
    STP_TRY(stp_alloc(&r->sorted, KEYED_POINTS, sizeof *r->sorted, "points", err));
done:
    return status;
}

static stp_status sort_part(void *context, size_t part, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    sorter *s = context;
    room *r = &s->rooms[worker];
    const uint64_t begin = s->begin[part], count = s->begin[part + 1] - begin;
    r->spill = s->spill;
    if (count > 1 && !r->sorted)
        STP_TRY(make_room(r, err));
    sort_range(s->points + begin, count, &s->order, CODE_BITS - PART_BITS, r);
done:
    return status;
}

static void add_blocks(sorter *s)
{
    for (uint32_t block = 0; block < block_count(s->count); block++)
        for (uint32_t part = 0; part < PART_COUNT; part++)
            s->begin[part] += s->histograms[block][part];
    place_parts(s->begin);
}

stp_status stp_morton_sort(stp_cloud_point *points, uint64_t count, stp_spill *spill,
                           const stp_dbox *box, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    sorter s = {.points = points,
                .count = count,
                .order = {.grid = stp_morton_grid_of(box)},
                .spill = spill};
    unsigned workers = stp_pool_thread_count(pool);
    const uint32_t blocks = block_count(count);
    STP_TRY(stp_alloc(&s.histograms, blocks, sizeof *s.histograms, "sort keys", err));
    STP_TRY(stp_alloc(&s.rooms, workers, sizeof *s.rooms, "sort keys", err));
    STP_TRY(stp_pool_run(pool, blocks, count_parts, &s, err));
    add_blocks(&s);
    move_to_parts(points, &s.order, CODE_BITS - PART_BITS, s.begin, spill);
    STP_TRY(stp_pool_run(pool, PART_COUNT, sort_part, &s, err));
done:
    for (unsigned i = 0; s.rooms && i < workers; i++) {
        free(s.rooms[i].keys);
        free(s.rooms[i].other);
        free(s.rooms[i].sorted);
    }
    free(s.rooms);
    free(s.histograms);
    return status;
}
