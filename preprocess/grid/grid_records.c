/* Keeps the records of a grid that this rank read, and gives them to the ranks that need them. */
#include "preprocess/grid/grid_records.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define WORD 64u
/* Records that all ranks together give at once, and each at least. Limits memory. */
#define GIVEN_RECORDS (UINT32_C(1) << 22)
#define GIVEN_RECORDS_LEAST 4096u
#define GIVEN_RECORDS_MOST (UINT32_C(1) << 18)
/* Tiles whose normals may need a sample. */
#define TAKERS_MOST 4u

/* What ranks give at once. */
typedef struct giver {
    const stp_grid_records *records;
    stp_height_grid *grid;
    const uint32_t *owners;
    stp_ranks *ranks;
    size_t item_bytes;
    size_t *sent, *received, *ends; /* by rank */
    stp_bytes out, in;
} giver;

stp_status stp_grid_records_create(stp_grid_records *out, const stp_scan_raster *whole,
                                   stp_grid_part *parts, size_t part_count, stp_rank_part records,
                                   bool bent, bool coloured, stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    stp_grid_records r = {.whole = *whole,
                          .parts = parts,
                          .part_count = part_count,
                          .overlap = stp_grid_parts_overlap(parts, part_count),
                          .begin = records.begin,
                          .end = records.end,
                          .spill = spill};
    const size_t count = records.end - records.begin;
    STP_TRY(stp_spill_alloc(spill, &r.z, count, sizeof *r.z, "heights", err));
    if (bent || r.overlap) /* whose box is known when it is known who has what */
        STP_TRY(stp_spill_alloc(spill, &r.xy, count, sizeof *r.xy, "places", err));
    if (coloured)
        STP_TRY(stp_spill_alloc(spill, &r.rgb, count, sizeof *r.rgb, "colours", err));
    *out = r;
    r = (stp_grid_records){0};
done:
    stp_grid_records_clear(&r);
    return status;
}

void stp_grid_records_set(stp_grid_records *r, uint64_t record, const stp_point *point)
{
    const uint64_t i = record - r->begin;
    r->z[i] = point->position.z;
    if (r->xy) {
        r->xy[i][0] = point->position.x;
        r->xy[i][1] = point->position.y;
    }
    for (int c = 0; r->rgb && c < 3; c++)
        r->rgb[i][c] = point->rgb[c];
    r->count++;
}

void stp_grid_records_leave_out(stp_grid_records *r, uint64_t record)
{
    r->z[record - r->begin] = NAN;
}

/* The place in the whole of a record. *part: the part of the record before, or 0. */
static uint64_t place_of(const stp_grid_records *r, size_t *part, uint64_t record)
{
    const stp_grid_part *p = &r->parts[*part];
    for (; record >= p->first + p->count; p = &r->parts[*part])
        ++*part;
    return stp_grid_part_place(p, &r->whole, record - p->first);
}

/* Removes samples at places that have one, marks the others', and finds their box. */
static stp_status sift_own(stp_grid_records *r, uint64_t *there, stp_bytes *twice, stp_dbox *box,
                           stp_error *err)
{
    stp_status status = STP_OK;
    size_t part = 0;
    *box = stp_dbox_empty();
    for (uint64_t record = r->begin; record < r->end; record++) {
        double *z = &r->z[record - r->begin];
        if (isnan(*z))
            continue;
        const uint64_t place = place_of(r, &part, record), bit = UINT64_C(1) << place % WORD;
        if (there[place / WORD] & bit) {
            const uint32_t number = (uint32_t)record;
            STP_TRY(stp_bytes_append(twice, &number, sizeof number, err));
            *z = NAN;
            r->count--;
            continue;
        }
        there[place / WORD] |= bit;
        const double *xy = r->xy[record - r->begin];
        stp_dbox_add(box, (stp_dvec3){xy[0], xy[1], *z});
    }
done:
    return status;
}

stp_status stp_grid_records_sift(stp_grid_records *r, stp_ranks *ranks, stp_bytes *twice,
                                 stp_dbox *box, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *there = NULL;
    const uint64_t words = (uint64_t)r->whole.columns * r->whole.rows / WORD + 1;
    if (!r->overlap)
        return STP_OK;
    STP_TRY(stp_spill_alloc(r->spill, &there, words, sizeof *there, "marks", err));
    for (unsigned rank = 0; rank < ranks->count; rank++) {
        if (rank == ranks->self)
            STP_TRY(sift_own(r, there, twice, box, err));
        if (rank + 1 < ranks->count)
            STP_TRY(stp_ranks_broadcast(ranks, rank, there, words * sizeof *there, err));
    }
done:
    stp_spill_free(r->spill, there);
    return status;
}

