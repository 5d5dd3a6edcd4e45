/* Makes a tile of a grid of heights a leaf. */
#include "base/memory.h"
#include "base/wide.h"
#include "formats/chunk/codec/inline.h"
#include "formats/chunk/codec/square/plane_fit.h"
#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/grid/grid_windows.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define SIDE_WITH_REACH (STP_TILE_SIDE + 2 * STP_GRID_REACH)
#define TILE_SQUARES ((STP_TILE_SIDE / STP_SQUARE_SIDE) * (STP_TILE_SIDE / STP_SQUARE_SIDE))
/* A sample's disc is at most as wide as that of a cell this many times as large. */
#define WIDEST_CELL 4.0
/* Discs have sizes of so many steps an octave, lest noise makes each a size of its own. */
#define STRETCH_STEPS 4
/* Half the diagonal of a cell over the disc's spacing, at most: discs of the default size meet. */
#define DIAGONAL_SHARE 0.6

/* Radius of a disc at the border of a hole over half the diagonal of a cell. */
#define BORDER_SHARE 1.06

/* What is found of a sample. Its item, six times as large, is made just before it goes into a
 * patch.
 */
typedef struct found {
    double spacing;
    vec3s normal;
    uint8_t normal_code[3];
    int16_t exponent;
    uint16_t column, row; /* in the tile */
} found;

/* A tile with the samples around it, as far as normals reach. */
typedef struct tile {
    const stp_height_grid *grid;
    const stp_point_item_params *params;
    uint32_t column, row;   /* of its first sample */
    uint32_t columns, rows; /* as far as the grid goes */
    stp_raster_frame frame; /* of the square at hand */
    double diagonal;        /* of its cells, the greater one */
    double side;            /* the root of a cell's area */
    double reach;           /* where holes grow: no disc of the square is limited to less */
    double spacing, wanted; /* of the sample before, and its lattice; 0: there is none */
    int exponent;
    double *z;      /* SIDE_WITH_REACH squared; NaN: none */
    found *found;   /* of square after square */
    uint32_t *ends; /* of the squares' samples */
    stp_chunk_extent extent;
    stp_patch_grid *grids; /* by square */
    uint32_t *together;    /* ends, among the squares, of those that lie together */
    uint32_t count, squares, together_count;
} tile;

static stp_raster_frame frame_at(const stp_height_grid *grid, uint32_t column, uint32_t row)
{
    return stp_raster_frame_at(&grid->raster, grid->nodes, column, row);
}

STP_INLINE double *height_at(const tile *t, uint32_t column, uint32_t row)
{
    return t->z + (size_t)(row + STP_GRID_REACH) * SIDE_WITH_REACH + column + STP_GRID_REACH;
}

static void load(tile *t)
{
    const stp_scan_raster *r = &t->grid->raster;
    for (uint32_t j = 0; j < SIDE_WITH_REACH; j++) {
        const int64_t row = (int64_t)t->row + j - STP_GRID_REACH;
        for (uint32_t i = 0; i < SIDE_WITH_REACH; i++) {
            const int64_t column = (int64_t)t->column + i - STP_GRID_REACH;
            const bool inside = row >= 0 && row < r->rows && column >= 0 && column < r->columns;
            t->z[(size_t)j * SIDE_WITH_REACH + i] =
                inside ? t->grid->z[(uint64_t)row * r->columns + (uint64_t)column] : NAN;
        }
    }
}

/* Whether all samples of a window are there and on the same surface. */
STP_INLINE bool is_whole(const stp_grid_windows *w, unsigned lane)
{
    return w->beyond[lane] <= 0.0 && !isnan(w->xz[lane] + w->yz[lane]);
}

/* Whether the chunk's columns are the grid's rows. The codec expects normals on the side from which
 * columns turn left to rows, but for level rasters. */
static bool is_turned(const stp_height_grid *grid, const stp_raster_frame *frame)
{
    return grid->nodes != NULL && frame->area < 0.0;
}

