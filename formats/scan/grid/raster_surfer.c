/* Reads grids of Golden Software's Surfer: ASCII (DSAA), binary of Surfer 6 (DSBB) and 7 (DSRB).
 *
 * Nodes lie on the grid's edges; the lowest row comes first. Heights of 1.70141e38 and more are
 * none, as everywhere (STP_SCAN_NONE_FROM), and in version 7 those of its own blank value, which
 * some writers leave 0. The format names no coordinate system. */
#include "base/memory.h"
#include "formats/scan/grid/raster.h"
#include "formats/scan/grid/raster_numbers.h"

#include <stdlib.h>
#include <string.h>

typedef struct surfer_raster {
    stp_raster_text text;
    uint32_t width;
    size_t bytes; /* of a height, 4 or 8; 0: as text */
    double blank; /* 0: none */
} surfer_raster;

/* Columns, rows, and the ends of x, y and z. */
enum { COLUMNS, ROWS, X, Y = 4, NUMBERS = 8 };

static stp_status need(surfer_raster *g, size_t size, const unsigned char **bytes, stp_error *err)
{
    stp_status status = STP_OK;
    size_t available = 0;
    STP_TRY(stp_source_peek(&g->text.source, size, bytes, &available, err));
    if (available < size)
        return stp_error_set(err, STP_CORRUPT, "%s ends at byte %llu: copy or export it again",
                             g->text.source.path, (unsigned long long)g->text.source.size);
    stp_source_consume(&g->text.source, size);
done:
    return status;
}

static void take_doubles(const unsigned char *bytes, double *out, size_t count)
{
    memcpy(out, bytes, count * sizeof *out);
}

static stp_status read_header_6(surfer_raster *g, double n[NUMBERS], stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *b;
    STP_TRY(need(g, 56, &b, err));
    n[COLUMNS] = b[4] | b[5] << 8;
    n[ROWS] = b[6] | b[7] << 8;
    take_doubles(b + 8, n + X, 6);
    g->bytes = 4;
done:
    return status;
}

/* Sections: a name, a size. GRID comes before DATA. */
static stp_status read_header_7(surfer_raster *g, double n[NUMBERS], stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *b;
    bool has_grid = false;
    g->bytes = 8;
    for (;;) {
        uint32_t size, rows, columns;
        STP_TRY(need(g, 8, &b, err));
        memcpy(&size, b + 4, sizeof size);
        if (memcmp(b, "DATA", 4) == 0 && has_grid)
            return STP_OK;
        if (memcmp(b, "GRID", 4) == 0 && size >= 72 && size < STP_SOURCE_REQUEST_MAX) {
            double place[4]; /* left, low, steps */
            STP_TRY(need(g, size, &b, err));
            memcpy(&rows, b, sizeof rows);
            memcpy(&columns, b + 4, sizeof columns);
            take_doubles(b + 8, place, 4);
            take_doubles(b + 64, &g->blank, 1);
            n[COLUMNS] = columns;
            n[ROWS] = rows;
            for (int k = 0; k < 2; k++) {
                n[X + 2 * k] = place[k];
                n[X + 2 * k + 1] = place[k] + (n[k] - 1.0) * place[2 + k];
            }
            has_grid = true;
            continue;
        }
        if (size > g->text.source.size - g->text.source.offset)
            return stp_error_set(err, STP_CORRUPT, "%s has no grid in it: export it again",
                                 g->text.source.path);
        stp_source_skip(&g->text.source, size);
    }
done:
    return status;
}

static stp_status read_header(surfer_raster *g, double n[NUMBERS], stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *b;
    const char *begin, *end;
    size_t available;
    STP_TRY(stp_source_peek(&g->text.source, 4, &b, &available, err));
    if (memcmp(b, "DSBB", 4) == 0)
        return read_header_6(g, n, err);
    if (memcmp(b, "DSRB", 4) == 0)
        return read_header_7(g, n, err);
    STP_TRY(stp_source_line(&g->text.source, &begin, &end, err));
    STP_TRY(stp_raster_text_read(&g->text, 0, n, NUMBERS, err));
done:
    return status;
}

static stp_status open_surfer(void *state, stp_raster_info *info, const char *path,
                              stp_raster_use use, uint32_t step, stp_error *err)
{
    surfer_raster *g = state;
    stp_status status = STP_OK;
    double n[NUMBERS] = {0.0};
    (void)use;
    (void)step;
    g->text.source.descriptor = -1;
    STP_TRY(stp_source_open(&g->text.source, path, err));
    STP_TRY(read_header(g, n, err));
    const double wide = n[X + 1] - n[X], high = n[Y + 1] - n[Y], most = 1e30;
    if (!stp_raster_is_side(n[COLUMNS]) || !stp_raster_is_side(n[ROWS]) ||
        !(wide > 0.0 && wide < most) || !(high > 0.0 && high < most) || n[COLUMNS] < 2.0 ||
        n[ROWS] < 2.0)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: its header needs 2 columns and rows at least, and ends of x and "
                             "y, the lower first: export it again",
                             path);
    g->width = (uint32_t)n[COLUMNS];
    *info = (stp_raster_info){.format = "Surfer grid",
                              .width = g->width,
                              .height = (uint32_t)n[ROWS],
                              .channels = 1,
                              .has_none = g->blank != 0.0,
                              .none = g->blank,
                              .floats = true,
                              .full = 1.0,
                              .spaced = true,
                              .dx = wide / (n[COLUMNS] - 1.0),
                              .dy = -high / (n[ROWS] - 1.0),
                              .placed = true,
                              .x = n[X],
                              .y = n[Y]};
done:
    return status;
}

static stp_status read_surfer(void *state, uint32_t row, double *values, stp_error *err)
{
    surfer_raster *g = state;
    stp_status status = STP_OK;
    const unsigned char *b;
    if (g->bytes == 0)
        return stp_raster_text_read(&g->text, row, values, g->width, err);
    STP_TRY(need(g, g->width * g->bytes, &b, err));
    if (g->bytes == 8)
        take_doubles(b, values, g->width);
    else
        for (uint32_t i = 0; i < g->width; i++)
            values[i] = stp_raster_float(b + 4 * (size_t)i, true);
done:
    return status;
}

static void close_surfer(void *state)
{
    surfer_raster *g = state;
    stp_source_close(&g->text.source);
}

const stp_raster_reader stp_raster_surfer = {.state_bytes = sizeof(surfer_raster),
                                             .each = true,
                                             .open = open_surfer,
                                             .read = read_surfer,
                                             .close = close_surfer};
