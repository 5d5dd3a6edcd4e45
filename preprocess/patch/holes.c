/* Finds how far places are from those where a grid has no samples. */
#include "preprocess/patch/holes.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

#define SIDE 8u
/* What stays open around a missing sample, in cells: discs that just meet, across a cell, reach
 * 0.71 cells far. Rays of images are off by no more. */
#define MARGIN_CELLS 0.25
/* A radius may be stored larger by this factor: there are 16 codes an octave. */
#define ROUNDED 1.0443

/* Columns and rows of the pyramid begin one before those of the grid. */
static stp_dvec3 place_at(const stp_holes *holes, uint32_t column, uint32_t row)
{
    const stp_holes_grid *g = &holes->grid;
    return g->place(g->context, (int64_t)column - 1, (int64_t)row - 1);
}

static void set_bit(stp_holes *holes, unsigned level, uint32_t column, uint32_t row)
{
    stp_holes_word *word =
        &holes->words[level][(size_t)(row / SIDE) * holes->columns[level] + column / SIDE];
    word->bits |= UINT64_C(1) << (row % SIDE * SIDE + column % SIDE);
}

static void add_ring(stp_holes *holes)
{
    const uint32_t columns = holes->grid.columns, rows = holes->grid.rows;
    for (uint32_t c = 0; c < columns + 2; c++) {
        set_bit(holes, 0, c, 0);
        set_bit(holes, 0, c, rows + 1);
    }
    for (uint32_t r = 0; r < rows + 2 && !holes->grid.round; r++) {
        set_bit(holes, 0, 0, r);
        set_bit(holes, 0, columns + 1, r);
    }
}

