/* Turns rows of heights into points. */
#include "formats/scan/grid/grid.h"

#include "base/memory.h"
#include "base/wide.h"
#include "formats/scan/grid/depth_guess.h"
#include "formats/scan/grid/raster.h"
#include "formats/scan/grid/relief_guess.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Rows that are in memory: the one that is read now, the one above it, the one below. */
enum { ROWS_HELD = 3 };

/* Squares of such slopes are still numbers. */
#define STEEPEST 1e150

typedef struct grid_reader {
    const char *path;
    uint32_t copy_step; /* as the heights were opened */
    stp_grid_params params;
    stp_raster_file *heights, *colours, *mask;
    const stp_raster_info *info, *colour_info, *mask_info;
    double *row, *colour_row, *mask_row; /* as the files have them */
    double *z[ROWS_HELD];                /* heights of row r at r % ROWS_HELD; NaN: no sample */
    uint16_t (*rgb[ROWS_HELD])[3];
    uint32_t step, columns, rows; /* every step-th column and row of the files is one of these */
    uint32_t rows_read, next_row, next_column;
    stp_scan_raster place; /* of heights */
    double by[2][2];       /* what the file's columns and rows that are read add to x and y */
    bool normals;
    stp_dvec3 camera; /* the origin, a station */
    char format[64];
    char keys[128];    /* GeoTIFF's keys, as text */
    char guessed[256]; /* a note of a pinhole or a spacing that is guessed; else "" */
    stp_scan_note note;
} grid_reader;

/* One row or column alone is a line of points. */
static bool is_plane(const grid_reader *g)
{
    return g->columns > 1 && g->rows > 1;
}

static bool is_pinhole(const grid_reader *g)
{
    return g->params.fx > 0.0;
}

/* ---- opening ---- */

/* Whether all colours of an image are grey, so that its first channel has heights. */
static stp_status look_for_grey(bool *out, const char *path, const stp_raster_info *info,
                                stp_error *err)
{
    stp_status status = STP_OK;
    stp_raster_file *raster = NULL;
    double *row = NULL;
    bool grey = info->channels - info->alpha == 3;
    STP_TRY(stp_raster_open(&raster, path, STP_RASTER_HEIGHTS, 1, err));
    info = stp_raster_get_info(raster);
    STP_TRY(stp_alloc(&row, info->width, info->channels * sizeof *row, "a row of heights", err));
    for (uint32_t r = 0; r < info->height && grey; r++) {
        STP_TRY(stp_raster_read(raster, r, row, err));
        for (const double *pixel = row; pixel < row + (size_t)info->width * info->channels;
             pixel += info->channels)
            grey = grey && pixel[0] == pixel[1] && pixel[0] == pixel[2];
    }
    *out = grey;
done:
    stp_raster_close(&raster);
    free(row);
    return status;
}

static stp_status check_heights(const grid_reader *g, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_raster_info *info = g->info;
    bool grey = info->channels - info->alpha == 1;
    if (!grey)
        STP_TRY(look_for_grey(&grey, path, info, err));
    if (!grey)
        status = stp_error_set(err, STP_UNSUPPORTED,
                               "%s is a picture of colours (%u channels), not of heights: give the "
                               "heights, and this with --colour",
                               path, info->channels);
done:
    return status;
}

/* Makes room for a row of an image that lies beside the heights, and checks its size. */
static stp_status begin_image(const grid_reader *g, const char *option, const char *file,
                              const char *path, const stp_raster_info *image, double **row,
                              stp_error *err)
{
    if (image->width != g->info->width || image->height != g->info->height)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s %s is %u x %u, but %s is %u x %u: give an image of the same size",
                             option, file, image->width, image->height, path, g->info->width,
                             g->info->height);
    return stp_alloc(row, g->info->width, image->channels * sizeof **row, "a row of an image", err);
}

static stp_status open_mask(grid_reader *g, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    if (g->params.mask == NULL)
        return STP_OK;
    STP_TRY(stp_raster_open(&g->mask, g->params.mask, STP_RASTER_COLOURS, 1, err));
    g->mask_info = stp_raster_get_info(g->mask);
    STP_TRY(begin_image(g, "--mask", g->params.mask, path, g->mask_info, &g->mask_row, err));
done:
    return status;
}