/* Of the window around a sample of the row, less what is behind a cliff. */
STP_INLINE stp_plane_sums sum_window(const tile *t, const double *middle, const stp_grid_windows *w,
                                     unsigned lane)
{
    const int reach = (int)t->grid->reach;
    stp_plane_sums s = {0};
    for (int j = -reach; j <= reach; j++)
        for (int i = -reach; i <= reach; i++) {
            const double z = middle[j * (int)SIDE_WITH_REACH + i] - *middle;
            if (fabs(z) <= w->by_columns[abs(i)][lane] + w->by_rows[abs(j)][lane] +
                               w->noise) /* else a cliff, or none */
                stp_plane_add(&s, i, j, z);
        }
    return s;
}

/* The normal of the plane that fits best through the samples around; upwards where they tell
 * nothing. */
STP_INLINE stp_dvec3 normal_of(const tile *t, const double *middle, const stp_grid_windows *w,
                               unsigned lane)
{
    const stp_plane_sums s = sum_window(t, middle, w, lane);
    const double *c = t->frame.by_column, *r = t->frame.by_row;
    const double area = t->frame.area;
    double slopes[2]; /* height by column and by row */
    (void)stp_plane_slopes(&s, slopes);
    const stp_dvec3 n = {(c[1] * slopes[1] - r[1] * slopes[0]) / area,
                         (r[0] * slopes[0] - c[0] * slopes[1]) / area, 1.0};
    return stp_dvec3_normalize(n);
}

/* The place of a normal's coordinate on the grid of its codes, whose steps are 2^shift: the
 * nearest, coordinate by coordinate, as a payload expects it. all: the coordinates' magnitudes,
 * summed up. */
STP_INLINE double place_of_normal(double coordinate, double all, unsigned shift)
{
    const double step = (double)(1u << shift), most = (1u << STP_NORMAL_BITS) - 1;
    return floor((coordinate / all + 1.0) * 0.5 * most / step + 0.5);
}

STP_INLINE void put_normal(const double place[2], unsigned shift, uint8_t out[3])
{
    int32_t code[2];
    for (int i = 0; i < 2; i++)
        code[i] = stp_normal_grid_code((int32_t)place[i], shift);
    stp_normal_codes_put(code, out);
}

/* Sets normals and their codes of a row, by the sums of whole windows: the arithmetic is that of
 * normal_of, a lane a sample. */
STP_INLINE void find_normals(const tile *t, unsigned shift, stp_grid_windows *restrict w)
{
    const int reach = (int)t->grid->reach, side = 2 * reach + 1;
    const int squares = reach * (reach + 1) * side / 3; /* of a row's columns, summed up */
    const double xx = side * squares, det = xx * xx;
    const double c[2] = {t->frame.by_column[0], t->frame.by_column[1]};
    const double r[2] = {t->frame.by_row[0], t->frame.by_row[1]}, area = t->frame.area;
#pragma GCC unroll 1
    for (unsigned k = 0; k < STP_SQUARE_SIDE; k++) {
        const double slope = w->xz[k] * xx / det, fall = w->yz[k] * xx / det;
        const double x = (c[1] * fall - r[1] * slope) / area;
        const double y = (r[0] * slope - c[0] * fall) / area;
        const double scale = 1.0 / sqrt(x * x + y * y + 1.0);
        const double n[3] = {x * scale, y * scale, scale}, all = fabs(n[0]) + fabs(n[1]) + n[2];
        w->normal[0][k] = n[0];
        w->normal[1][k] = n[1];
        w->normal[2][k] = n[2];
        w->code[0][k] = place_of_normal(n[0], all, shift);
        w->code[1][k] = place_of_normal(n[1], all, shift);
    }
}

/* Whether the sample, which is none, is one of 2 x 2 that are none. */
static bool is_in_wide_hole(const double *none)
{
    const int row = SIDE_WITH_REACH;
    for (int j = -row; j <= row; j += 2 * row)
        for (int i = -1; i <= 1; i += 2)
            if (isnan(none[i]) && isnan(none[j]) && isnan(none[i + j]))
                return true;
    return false;
}

