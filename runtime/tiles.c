/* Boxes of chunks to tiles, tiles to rectangles. */
#include "runtime/tiles.h"

#include "base/memory.h"
#include "runtime/gpu_layout.h"

#include <stdlib.h>
#include <string.h>

/* How far the surface may reach beyond the discs that bounds hold: coarse ellipses overlap. */
#define MARGIN_PX 6.0

/* A chunk that may cover so many tiles is looked at patch by patch. */
#define LARGE_TILES 24

/* Rectangles end on multiples of so many pixels of their level: what rasterisers work by. */
#define CELL_PX 4

/* Cells along one side of level l. */
static size_t cells_across(int viewport_px, int l)
{
    int cell = CELL_PX << l; /* viewport pixels */
    return (size_t)((viewport_px + cell - 1) / cell);
}

stp_status stp_tiles_begin(stp_tiles *t, int width, int height, stp_error *err)
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
    int columns = (width + STP_TILE_PX - 1) / STP_TILE_PX;
    int rows = (height + STP_TILE_PX - 1) / STP_TILE_PX;
    size_t count = (size_t)columns * (size_t)rows;
    STP_TRY(stp_alloc(&t->now, count, 1, "tiles", err));
    STP_TRY(stp_alloc(&t->last, count, 1, "tiles", err));
    STP_TRY(
        stp_alloc(&t->cells, cells_across(width, 0) * cells_across(height, 0), 1, "tiles", err));
    t->width = width;
    t->height = height;
    t->columns = columns;
    t->rows = rows;
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
    free(t->cells);
    free(t->rects);
    *t = (stp_tiles){0};
}

/* Window pixels. */
typedef struct rectangle {
    double x0, y0, x1, y1;
} rectangle;

/* The tiles that meet a rectangle: columns c0 to c1, rows r0 to r1, without the last. */
typedef struct tile_range {
    int c0, r0, c1, r1;
} tile_range;

static tile_range tiles_of(const stp_tiles *t, const rectangle *a)
{
    return (tile_range){(int)fmin(fmax(floor((a->x0 - MARGIN_PX) / STP_TILE_PX), 0.0), t->columns),
                        (int)fmin(fmax(floor((a->y0 - MARGIN_PX) / STP_TILE_PX), 0.0), t->rows),
                        (int)fmax(fmin(ceil((a->x1 + MARGIN_PX) / STP_TILE_PX), t->columns), 0.0),
                        (int)fmax(fmin(ceil((a->y1 + MARGIN_PX) / STP_TILE_PX), t->rows), 0.0)};
}

static void add_range(stp_tiles *t, const tile_range *a)
{
    for (int r = a->r0; a->c0 < a->c1 && r < a->r1; r++)
        memset(t->now + (size_t)r * (size_t)t->columns + a->c0, 1, (size_t)(a->c1 - a->c0));
}

/* The rectangle around a chunk's box; everything where the box comes near the eye. */
static rectangle around_box(const stp_chunk_entry *e, const stp_view *view)
{
    rectangle a = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    for (int i = 0; i < 8; i++) {
        stp_dvec3 corner = {(double)(i & 1 ? e->box_max.x : e->box_min.x),
                            (double)(i & 2 ? e->box_max.y : e->box_min.y),
                            (double)(i & 4 ? e->box_max.z : e->box_min.z)};
        stp_dvec3 w = stp_view_project(view, stp_dvec3_add(e->origin, corner));
        if (!view->orthographic && w.z <= view->near_depth)
            return (rectangle){0.0, 0.0, view->width, view->height};
        a.x0 = fmin(a.x0, w.x);
        a.y0 = fmin(a.y0, w.y);
        a.x1 = fmax(a.x1, w.x);
        a.y1 = fmax(a.y1, w.y);
    }
    return a;
}

/* A view as the loop over patches needs it, for one chunk: floats, since the margin is pixels. */
typedef struct patch_view {
    float origin[3]; /* of the chunk, in eye space */
    float right[3], up[3], back[3];
    float f, near_depth, middle[2]; /* of the picture, pixels */
    bool orthographic;
} patch_view;

static void set_axis(float out[3], stp_dvec3 axis)
{
    out[0] = (float)axis.x;
    out[1] = (float)axis.y;
    out[2] = (float)axis.z;
}

static patch_view patch_view_of(const stp_view *view, const stp_chunk_entry *e)
{
    stp_dvec3 origin = stp_dvec3_sub(e->origin, view->eye);
    patch_view v = {.origin = {(float)stp_dvec3_dot(view->right, origin),
                               (float)stp_dvec3_dot(view->up, origin),
                               (float)stp_dvec3_dot(view->back, origin)},
                    .f = (float)view->f,
                    .near_depth = (float)view->near_depth,
                    .middle = {0.5f * (float)view->width, 0.5f * (float)view->height},
                    .orthographic = view->orthographic};
    set_axis(v.right, view->right);
    set_axis(v.up, view->up);
    set_axis(v.back, view->back);
    return v;
}

static float along(float origin, const float axis[3], const float p[3])
{
    return origin + axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
}

/* The tile that a window coordinate lies in, between two. */
static int tile_at(float px, int least, int most)
{
    float tile = px * (1.0f / STP_TILE_PX);
    return tile <= (float)least ? least : tile >= (float)most ? most : (int)tile;
}

