/* Finds how far places are from those where a grid has no samples. */
#include "preprocess/patch/holes.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

#define SIDE 8u
/* What stays open around a missing sample, in cells: discs that just meet, across a cell, reach
 * 0.71 cells far. */
#define MARGIN_CELLS 0.25
/* A radius may be stored larger by this factor: there are 16 codes an octave. */
#define ROUNDED 1.0443

stp_status stp_holes_create(stp_holes *out, const stp_scan_raster *raster, stp_error *err)
{
    stp_status status = STP_OK;
    stp_holes holes = {.raster = *raster, .margin = MARGIN_CELLS * fmin(raster->dx, raster->dy)};
    uint32_t columns = raster->columns, rows = raster->rows;
    do {
        const unsigned l = holes.level_count++;
        columns = holes.columns[l] = (columns - 1) / SIDE + 1;
        rows = holes.rows[l] = (rows - 1) / SIDE + 1;
        STP_TRY(
            stp_alloc(&holes.words[l], (size_t)columns * rows, sizeof **holes.words, "holes", err));
    } while (columns > 1 || rows > 1);
    *out = holes;
    holes = (stp_holes){0};
done:
    stp_holes_clear(&holes);
    return status;
}

void stp_holes_clear(stp_holes *holes)
{
    for (unsigned l = 0; l < holes->level_count; l++)
        free(holes->words[l]);
    *holes = (stp_holes){0};
}

static void set_bit(stp_holes *holes, unsigned level, uint32_t column, uint32_t row)
{
    uint64_t *word =
        &holes->words[level][(size_t)(row / SIDE) * holes->columns[level] + column / SIDE];
    *word |= UINT64_C(1) << (row % SIDE * SIDE + column % SIDE);
}

void stp_holes_add(stp_holes *holes, uint32_t column, uint32_t row)
{
    set_bit(holes, 0, column, row);
}

void stp_holes_finish(stp_holes *holes)
{
    for (unsigned l = 0; l + 1 < holes->level_count; l++)
        for (uint32_t row = 0; row < holes->rows[l]; row++)
            for (uint32_t column = 0; column < holes->columns[l]; column++)
                if (holes->words[l][(size_t)row * holes->columns[l] + column])
                    set_bit(holes, l + 1, column, row);
}

/* A search from a place in columns and rows. */
typedef struct search {
    const stp_holes *holes;
    double at[2], cell[2];
    double squared; /* of the least distance so far */
} search;

/* How far the place is from `count` columns or rows from `first` on, world units. */
static double off(const search *s, int axis, uint32_t first, uint32_t count)
{
    const double before = first - s->at[axis], after = s->at[axis] - (first + (count - 1.0));
    return s->cell[axis] * fmax(0.0, fmax(before, after));
}

/* Lowers the distance to that of the nearest missing sample of a word, if it is less. */
static void search_word(search *s, unsigned level, uint32_t column, uint32_t row)
{
    const uint32_t side = UINT32_C(1) << 3 * level;
    uint64_t word = s->holes->words[level][(size_t)row * s->holes->columns[level] + column];
    for (; word; word &= word - 1) {
        const unsigned bit = (unsigned)__builtin_ctzll(word);
        const uint32_t c = column * SIDE + bit % SIDE, r = row * SIDE + bit / SIDE;
        const double x = off(s, 0, c * side, side), y = off(s, 1, r * side, side);
        if (x * x + y * y >= s->squared)
            continue;
        if (level == 0)
            s->squared = x * x + y * y;
        else
            search_word(s, level - 1, c, r);
    }
}

double stp_holes_distance(const stp_holes *holes, double x, double y, double most)
{
    const stp_scan_raster *r = &holes->raster;
    search s = {
        .holes = holes, .at = {(x - r->x) / r->dx, (r->y - y) / r->dy}, .cell = {r->dx, r->dy}};
    const double count[2] = {r->columns, r->rows};
    uint32_t near[2];
    for (int a = 0; a < 2; a++) { /* beyond the grid */
        most = fmin(most, s.cell[a] * fmin(s.at[a] + 1.0, count[a] - s.at[a]));
        near[a] = (uint32_t)fmax(0.0, fmin(s.at[a] + 0.5, count[a] - 1.0));
    }
    if (!(most > 0.0))
        return 0.0;
    s.squared = most * most;
    for (unsigned l = 0; l < holes->level_count; l++) { /* those about the place first */
        near[0] /= SIDE;
        near[1] /= SIDE;
        search_word(&s, l, near[0], near[1]);
    }
    return sqrt(s.squared);
}

double stp_holes_radius(const stp_holes *holes, stp_dvec3 place, double most)
{
    const double reach = stp_holes_distance(holes, place.x, place.y, most + holes->margin);
    return fmax(0.0, reach - holes->margin);
}

/* A place that a disc may have. */
typedef struct choice {
    stp_dvec3 centre;
    double radius, reach; /* reach: from the nearest missing sample */
    double left_out;      /* how far the finer discs reach out of it */
} choice;

static choice choose(const stp_holes *holes, stp_dvec3 origin, const stp_disc *finer,
                     unsigned count, stp_dvec3 centre, double most, double step)
{
    choice out = {
        .centre = {nearbyint(centre.x / step) * step, nearbyint(centre.y / step) * step, centre.z}};
    const stp_dvec3 place = stp_dvec3_add(origin, out.centre);
    out.reach = stp_holes_distance(holes, place.x, place.y, most + holes->margin);
    out.radius = out.reach - holes->margin;
    if (out.radius < step)
        out.radius = 0.0;
    for (unsigned i = 0; i < count; i++)
        out.left_out =
            stp_max(out.left_out, stp_dvec3_length(stp_dvec3_sub(finer[i].centre, out.centre)) +
                                      finer[i].radius - out.radius);
    return out;
}

/* Points are taken only if nothing else is left: the one farthest from holes. */
static bool is_better(const choice *a, const choice *b)
{
    if (a->radius == 0.0 || b->radius == 0.0)
        return a->radius > 0.0 || (b->radius == 0.0 && a->reach > b->reach);
    return a->left_out < b->left_out;
}

bool stp_holes_limit(const stp_holes *holes, stp_dvec3 origin, const stp_disc *finer,
                     unsigned count, double step, stp_disc *disc)
{
    const double most = disc->radius * ROUNDED;
    choice best = choose(holes, origin, finer, count, disc->centre, most, step);
    if (best.radius >= most)
        return false;
    for (unsigned i = 0; i < count; i++) {
        const choice own = choose(holes, origin, finer, count, finer[i].centre, disc->radius, step);
        if (is_better(&own, &best))
            best = own;
    }
    disc->centre = best.centre;
    disc->radius = stp_min(best.radius, disc->radius);
    return true;
}