static stp_status open_colours(grid_reader *g, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    const bool own = g->params.colour == NULL;
    /* AL3D brings its own colours; other formats have none */
    if (own && strcmp(g->info->format, "AL3D") != 0)
        return STP_OK;
    status =
        stp_raster_open(&g->colours, own ? path : g->params.colour, STP_RASTER_COLOURS, 1, err);
    if (status != STP_OK) /* an AL3D file may come without colours */
        return own && status == STP_UNSUPPORTED ? STP_OK : status;
    g->colour_info = stp_raster_get_info(g->colours);
    STP_TRY(begin_image(g, "--colour", own ? path : g->params.colour, path, g->colour_info,
                        &g->colour_row, err));
    for (int i = 0; i < ROWS_HELD; i++)
        STP_TRY(stp_alloc(&g->rgb[i], g->columns, sizeof *g->rgb[i], "a row of colours", err));
done:
    return status;
}

/* step: of the file's own columns and rows. */
static void choose_step(grid_reader *g, uint32_t step)
{
    const uint32_t width = g->info->width, height = g->info->height;
    const uint32_t most = (width < height ? width : height) - 1, own = step / g->info->reduced;
    const uint32_t wanted = own > most ? most : own;
    g->step = wanted > 1 ? wanted : 1;
    g->columns = (width - 1) / g->step + 1;
    g->rows = (height - 1) / g->step + 1;
}

/* Puts a column and a row that are not the first ones in place of these, so that x increases along
 * rows and the top row is first. by: what columns and rows add to x and y. */
static void order_place(grid_reader *g, double by[2][2])
{
    stp_scan_raster *p = &g->place;
    if (fabs(by[0][1] * by[1][0]) > fabs(by[0][0] * by[1][1])) {
        const double column[2] = {by[0][0], by[0][1]};
        memcpy(by[0], by[1], sizeof by[0]);
        memcpy(by[1], column, sizeof by[1]);
        p->columns = g->rows;
        p->rows = g->columns;
        p->order = STP_RASTER_BY_COLUMN;
    }
    const uint32_t counts[2] = {p->columns, p->rows};
    const unsigned turned[2] = {by[0][0] < 0.0 ? STP_RASTER_FROM_RIGHT : 0,
                                by[1][1] > 0.0 ? STP_RASTER_FROM_BELOW : 0};
    for (unsigned k = 0; k < 2; k++) {
        if (turned[k] == 0)
            continue;
        p->order |= turned[k];
        p->x += (counts[k] - 1) * by[k][0];
        p->y += (counts[k] - 1) * by[k][1];
        by[k][0] = -by[k][0];
        by[k][1] = -by[k][1];
    }
}

static void choose_place(grid_reader *g)
{
    const stp_raster_info *info = g->info;
    const bool given = g->params.dx > 0.0, own = !given && info->spaced;
    const double reduced = own ? 1.0 : info->reduced;
    const double dx = reduced * (given ? g->params.dx : own ? info->dx : 1.0);
    const double dy = reduced * (given ? g->params.dy : own ? info->dy : 1.0);
    const double step = g->step, turned = own ? step : 0.0;
    const bool placed = !given && info->placed;
    double by[2][2] = {{step * dx, turned * info->skew[0]}, {turned * info->skew[1], -step * dy}};
    memcpy(g->by, by, sizeof by);
    g->place = (stp_scan_raster){.columns = g->columns,
                                 .rows = g->rows,
                                 .x = placed ? info->x : 0.0,
                                 .y = placed ? info->y : (double)(info->height - 1) * dy};
    order_place(g, by);
    g->place.dx = by[0][0];
    g->place.dy = -by[1][1];
    g->place.skew[0] = by[0][1];
    g->place.skew[1] = by[1][0];
    if (g->params.scale == 0.0)
        g->params.scale = 1.0;
    g->place.scale = g->params.scale * (info->scale != 0.0 ? info->scale : 1.0);
    g->place.offset = g->params.scale * (info->scale != 0.0 ? info->offset : 0.0);
}