/* Whether a sample is next to a hole two samples wide or wider, or at the grid's border. */
static bool is_border(const double *middle)
{
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) {
            const double *next = middle + j * (int)SIDE_WITH_REACH + i;
            if (isnan(*next) && is_in_wide_hole(next))
                return true;
        }
    return false;
}

/* How much wider a disc is than a level one: the root of how much larger its cell is, in steps. */
static double stretch_of(double upwards)
{
    static const double stretch[STRETCH_STEPS + 1] = {
        1.0, 0x1.306fe0a31b715p+0, 0x1.6a09e667f3bcdp+0, 0x1.ae89f995ad3adp+0, 2.0};
    /* squares of what lies amid two steps */
    static const double from[STRETCH_STEPS] = {0x1.306fe0a31b715p+0, 0x1.ae89f995ad3adp+0,
                                               0x1.306fe0a31b715p+1, 0x1.ae89f995ad3adp+1};
    const double cell = stp_min(1.0 / stp_max(upwards, 1e-3), WIDEST_CELL);
    unsigned step = 0;
    for (unsigned k = 0; k < STRETCH_STEPS; k++)
        step += cell > from[k];
    return stretch[step];
}

/* At the border of a wide hole a disc is just large enough to meet its neighbours, so that the hole
 * stays as wide as it is. Single samples that are missing are closed. */
STP_INLINE double spacing_of(const tile *t, const double *middle, bool whole, double upwards)
{
    const double stretch = stretch_of(upwards);
    if (!whole && !t->grid->holes && is_border(middle))
        return 0.5 * BORDER_SHARE * stretch * t->diagonal / t->params->lambda;
    return stp_max(stretch * t->side, DIAGONAL_SHARE * t->diagonal);
}

/* Where holes grow, no disc covers a place without a sample. */
STP_INLINE double open_spacing(const tile *t, stp_dvec3 place, double spacing)
{
    const double radius = spacing * t->params->lambda;
    if (!t->grid->holes || radius <= t->reach)
        return spacing;
    return stp_holes_radius(t->grid->holes, place, radius) / t->params->lambda;
}

/* Where a bent raster's sample is, or where its frame, as a chunk has it, has it: places of such
 * samples need no bytes. */
static stp_dvec3 bent_place(const stp_height_grid *grid, const stp_raster_frame *f, uint32_t column,
                            uint32_t row, double z)
{
    const double *xy = grid->xy[(uint64_t)row * grid->raster.columns + column];
    double at[2];
    for (int k = 0; k < 2; k++)
        at[k] = f->at[k] + (column - f->first[0]) * (double)(float)f->by_column[k] +
                (row - f->first[1]) * (double)(float)f->by_row[k];
    if (hypot(at[0] - xy[0], at[1] - xy[1]) <= grid->move_most)
        return (stp_dvec3){at[0], at[1], z};
    return (stp_dvec3){xy[0], xy[1], z};
}

/* The place of a sample of the tile. frame: of its square. */
STP_INLINE stp_dvec3 place_of(const tile *t, const stp_raster_frame *frame, uint32_t column,
                              uint32_t row)
{
    const double z = *height_at(t, column, row);
    const uint32_t c = t->column + column, r = t->row + row;
    return t->grid->xy ? bent_place(t->grid, frame, c, r, z)
                       : stp_scan_raster_at(&t->grid->raster, c, r, z);
}

STP_INLINE void set_item(stp_item *out, const tile *t, const found *s, stp_dvec3 position)
{
    const stp_height_grid *grid = t->grid;
    const uint64_t place =
        (uint64_t)(t->row + s->row) * grid->raster.columns + t->column + s->column;
    stp_point_facts facts = {
        .position = position,
        .spacing = s->spacing,
        .normal = s->normal,
        .normal_code = {s->normal_code[0], s->normal_code[1], s->normal_code[2]},
        .source = (uint32_t)place,
        .rgb = {STP_POINT_GREY, STP_POINT_GREY, STP_POINT_GREY},
        .flags =
            STP_SAMPLE_HAS_NORMAL | STP_SAMPLE_ORIENTED | STP_FIT_GIVEN << STP_SAMPLE_FIT_SHIFT};
    for (int k = 0; grid->rgb && k < 3; k++)
        facts.rgb[k] = grid->rgb[place][k];
    stp_point_item_set(out, &facts, s->exponent, t->params);
}

