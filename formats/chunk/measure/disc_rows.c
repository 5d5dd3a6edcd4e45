/* Rows of discs, and the search for the nearest one. */
#include "formats/chunk/measure/disc_rows.h"

#include "base/memory.h"
#include "base/wide.h"
#include "formats/chunk/measure/patch_bounds.h"

#include <stdlib.h>
#include <string.h>

#define STEP ((int)STP_LANE_STEP)
/* The upwards part of the steepest normal that steps are found for, and the most turns it takes. */
#define STEEPEST 0.02f
#define STEPS_MOST 8
/* A bit for each point of a disc. */
#define POINTS ((1u << STP_DISC_POINTS) - 1)
/* Discs are tried among 2 NEAR columns and rows about a point; if all of these are a hole, among
 * 2 WIDE. */
#define NEAR 4
#define WIDE 16
/* Squares of places that share the greatest distance from discs. */
#define SQUARE 8
/* Places around those of the chunk: a merged disc reaches some 12 cells out of its patch. */
#define MARGIN 32
/* A disc lies this near to its place, in sides of a cell. No comparison here is with what is not
 * finite: the compiler takes all numbers for finite. */
#define OFF_MOST 0.03125f
/* A float of less magnitude, added to the second number, loses its fraction. */
#define WHOLE_MOST 0x1p22f
#define WHOLE_ADDED 0x1.8p23f
/* Cells a grid unit: floats tell a place to less than 1/128 cell. */
#define INVERSE_MOST 0x1p16
/* Places for each disc, at most, and so many more. */
#define PLACES_PER_DISC 4u
#define PLACES_FREE 16384u
/* Places beside the chunk's own that discs reach, and that may be a hole. */
#define BESIDE 12
/* A narrower hole, in columns or rows from the nearest disc, is no hole: the discs around fill it.
 */
#define HOLE_LEAST 2u
/* The cosine of the steepest disc under which holes are looked for. */
#define LEVEL_LEAST 0.1

static inline float nearest_whole(float x)
{
    return (x + WHOLE_ADDED) - WHOLE_ADDED;
}

/* The place of a disc. False if it is off its place. */
static bool find_place(const stp_disc_rows *r, const float centre[3], int out[2])
{
    for (int a = 0; a < 2; a++) {
        const float at = (centre[a] - r->first[a]) * r->inverse[a];
        const float whole = nearest_whole(at);
        if (!(fabsf(at - whole) <= OFF_MOST) || fabsf(at) >= WHOLE_MOST)
            return false;
        out[a] = (int)whole;
    }
    return true;
}

/* Sets columns, rows and the first place from the box of the chunk's own discs. False if its
 * corners are off their places, or too far apart. */
static bool find_extent(stp_disc_rows *r, const stp_disc_grid *g)
{
    int from[2], to[2], low[2], high[2];
    if (!find_place(r, g->low, from) || !find_place(r, g->high, to))
        return false;
    for (int a = 0; a < 2; a++) {
        low[a] = from[a] < to[a] ? from[a] : to[a];
        high[a] = from[a] < to[a] ? to[a] : from[a];
    }
    const uint64_t columns = (uint64_t)((int64_t)high[0] - low[0] + 1 + 2 * MARGIN);
    const uint64_t rows = (uint64_t)((int64_t)high[1] - low[1] + 1 + 2 * MARGIN);
    for (int a = 0; a < 2; a++)
        r->first[a] += (float)(low[a] - MARGIN) / r->inverse[a];
    r->columns = (int)columns;
    r->rows = (int)rows;
    return columns * rows <= PLACES_PER_DISC * (uint64_t)g->own_count + PLACES_FREE;
}

static uint8_t *hollow_at(const stp_disc_rows *r, int column, int row)
{
    return r->hollow + (size_t)(row / SQUARE) * (size_t)(r->columns / SQUARE + 1) + column / SQUARE;
}