/* Notes the system of coordinates as LAS files do. */
static void describe_system(grid_reader *g, stp_scan_info *info)
{
    const bool angles = g->info->degrees;
    if (is_pinhole(g) || g->params.dx > 0.0 || (g->info->epsg == 0 && !angles))
        return;
    snprintf(g->keys, sizeof g->keys, "GTModelTypeGeoKey=%d\n%s=%u", angles ? 2 : 1,
             angles ? "GeographicTypeGeoKey" : "ProjectedCSTypeGeoKey", g->info->epsg);
    const size_t length = strlen(g->keys);
    if (g->info->vertical != 0)
        snprintf(g->keys + length, sizeof g->keys - length, "\nVerticalCSTypeGeoKey=%u",
                 g->info->vertical);
    g->note = (stp_scan_note){"geokeys", g->keys};
    info->notes = &g->note;
    info->note_count = 1;
}

static void describe(grid_reader *g, stp_scan_info *info)
{
    const bool pinhole = is_pinhole(g);
    snprintf(g->format, sizeof g->format, "%s of %s", g->info->format,
             !pinhole                          ? "heights"
             : g->params.disparity_focal > 0.0 ? "disparities"
                                               : "depths");
    info->format = g->format;
    info->point_count = (uint64_t)g->columns * g->rows;
    info->attributes = (g->colours != NULL ? STP_POINT_HAS_COLOUR : 0u) |
                       (g->normals ? STP_POINT_HAS_NORMAL : 0u) |
                       (pinhole ? STP_POINT_HAS_STATION : 0u);
    info->heights = !pinhole;
    describe_system(g, info);
    if (g->guessed[0] != '\0') { /* then there is no system */
        g->note = (stp_scan_note){pinhole ? "camera" : "spacing", g->guessed};
        info->notes = &g->note;
        info->note_count = 1;
    }
    if (!pinhole) {
        if (is_plane(g))
            info->raster = g->place;
        info->seek_points = g->columns;
        return;
    }
    info->grid = (stp_scan_grid){.columns = g->columns, .rows = g->rows};
    info->stations = &g->camera;
    info->station_count = 1;
    info->station_word = STP_STATION_TOLD;
}

static stp_status open_grid(void *state, stp_scan_info *info, const char *path,
                            const stp_scan_params *params, stp_error *err)
{
    grid_reader *g = state;
    stp_status status = STP_OK;
    if (params->grid != NULL)
        g->params = *params->grid;
    STP_TRY(stp_depth_guess(&g->params, g->guessed, sizeof g->guessed, path, err));
    STP_TRY(stp_relief_guess(&g->params, g->guessed, sizeof g->guessed, path, err));
    /* images beside the heights have their size, and a pinhole is told for the whole image */
    const bool whole = is_pinhole(g) || g->params.colour != NULL || g->params.mask != NULL;
    const uint32_t step = params->grid_step > 1 ? params->grid_step : 1;
    g->path = path;
    g->copy_step = whole ? 1 : step;
    STP_TRY(stp_raster_open(&g->heights, path, STP_RASTER_HEIGHTS, g->copy_step, err));
    g->info = stp_raster_get_info(g->heights);
    STP_TRY(check_heights(g, path, err));
    choose_step(g, step);
    STP_TRY(stp_alloc(&g->row, g->info->width, g->info->channels * sizeof *g->row,
                      "a row of heights", err));
    for (int i = 0; i < ROWS_HELD; i++)
        STP_TRY(stp_alloc(&g->z[i], g->columns, sizeof *g->z[i], "a row of heights", err));
    STP_TRY(open_colours(g, path, err));
    STP_TRY(open_mask(g, path, err));
    const bool degrees = g->info->degrees && !(g->params.dx > 0.0);
    g->normals = !is_pinhole(g) && !degrees && !params->recompute_normals && is_plane(g);
    choose_place(g);
    describe(g, info);
done:
    return status;
}

/* ---- reading ---- */

/* Far off: by so much of a number. */
#define FAR_PART 0.1