stp_status stp_grid_records_count(const stp_grid_records *r, stp_height_grid *grid,
                                  stp_ranks *ranks, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *counts = NULL;
    size_t part = 0;
    const uint32_t tiles = stp_height_grid_tile_count(grid);
    STP_TRY(stp_alloc(&counts, tiles, sizeof *counts, "tiles", err));
    for (uint64_t record = r->begin; record < r->end; record++)
        if (!isnan(r->z[record - r->begin]))
            counts[stp_height_grid_tile_at(grid, place_of(r, &part, record))]++;
    STP_TRY(stp_ranks_sum(ranks, counts, tiles, err));
    for (uint32_t i = 0; i < tiles; i++)
        grid->tile_samples[i] = (uint32_t)counts[i];
done:
    free(counts);
    return status;
}

/* Lists the ranks that need the sample at a place, each once. Returns how many. */
static unsigned find_takers(const giver *g, uint64_t place, uint32_t takers[TAKERS_MOST])
{
    const stp_scan_raster *r = &g->grid->raster;
    const uint32_t reach = STP_GRID_REACH, side = STP_TILE_SIDE;
    const uint32_t at[2] = {(uint32_t)(place % r->columns), (uint32_t)(place / r->columns)};
    const uint32_t ends[2] = {r->columns - 1, r->rows - 1};
    uint32_t low[2], high[2];
    unsigned count = 0;
    for (int k = 0; k < 2; k++) {
        low[k] = (at[k] > reach ? at[k] - reach : 0) / side;
        high[k] = (ends[k] - at[k] > reach ? at[k] + reach : ends[k]) / side;
    }
    for (uint32_t row = low[1]; row <= high[1]; row++)
        for (uint32_t column = low[0]; column <= high[0]; column++) {
            const uint32_t owner = g->owners[row * g->grid->tile_columns + column];
            bool new = owner != STP_TILE_OF_NONE;
            for (unsigned i = 0; i < count; i++)
                new = new &&takers[i] != owner;
            if (new)
                takers[count++] = owner;
        }
    return count;
}

/* Puts a sample that a packet has at `from` into the grid. Around own tiles only heights matter. */
static void put(const giver *g, const uint8_t *from)
{
    uint32_t place;
    stp_height_grid *grid = g->grid;
    memcpy(&place, from, sizeof place);
    from += sizeof place;
    memcpy(&grid->z[place], from, sizeof *grid->z);
    from += sizeof *grid->z;
    if ((!grid->xy && !grid->rgb) ||
        g->owners[stp_height_grid_tile_at(grid, place)] != g->ranks->self)
        return;
    if (grid->xy) {
        memcpy(grid->xy[place], from, sizeof *grid->xy);
        from += sizeof *grid->xy;
    }
    if (grid->rgb)
        memcpy(grid->rgb[place], from, sizeof *grid->rgb);
}

/* Makes a packet's item of a record. */
static void pack(const giver *g, uint64_t record, uint64_t place, uint8_t *to)
{
    const stp_grid_records *r = g->records;
    const uint64_t i = record - r->begin;
    const uint32_t number = (uint32_t)place;
    memcpy(to, &number, sizeof number);
    to += sizeof number;
    memcpy(to, &r->z[i], sizeof *r->z);
    to += sizeof *r->z;
    if (g->grid->xy) {
        memcpy(to, r->xy[i], sizeof *r->xy);
        to += sizeof *r->xy;
    }
    if (g->grid->rgb)
        memcpy(to, r->rgb[i], sizeof *r->rgb);
}

/* Counts what each rank gets of records [begin, end); or if fill is set, makes the packets. */
static void pack_all(giver *g, uint64_t begin, uint64_t end, bool fill)
{
    const stp_grid_records *r = g->records;
    size_t part = 0;
    for (uint64_t record = begin; record < end; record++) {
        uint32_t takers[TAKERS_MOST];
        uint8_t item[64];
        if (isnan(r->z[record - r->begin]))
            continue;
        const uint64_t place = place_of(r, &part, record);
        const unsigned count = find_takers(g, place, takers);
        if (fill)
            pack(g, record, place, item);
        for (unsigned i = 0; i < count; i++) {
            const uint32_t taker = takers[i];
            if (!fill) {
                g->sent[taker] += taker == g->ranks->self ? 0 : g->item_bytes;
            } else if (taker == g->ranks->self) {
                put(g, item);
            } else {
                memcpy(g->out.data + g->ends[taker], item, g->item_bytes);
                g->ends[taker] += g->item_bytes;
            }
        }
    }
}

/* Gives records [begin, end), and takes what comes. */
static stp_status give_some(giver *g, uint64_t begin, uint64_t end, stp_error *err)
{
    stp_status status = STP_OK;
    size_t sum = 0;
    memset(g->sent, 0, g->ranks->count * sizeof *g->sent);
    pack_all(g, begin, end, false);
    for (unsigned rank = 0; rank < g->ranks->count; rank++) {
        g->ends[rank] = sum;
        sum += g->sent[rank];
    }
    g->out.size = 0;
    STP_TRY(stp_bytes_append(&g->out, NULL, sum, err));
    pack_all(g, begin, end, true);
    STP_TRY(stp_ranks_exchange_bytes(g->ranks, g->out.data, g->sent, &g->in, g->received, err));
    if (g->in.size % g->item_bytes > 0)
        return stp_error_set(err, STP_INTERNAL, "a packet of samples has a wrong size");
    for (size_t at = 0; at < g->in.size; at += g->item_bytes)
        put(g, g->in.data + at);
    stp_spill_relieve(g->grid->spill);
done:
    return status;
}