static bool is_empty(const stp_disc_rows *r, size_t place)
{
    return r->disc[place] == r->none;
}

/* Finds the places of STEP discs; less than 0: beyond the rows. False if one is off its place. */
STP_WIDE
static bool find_places(const stp_disc_rows *r, const stp_lane_disc discs[STEP],
                        int32_t place[STEP])
{
    const float most[2] = {(float)(r->columns - 1), (float)(r->rows - 1)};
    const float first[2] = {r->first[0], r->first[1]}, inverse[2] = {r->inverse[0], r->inverse[1]};
    const int columns = r->columns;
    float centre[2][STEP];
    int off = 0;
    for (int i = 0; i < STEP; i++)
        for (int a = 0; a < 2; a++)
            centre[a][i] = discs[i].numbers[a];
    for (int i = 0; i < STEP; i++) {
        const float x = (centre[0][i] - first[0]) * inverse[0];
        const float y = (centre[1][i] - first[1]) * inverse[1];
        const float column = nearest_whole(x), row = nearest_whole(y);
        const float in[2] = {fminf(fmaxf(column, 0.0f), most[0]), fminf(fmaxf(row, 0.0f), most[1])};
        const int at = (int)in[1] * columns + (int)in[0];
        off |= (fabsf(x - column) > OFF_MOST) | (fabsf(x) >= WHOLE_MOST);
        off |= (fabsf(y - row) > OFF_MOST) | (fabsf(y) >= WHOLE_MOST);
        place[i] = (in[0] == column) & (in[1] == row) ? at : -1;
    }
    return off == 0;
}

/* Puts all discs into their places. False if two have one place, or one is off. */
static bool put_discs(stp_disc_rows *r, const stp_disc_grid *g)
{
    const size_t places = (size_t)r->columns * (size_t)r->rows;
    for (size_t i = 0; i < places; i++)
        r->disc[i] = r->none;
    for (uint32_t d = 0; d < g->count; d += STEP) {
        const uint32_t left = g->count - d, count = left < STEP ? left : STEP;
        stp_lane_disc last[STEP];
        int32_t place[STEP];
        for (uint32_t i = 0; left < STEP && i < STEP; i++)
            last[i] = g->numbers[d + (i < left ? i : 0)];
        if (!find_places(r, left < STEP ? last : &g->numbers[d], place))
            return false;
        for (uint32_t i = 0; i < count; i++) {
            if (place[i] < 0)
                continue;
            if (!is_empty(r, (size_t)place[i]))
                return false;
            r->disc[place[i]] = d + i;
        }
    }
    return true;
}

/* Whether all places of the chunk, and beside it, have discs. */
static bool is_whole(const stp_disc_rows *r)
{
    for (int row = MARGIN - BESIDE; row < r->rows - MARGIN + BESIDE; row++)
        for (int column = MARGIN - BESIDE; column < r->columns - MARGIN + BESIDE; column++)
            if (is_empty(r, (size_t)row * (size_t)r->columns + (size_t)column))
                return false;
    return true;
}

/* Lowers distances of a row to what those of the row beside it allow. */
static void sweep_down(const uint8_t *restrict beside, uint8_t *restrict row, int columns)
{
    for (int i = 1; i + 1 < columns; i++) {
        uint8_t least = beside[i - 1] < beside[i] ? beside[i - 1] : beside[i];
        least = beside[i + 1] < least ? beside[i + 1] : least;
        least = (uint8_t)(least + 1);
        row[i] = row[i] < least ? row[i] : least;
    }
}

static void sweep_along(uint8_t *row, int columns)
{
    for (int i = 1; i < columns; i++)
        row[i] = row[i] <= row[i - 1] ? row[i] : (uint8_t)(row[i - 1] + 1);
    for (int i = columns - 1; i-- > 0;)
        row[i] = row[i] <= row[i + 1] ? row[i] : (uint8_t)(row[i + 1] + 1);
}