/* Adds a patch's tiles inside the box; false where it comes near the eye. */
static bool add_patch(stp_tiles *t, const patch_view *v, const stp_gpu_patch *p,
                      const tile_range *box)
{
    float x = along(v->origin[0], v->right, p->bound_centre);
    float y = along(v->origin[1], v->up, p->bound_centre);
    float depth = -along(v->origin[2], v->back, p->bound_centre);
    float scale = v->f, reach = p->bound_radius * v->f;
    if (!v->orthographic) {
        if (depth - p->bound_radius <= v->near_depth)
            return false;
        float inverse = 1.0f / depth;
        scale *= inverse;
        reach *= sqrtf(1.0f + (x * x + y * y) * inverse * inverse) / (depth - p->bound_radius);
    }
    x = v->middle[0] + x * scale;
    y = v->middle[1] + y * scale;
    reach += (float)MARGIN_PX;
    int c0 = tile_at(x - reach, box->c0, box->c1), r0 = tile_at(y - reach, box->r0, box->r1);
    int c1 = tile_at(x + reach + STP_TILE_PX, box->c0, box->c1);
    int r1 = tile_at(y + reach + STP_TILE_PX, box->r0, box->r1);
    for (int r = r0; r < r1; r++)
        for (int c = c0; c < c1; c++)
            t->now[r * t->columns + c] = 1;
    return true;
}

/* The patches of a large chunk, which lies in the box, one by one; false if that cannot be told. */
static bool add_patches(stp_tiles *t, const stp_tiles_source *s, const stp_draw *draw,
                        const tile_range *box)
{
    const stp_chunk_entry *e = &s->model->entries[draw->chunk];
    const stp_resident *resident =
        stp_chunk_cache_get(s->cache, stp_chunk_cache_slot(s->cache, draw->chunk));
    patch_view view = patch_view_of(s->view, e);
    for (uint32_t i = 0; i < e->patch_count; i++) {
        const stp_gpu_patch *p = &resident->patches[i];
        if (p->child < 64 && (draw->drawn_children >> p->child & 1))
            continue;
        if (!add_patch(t, &view, p, box))
            return false;
    }
    return true;
}

static void add_draw(stp_tiles *t, const stp_tiles_source *s, const stp_draw *draw)
{
    const stp_chunk_entry *entries = s->model->entries, *e = &entries[draw->chunk];
    rectangle a = around_box(e, s->view);
    tile_range range = tiles_of(t, &a);
    if ((range.c1 - range.c0) * (range.r1 - range.r0) >= LARGE_TILES &&
        add_patches(t, s, draw, &range))
        return;
    if (e->child_count == 0)
        add_range(t, &range);
    for (uint32_t k = 0; k < e->child_count; k++) /* its patches stand for children */
        if (!(draw->drawn_children >> k & 1)) {
            a = around_box(&entries[e->first_child + k], s->view);
            range = tiles_of(t, &a);
            add_range(t, &range);
        }
}

/* The cells of level l that viewport pixels begin <= p < end meet; `across` of them there are. */
static void cells_of(int begin, int end, int l, size_t across, size_t *first, size_t *last)
{
    int cell = CELL_PX << l;
    *first = begin > 0 ? (size_t)(begin / cell) : 0;
    *last = (size_t)((end + cell - 1) / cell);
    if (*last > across)
        *last = across;
}

/* Marks the cells of level l that the tiles need. */
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

/* Whether the cells c0 to c1 of a row are a run: all set, and none beside them. */
static bool is_run(const uint8_t *row, size_t columns, size_t c0, size_t c1)
{
    if ((c0 > 0 && row[c0 - 1] != 0) || (c1 < columns && row[c1] != 0))
        return false;
    return memchr(row + c0, 0, c1 - c0) == NULL;
}

static stp_status add_rect(stp_tiles *t, int l, const stp_tile_rect *cells, stp_error *err)
{
    int width = (t->width + (1 << l) - 1) >> l, height = (t->height + (1 << l) - 1) >> l;
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

/* Runs of level l's cells, each with the runs below that are as wide. */
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

stp_status stp_tiles_add(stp_tiles *t, const stp_tiles_source *source, const stp_draw *draws,
                         size_t count, bool first, stp_error *err)
{
    stp_status status = STP_OK;
    size_t tile_count = (size_t)t->columns * (size_t)t->rows;
    if (first)
        memset(t->now, 0, tile_count);
    for (size_t i = 0; i < count; i++)
        add_draw(t, source, &draws[i]);
    if (t->known_levels < 0)
        memset(t->last, 1, tile_count);
    for (size_t i = 0; i < tile_count; i++)
        t->last[i] |= t->now[i];
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

/* One triangle around the whole level, cut to each rectangle: two would share a diagonal, which
 * rasterisers that work by blocks of pixels pay twice for. */
static void draw_rects(const stp_tiles *t, int l, const stp_tile_rect *rects, size_t count)
{
    glViewport(0, 0, (t->width + (1 << l) - 1) >> l, (t->height + (1 << l) - 1) >> l);
    glBindVertexArray(t->array);
    for (size_t i = 0; i < count; i++) {
        const stp_tile_rect *a = &rects[i];
        glScissor(a->x0, a->y0, a->x1 - a->x0, a->y1 - a->y0);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    }
}

void stp_tiles_draw(const stp_tiles *t, int l)
{
    if ((l > 0 && t->whole) || l >= STP_TILE_LEVELS)
        stp_tiles_draw_whole(t, l);
    else
        draw_rects(t, l, t->rects + t->level_begin[l], t->level_begin[l + 1] - t->level_begin[l]);
}

void stp_tiles_draw_whole(const stp_tiles *t, int l)
{
    draw_rects(t, l, &(stp_tile_rect){0, 0, t->width, t->height}, 1);
}
