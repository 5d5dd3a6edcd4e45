/* Finds nearest points on a union of many discs, and measures the promise with them. */
#include "tests/support/promise.h"

#include "base/memory.h"
#include "formats/chunk/measure/patch_bounds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A surface of some hundred thousand discs has some ten of them in a cell then: a search visits few
 * cells, and the grid fits a processor's cache. */
#define CELLS_LIMIT 500000.0

struct promise_index {
    promise_disc *discs; /* sorted by cell */
    size_t *source;      /* the caller's index of each disc */
    size_t *cell_begin;  /* cells + 1 */
    double *cell_radius; /* greatest radius in the cell */
    size_t count;
    stp_dbox box;
    double cell;
    long size[3];
    double radius; /* greatest radius of all */
};

/* ---- one disc ---- */

static bool is_zero(stp_dvec3 v)
{
    return v.x == 0.0 && v.y == 0.0 && v.z == 0.0;
}

stp_dvec3 promise_nearest_on(const promise_disc *disc, stp_dvec3 x)
{
    stp_dvec3 v = stp_dvec3_sub(x, disc->centre);
    double height = stp_dvec3_dot(v, disc->normal);
    stp_dvec3 in_plane = stp_dvec3_sub(v, stp_dvec3_scale(disc->normal, height));
    double length = stp_dvec3_length(in_plane);
    if (length > disc->radius)
        in_plane = stp_dvec3_scale(in_plane, disc->radius / length);
    return stp_dvec3_add(disc->centre, in_plane);
}

/* ---- the grid ---- */

static long cell_on_axis(const promise_index *index, double p, double low, int axis)
{
    double k = floor((p - low) / index->cell);
    return k < 0.0 ? 0 : k >= (double)index->size[axis] ? index->size[axis] - 1 : (long)k;
}

static void cell_of(const promise_index *index, stp_dvec3 p, long out[3])
{
    out[0] = cell_on_axis(index, p.x, index->box.min.x, 0);
    out[1] = cell_on_axis(index, p.y, index->box.min.y, 1);
    out[2] = cell_on_axis(index, p.z, index->box.min.z, 2);
}

static size_t cell_number(const promise_index *index, const long c[3])
{
    return (size_t)((c[2] * index->size[1] + c[1]) * index->size[0] + c[0]);
}

static void shape_grid(promise_index *index, const promise_disc *discs, size_t count)
{
    double radius_sum = 0.0;
    index->box = stp_dbox_empty();
    for (size_t i = 0; i < count; i++) {
        stp_dbox_add(&index->box, discs[i].centre);
        index->radius = fmax(index->radius, discs[i].radius);
        radius_sum += discs[i].radius;
    }
    stp_dvec3 size = stp_dvec3_sub(index->box.max, index->box.min);
    double longest = fmax(size.x, fmax(size.y, size.z));
    double cell = fmax(radius_sum / (double)count, longest * 1e-4);
    if (!(cell > 0.0))
        cell = 1.0;
    for (;; cell *= 1.3) {
        double counts[3] = {floor(size.x / cell) + 1.0, floor(size.y / cell) + 1.0,
                            floor(size.z / cell) + 1.0};
        if (counts[0] * counts[1] * counts[2] > CELLS_LIMIT)
            continue;
        for (int k = 0; k < 3; k++)
            index->size[k] = (long)counts[k];
        break;
    }
    index->cell = cell;
}

stp_status promise_index_create(promise_index **out, const promise_disc *discs, size_t count,
                                stp_error *err)
{
    stp_status status = STP_OK;
    promise_index *index = NULL;
    if (count == 0)
        return stp_error_set(err, STP_EMPTY, "no level-0 discs");
    STP_TRY(stp_alloc(&index, 1, sizeof *index, "an index", err));
    index->count = count;
    shape_grid(index, discs, count);
    size_t cells = (size_t)(index->size[0] * index->size[1] * index->size[2]);
    STP_TRY(stp_alloc(&index->discs, count, sizeof *index->discs, "an index", err));
    STP_TRY(stp_alloc(&index->source, count, sizeof *index->source, "an index", err));
    STP_TRY(stp_alloc(&index->cell_begin, cells + 2, sizeof *index->cell_begin, "an index", err));
    STP_TRY(stp_alloc(&index->cell_radius, cells, sizeof *index->cell_radius, "an index", err));
    /* counting sort by cell: begin[c + 2] counts, then begin[c + 1] is the next place in c */
    for (size_t i = 0; i < count; i++) {
        long c[3];
        cell_of(index, discs[i].centre, c);
        index->cell_begin[cell_number(index, c) + 2]++;
    }
    for (size_t c = 2; c < cells + 2; c++)
        index->cell_begin[c] += index->cell_begin[c - 1];
    for (size_t i = 0; i < count; i++) {
        long c[3];
        cell_of(index, discs[i].centre, c);
        size_t number = cell_number(index, c), place = index->cell_begin[number + 1]++;
        index->discs[place] = discs[i];
        index->source[place] = i;
        index->cell_radius[number] = fmax(index->cell_radius[number], discs[i].radius);
    }
    *out = index;
    index = NULL;
done:
    promise_index_destroy(&index);
    return status;
}