/* stp_run_maker, of a tile: a run is a square. */
static void make_items(const void *context, const uint32_t *order, uint32_t count, stp_item *items)
{
    const tile *t = context;
    const found *first = &t->found[order[0]];
    const stp_raster_frame frame =
        frame_at(t->grid, t->column + (first->column & ~(STP_SQUARE_SIDE - 1u)),
                 t->row + (first->row & ~(STP_SQUARE_SIDE - 1u)));
    for (uint32_t i = 0; i < count; i++) {
        const found *s = &t->found[order[i]];
        set_item(&items[i], t, s, place_of(t, &frame, s->column, s->row));
    }
}

STP_INLINE void add_sample(tile *t, uint32_t column, uint32_t row, const stp_grid_windows *sums)
{
    const double *z = height_at(t, column, row);
    if (isnan(*z))
        return;
    const unsigned lane = column % STP_SQUARE_SIDE;
    const unsigned shift = STP_NORMAL_BITS - t->params->normal_bits;
    const bool whole = is_whole(sums, lane);
    stp_dvec3 normal = {sums->normal[0][lane], sums->normal[1][lane], sums->normal[2][lane]};
    double code[2] = {sums->code[0][lane], sums->code[1][lane]};
    if (!whole) {
        normal = normal_of(t, z, sums, lane);
        const double all = fabs(normal.x) + fabs(normal.y) + normal.z;
        code[0] = place_of_normal(normal.x, all, shift);
        code[1] = place_of_normal(normal.y, all, shift);
    }
    const stp_dvec3 place = place_of(t, &t->frame, column, row);
    found *out = &t->found[t->count++];
    const double wanted = spacing_of(t, z, whole, normal.z);
    out->spacing = open_spacing(t, place, wanted);
    out->normal = stp_dvec3_to_float(normal);
    out->column = (uint16_t)column;
    out->row = (uint16_t)row;
    put_normal(code, shift, out->normal_code);
    stp_dbox_add(&t->extent.box, place);
    if (out->spacing != t->spacing || wanted != t->wanted) { /* most have those of the one before */
        t->spacing = out->spacing;
        t->wanted = wanted;
        t->exponent = stp_point_exponent(place, wanted, t->params);
        out->exponent = (int16_t)t->exponent;
        stp_item item;
        set_item(&item, t, out, place);
        stp_chunk_extent_add(&t->extent, place, item.area, item.disc.bound, item.exponent);
    }
    out->exponent = (int16_t)t->exponent;
}

/* The greatest radius that discs of a square may have, wherever in it. Those of cells are no wider
 * than so many diagonals. */
static double reach_of(const tile *t, uint32_t column, uint32_t row)
{
    const double half = 0.5 * (STP_SQUARE_SIDE - 1), most = 2.0 * STP_SQUARE_SIDE;
    const stp_dvec3 middle =
        stp_raster_frame_place(&t->frame, t->column + column + half, t->row + row + half);
    return stp_holes_radius(t->grid->holes, middle, most * t->diagonal) - half * t->diagonal;
}

