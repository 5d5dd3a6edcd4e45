/* Turns marks into tiles, and tiles into rectangles. */
#include "runtime/cut/tiles.h"

#include "base/memory.h"
#include "runtime/gl/gpu_layout.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The surface may reach so far beyond the discs in the bounds, since coarse ellipses overlap. */
#define MARGIN_PX 6.0f

/* Rectangles end on multiples of so many pixels of their level: rasterisers work in such blocks. */
#define CELL_PX 4

int stp_tiles_level_px(int viewport_px, int l)
{
    return (viewport_px + (1 << l) - 1) >> l;
}

/* The number of cells of level l along a side of viewport_px pixels. */
static size_t cells_across(int viewport_px, int l)
{
    return (size_t)((stp_tiles_level_px(viewport_px, l) + CELL_PX - 1) / CELL_PX);
}

stp_status stp_tiles_begin(stp_tiles *t, int width, int height, unsigned workers, stp_error *err)
{
    stp_status status = STP_OK;
    if (t->width == width && t->height == height) {
        if (t->drawn) {
            uint8_t *last = t->now;
            t->now = t->last;
            t->last = last;
        }
        t->drawn = false;
        return STP_OK;
    }
    stp_tiles_destroy(t);
    t->columns = (width + STP_TILE_PX - 1) / STP_TILE_PX;
    t->rows = (height + STP_TILE_PX - 1) / STP_TILE_PX;
    t->count = (size_t)t->columns * (size_t)t->rows;
    t->workers = workers;
    STP_TRY(stp_alloc(&t->now, t->count, 1, "tiles", err));
    STP_TRY(stp_alloc(&t->last, t->count, 1, "tiles", err));
    STP_TRY(stp_alloc(&t->marks, t->count, workers, "tiles", err));
    STP_TRY(
        stp_alloc(&t->cells, cells_across(width, 0) * cells_across(height, 0), 1, "tiles", err));
    t->width = width;
    t->height = height;
    t->known_levels = -1;
    glCreateVertexArrays(1, &t->array);
done:
    if (status != STP_OK)
        stp_tiles_destroy(t);
    return status;
}

void stp_tiles_destroy(stp_tiles *t)
{
    if (t->array != 0)
        glDeleteVertexArrays(1, &t->array);
    free(t->now);
    free(t->last);
    free(t->marks);
    free(t->cells);
    free(t->rects);
    *t = (stp_tiles){0};
}

/* The tile of a window coordinate, clamped to 0..count. */
static int tile_at(float px, int count)
{
    float tile = px * (1.0f / STP_TILE_PX);
    return tile <= 0.0f ? 0 : tile >= (float)count ? count : (int)tile;
}

/* Tiles c0 <= column < c1, r0 <= row < r1. */
typedef struct tile_span {
    int c0, c1, r0, r1;
} tile_span;

/* The tiles that a rectangle of window coordinates and the margin around it may cover. */
static tile_span span_of(const stp_tiles *t, float x0, float y0, float x1, float y1)
{
    return (tile_span){
        tile_at(x0 - MARGIN_PX, t->columns), tile_at(x1 + MARGIN_PX + STP_TILE_PX, t->columns),
        tile_at(y0 - MARGIN_PX, t->rows), tile_at(y1 + MARGIN_PX + STP_TILE_PX, t->rows)};
}

void stp_tiles_mark(stp_tiles *t, unsigned worker, float x, float y, float reach)
{
    if (!isfinite(x + y + reach)) { /* the place is unknown, so it may be anywhere */
        stp_tiles_mark_all(t, worker);
        return;
    }
    const tile_span span = span_of(t, x - reach, y - reach, x + reach, y + reach);
    uint8_t *marks = t->marks + worker * t->count;
    for (int r = span.r0; r < span.r1; r++)
        for (int c = span.c0; c < span.c1; c++)
            marks[r * t->columns + c] = 1;
}

bool stp_tiles_marked(const stp_tiles *t, unsigned worker, const float low[2], const float high[2])
{
    const tile_span span = span_of(t, low[0], low[1], high[0], high[1]);
    const uint8_t *marks = t->marks + worker * t->count;
    for (int r = span.r0; r < span.r1; r++)
        for (int c = span.c0; c < span.c1; c++)
            if (marks[r * t->columns + c] == 0)
                return false;
    return true;
}

void stp_tiles_mark_all(stp_tiles *t, unsigned worker)
{
    memset(t->marks + worker * t->count, 1, t->count);
}

void stp_tiles_mark_again(stp_tiles *t)
{
    memcpy(t->marks, t->last, t->count); /* by the first worker; stp_tiles_begin has swapped them */
}

/* The cells of level l that hold any viewport pixel p with begin <= p < end, out of `across`. */
static void cells_of(int begin, int end, int l, size_t across, size_t *first, size_t *last)
{
    int cell = CELL_PX << l;
    *first = begin > 0 ? (size_t)(begin / cell) : 0;
    *last = (size_t)((end + cell - 1) / cell);
    if (*last > across)
        *last = across;
}

/* Marks the cells of level l that the tiles of `last` need. */
static void mark_cells(stp_tiles *t, int l, size_t columns, size_t rows)
{
    int beside = (2 << l) - 2; /* one pixel of level l and of each level below: 2 + 4 + ... + 2^l */
    memset(t->cells, 0, columns * rows);
    for (int r = 0; r < t->rows; r++) {
        const uint8_t *tiles = t->last + (size_t)r * (size_t)t->columns;
        for (int c = 0; c < t->columns; c++) {
            size_t c0, c1, r0, r1;
            if (tiles[c] == 0)
                continue;
            cells_of(c * STP_TILE_PX - beside, (c + 1) * STP_TILE_PX + beside, l, columns, &c0,
                     &c1);
            cells_of(r * STP_TILE_PX - beside, (r + 1) * STP_TILE_PX + beside, l, rows, &r0, &r1);
            for (size_t row = r0; row < r1; row++)
                memset(t->cells + row * columns + c0, 1, c1 - c0);
        }
    }
}