/* Finds how far each place is from the nearest disc. The way there goes aslant, then up, down or
 * along a row. The outermost columns are far from all discs of the chunk. */
static stp_status find_holes(stp_disc_rows *r, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t columns = (size_t)r->columns;
    const size_t squares = (columns / SQUARE + 1) * (size_t)(r->rows / SQUARE + 1);
    if (is_whole(r))
        return STP_OK;
    STP_TRY(stp_alloc(&r->away, columns * (size_t)r->rows, sizeof *r->away, "holes", err));
    STP_TRY(stp_alloc(&r->hollow, squares, sizeof *r->hollow, "holes", err));
    for (int row = 0; row < r->rows; row++) {
        uint8_t *away = r->away + (size_t)row * columns;
        for (size_t i = 0; i < columns; i++)
            away[i] = is_empty(r, (size_t)row * columns + i) ? MARGIN : 0;
        if (row > 0)
            sweep_down(away - columns, away, r->columns);
    }
    for (int row = r->rows - 1; row >= 0; row--) {
        uint8_t *away = r->away + (size_t)row * columns;
        if (row + 1 < r->rows)
            sweep_down(away + columns, away, r->columns);
    }
    for (int row = 0; row < r->rows; row++) {
        uint8_t *away = r->away + (size_t)row * columns;
        sweep_along(away, r->columns);
        uint8_t *hollow = hollow_at(r, 0, row);
        for (int i = 0; i < r->columns; i++)
            hollow[i / SQUARE] = away[i] > hollow[i / SQUARE] ? away[i] : hollow[i / SQUARE];
    }
done:
    return status;
}

stp_status stp_disc_rows_create(stp_disc_rows *out, const stp_disc_grid *grid, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk *chunk = grid->chunk;
    stp_disc_rows r = {.discs = grid->numbers, .none = grid->count};
    *out = (stp_disc_rows){0};
    if (chunk->raster_count != 1 || !chunk->rasters[0].level || grid->carry || grid->carry_around)
        return STP_OK;
    for (int a = 0; a < 2; a++) {
        const double *across = chunk->rasters[0].across[a];
        r.first[a] = (float)(across[0] * grid->scale);
        const double inverse = 1.0 / (across[1 + a] * grid->scale);
        if (!(fabs(inverse) <= INVERSE_MOST))
            return STP_OK;
        r.inverse[a] = (float)inverse;
        r.side[a] = 1.0f / r.inverse[a];
    }
    if (!find_extent(&r, grid))
        return STP_OK;
    const size_t places = (size_t)r.columns * (size_t)r.rows;
    STP_TRY(stp_alloc_unset(&r.disc, places, sizeof *r.disc, "discs", err));
    if (put_discs(&r, grid)) {
        STP_TRY(find_holes(&r, err));
        *out = r;
        r = (stp_disc_rows){0};
    }
done:
    stp_disc_rows_clear(&r);
    return status;
}

void stp_disc_rows_clear(stp_disc_rows *r)
{
    free(r->disc);
    free(r->hollow);
    free(r->away);
    *r = (stp_disc_rows){0};
}

/* The cost of a point over each of STEP discs. */
static inline void tell_discs(const stp_disc_rows *r, const uint32_t index[STEP],
                              const stp_over *over, const float point[3], float cost[STEP])
{
    float of[STP_LANE_CARRIED][STEP];
    stp_lane_discs_take(r->discs, index, of[0], STEP);
    for (int i = 0; i < STEP; i++) {
        const bool own = index[i] - over->begin < over->end - over->begin;
        float disc[STP_LANE_NUMBERS] = {0.0f};
        for (int c = 0; c < STP_LANE_CARRIED; c++)
            disc[c] = of[c][i];
        cost[i] = stp_lane_value(point, disc, own, STP_OVER_COST, over);
    }
}

/* What a search has found so far, by lane. */
typedef struct least {
    float cost[STEP];
    int row[STEP];
} least;