void promise_index_destroy(promise_index **index)
{
    if (*index == NULL)
        return;
    free((*index)->discs);
    free((*index)->source);
    free((*index)->cell_begin);
    free((*index)->cell_radius);
    free(*index);
    *index = NULL;
}

typedef struct search {
    stp_dvec3 x, best;
    double distance;
    size_t place;
} search;

static void search_cell(const promise_index *index, size_t cell, search *s)
{
    for (size_t i = index->cell_begin[cell]; i < index->cell_begin[cell + 1]; i++) {
        const promise_disc *disc = &index->discs[i];
        stp_dvec3 to_centre = stp_dvec3_sub(s->x, disc->centre);
        double reach = s->distance + disc->radius;
        if (stp_dvec3_dot(to_centre, to_centre) > reach * reach * (1.0 + 1e-12))
            continue;
        stp_dvec3 y = promise_nearest_on(disc, s->x);
        double distance = stp_dvec3_length(stp_dvec3_sub(s->x, y));
        if (distance < s->distance) {
            s->distance = distance;
            s->best = y;
            s->place = i;
        }
    }
}

/* The distance from x to a cell, along one axis. */
static double cell_away(double x, double low, long c, double cell)
{
    double begin = low + (double)c * cell;
    return x < begin ? begin - x : x > begin + cell ? x - begin - cell : 0.0;
}

/* Whether a cell may have a disc nearer to x than the best. The centres of the cell's discs lie in
 * its box, except for rounding. */
static bool cell_reaches(const promise_index *index, const search *s, const long c[3], size_t cell)
{
    double x = cell_away(s->x.x, index->box.min.x, c[0], index->cell);
    double y = cell_away(s->x.y, index->box.min.y, c[1], index->cell);
    double z = cell_away(s->x.z, index->box.min.z, c[2], index->cell);
    double reach = s->distance + index->cell_radius[cell] + 1e-9 * index->cell;
    return x * x + y * y + z * z < reach * reach;
}

/* Searches the cells on the surface of a cube, `ring` cells from the middle. */
static void search_ring(const promise_index *index, const long middle[3], long ring, search *s)
{
    long low[3], high[3], c[3];
    for (int k = 0; k < 3; k++) {
        low[k] = middle[k] - ring < 0 ? 0 : middle[k] - ring;
        high[k] = middle[k] + ring >= index->size[k] ? index->size[k] - 1 : middle[k] + ring;
    }
    for (c[2] = low[2]; c[2] <= high[2]; c[2]++)
        for (c[1] = low[1]; c[1] <= high[1]; c[1]++) {
            bool face = labs(c[2] - middle[2]) == ring || labs(c[1] - middle[1]) == ring;
            long step = face || ring == 0 ? 1 : 2 * ring;
            for (c[0] = face ? low[0] : middle[0] - ring; c[0] <= high[0]; c[0] += step) {
                if (c[0] < low[0])
                    continue;
                size_t cell = cell_number(index, c);
                if (index->cell_begin[cell] < index->cell_begin[cell + 1] &&
                    cell_reaches(index, s, c, cell))
                    search_cell(index, cell, s);
            }
        }
}

stp_dvec3 promise_nearest(const promise_index *index, stp_dvec3 x, size_t *disc)
{
    search s = {.x = x, .distance = INFINITY};
    long middle[3];
    cell_of(index, x, middle);
    long rings = index->size[0] + index->size[1] + index->size[2];
    for (long ring = 0; ring < rings; ring++) {
        /* everything beyond is at least this far from x, even if x is outside the box */
        double beyond = ((double)ring - 1.0) * index->cell;
        if (beyond - index->radius > s.distance)
            break;
        search_ring(index, middle, ring, &s);
    }
    if (disc != NULL)
        *disc = index->source[s.place];
    return s.best;
}

/* ---- the promise ---- */

