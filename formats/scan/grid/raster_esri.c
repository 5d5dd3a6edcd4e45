/* Reads ESRI ASCII grids: lines of names and numbers, then the rows' numbers, the top row first.
 *
 * The format names no coordinate system. Cells of seconds of arc are degrees: a third, or a whole
 * number of seconds, that no length would be written as (1/1200, not 0.01), on the globe, and not
 * at its corner 0, 0. */
#include "base/memory.h"
#include "formats/scan/grid/raster.h"
#include "formats/scan/grid/raster_numbers.h"
#include "formats/scan/number.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

typedef enum esri_key {
    COLUMNS,
    ROWS,
    LEFT,
    LEFT_MIDDLE,
    BELOW,
    BELOW_MIDDLE,
    CELL,
    DX,
    DY,
    NONE,
    KEYS
} esri_key;

typedef struct esri_raster {
    stp_raster_text text;
    uint32_t width;
    bool has[KEYS];
    double numbers[KEYS];
} esri_raster;

/* The key that a word names, or KEYS. */
static esri_key key_of(const char *begin, const char *end)
{
    static const char *const names[KEYS] = {
        [COLUMNS] = "ncols",         [ROWS] = "nrows",      [LEFT] = "xllcorner",
        [LEFT_MIDDLE] = "xllcenter", [BELOW] = "yllcorner", [BELOW_MIDDLE] = "yllcenter",
        [CELL] = "cellsize",         [DX] = "dx",           [DY] = "dy",
        [NONE] = "nodata_value"};
    const size_t length = (size_t)(end - begin);
    int k = 0;
    while (k < KEYS && (strlen(names[k]) != length || strncasecmp(names[k], begin, length) != 0))
        k++;
    return (esri_key)k;
}

/* Reads lines of keys up to the first of numbers, which *at then begins. */
static stp_status read_keys(esri_raster *g, stp_error *err)
{
    stp_status status = STP_OK;
    for (;;) {
        const char *begin, *end;
        STP_TRY(stp_source_line(&g->text.source, &begin, &end, err));
        if (begin == NULL)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s ends within its header: copy or export it again",
                                 g->text.source.path);
        const char *at = begin, *word = stp_token(&at, end);
        if (word == NULL)
            continue;
        const char *word_end = at;
        const esri_key key = key_of(word, word_end);
        if (key == KEYS) {
            g->text.at = begin;
            g->text.end = end;
            return STP_OK;
        }
        const char *number = stp_token(&at, end);
        if (number == NULL || !stp_raster_text_number(number, at, &g->numbers[key]))
            return stp_error_set(
                err, STP_CORRUPT,
                "%s: line %llu: %.*s needs a number: mend it, or export the file again",
                g->text.source.path, (unsigned long long)g->text.source.line,
                (int)(word_end - word), word);
        g->has[key] = true;
    }
done:
    return status;
}

#define SECONDS 3600.0
#define SECONDS_ROUNDING 1e-5 /* of a cell: it is written with few digits */
#define WGS_84 4326u

/* Whether a cell is of seconds of arc, and has more digits than a length would. */
static bool is_seconds(double cell)
{
    const double thirds = 3.0 * SECONDS * cell, whole = round(thirds), digits = 1e5 * cell;
    return whole >= 1.0 && (whole == 1.0 || fmod(whole, 3.0) == 0.0) &&
           fabs(thirds - whole) <= SECONDS_ROUNDING * whole &&
           fabs(digits - round(digits)) > SECONDS_ROUNDING * digits;
}

static bool is_on_globe(const stp_raster_info *info)
{
    const double right = info->x + info->width * info->dx, low = info->y - info->height * info->dy;
    return info->x >= -181.0 && right <= 361.0 && low >= -91.0 && info->y <= 91.0 &&
           (fabs(info->x) > info->dx || fabs(low) > info->dy);
}

static stp_status open_esri(void *state, stp_raster_info *info, const char *path,
                            stp_raster_use use, uint32_t step, stp_error *err)
{
    esri_raster *g = state;
    stp_status status = STP_OK;
    const double *n = g->numbers;
    (void)use;
    (void)step;
    g->text.source.descriptor = -1;
    STP_TRY(stp_source_open(&g->text.source, path, err));
    STP_TRY(read_keys(g, err));
    const double dx = g->has[DX] ? n[DX] : n[CELL], dy = g->has[DY] ? n[DY] : n[CELL];
    if (!stp_raster_is_side(n[COLUMNS]) || !stp_raster_is_side(n[ROWS]) || !(dx > 0.0) ||
        !(dy > 0.0))
        return stp_error_set(
            err, STP_CORRUPT,
            "%s: its header needs ncols, nrows and cellsize, each greater than 0: mend it", path);
    g->width = (uint32_t)n[COLUMNS];
    *info = (stp_raster_info){.format = "ESRI ASCII grid",
                              .width = g->width,
                              .height = (uint32_t)n[ROWS],
                              .channels = 1,
                              .floats = true,
                              .full = 1.0,
                              .has_none = g->has[NONE],
                              .none = n[NONE],
                              .spaced = true,
                              .dx = dx,
                              .dy = dy,
                              .placed = (g->has[LEFT] || g->has[LEFT_MIDDLE]) &&
                                        (g->has[BELOW] || g->has[BELOW_MIDDLE])};
    info->x = g->has[LEFT_MIDDLE] ? n[LEFT_MIDDLE] : n[LEFT] + 0.5 * dx;
    info->y = (g->has[BELOW_MIDDLE] ? n[BELOW_MIDDLE] : n[BELOW] + 0.5 * dy) + (n[ROWS] - 1.0) * dy;
    if (info->placed && is_seconds(dx) && is_seconds(dy) && is_on_globe(info)) {
        info->degrees = true;
        info->epsg = WGS_84;
    }
done:
    return status;
}

static stp_status read_esri(void *state, uint32_t row, double *values, stp_error *err)
{
    esri_raster *g = state;
    return stp_raster_text_read(&g->text, row, values, g->width, err);
}

static void close_esri(void *state)
{
    esri_raster *g = state;
    stp_source_close(&g->text.source);
}

const stp_raster_reader stp_raster_esri = {.state_bytes = sizeof(esri_raster),
                                           .each = true,
                                           .open = open_esri,
                                           .read = read_esri,
                                           .close = close_esri};
