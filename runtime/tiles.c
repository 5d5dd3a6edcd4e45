/* Boxes of chunks to tiles, tiles to triangles. */
#include "runtime/tiles.h"

#include "base/memory.h"
#include "runtime/gpu_layout.h"

#include <stdlib.h>
#include <string.h>

/* How far the surface may reach beyond the boxes: a little for the floor under an ellipse, and the
 * rest in radii of the discs. */
#define MARGIN_PX 4.0
#define MARGIN_RADII 1.0

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
    t->width = width;
    t->height = height;
    t->columns = columns;
    t->rows = rows;
    t->known_levels = -1;
    glCreateBuffers(1, &t->buffer);
    glCreateVertexArrays(1, &t->array);
    glVertexArrayVertexBuffer(t->array, 0, t->buffer, 0, 2 * sizeof(float));
    glVertexArrayAttribFormat(t->array, 0, 2, GL_FLOAT, GL_FALSE, 0);
    glVertexArrayAttribBinding(t->array, 0, 0);
    glEnableVertexArrayAttrib(t->array, 0);
done:
    if (status != STP_OK)
        stp_tiles_destroy(t);
    return status;
}

void stp_tiles_destroy(stp_tiles *t)
{
    if (t->buffer != 0) {
        glDeleteVertexArrays(1, &t->array);
        glDeleteBuffers(1, &t->buffer);
    }
    free(t->now);
    free(t->last);
    free(t->corners);
    *t = (stp_tiles){0};
}

/* Sets the tiles that meet a range of window pixels. */
static void add_rectangle(stp_tiles *t, double x0, double y0, double x1, double y1)
{
    int c0 = (int)fmax(floor(x0 / STP_TILE_PX), 0.0);
    int r0 = (int)fmax(floor(y0 / STP_TILE_PX), 0.0);
    int c1 = (int)fmin(ceil(x1 / STP_TILE_PX), t->columns);
    int r1 = (int)fmin(ceil(y1 / STP_TILE_PX), t->rows);
    for (int r = r0; c0 < c1 && r < r1; r++)
        memset(t->now + (size_t)r * (size_t)t->columns + c0, 1, (size_t)(c1 - c0));
}

/* The rectangle around a chunk's box; everything where the box comes near the eye. */
static void add_chunk(stp_tiles *t, const stp_chunk_entry *e, const stp_view *view, double margin)
{
    double x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY;
    for (int i = 0; i < 8; i++) {
        stp_dvec3 corner = {(double)(i & 1 ? e->box_max.x : e->box_min.x),
                            (double)(i & 2 ? e->box_max.y : e->box_min.y),
                            (double)(i & 4 ? e->box_max.z : e->box_min.z)};
        stp_dvec3 w = stp_view_project(view, stp_dvec3_add(e->origin, corner));
        if (!view->orthographic && w.z <= view->near_depth) {
            add_rectangle(t, 0.0, 0.0, t->width, t->height);
            return;
        }
        x0 = fmin(x0, w.x);
        y0 = fmin(y0, w.y);
        x1 = fmax(x1, w.x);
        y1 = fmax(y1, w.y);
    }
    add_rectangle(t, x0 - margin, y0 - margin, x1 + margin, y1 + margin);
}

static void add_cut(stp_tiles *t, const stp_model *model, const stp_view *view, const stp_cut *cut)
{
    for (size_t i = 0; i < cut->draw_count; i++) {
        const stp_draw *draw = &cut->draws[i];
        const stp_chunk_entry *e = &model->entries[draw->chunk];
        double radius = (double)e->radius_max * fmax((double)draw->scale, 0.0);
        double margin = MARGIN_PX + MARGIN_RADII * fmin(radius, STP_TILE_PX);
        if (e->child_count == 0)
            add_chunk(t, e, view, margin);
        for (uint32_t k = 0; k < e->child_count; k++) /* its patches stand for children */
            if (!(draw->drawn_children >> k & 1))
                add_chunk(t, &model->entries[e->first_child + k], view, margin);
    }
}