stp_status stp_holes_create(stp_holes *out, const stp_holes_grid *grid, stp_error *err)
{
    stp_status status = STP_OK;
    stp_holes holes = {.grid = *grid};
    uint32_t columns = grid->columns + 2, rows = grid->rows + 2;
    if (!grid->rays)
        holes.middle = grid->place(grid->context, grid->columns / 2, grid->rows / 2);
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

void stp_holes_add(stp_holes *holes, uint32_t column, uint32_t row)
{
    set_bit(holes, 0, column + 1, row + 1);
}

/* Widens a word's box by a place relative to the middle. */
static void widen(stp_holes_word *word, const double at[3])
{
    for (int i = 0; i < 3; i++) {
        const float v = (float)at[i];
        word->low[i] = fminf(word->low[i], v > at[i] ? nextafterf(v, -INFINITY) : v);
        word->high[i] = fmaxf(word->high[i], v < at[i] ? nextafterf(v, INFINITY) : v);
    }
}

static void finish_word(stp_holes *holes, unsigned level, uint32_t column, uint32_t row)
{
    stp_holes_word *word = &holes->words[level][(size_t)row * holes->columns[level] + column];
    for (int i = 0; i < 3; i++) {
        word->low[i] = INFINITY;
        word->high[i] = -INFINITY;
    }
    for (uint64_t bits = word->bits; bits; bits &= bits - 1) {
        const unsigned bit = (unsigned)__builtin_ctzll(bits);
        const uint32_t c = column * SIDE + bit % SIDE, r = row * SIDE + bit / SIDE;
        if (level == 0) {
            const stp_dvec3 p = stp_dvec3_sub(place_at(holes, c, r), holes->middle);
            widen(word, (const double[3]){p.x, p.y, p.z});
            continue;
        }
        const stp_holes_word *below =
            &holes->words[level - 1][(size_t)r * holes->columns[level - 1] + c];
        for (int i = 0; i < 3; i++) {
            word->low[i] = fminf(word->low[i], below->low[i]);
            word->high[i] = fmaxf(word->high[i], below->high[i]);
        }
    }
}

void stp_holes_finish(stp_holes *holes)
{
    add_ring(holes);
    for (unsigned l = 0; l < holes->level_count; l++)
        for (uint32_t row = 0; row < holes->rows[l]; row++)
            for (uint32_t column = 0; column < holes->columns[l]; column++) {
                if (!holes->words[l][(size_t)row * holes->columns[l] + column].bits)
                    continue;
                finish_word(holes, l, column, row);
                if (l + 1 < holes->level_count)
                    set_bit(holes, l + 1, column, row);
            }
}

/* A search from a place, or, for rays, from a direction. */
typedef struct search {
    const stp_holes *holes;
    double at[3];   /* relative to the middle */
    double squared; /* of the least distance so far */
} search;

static double squared_to_box(const search *s, const stp_holes_word *word)
{
    double sum = 0.0;
    for (int i = 0; i < 3; i++) {
        const double off = fmax(0.0, fmax(word->low[i] - s->at[i], s->at[i] - word->high[i]));
        sum += off * off;
    }
    return sum;
}

static double squared_to(const search *s, uint32_t column, uint32_t row)
{
    const stp_dvec3 p = stp_dvec3_sub(place_at(s->holes, column, row), s->holes->middle);
    const stp_dvec3 way = stp_dvec3_sub(p, (stp_dvec3){s->at[0], s->at[1], s->at[2]});
    return stp_dvec3_dot(way, way);
}

/* Lowers the distance to that of the nearest missing sample of a word, if it is less. */
static void search_word(search *s, unsigned level, uint32_t column, uint32_t row)
{
    const stp_holes_word *word =
        &s->holes->words[level][(size_t)row * s->holes->columns[level] + column];
    if (squared_to_box(s, word) >= s->squared)
        return;
    for (uint64_t bits = word->bits; bits; bits &= bits - 1) {
        const unsigned bit = (unsigned)__builtin_ctzll(bits);
        const uint32_t c = column * SIDE + bit % SIDE, r = row * SIDE + bit / SIDE;
        if (level == 0)
            s->squared = fmin(s->squared, squared_to(s, c, r));
        else
            search_word(s, level - 1, c, r);
    }
}

/* How long the way between two directions is, at most, if one of them passes the end of the other
 * at a distance; lengths are 1. */
static double chord_of(double distance)
{
    return distance < 1.0 ? 2.0 * sin(0.5 * asin(distance)) : M_SQRT2;
}

static double from_chord(double chord)
{
    return chord < M_SQRT2 ? chord * sqrt(1.0 - 0.25 * chord * chord) : 1.0;
}

double stp_holes_distance(const stp_holes *holes, stp_dvec3 place, double most)
{
    const stp_holes_grid *grid = &holes->grid;
    if (holes->level_count == 0)
        return most;
    stp_dvec3 from = stp_dvec3_sub(place, holes->middle);
    double length = 1.0, limit = most;
    if (grid->rays) {
        from = stp_dvec3_sub(place, grid->station);
        length = stp_dvec3_length(from);
        from = stp_dvec3_scale(from, 1.0 / length);
        limit = chord_of(most / length);
    }
    search s = {.holes = holes,
                .at = {from.x, from.y, grid->rays ? from.z : 0.0},
                .squared = limit * limit};
    search_word(&s, holes->level_count - 1, 0, 0);
    const double found = sqrt(s.squared);
    return fmin(most, grid->rays ? length * from_chord(found) : found);
}

/* What stays open around a missing sample near a place. */
static double margin_at(const stp_holes *holes, stp_dvec3 place)
{
    const stp_holes_grid *grid = &holes->grid;
    const stp_dvec3 ray = stp_dvec3_sub(place, grid->station);
    return MARGIN_CELLS * grid->cell * (grid->rays ? stp_dvec3_length(ray) : 1.0);
}

/* The same, and how far the nearest missing sample is, if it limits the radius. */
static double radius_at(const stp_holes *holes, stp_dvec3 place, double most, double *reach)
{
    const double margin = margin_at(holes, place);
    *reach = stp_holes_distance(holes, place, most + margin);
    return fmin(most, fmax(0.0, *reach - margin));
}

double stp_holes_radius(const stp_holes *holes, stp_dvec3 place, double most)
{
    double reach;
    return radius_at(holes, place, most, &reach);
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
    choice out = {.centre = {nearbyint(centre.x / step) * step, nearbyint(centre.y / step) * step,
                             nearbyint(centre.z / step) * step}};
    out.radius = radius_at(holes, stp_dvec3_add(origin, out.centre), most, &out.reach);
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
    if (holes->level_count == 0)
        return false;
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