/* Tries STEP discs of a row from `column` on. */
static inline void try_row(const stp_disc_rows *r, int column, int row, const stp_over *over,
                           const float point[3], least *l)
{
    const uint32_t *index = r->disc + (size_t)row * (size_t)r->columns + (size_t)column;
    float cost[STEP];
    uint32_t any = 0;
    for (int i = 0; i < STEP; i++)
        any |= index[i] ^ r->none;
    if (any == 0)
        return;
    tell_discs(r, index, over, point, cost);
    for (int i = 0; i < STEP; i++) {
        l->row[i] = cost[i] < l->cost[i] ? row : l->row[i];
        l->cost[i] = fminf(cost[i], l->cost[i]);
    }
}

/* Tries the discs of STEP columns, the rows next to the point first. Returns the least cost. */
STP_WIDE
static float search(const stp_disc_rows *r, int column, int row, int rows, const stp_over *over,
                    const float x[3], float stop, uint32_t *disc)
{
    const float point[3] = {x[0], x[1], x[2]};
    const stp_over o = *over;
    float found = STP_LANE_FAR;
    int lane = 0;
    least l;
    for (int i = 0; i < STEP; i++) {
        l.cost[i] = STP_LANE_FAR;
        l.row[i] = row;
    }
    for (int ring = 1; ring <= rows / 2 && found > stop; ring++) {
        try_row(r, column, row + 1 - ring, &o, point, &l);
        try_row(r, column, row + ring, &o, point, &l);
        found = l.cost[0];
        for (int i = 1; i < STEP; i++)
            found = fminf(found, l.cost[i]);
    }
    for (int i = 1; i < STEP; i++)
        lane = l.cost[i] == found ? i : lane;
    *disc = r->disc[(size_t)l.row[lane] * (size_t)r->columns + (size_t)(column + lane)];
    return found;
}

/* The column or row of the place just before x, at least `reach` places from the ends. */
static int place_before(const stp_disc_rows *r, int axis, float x, int reach)
{
    const int most = (axis ? r->rows : r->columns) - reach - 1;
    const float place = (x - r->first[axis]) * r->inverse[axis];
    return (int)fminf(fmaxf(place, (float)(reach - 1)), (float)most);
}

float stp_disc_rows_least(const stp_disc_rows *r, const float x[3], const stp_over *over,
                          float stop, uint32_t *disc)
{
    float found = STP_LANE_FAR;
    for (int reach = NEAR; reach <= WIDE && found >= STP_DISC_ROWS_NONE; reach *= WIDE / NEAR) {
        const int column = place_before(r, 0, x[0], reach), row = place_before(r, 1, x[1], reach);
        for (int c = 1 - reach; c < reach && found > stop; c += STEP) {
            uint32_t d;
            const float cost = search(r, column + c, row, 2 * reach, over, x, stop, &d);
            *disc = cost < found ? d : *disc;
            found = fminf(found, cost);
        }
    }
    return found;
}

/* A step's columns and rows are this long, and rise so much, in grid units. */
typedef struct slope {
    float side[2], rise[2];
} slope;

/* The product of two steps as vectors along a slope. */
static float product(const slope *s, const float a[2], const float b[2])
{
    const float up =
        (a[0] * s->rise[0] + a[1] * s->rise[1]) * (b[0] * s->rise[0] + b[1] * s->rise[1]);
    return a[0] * b[0] * s->side[0] * s->side[0] + a[1] * b[1] * s->side[1] * s->side[1] + up;
}

/* The way that a step goes in memory: no farther than all places. Where cells are a million times
 * as long as wide, it would be. */
static int32_t way_of(const stp_disc_rows *r, const float step[2])
{
    const float columns = (float)r->columns, places = columns * (float)r->rows;
    return (int32_t)fmaxf(-places, fminf(step[0] + step[1] * columns, places));
}

