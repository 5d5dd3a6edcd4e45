/* Rows of discs, and the search for the nearest one. */
#include "formats/chunk/measure/disc_rows.h"

#include "base/memory.h"
#include "base/wide.h"
#include "formats/chunk/measure/patch_bounds.h"

#include <stdlib.h>
#include <string.h>

#define FAR 1e18f /* its square is a float, too */
#define STEP ((int)STP_LANE_STEP)
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
/* The place of a disc. False if it is off its place. */
static bool find_place(const stp_disc_rows *r, const float centre[3], int out[2])
{
    for (int a = 0; a < 2; a++) {
        const float at = (centre[a] - r->first[a]) * r->inverse[a];
        const float whole = (at + WHOLE_ADDED) - WHOLE_ADDED;
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

static float *numbers_at(const stp_disc_rows *r, int column, int row)
{
    return r->numbers + (size_t)row * STP_LANE_CARRIED * (size_t)r->columns + column;
}

static uint8_t *hollow_at(const stp_disc_rows *r, int column, int row)
{
    return r->hollow + (size_t)(row / SQUARE) * (size_t)(r->columns / SQUARE + 1) + column / SQUARE;
}

/* Puts all discs into their places. False if two have one place, or one is off. */
static bool put_discs(stp_disc_rows *r, const stp_disc_grid *g)
{
    const size_t columns = (size_t)r->columns;
    for (int row = 0; row < r->rows; row++)
        for (size_t i = 0; i < columns; i++)
            numbers_at(r, 0, row)[i] = FAR;
    for (uint32_t d = 0; d < g->count; d++) {
        const float *from = g->numbers[d].numbers;
        int at[2];
        if (!find_place(r, from, at))
            return false;
        if (at[0] < 0 || at[1] < 0 || at[0] >= r->columns || at[1] >= r->rows)
            continue;
        float *to = numbers_at(r, at[0], at[1]);
        if (to[0] != FAR)
            return false;
        for (size_t c = 0; c < STP_LANE_CARRIED; c++)
            to[c * columns] = from[c];
        r->disc[(size_t)at[1] * columns + (size_t)at[0]] = d;
    }
    return true;
}

/* Where there is no disc is a ball far away. */
static void fill_gaps(stp_disc_rows *r)
{
    const size_t columns = (size_t)r->columns;
    for (int row = 0; row < r->rows; row++)
        for (int column = 0; column < r->columns; column++) {
            float *to = numbers_at(r, column, row);
            for (size_t c = 1; c < STP_LANE_CARRIED && to[0] == FAR; c++)
                to[c * columns] = c < STP_LANE_NORMAL ? FAR : 0.0f;
        }
}

/* Whether all places of the chunk, and beside it, have discs. */
static bool is_whole(const stp_disc_rows *r)
{
    for (int row = MARGIN - BESIDE; row < r->rows - MARGIN + BESIDE; row++)
        for (int column = MARGIN - BESIDE; column < r->columns - MARGIN + BESIDE; column++)
            if (*numbers_at(r, column, row) == FAR)
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
        const float *x = numbers_at(r, 0, row);
        for (size_t i = 0; i < columns; i++)
            away[i] = x[i] == FAR ? MARGIN : 0;
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
        for (int i = 0; i < r->columns; i++)
            *hollow_at(r, i, row) =
                away[i] > *hollow_at(r, i, row) ? away[i] : *hollow_at(r, i, row);
    }
done:
    return status;
}

stp_status stp_disc_rows_create(stp_disc_rows *out, const stp_disc_grid *grid, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk *chunk = grid->chunk;
    stp_disc_rows r = {.discs = grid->numbers};
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
    }
    if (!find_extent(&r, grid))
        return STP_OK;
    const size_t places = (size_t)r.columns * (size_t)r.rows;
    STP_TRY(
        stp_alloc_unset(&r.numbers, places * STP_LANE_CARRIED, sizeof *r.numbers, "discs", err));
    STP_TRY(stp_alloc(&r.disc, places, sizeof *r.disc, "discs", err));
    if (put_discs(&r, grid)) {
        fill_gaps(&r);
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
    free(r->numbers);
    free(r->disc);
    free(r->hollow);
    free(r->away);
    *r = (stp_disc_rows){0};
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
    const float *at[STP_LANE_CARRIED];
    const size_t columns = (size_t)r->columns;
    const uint32_t *index = r->disc + (size_t)row * columns + (size_t)column;
    for (size_t c = 0; c < STP_LANE_CARRIED; c++)
        at[c] = numbers_at(r, column, row) + c * columns;
    for (int i = 0; i < STEP; i++) {
        const bool own = index[i] - over->begin < over->end - over->begin;
        float disc[STP_LANE_NUMBERS] = {0.0f};
        for (int c = 0; c < STP_LANE_CARRIED; c++)
            disc[c] = at[c][i];
        const float cost = stp_lane_value(point, disc, own, STP_OVER_COST, over);
        l->row[i] = cost < l->cost[i] ? row : l->row[i];
        l->cost[i] = fminf(cost, l->cost[i]);
    }
}

/* Tries the discs of STEP columns, the rows next to the point first. Returns the least cost. */
STP_WIDE
static float search(const stp_disc_rows *r, int column, int row, int rows, const stp_over *over,
                    const float x[3], float stop, uint32_t *disc)
{
    const float point[3] = {x[0], x[1], x[2]};
    const stp_over o = *over;
    float found = FAR;
    int lane = 0;
    least l;
    for (int i = 0; i < STEP; i++) {
        l.cost[i] = FAR;
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
    float found = FAR;
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

/* Lanes beyond the points are as lane 0: their points are the centre, too. */
void stp_disc_rows_pair(const stp_disc_rows *r, stp_paired_lanes *lanes)
{
    const float most[2] = {(float)(r->columns - 1), (float)(r->rows - 1)};
    int32_t place[STP_DISC_LANES];
    for (unsigned i = 0; i < STP_DISC_LANES; i++) {
        float at[2];
        for (int a = 0; a < 2; a++)
            at[a] = fminf(fmaxf((lanes->point[a][i] - r->first[a]) * r->inverse[a] + 0.5f, 0.0f),
                          most[a]);
        place[i] = (int)at[1] * r->columns + (int)at[0];
    }
    for (unsigned i = 0; i < STP_DISC_POINTS; i++) {
        const uint32_t disc = r->disc[place[i]];
        const float *d = r->discs[disc].numbers;
        lanes->index[i] = disc;
        for (int c = 0; c < STP_LANE_CARRIED; c++)
            lanes->disc[c][i] = d[c];
    }
    for (unsigned i = STP_DISC_POINTS; i < STP_DISC_LANES; i++)
        lanes->index[i] = lanes->index[0];
    for (int c = 0; c < STP_LANE_CARRIED; c++)
        for (unsigned i = STP_DISC_POINTS; i < STP_DISC_LANES; i++)
            lanes->disc[c][i] = lanes->disc[c][0];
    memset(lanes->disc[STP_LANE_CARRIED], 0, /* nothing is carried where discs lie in rows */
           (STP_LANE_NUMBERS - STP_LANE_CARRIED) * sizeof lanes->disc[0]);
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
    for (int row = from[1]; row <= to[1]; row = (row | (SQUARE - 1)) + 1)
        for (int column = from[0]; column <= to[0]; column = (column | (SQUARE - 1)) + 1) {
            const int end[2] = {column | (SQUARE - 1), row | (SQUARE - 1)};
            if (*hollow_at(r, column, row) > most)
                found |= hole_in(r, disc, (const int[2]){column, row},
                                 (const int[2]){end[0] < to[0] ? end[0] : to[0],
                                                end[1] < to[1] ? end[1] : to[1]},
                                 &most, out);
        }
    return found;
}