/* Puts heights or depths in the place of numbers; NaN if they are no samples. */
STP_WIDE
static void find_values(const grid_reader *g, double *restrict z)
{
    const stp_grid_params *p = &g->params;
    const double none = g->info->has_none ? g->info->none : NAN; /* NaN equals nothing */
    const double invalid = p->has_invalid ? p->invalid : NAN;
    const double least = is_pinhole(g) ? 0.0 : -STP_SCAN_NONE_FROM; /* a sample's is greater */
    const double focal = p->disparity_focal * p->disparity_base;
    const double scale = g->info->scale, offset = g->info->offset, own = p->scale;
    for (uint32_t i = 0; i < g->columns; i++) {
        const double n = z[i];
        const bool is_sample = n > least && n < STP_SCAN_NONE_FROM && n != none && n != invalid;
        z[i] = is_sample ? n : NAN;
    }
    for (uint32_t i = 0; scale != 0.0 && i < g->columns; i++)
        z[i] = scale * z[i] + offset;
    for (uint32_t i = 0; i < g->columns; i++)
        z[i] = p->disparity_focal > 0.0 ? focal / z[i] : own * z[i];
}

/* Makes holes of such numbers if what lies before and behind them in the row is far off: a trench
 * in the sea has slopes. */
static void leave_out_usual_none(const grid_reader *g, double *z)
{
    const uint32_t channels = g->info->channels, n = g->columns;
    double before = NAN;
    for (uint32_t i = 0; i < n;) {
        const double number = g->row[(size_t)i * g->step * channels];
        uint32_t end = i + 1;
        while (end < n && g->row[(size_t)end * g->step * channels] == number)
            end++;
        const double after = end < n ? g->row[(size_t)end * g->step * channels] : NAN;
        const double far = FAR_PART * fabs(number);
        if (stp_is_usual_none(number) && !(fabs(before - number) < far) &&
            !(fabs(after - number) < far))
            for (uint32_t k = i; k < end; k++)
                z[k] = NAN;
        before = number;
        i = end;
    }
}

/* Whether a row has any of them. */
STP_WIDE
static bool has_usual_none(const double *row, size_t count)
{
    int any = 0;
    for (size_t i = 0; i < count; i++)
        any |= stp_is_usual_none(row[i]);
    return any != 0;
}

static void keep_heights(const grid_reader *g, double *z)
{
    const uint32_t channels = g->info->channels;
    for (uint32_t i = 0; i < g->columns; i++) {
        const double *pixel = g->row + (size_t)i * g->step * channels;
        z[i] = g->info->alpha && pixel[channels - 1] == 0.0 ? NAN : pixel[0];
    }
    find_values(g, z);
    if (!g->params.has_invalid && has_usual_none(g->row, (size_t)g->info->width * channels))
        leave_out_usual_none(g, z);
}

/* Added and taken off, it leaves the nearest whole number, of two the even one. */
#define WHOLE_ADDED 0x1.8p52

/* Numbers up to `full` as 16 bits; NaN becomes 0. */
STP_WIDE
static void keep_numbers(const double *restrict numbers, size_t count, double full,
                         uint16_t *restrict out)
{
    for (size_t i = 0; i < count; i++) {
        const double share = numbers[i] / full;
        const double place = 65535.0 * stp_min(stp_max(share, 0.0), 1.0);
        out[i] = (uint16_t)(int32_t)((place + WHOLE_ADDED) - WHOLE_ADDED);
    }
}

static void keep_colours(const grid_reader *g, double *z, uint16_t (*rgb)[3])
{
    const uint32_t channels = g->colour_info->channels;
    const double full = g->colour_info->full;
    const size_t stride = (size_t)g->step * channels;
    if (channels == 3 && g->step == 1) {
        keep_numbers(g->colour_row, 3 * (size_t)g->columns, full, rgb[0]);
        return;
    }
    for (uint32_t i = 0; i < g->columns; i++) {
        const double *pixel = g->colour_row + i * stride;
        if (g->colour_info->alpha && pixel[channels - 1] == 0.0)
            z[i] = NAN;
        keep_numbers(pixel, channels < 3 ? 1 : 3, full, rgb[i]);
        for (int k = 1; channels < 3 && k < 3; k++)
            rgb[i][k] = rgb[i][0];
    }
}