/* Two triangles. */
static stp_status add_quad(stp_tiles *t, int c0, int r0, int c1, int r1, stp_error *err)
{
    static const int order[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    const int x[2] = {c0 * STP_TILE_PX, c1 * STP_TILE_PX};
    const int y[2] = {r0 * STP_TILE_PX, r1 * STP_TILE_PX};
    stp_status status = stp_grow(&t->corners, &t->corner_capacity, t->corner_count + 6,
                                 2 * sizeof *t->corners, "tiles", err);
    for (int i = 0; status == STP_OK && i < 6; i++) {
        t->corners[2 * t->corner_count] = (float)x[order[i][0]];
        t->corners[2 * t->corner_count + 1] = (float)y[order[i][1]];
        t->corner_count++;
    }
    return status;
}

/* Whether a row's tiles from c0 to c1 are a run: all set, and none beside them. */
static bool is_run(const stp_tiles *t, int row, int c0, int c1)
{
    const uint8_t *tiles = t->last + (size_t)row * (size_t)t->columns;
    if ((c0 > 0 && tiles[c0 - 1] != 0) || (c1 < t->columns && tiles[c1] != 0))
        return false;
    return memchr(tiles + c0, 0, (size_t)(c1 - c0)) == NULL;
}

/* Quads of runs, and of the runs below that are as wide, from `last`, which holds both frames. */
static stp_status add_quads(stp_tiles *t, stp_error *err)
{
    for (int r = 0; r < t->rows; r++) {
        for (int c0 = 0, c1; c0 < t->columns; c0 = c1) {
            for (c1 = c0 + 1;
                 c1 < t->columns && t->last[r * t->columns + c1] == t->last[r * t->columns + c0];)
                c1++;
            if (t->last[r * t->columns + c0] == 0 || (r > 0 && is_run(t, r - 1, c0, c1)))
                continue;
            int end = r + 1;
            while (end < t->rows && is_run(t, end, c0, c1))
                end++;
            stp_status status = add_quad(t, c0, r, c1, end, err);
            if (status != STP_OK)
                return status;
        }
    }
    return STP_OK;
}

stp_status stp_tiles_set_cut(stp_tiles *t, const stp_model *model, const stp_view *view,
                             const stp_cut *cut, stp_error *err)
{
    stp_status status = STP_OK;
    size_t count = (size_t)t->columns * (size_t)t->rows;
    memset(t->now, 0, count);
    add_cut(t, model, view, cut);
    if (t->known_levels < 0)
        memset(t->last, 1, count);
    for (size_t i = 0; i < count; i++)
        t->last[i] |= t->now[i];
    t->corner_count = 0;
    STP_TRY(add_quad(t, 0, 0, t->columns, t->rows, err));
    STP_TRY(add_quads(t, err));
    glNamedBufferData(t->buffer, (GLsizeiptr)(t->corner_count * 2 * sizeof *t->corners), t->corners,
                      GL_STREAM_DRAW);
done:
    return status;
}

void stp_tiles_set_levels(stp_tiles *t, int levels)
{
    t->whole = levels > t->known_levels;
    t->known_levels = levels;
    t->drawn = true;
}

static void draw_corners(const stp_tiles *t, int l, GLint first, GLsizei count)
{
    int width = (t->width + (1 << l) - 1) >> l, height = (t->height + (1 << l) - 1) >> l;
    glViewport(0, 0, width, height);
    glScissor(0, 0, width, height);
    /* One pixel of level l, and of each level below: 2 + 4 + ... + 2^l. */
    glUniform3f(STP_UNIFORM_TILE_TO_CLIP, 2.0f / (float)(width << l), 2.0f / (float)(height << l),
                (float)((2 << l) - 2));
    glBindVertexArray(t->array);
    glDrawArrays(GL_TRIANGLES, first, count);
}

void stp_tiles_draw(const stp_tiles *t, int l)
{
    if ((l > 0 && t->whole) || l >= STP_TILE_LEVELS)
        stp_tiles_draw_whole(t, l);
    else
        draw_corners(t, l, 6, (GLsizei)t->corner_count - 6);
}

void stp_tiles_draw_whole(const stp_tiles *t, int l)
{
    draw_corners(t, l, 0, 6);
}
