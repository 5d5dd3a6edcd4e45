/* Rows of discs, and the search for the nearest one. */
#include "formats/chunk/measure/disc_rows.h"

#include "base/memory.h"
#include "base/wide.h"

#include <stdlib.h>

#define FAR 1e18f /* its square is a float, too */
#define STEP ((int)STP_LANE_STEP)
/* Columns before that of a point that are tried, and rows on either side of it. No other disc has
 * its place in less than 4 sides of a cell from the point. */
#define BEFORE 3
#define RINGS 4
/* Squares of places that share a greatest radius: those beside a square hold all that a search
 * tries. */
#define SQUARE 8
/* Places around those of the chunk: a merged disc reaches some 12 cells out of its patch. */
#define MARGIN 32
/* A disc lies this near to its place, in sides of a cell. No comparison here is with what is not
 * finite: the compiler takes all numbers for finite. */
#define OFF_MOST 0.03125f
/* A nearest disc is sure within this distance, in sides of a cell; for that, discs beyond the
 * squares beside a point's own have no larger radius than this. */
#define ROOM_MOST 2.0f
#define RADIUS_MOST ((float)SQUARE - ROOM_MOST)
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
/* The factor of squared distances for errors of floats. */
#define ROOM_SLACK 0.9999f

/* The place of a disc. False if it is off its place. */
static bool find_place(const stp_disc_rows *r, const float centre[3], int out[2])
{
    for (int a = 0; a < 2; a++) {
        const float at = (centre[a] - r->first[a]) * r->inverse[a], whole = floorf(at + 0.5f);
        if (!(fabsf(at - whole) <= OFF_MOST) || fabsf(whole) > 0x1p24f)
            return false;
        out[a] = (int)whole;
    }
    return true;
}

/* Sets columns, rows and the first place from the chunk's own discs. False if they are in no rows
 * or too far apart. */