static void keep_mask(const grid_reader *g, double *z)
{
    const uint32_t channels = g->mask_info->channels, colours = channels - g->mask_info->alpha;
    for (uint32_t i = 0; i < g->columns; i++) {
        const double *pixel = g->mask_row + (size_t)i * g->step * channels;
        bool black = true;
        for (uint32_t k = 0; k < colours; k++)
            black &= !(pixel[k] > 0.0);
        if (black || (g->mask_info->alpha && pixel[channels - 1] == 0.0))
            z[i] = NAN;
    }
}

static stp_status read_row(grid_reader *g, stp_error *err)
{
    stp_status status = STP_OK;
    double *z = g->z[g->rows_read % ROWS_HELD];
    const uint32_t row = g->rows_read * g->step;
    STP_TRY(stp_raster_read(g->heights, row, g->row, err));
    keep_heights(g, z);
    if (g->colours != NULL) {
        STP_TRY(stp_raster_read(g->colours, row, g->colour_row, err));
        keep_colours(g, z, g->rgb[g->rows_read % ROWS_HELD]);
    }
    if (g->mask != NULL) {
        STP_TRY(stp_raster_read(g->mask, row, g->mask_row, err));
        keep_mask(g, z);
    }
    g->rows_read++;
done:
    return status;
}

/* How much heights rise to the next sample: from both sides, or from one, if the other is none.
 * NaN: both are none. */
static double rise(double before, double here, double after)
{
    if (!isnan(before) && !isnan(after))
        return (after - before) / 2.0;
    return isnan(before) ? after - here : here - before;
}

/* Zero, which means unknown, if a sample has no neighbour in its row or none in its column, or if
 * numbers are too large for a slope. */
static vec3s normal_of(const grid_reader *g, uint32_t row, uint32_t column)
{
    const double *z = g->z[row % ROWS_HELD];
    const bool above = row > 0, below = row + 1 < g->rows;
    const double(*by)[2] = g->by;
    const double across = rise(column > 0 ? z[column - 1] : NAN, z[column],
                               column + 1 < g->columns ? z[column + 1] : NAN);
    const double down = rise(above ? g->z[(row - 1) % ROWS_HELD][column] : NAN, z[column],
                             below ? g->z[(row + 1) % ROWS_HELD][column] : NAN);
    double zx = across / by[0][0], zy = down / by[1][1];
    if (by[0][1] != 0.0 || by[1][0] != 0.0) {
        const double area = by[0][0] * by[1][1] - by[0][1] * by[1][0];
        zx = (across * by[1][1] - down * by[0][1]) / area;
        zy = (down * by[0][0] - across * by[1][0]) / area;
    }
    if (!(fabs(zx) < STEEPEST) || !(fabs(zy) < STEEPEST))
        return (vec3s){{0.0f, 0.0f, 0.0f}};
    return stp_dvec3_to_float(stp_dvec3_normalize((stp_dvec3){-zx, -zy, 1.0}));
}

static stp_dvec3 position_of(const grid_reader *g, uint32_t row, uint32_t column, double z)
{
    const stp_grid_params *p = &g->params;
    if (!is_pinhole(g)) {
        uint32_t at[2] = {column, row};
        if (g->place.order != 0)
            stp_scan_raster_find(&g->place, (uint64_t)row * g->columns + column, at);
        return stp_scan_raster_at(&g->place, at[0], at[1], z);
    }
    const double x = ((double)column * g->step - p->cx) / p->fx;
    const double y = ((double)row * g->step - p->cy) / p->fy;
    if (p->along_ray)
        z /= sqrt(x * x + y * y + 1.0);
    return (stp_dvec3){x * z, y * z, z};
}