/* A sparse array of which pages are claimed one by one. */
typedef struct paged {
    void *array;
    size_t size, bytes; /* of an element, of all */
    uint64_t *claimed;  /* a bit for each page */
} paged;

/* Claims the pages of elements [begin, end) that are not claimed yet. heights: they become NaN. */
static stp_status claim(paged *p, uint64_t begin, uint64_t end, bool heights, stp_spill *spill,
                        stp_error *err)
{
    stp_status status = STP_OK;
    const size_t page = (size_t)sysconf(_SC_PAGESIZE), last = (end * p->size - 1) / page;
    for (size_t i = begin * p->size / page; i <= last; i++) {
        const size_t first = i;
        for (; i <= last && !(p->claimed[i / WORD] >> i % WORD & 1); i++)
            p->claimed[i / WORD] |= UINT64_C(1) << i % WORD;
        if (i == first)
            continue;
        const size_t until = i * page < p->bytes ? i * page : p->bytes;
        char *from = (char *)p->array + first * page;
        STP_TRY(stp_spill_claim(spill, from, until - first * page, "heights", err));
        for (double *z = (double *)(void *)from; heights && (char *)z < (char *)p->array + until;)
            *z++ = NAN;
    }
done:
    return status;
}

static int64_t least(int64_t a, int64_t b)
{
    return a < b ? a : b;
}

/* Claims what own tiles need of an array. heights: also of the samples around them. */
static stp_status claim_own(const giver *g, void *array, size_t size, bool heights, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_height_grid *grid = g->grid;
    const int64_t columns = grid->raster.columns, rows = grid->raster.rows;
    const int64_t side = STP_TILE_SIDE, around = heights ? STP_GRID_REACH : 0;
    paged p = {.array = array, .size = size, .bytes = (size_t)(columns * rows) * size};
    if (!array)
        return STP_OK;
    const size_t pages = p.bytes / (size_t)sysconf(_SC_PAGESIZE) + 1;
    STP_TRY(stp_alloc(&p.claimed, pages / WORD + 1, sizeof *p.claimed, "pages", err));
    for (uint32_t tile = 0; tile < stp_height_grid_tile_count(grid); tile++) {
        const int64_t column = tile % grid->tile_columns * side;
        const int64_t row = tile / grid->tile_columns * side;
        const int64_t low = column > around ? column - around : 0;
        const int64_t high = least(column + side + around, columns);
        if (g->owners[tile] != g->ranks->self)
            continue;
        for (int64_t r = row > around ? row - around : 0; r < least(row + side + around, rows); r++)
            STP_TRY(claim(&p, (uint64_t)(r * columns + low), (uint64_t)(r * columns + high),
                          heights, grid->spill, err));
        stp_spill_relieve(grid->spill);
    }
done:
    free(p.claimed);
    return status;
}

stp_status stp_grid_records_give(const stp_grid_records *r, stp_height_grid *grid,
                                 const uint32_t *owners, uint64_t most, stp_ranks *ranks,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    giver g = {.records = r, .grid = grid, .owners = owners, .ranks = ranks};
    const uint32_t share = GIVEN_RECORDS / ranks->count;
    const uint64_t step = share < GIVEN_RECORDS_LEAST  ? GIVEN_RECORDS_LEAST
                          : share > GIVEN_RECORDS_MOST ? GIVEN_RECORDS_MOST
                                                       : share;
    g.item_bytes = sizeof(uint32_t) + sizeof *grid->z + (grid->xy ? sizeof *grid->xy : 0) +
                   (grid->rgb ? sizeof *grid->rgb : 0);
    STP_TRY(stp_alloc(&g.sent, ranks->count, sizeof *g.sent, "ranks", err));
    STP_TRY(stp_alloc(&g.received, ranks->count, sizeof *g.received, "ranks", err));
    STP_TRY(stp_alloc(&g.ends, ranks->count, sizeof *g.ends, "ranks", err));
    STP_TRY(claim_own(&g, grid->z, sizeof *grid->z, true, err));
    STP_TRY(claim_own(&g, grid->xy, sizeof *grid->xy, false, err));
    STP_TRY(claim_own(&g, grid->rgb, sizeof *grid->rgb, false, err));
    for (uint64_t at = 0; at < most; at += step) {
        const uint64_t begin = at < r->end - r->begin ? r->begin + at : r->end;
        STP_TRY(give_some(&g, begin, r->end - begin < step ? r->end : begin + step, err));
    }
done:
    free(g.sent);
    free(g.received);
    free(g.ends);
    free(g.out.data);
    free(g.in.data);
    return status;
}

void stp_grid_records_clear(stp_grid_records *r)
{
    stp_spill_free(r->spill, r->z);
    stp_spill_free(r->spill, r->xy);
    stp_spill_free(r->spill, r->rgb);
    free(r->parts);
    *r = (stp_grid_records){0};
}