static bool find_extent(stp_disc_rows *r, const stp_disc_grid *g)
{
    int low[2] = {INT32_MAX, INT32_MAX}, high[2] = {INT32_MIN, INT32_MIN};
    for (uint32_t d = 0; d < g->own_count; d++) {
        int at[2];
        if (!find_place(r, g->numbers[d].numbers, at))
            return false;
        for (int a = 0; a < 2; a++) {
            low[a] = at[a] < low[a] ? at[a] : low[a];
            high[a] = at[a] > high[a] ? at[a] : high[a];
        }
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

static float *widest_at(const stp_disc_rows *r, int column, int row)
{
    return r->widest + (size_t)(row / SQUARE) * (size_t)(r->columns / SQUARE + 1) + column / SQUARE;
}

/* Raises the greatest radius of each square to those of the squares beside it: first along rows,
 * then along columns. */
static stp_status widen(stp_disc_rows *r, stp_error *err)
{
    const size_t wide = (size_t)r->columns / SQUARE + 1, deep = (size_t)r->rows / SQUARE + 1;
    const size_t count = wide * deep;
    float *along = NULL;
    const stp_status status = stp_alloc(&along, count, sizeof *along, "discs", err);
    for (size_t row = 0; status == STP_OK && row < count; row += wide)
        for (size_t i = row; i < row + wide; i++)
            along[i] = fmaxf(r->widest[i], fmaxf(i > row ? r->widest[i - 1] : 0.0f,
                                                 i + 1 < row + wide ? r->widest[i + 1] : 0.0f));
    for (size_t i = 0; status == STP_OK && i < count; i++)
        r->widest[i] = fmaxf(along[i], fmaxf(i >= wide ? along[i - wide] : 0.0f,
                                             i + wide < count ? along[i + wide] : 0.0f));
    free(along);
    return status;
}

/* Puts all discs into their places. False if two have one place, or one is too large or off. */
static bool put_discs(stp_disc_rows *r, const stp_disc_grid *g)
{
    const size_t columns = (size_t)r->columns;
    for (size_t i = 0; i < (size_t)r->rows * columns * STP_LANE_CARRIED; i++)
        r->numbers[i] = FAR;
    for (uint32_t d = 0; d < g->count; d++) {
        const float *from = g->numbers[d].numbers;
        int at[2];
        if (!find_place(r, from, at) || !(from[STP_LANE_RADIUS] <= RADIUS_MOST * r->side))
            return false;
        if (at[0] < 0 || at[1] < 0 || at[0] >= r->columns || at[1] >= r->rows)
            continue;
        float *to = numbers_at(r, at[0], at[1]);
        if (to[0] != FAR)
            return false;
        for (size_t c = 0; c < STP_LANE_CARRIED; c++)
            to[c * columns] = from[c];
        r->disc[(size_t)at[1] * columns + (size_t)at[0]] = d;
        float *widest = widest_at(r, at[0], at[1]);
        *widest = fmaxf(*widest, from[STP_LANE_RADIUS]);
    }
    return true;
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

/* The least of four places beside one, those before it or (by = -1) behind it, and 1 more. */
static uint8_t next_away(const stp_disc_rows *r, int column, int row, int by)
{
    static const int beside[4][2] = {{-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    unsigned least = MARGIN;
    for (int k = 0; k < 4; k++) {
        const int i = column + by * beside[k][0], j = row + by * beside[k][1];
        const bool inside = i >= 0 && i < r->columns && j >= 0 && j < r->rows;
        const unsigned away = inside ? r->away[(size_t)j * (size_t)r->columns + (size_t)i] : MARGIN;
        least = away < least ? away : least;
    }
    return (uint8_t)(least + 1);
}

static stp_status find_holes(stp_disc_rows *r, stp_error *err)
{
    const size_t count = (size_t)r->columns * (size_t)r->rows;
    if (is_whole(r))
        return STP_OK;
    const stp_status status = stp_alloc(&r->away, count, sizeof *r->away, "holes", err);
    if (status != STP_OK)
        return status;
    for (int by = 1; by >= -1; by -= 2)
        for (size_t n = 0; n < count; n++) {
            const size_t place = by > 0 ? n : count - 1 - n;
            const int column = (int)(place % (size_t)r->columns),
                      row = (int)(place / (size_t)r->columns);
            const uint8_t next = next_away(r, column, row, by);
            if (*numbers_at(r, column, row) != FAR)
                r->away[place] = 0;
            else if (by > 0 || next < r->away[place])
                r->away[place] = next;
        }
    return STP_OK;
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
    r.side = (1.0f - OFF_MOST) / fmaxf(fabsf(r.inverse[0]), fabsf(r.inverse[1]));
    if (!find_extent(&r, grid))
        return STP_OK;
    const size_t places = (size_t)r.columns * (size_t)r.rows;
    const size_t squares = (size_t)(r.columns / SQUARE + 1) * (size_t)(r.rows / SQUARE + 1);
    STP_TRY(stp_alloc(&r.numbers, places * STP_LANE_CARRIED, sizeof *r.numbers, "discs", err));
    STP_TRY(stp_alloc(&r.disc, places, sizeof *r.disc, "discs", err));
    STP_TRY(stp_alloc(&r.widest, squares, sizeof *r.widest, "discs", err));
    if (put_discs(&r, grid)) {
        STP_TRY(widen(&r, err));
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
    free(r->widest);
    free(r->away);
    *r = (stp_disc_rows){0};
}

/* What a search has found so far, by lane. */
typedef struct nearest {
    float squared[STEP];
    int row[STEP];
} nearest;

/* Tries the discs of a row from `column` on. */
static inline void try_row(const stp_disc_rows *r, int column, int row, const float point[3],
                           nearest *f)
{
    const float *at[STP_LANE_CARRIED];
    const size_t columns = (size_t)r->columns;
    for (size_t c = 0; c < STP_LANE_CARRIED; c++)
        at[c] = numbers_at(r, column, row) + c * columns;
    for (int i = 0; i < STEP; i++) {
        float disc[STP_LANE_NUMBERS], height;
        for (int c = 0; c < STP_LANE_CARRIED; c++)
            disc[c] = at[c][i];
        const float overhang = stp_lane_overhang(point, disc, &height);
        const float squared = height * height + overhang * overhang;
        f->row[i] = squared < f->squared[i] ? row : f->row[i];
        f->squared[i] = fminf(squared, f->squared[i]);
    }
}

static inline float least_of(const nearest *f)
{
    float least = f->squared[0];
    for (int i = 1; i < STEP; i++)
        least = fminf(least, f->squared[i]);
    return least;
}

static inline uint32_t disc_of_least(const stp_disc_rows *r, const nearest *f, int column,
                                     float least)
{
    int lane = 0;
    for (int i = 1; i < STEP; i++)
        lane = f->squared[i] == least ? i : lane;
    return r->disc[(size_t)f->row[lane] * (size_t)r->columns + (size_t)(column - BEFORE + lane)];
}

STP_WIDE
static bool search(const stp_disc_rows *r, const float x[3], const int at[2],
                   const stp_near_enough *enough, float *squared, uint32_t *disc)
{
    const float point[3] = {x[0], x[1], x[2]}, widest = *widest_at(r, at[0], at[1]);
    nearest f;
    for (int i = 0; i < STEP; i++) {
        f.squared[i] = FAR * FAR;
        f.row[i] = at[1];
    }
    for (int ring = 1; ring <= RINGS; ring++) {
        try_row(r, at[0] - BEFORE, at[1] + 1 - ring, point, &f);
        try_row(r, at[0] - BEFORE, at[1] + ring, point, &f);
        const float room = fminf((float)ring * r->side - widest, ROOM_MOST * r->side);
        const float least = least_of(&f);
        const bool done =
            least <= enough->squared || (room > 0.0f && least < room * room * ROOM_SLACK);
        if (!done && least > enough->over.near_squared)
            continue;
        *squared = least;
        *disc = disc_of_least(r, &f, at[0], least);
        if (done || stp_lane_cost(&r->discs[*disc], &enough->over, point) <= enough->cost)
            return true;
    }
    return false;
}

bool stp_disc_rows_nearest(const stp_disc_rows *r, stp_dvec3 x, const stp_near_enough *enough,
                           double *squared, uint32_t *disc)
{
    const float point[3] = {(float)x.x, (float)x.y, (float)x.z};
    const int most[2] = {r->columns - (STEP - BEFORE), r->rows - (STEP - BEFORE)};
    int at[2];
    float least = 0.0f;
    for (int a = 0; a < 2; a++) {
        const float place = (point[a] - r->first[a]) * r->inverse[a];
        if (!(place >= (float)RINGS && place < (float)most[a]))
            return false;
        at[a] = (int)place;
    }
    const bool found = search(r, point, at, enough, &least, disc);
    *squared = (double)least;
    return found;
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

bool stp_disc_rows_hole(const stp_disc_rows *r, const stp_disc *disc, stp_dvec3 *out)
{
    const double centre[2] = {disc->centre.x, disc->centre.y};
    const int count[2] = {r->columns, r->rows};
    int from[2], to[2];
    unsigned most = HOLE_LEAST - 1;
    bool found = false;
    if (!r->away || fabs(disc->normal.z) < LEVEL_LEAST)
        return false;
    for (int a = 0; a < 2; a++) {
        const double middle = (centre[a] - (double)r->first[a]) * (double)r->inverse[a];
        const double reach = disc->radius * fabs((double)r->inverse[a]);
        from[a] = (int)fmax(0.0, ceil(middle - reach));
        to[a] = (int)fmin((double)count[a] - 1.0, floor(middle + reach));
    }
    for (int row = from[1]; row <= to[1]; row++)
        for (int column = from[0]; column <= to[0]; column++) {
            const unsigned away = r->away[(size_t)row * (size_t)r->columns + (size_t)column];
            stp_dvec3 point;
            if (away <= most || !point_at(r, disc, column, row, &point))
                continue;
            most = away;
            *out = point;
            found = true;
        }
    return found;
}