/* Takes from the longer step as many shorter ones as shorten it (Lagrange). */
void stp_disc_rows_steps(const stp_disc_rows *r, const float normal[3], stp_disc_steps *out)
{
    const float up = fmaxf(fabsf(normal[2]), STEEPEST);
    const slope s = {{r->side[0], r->side[1]},
                     {normal[0] * r->side[0] / up, normal[1] * r->side[1] / up}};
    float step[2][2] = {{1.0f, 0.0f}, {0.0f, 1.0f}};
    float times = 1.0f;
    for (int i = 0; i < STEPS_MOST && times != 0.0f; i++) {
        const float squared[2] = {product(&s, step[0], step[0]), product(&s, step[1], step[1])};
        const int shorter = squared[1] < squared[0], longer = 1 - shorter;
        times = nearest_whole(product(&s, step[0], step[1]) / squared[shorter]);
        for (int k = 0; k < 2; k++)
            step[longer][k] -= times * step[shorter][k];
    }
    const float turn = step[0][0] * step[1][1] - step[0][1] * step[1][0]; /* 1 or -1 */
    const int32_t one = way_of(r, step[0]), other = way_of(r, step[1]);
    *out = (stp_disc_steps){
        .by = {{step[0][0], step[0][1]}, {step[1][0], step[1][1]}},
        .inverse = {{turn * step[1][1], -turn * step[1][0]},
                    {-turn * step[0][1], turn * step[0][0]}},
        .around = {one, -one, other, -other, one + other, -one - other, one - other, other - one}};
}

/* Pairs points with the discs of the places that they are nearest to. */
static inline void take_nearest(const stp_disc_rows *r, const stp_disc_steps *s,
                                int32_t place[STP_DISC_LANES], stp_paired_lanes *lanes)
{
    const float most[2] = {(float)(r->columns - 1), (float)(r->rows - 1)};
    for (unsigned i = 0; i < STP_DISC_LANES; i++) {
        const float x = (lanes->point[0][i] - r->first[0]) * r->inverse[0];
        const float y = (lanes->point[1][i] - r->first[1]) * r->inverse[1];
        const float a = nearest_whole(x * s->inverse[0][0] + y * s->inverse[0][1]);
        const float b = nearest_whole(x * s->inverse[1][0] + y * s->inverse[1][1]);
        const float column = fminf(fmaxf(a * s->by[0][0] + b * s->by[1][0], 0.0f), most[0]);
        const float row = fminf(fmaxf(a * s->by[0][1] + b * s->by[1][1], 0.0f), most[1]);
        place[i] = (int)row * r->columns + (int)column;
    }
    for (unsigned i = 0; i < STP_DISC_LANES; i++)
        lanes->index[i] = r->disc[place[i]];
    stp_paired_lanes_take(lanes, r->discs);
    memset(lanes->disc[STP_LANE_CARRIED], 0, /* nothing is carried where discs lie in rows */
           (STP_LANE_NUMBERS - STP_LANE_CARRIED) * sizeof lanes->disc[0]);
}

/* The least cost of a point over the discs around its own, one or both steps away. */
static inline float least_around(const stp_disc_rows *r, const stp_disc_steps *s, int32_t place,
                                 const float point[3], const stp_over *over)
{
    const int32_t last = r->columns * r->rows - 1;
    int32_t at[STEP];
    uint32_t index[STEP];
    float cost[STEP];
    for (int i = 0; i < STEP; i++) { /* beyond a row's end is another disc, which may do, too */
        const int32_t there = place + s->around[i], low = there > 0 ? there : 0;
        at[i] = low < last ? low : last;
    }
    for (int i = 0; i < STEP; i++)
        index[i] = r->disc[at[i]];
    tell_discs(r, index, over, point, cost);
    for (int half = STEP / 2; half > 0; half /= 2)
        for (int i = 0; i < half; i++)
            cost[i] = fminf(cost[i], cost[i + half]);
    return cost[0];
}