/* Whether the cells c0..c1 - 1 of a row are a run: all set, and none set next to them. */
static bool is_run(const uint8_t *row, size_t columns, size_t c0, size_t c1)
{
    if ((c0 > 0 && row[c0 - 1] != 0) || (c1 < columns && row[c1] != 0))
        return false;
    return memchr(row + c0, 0, c1 - c0) == NULL;
}

static stp_status add_rect(stp_tiles *t, int l, const stp_tile_rect *cells, stp_error *err)
{
    int width = stp_tiles_level_px(t->width, l), height = stp_tiles_level_px(t->height, l);
    stp_status status =
        stp_grow(&t->rects, &t->rect_capacity, t->rect_count + 1, sizeof *t->rects, "tiles", err);
    if (status != STP_OK)
        return status;
    stp_tile_rect *rect = &t->rects[t->rect_count++];
    *rect = (stp_tile_rect){CELL_PX * cells->x0, CELL_PX * cells->y0, CELL_PX * cells->x1,
                            CELL_PX * cells->y1};
    rect->x1 = rect->x1 < width ? rect->x1 : width;
    rect->y1 = rect->y1 < height ? rect->y1 : height;
    return STP_OK;
}

/* Adds a rectangle for each run of cells, extended over the rows below that have the same run. */
static stp_status add_rects(stp_tiles *t, int l, stp_error *err)
{
    size_t columns = cells_across(t->width, l), rows = cells_across(t->height, l);
    stp_status status = STP_OK;
    mark_cells(t, l, columns, rows);
    for (size_t r = 0; r < rows; r++) {
        const uint8_t *row = t->cells + r * columns;
        for (size_t c0 = 0, c1; c0 < columns && status == STP_OK; c0 = c1) {
            for (c1 = c0 + 1; c1 < columns && row[c1] == row[c0];)
                c1++;
            if (row[c0] == 0 || (r > 0 && is_run(row - columns, columns, c0, c1)))
                continue;
            size_t end = r + 1;
            while (end < rows && is_run(t->cells + end * columns, columns, c0, c1))
                end++;
            status = add_rect(t, l, &(stp_tile_rect){(int)c0, (int)r, (int)c1, (int)end}, err);
        }
    }
    return status;
}

/* Adds the workers' marks to `now`, and `now` to `last`. */
static void take_marks(stp_tiles *t, bool first)
{
    if (first)
        memset(t->now, 0, t->count);
    for (size_t w = 0; w < t->workers; w++)
        for (size_t i = 0; i < t->count; i++)
            t->now[i] |= t->marks[w * t->count + i];
    memset(t->marks, 0, t->workers * t->count);
    if (t->known_levels < 0)
        memset(t->last, 1, t->count);
    for (size_t i = 0; i < t->count; i++)
        t->last[i] |= t->now[i];
}

stp_status stp_tiles_collect(stp_tiles *t, bool first, stp_error *err)
{
    stp_status status = STP_OK;
    take_marks(t, first);
    t->rect_count = 0;
    for (int l = 0; l < STP_TILE_LEVELS; l++) {
        t->level_begin[l] = t->rect_count;
        STP_TRY(add_rects(t, l, err));
    }
    t->level_begin[STP_TILE_LEVELS] = t->rect_count;
done:
    return status;
}

void stp_tiles_set_levels(stp_tiles *t, int levels)
{
    t->whole = levels > t->known_levels;
    t->known_levels = levels;
    t->drawn = true;
}

/* Draws each rectangle as one triangle around the whole level, cut by the scissor. Two triangles
 * would share a diagonal, and rasterisers that work in blocks of pixels would draw blocks on the
 * diagonal twice. */
static void draw_rects(const stp_tiles *t, int l, const stp_tile_rect *rects, size_t count)
{
    glViewport(0, 0, stp_tiles_level_px(t->width, l), stp_tiles_level_px(t->height, l));
    glBindVertexArray(t->array);
    for (size_t i = 0; i < count; i++) {
        const stp_tile_rect *a = &rects[i];
        glScissor(a->x0, a->y0, a->x1 - a->x0, a->y1 - a->y0);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
}

size_t stp_tiles_rects(const stp_tiles *t, int l, stp_tile_rect *whole, const stp_tile_rect **rects)
{
    if ((l > 0 && t->whole) || l >= STP_TILE_LEVELS) {
        *whole = (stp_tile_rect){0, 0, stp_tiles_level_px(t->width, l),
                                 stp_tiles_level_px(t->height, l)};
        *rects = whole;
        return 1;
    }
    *rects = t->rects + t->level_begin[l];
    return t->level_begin[l + 1] - t->level_begin[l];
}

void stp_tiles_draw(const stp_tiles *t, int l)
{
    stp_tile_rect whole;
    const stp_tile_rect *rects;
    size_t count = stp_tiles_rects(t, l, &whole, &rects);
    draw_rects(t, l, rects, count);
}

void stp_tiles_draw_whole(const stp_tiles *t, int l)
{
    draw_rects(t, l, &(stp_tile_rect){0, 0, t->width, t->height}, 1);
}

void stp_tiles_draw_pixel(const stp_tiles *t, int x, int y)
{
    draw_rects(t, 0, &(stp_tile_rect){x, y, x + 1, y + 1}, 1);
}