/* Written in place: copied, it would be read as vectors just after its parts are written. */
static inline void make_point(const grid_reader *g, uint32_t row, uint32_t column, bool level,
                              stp_point *out)
{
    const double z = g->z[row % ROWS_HELD][column];
    memset(out, 0, sizeof *out);
    if (isnan(z)) {
        out->reject = STP_REJECT_INVALID;
        return;
    }
    out->position =
        level ? stp_scan_raster_at(&g->place, column, row, z) : position_of(g, row, column, z);
    out->station = !level && is_pinhole(g) ? 1 : 0;
    if (g->normals)
        out->normal = normal_of(g, row, column);
    for (int k = 0; k < 3; k++)
        out->rgb[k] = g->colours ? g->rgb[row % ROWS_HELD][column][k] : STP_POINT_GREY;
}

/* Makes points side by side. Those of heights whose rows come in order need no look at how. */
static void make_points(const grid_reader *g, uint32_t row, uint32_t column, size_t count,
                        stp_point *out)
{
    const bool level = !is_pinhole(g) && g->place.order == 0;
    for (size_t i = 0; level && i < count; i++)
        make_point(g, row, column + (uint32_t)i, true, &out[i]);
    for (size_t i = 0; !level && i < count; i++)
        make_point(g, row, column + (uint32_t)i, false, &out[i]);
}

static stp_status read_grid(void *state, stp_point *points, size_t capacity, size_t *count,
                            stp_error *err)
{
    grid_reader *g = state;
    stp_status status = STP_OK;
    size_t got = 0;
    while (got < capacity && g->next_row < g->rows) {
        while (g->rows_read < g->rows && g->rows_read < g->next_row + 2)
            STP_TRY(read_row(g, err));
        const size_t left = g->columns - g->next_column;
        const size_t more = capacity - got < left ? capacity - got : left;
        make_points(g, g->next_row, g->next_column, more, &points[got]);
        got += more;
        g->next_column += (uint32_t)more;
        if (g->next_column == g->columns) {
            g->next_column = 0;
            g->next_row++;
        }
    }
    *count = got;
done:
    return status;
}

/* Opens an image anew, if it is there, so that it is read from its top. */
static stp_status open_anew(const grid_reader *g, stp_raster_file **image,
                            const stp_raster_info **info, const char *path, stp_raster_use use,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_raster_file *anew = NULL;
    if (*image == NULL)
        return STP_OK;
    const uint32_t step = use == STP_RASTER_HEIGHTS ? g->copy_step : 1;
    STP_TRY(stp_raster_open(&anew, path, use, step, err));
    const stp_raster_info *now = stp_raster_get_info(anew);
    if (now->channels != (*info)->channels || now->width != (*info)->width ||
        now->height != (*info)->height) {
        status = stp_error_set(err, STP_CORRUPT, "%s changed while it was read", path);
        goto done;
    }
    stp_raster_close(image);
    *image = anew;
    *info = now;
    anew = NULL;
done:
    stp_raster_close(&anew);
    return status;
}

static stp_status seek_grid(void *state, uint64_t point, stp_error *err)
{
    grid_reader *g = state;
    stp_status status = STP_OK;
    const uint32_t row = (uint32_t)(point / g->columns);
    const uint32_t first = row > 0 ? row - 1 : 0; /* normals need the row above */
    const char *colours = g->params.colour != NULL ? g->params.colour : g->path;
    if (first < g->rows_read) {
        STP_TRY(open_anew(g, &g->heights, &g->info, g->path, STP_RASTER_HEIGHTS, err));
        STP_TRY(open_anew(g, &g->colours, &g->colour_info, colours, STP_RASTER_COLOURS, err));
        STP_TRY(open_anew(g, &g->mask, &g->mask_info, g->params.mask, STP_RASTER_COLOURS, err));
    }
    g->rows_read = first;
    g->next_row = row;
    g->next_column = 0;
done:
    return status;
}

static void close_grid(void *state)
{
    grid_reader *g = state;
    stp_raster_close(&g->heights);
    stp_raster_close(&g->colours);
    stp_raster_close(&g->mask);
    free(g->row);
    free(g->colour_row);
    free(g->mask_row);
    for (int i = 0; i < ROWS_HELD; i++) {
        free(g->z[i]);
        free(g->rgb[i]);
    }
}

const stp_scan_reader stp_grid_reader = {.state_bytes = sizeof(grid_reader),
                                         .open = open_grid,
                                         .read = read_grid,
                                         .close = close_grid,
                                         .seek = seek_grid};