STP_WIDE
uint32_t stp_disc_rows_above(const stp_disc_rows *r, const stp_disc_steps *steps,
                             const stp_over *over, float limit, stp_paired_lanes *lanes,
                             float value[STP_DISC_LANES])
{
    int32_t place[STP_DISC_LANES];
    take_nearest(r, steps, place, lanes);
    const uint32_t above = stp_paired_lanes_above(lanes, over, limit, value) & POINTS;
    for (uint32_t left = above; left; left &= left - 1) {
        const int i = __builtin_ctz(left);
        const float point[3] = {lanes->point[0][i], lanes->point[1][i], lanes->point[2][i]};
        value[i] = fminf(value[i], least_around(r, steps, place[i], point, over));
    }
    uint32_t still = 0;
    for (unsigned i = 0; i < STP_DISC_POINTS; i++)
        still |= (value[i] <= limit ? 0u : 1u) << i;
    return above & still;
}

/* The disc's point over or under a place; false if that is beyond its rim. */
static bool point_at(const stp_disc_rows *r, const stp_disc *disc, int column, int row,
                     stp_dvec3 *out)
{
    const stp_dvec3 n = disc->normal;
    const double x = (double)((float)column / r->inverse[0] + r->first[0]) - disc->centre.x;
    const double y = (double)((float)row / r->inverse[1] + r->first[1]) - disc->centre.y;
    const double z = -(x * n.x + y * n.y) / n.z;
    *out = stp_dvec3_add(disc->centre, (stp_dvec3){x, y, z});
    return x * x + y * y + z * z <= disc->radius * disc->radius;
}

/* Looks for the place of a square, between two corners, that is farthest from discs. */
static bool hole_in(const stp_disc_rows *r, const stp_disc *disc, const int from[2],
                    const int to[2], unsigned *most, stp_dvec3 *out)
{
    bool found = false;
    for (int row = from[1]; row <= to[1]; row++)
        for (int column = from[0]; column <= to[0]; column++) {
            const unsigned away = r->away[(size_t)row * (size_t)r->columns + (size_t)column];
            stp_dvec3 point;
            if (away <= *most || !point_at(r, disc, column, row, &point))
                continue;
            *most = away;
            *out = point;
            found = true;
        }
    return found;
}

bool stp_disc_rows_hole(const stp_disc_rows *r, const stp_disc *disc, stp_dvec3 *out)
{
    const double centre[2] = {disc->centre.x, disc->centre.y};
    const double normal[2] = {disc->normal.x, disc->normal.y};
    const int count[2] = {r->columns, r->rows};
    int from[2], to[2];
    unsigned most = HOLE_LEAST - 1;
    bool found = false;
    if (!r->away || fabs(disc->normal.z) < LEVEL_LEAST)
        return false;
    for (int a = 0; a < 2; a++) {
        const double middle = (centre[a] - (double)r->first[a]) * (double)r->inverse[a];
        const double across = disc->radius * sqrt(fmax(0.0, 1.0 - normal[a] * normal[a]));
        const double reach = fmin(across * fabs((double)r->inverse[a]), MARGIN);
        from[a] = (int)fmax(0.0, ceil(middle - reach));
        to[a] = (int)fmin((double)count[a] - 1.0, floor(middle + reach));
    }
    for (int row = from[1]; row <= to[1]; row = (row | (SQUARE - 1)) + 1) {
        const uint8_t *hollow = hollow_at(r, from[0], row);
        for (int column = from[0]; column <= to[0]; column = (column | (SQUARE - 1)) + 1) {
            const int end[2] = {column | (SQUARE - 1), row | (SQUARE - 1)};
            if (*hollow++ > most)
                found |= hole_in(r, disc, (const int[2]){column, row},
                                 (const int[2]){end[0] < to[0] ? end[0] : to[0],
                                                end[1] < to[1] ? end[1] : to[1]},
                                 &most, out);
        }
    }
    return found;
}