/* Samples stand in Morton order, so that those that a level merges are next to each other. */
STP_WIDE
static void add_square(tile *t, uint32_t column, uint32_t row)
{
    const uint32_t before = t->count;
    if (column >= t->columns || row >= t->rows) /* a square beyond the grid */
        return;
    t->frame = frame_at(t->grid, t->column + column, t->row + row);
    const double *across = t->frame.by_column, *down = t->frame.by_row;
    t->diagonal = fmax(hypot(across[0] + down[0], across[1] + down[1]),
                       hypot(across[0] - down[0], across[1] - down[1]));
    t->side = sqrt(fabs(t->frame.area));
    const double sides[2] = {t->frame.wide, t->frame.deep};
    const bool turned = is_turned(t->grid, &t->frame);
    if (t->grid->holes)
        t->reach = reach_of(t, column, row);
    stp_grid_windows by_row[STP_SQUARE_SIDE];
    for (uint32_t r = 0; r < STP_SQUARE_SIDE; r++) {
        const double *middle = height_at(t, column, row + r);
        stp_grid_windows_sum(middle, SIDE_WITH_REACH, sides, t->grid, &by_row[r]);
        find_normals(t, STP_NORMAL_BITS - t->params->normal_bits, &by_row[r]);
    }
    for (uint32_t i = 0; i < STP_SQUARE_SIDE * STP_SQUARE_SIDE; i++) {
        const uint32_t a = stp_square_column(i), b = stp_square_row(i);
        const uint32_t c = column + (turned ? b : a), r = row + (turned ? a : b);
        if (c < t->columns && r < t->rows)
            add_sample(t, c, r, &by_row[r - row]);
    }
    if (t->count == before)
        return;
    t->grids[t->squares] = (stp_patch_grid){.along = {0.0, 0.0, 1.0},
                                            .merged_bits = stp_merged_bits(t->params->normal_bits),
                                            .noise = t->grid->noise,
                                            .level = t->grid->nodes == NULL};
    t->ends[t->squares++] = t->count;
}

/* So do squares. Those of 8 x 8 squares lie together, and so do more if there are no more than 64.
 */
static void add_squares(tile *t)
{
    uint32_t begin = 0, end = 0; /* of squares that lie together */
    for (uint32_t i = 0; i < TILE_SQUARES; i++) {
        const uint32_t c = stp_square_column(i), r = stp_square_row(i);
        add_square(t, c * STP_SQUARE_SIDE, r * STP_SQUARE_SIDE);
        if ((i + 1) % STP_PATCH_SAMPLES > 0 || t->squares == end)
            continue;
        if (end > begin && t->squares - begin > STP_PATCH_SAMPLES) {
            t->together[t->together_count++] = end;
            begin = end;
        }
        end = t->squares;
    }
    t->together[t->together_count++] = end;
}

/* A frame as a chunk has it. Rasters that are not level have floats. */
static stp_raster raster_of(const stp_height_grid *grid, const stp_raster_frame *frame,
                            stp_dvec3 origin)
{
    const bool level = grid->nodes == NULL, turned = is_turned(grid, frame);
    const double from[2] = {origin.x, origin.y};
    const double *columns = turned ? frame->by_row : frame->by_column;
    const double *rows = turned ? frame->by_column : frame->by_row;
    stp_raster out = {.level = level, .axis = 2, .side = level ? 0 : STP_RASTER_NODE};
    for (int k = 0; k < 2; k++) {
        out.across[k][0] = frame->at[k] - from[k];
        out.across[k][1] = level ? columns[k] : (double)(float)columns[k];
        out.across[k][2] = level ? rows[k] : (double)(float)rows[k];
    }
    return out;
}

/* Tells the chunk the rasters of the tile: one for each frame. */
static stp_status add_rasters(const tile *t, stp_built_chunk *out, stp_error *err)
{
    const stp_height_grid *grid = t->grid;
    const uint32_t each = grid->nodes ? STP_RASTER_NODE : STP_TILE_SIDE,
                   side = STP_TILE_SIDE / each;
    stp_raster *rasters = NULL;
    const stp_status status =
        stp_alloc(&rasters, (size_t)side * side, sizeof *rasters, "rasters", err);
    if (status != STP_OK)
        return status;
    out->chunk->rasters = rasters;
    out->chunk->reach = grid->reach;
    for (uint32_t r = 0; r < t->rows; r += each)
        for (uint32_t c = 0; c < t->columns; c += each) {
            const stp_raster_frame frame = frame_at(grid, t->column + c, t->row + r);
            rasters[out->chunk->raster_count++] = raster_of(grid, &frame, out->origin);
        }
    return STP_OK;
}