void promise_trace(const promise_index *index, const promise_disc *drawn, stp_dvec3 eye,
                   promise_pairs *out)
{
    stp_dvec3 u, v;
    stp_dvec3 normal = drawn->normal;
    if (is_zero(normal))
        normal = stp_dvec3_normalize(stp_dvec3_sub(eye, drawn->centre));
    stp_disc_axes(normal, &u, &v);
    out->drawn[0] = drawn->centre;
    for (int i = 0; i < PROMISE_RIM_POINTS; i++) {
        double angle = 2.0 * M_PI * (double)i / PROMISE_RIM_POINTS;
        stp_dvec3 rim = stp_dvec3_add(stp_dvec3_scale(u, drawn->radius * cos(angle)),
                                      stp_dvec3_scale(v, drawn->radius * sin(angle)));
        out->drawn[i + 1] = stp_dvec3_add(drawn->centre, rim);
    }
    for (int i = 0; i < PROMISE_POINTS; i++)
        out->nearest[i] = promise_nearest(index, out->drawn[i], &out->disc[i]);
}

static bool project(const stp_view *view, stp_dvec3 world, double out[2])
{
    stp_dvec3 p = stp_dvec3_sub(world, view->eye);
    double depth = -stp_dvec3_dot(view->back, p);
    double scale = view->orthographic ? view->f : view->f / depth;
    out[0] = scale * stp_dvec3_dot(view->right, p);
    out[1] = scale * stp_dvec3_dot(view->up, p);
    return depth > view->near_depth;
}

double promise_displacement_px(const stp_view *view, stp_dvec3 a, stp_dvec3 b)
{
    double p[2], q[2];
    if (!project(view, a, p) || !project(view, b, q))
        return -1.0;
    double x = p[0] - q[0], y = p[1] - q[1];
    return sqrt(x * x + y * y);
}

void promise_add(promise_tally *tally, const promise_pairs *pairs, const stp_view *view,
                 double threshold_px)
{
    const size_t bins = sizeof tally->histogram / sizeof *tally->histogram;
    tally->discs++;
    for (int i = 0; i < PROMISE_POINTS; i++) {
        double px = promise_displacement_px(view, pairs->drawn[i], pairs->nearest[i]);
        if (px < 0.0) {
            tally->behind++;
            continue;
        }
        double bin = 32.0 * px / threshold_px;
        tally->histogram[bin < (double)bins - 1.0 ? (size_t)bin : bins - 1]++;
        tally->points++;
        tally->broken += px > threshold_px;
        tally->max_px = px > tally->max_px ? px : tally->max_px;
        tally->sum_px += px;
    }
}

double promise_quantile(const promise_tally *tally, double share)
{
    size_t seen = 0, bin = 0;
    const size_t bins = sizeof tally->histogram / sizeof *tally->histogram;
    for (; bin < bins; bin++) {
        seen += tally->histogram[bin];
        if ((double)seen >= share * (double)tally->points)
            break;
    }
    return (double)(bin + 1) / 32.0;
}

/* ---- chunk files ---- */

promise_disc promise_disc_from_sample(const stp_chunk_entry *entry, const stp_patch *patch,
                                      const stp_sample *sample)
{
    promise_disc disc = {
        .centre = stp_dvec3_add(entry->origin, stp_sample_position(sample, patch)),
        .radius = stp_sample_radius(sample, patch),
    };
    if (sample->flags & STP_SAMPLE_HAS_NORMAL)
        disc.normal = stp_dvec3_normalize(stp_dvec3_from_float(stp_normal_decode(sample->normal)));
    return disc;
}

static stp_status append_leaf(stp_chunk_file *file, uint32_t id, promise_disc **discs,
                              size_t *capacity, size_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry entry;
    stp_chunk *chunk = NULL;
    STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
    if (entry.child_count > 0)
        goto done;
    STP_TRY(stp_chunk_file_read(file, id, 0, &chunk, err));
    STP_TRY(
        stp_grow(discs, capacity, *count + entry.sample_count[0], sizeof **discs, "discs", err));
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++)
            (*discs)[(*count)++] =
                promise_disc_from_sample(&entry, &chunk->patches[p], &chunk->samples[0][i]);
done:
    stp_chunk_destroy(&chunk);
    return status;
}

stp_status promise_load_leaves(stp_chunk_file *file, promise_disc **discs, size_t *count,
                               stp_error *err)
{
    stp_status status = STP_OK;
    promise_disc *list = NULL;
    size_t capacity = 0, used = 0;
    uint32_t chunk_count = stp_chunk_file_get_info(file)->chunk_count;
    for (uint32_t id = 0; id < chunk_count; id++)
        STP_TRY(append_leaf(file, id, &list, &capacity, &used, err));
    *discs = list;
    *count = used;
    list = NULL;
done:
    free(list);
    return status;
}