/* How far stored samples are from those that were read: items were moved. Samples stand in their
 * order. */
static void measure_displacement(const tile *t, stp_built_chunk *out)
{
    const stp_chunk *chunk = out->chunk;
    stp_resolution resolution = t->params->resolution;
    uint32_t i = 0;
    if (resolution.precision > 0.0)
        resolution.precision += t->grid->move_most;
    out->displacement = (stp_displacement){0};
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (; i < chunk->level_begin[0][p + 1]; i++) {
            const stp_dvec3 own = stp_sample_position(&chunk->samples[0][i], &chunk->patches[p]);
            const found *s = &t->found[i];
            const uint64_t row = t->row + s->row, column = t->column + s->column;
            const double *xy = t->grid->xy[row * t->grid->raster.columns + column];
            const stp_dvec3 read = {xy[0], xy[1], *height_at(t, s->column, s->row)};
            stp_item item;
            set_item(&item, t, s, read);
            stp_displacement_add(&out->displacement, &item, stp_dvec3_add(out->origin, own),
                                 &resolution);
        }
}

static uint32_t least(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

stp_status stp_height_grid_leaf(const stp_height_grid *grid, uint32_t index,
                                const stp_point_item_params *params, stp_built_chunk *out,
                                stp_error *err)
{
    stp_status status = STP_OK;
    tile t = {.grid = grid,
              .params = params,
              .column = index % grid->tile_columns * STP_TILE_SIDE,
              .row = index / grid->tile_columns * STP_TILE_SIDE,
              .extent = stp_chunk_extent_none(params->vertex_least)};
    t.columns = least(grid->raster.columns - t.column, STP_TILE_SIDE);
    t.rows = least(grid->raster.rows - t.row, STP_TILE_SIDE);
    STP_TRY(stp_alloc_unset(&t.z, (size_t)SIDE_WITH_REACH * SIDE_WITH_REACH, sizeof *t.z, "heights",
                            err));
    STP_TRY(stp_alloc_unset(&t.found, grid->tile_samples[index], sizeof *t.found, "samples", err));
    STP_TRY(stp_alloc(&t.ends, TILE_SQUARES, sizeof *t.ends, "patches", err));
    STP_TRY(stp_alloc(&t.together, TILE_SQUARES, sizeof *t.together, "patches", err));
    STP_TRY(stp_alloc(&t.grids, TILE_SQUARES, sizeof *t.grids, "patches", err));
    load(&t);
    add_squares(&t);
    const stp_item_group group = {.make = make_items,
                                  .context = &t,
                                  .extent = &t.extent,
                                  .run_ends = t.ends,
                                  .together_ends = t.together,
                                  .run_grids = t.grids,
                                  .holes = grid->holes,
                                  .regular = true,
                                  .count = t.count,
                                  .run_count = t.squares,
                                  .together_count = t.together_count};
    STP_TRY(stp_chunk_build_leaf(out, &group, params, err));
    if (grid->xy)
        measure_displacement(&t, out);
    STP_TRY(add_rasters(&t, out, err));
done:
    free(t.z);
    free(t.found);
    free(t.ends);
    free(t.together);
    free(t.grids);
    return status;
}

stp_dvec3 stp_height_grid_tile_middle(const stp_height_grid *grid, uint32_t index)
{
    const uint32_t below = index / grid->tile_columns, right = index % grid->tile_columns;
    const uint32_t column = right * STP_TILE_SIDE + STP_TILE_SIDE / 2;
    const uint32_t row = below * STP_TILE_SIDE + STP_TILE_SIDE / 2;
    const stp_raster_frame frame =
        frame_at(grid, least(column, grid->raster.columns - 1), least(row, grid->raster.rows - 1));
    stp_dvec3 out = stp_raster_frame_place(&frame, column, row);
    out.z = 0.5 * (grid->box.min.z + grid->box.max.z);
    return out;
}
