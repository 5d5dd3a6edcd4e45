/* Tells whether parts together are a height field. */
#include "preprocess/maps/parts/part_field.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/maps/map_make.h"
#include "preprocess/maps/map_points.h"

#include <stdlib.h>
#include <string.h>

typedef struct stp_field_square {
    float least, most, sum; /* heights, in spacings of the grid */
    uint32_t count;
} stp_field_square;

typedef struct grid {
    stp_part_field *field;
    stp_map_frame frame;
    uint32_t columns, rows;
} grid;

/* The points of a part and of those joined with it, one after another. */
typedef struct walk {
    const stp_part_field *field;
    uint32_t part, at;
} walk;

static const stp_part_copy *copy_of(const stp_part_field *field, uint32_t part)
{
    return field->copies && field->copies[part].points ? &field->copies[part] : NULL;
}

stp_part_point stp_part_field_point(const stp_part_field *field, uint32_t place)
{
    const stp_cloud_point *p = &field->cloud->points[place];
    return (stp_part_point){p->position, stp_cloud_normal(field->cloud, place), p->spacing};
}

static bool walk_next(walk *w, stp_part_point *out)
{
    for (const stp_part_field *f = w->field; w->part != STP_PART_NONE; w->part = f->next[w->part]) {
        const stp_part_copy *copy = copy_of(f, w->part);
        const uint32_t begin = f->begins[w->part];
        if (w->at < (copy ? copy->count : f->begins[w->part + 1] - begin)) {
            *out = copy ? copy->points[w->at] : stp_part_field_point(f, f->places[begin + w->at]);
            w->at++;
            return true;
        }
        w->at = 0;
    }
    return false;
}

/* Adds the points of a part to the grid's box and to the area over its plane. */
static uint32_t measure(const grid *g, uint32_t part, stp_dbox *box, double *area)
{
    walk w = {g->field, part, 0};
    stp_part_point p;
    uint32_t count = 0;
    for (; walk_next(&w, &p); count++) {
        const double spacing = (double)p.spacing;
        const stp_dvec3 n = stp_dvec3_from_float(p.normal);
        *area += spacing * spacing * stp_max(stp_dvec3_dot(n, g->frame.axes[2]), 0.0);
        stp_dbox_add(box, stp_map_frame_local(&g->frame, p.position));
    }
    return count;
}

/* Puts the points of a part into their squares. */
static void fill(const grid *g, uint32_t part)
{
    const stp_map_frame *frame = &g->frame;
    walk w = {g->field, part, 0};
    stp_part_point p;
    while (walk_next(&w, &p)) {
        const stp_dvec3 at =
            stp_dvec3_scale(stp_map_frame_local(frame, p.position), 1.0 / frame->spacing);
        const stp_dvec3 n = stp_dvec3_from_float(p.normal);
        const double column = stp_max(floor(at.x), 0.0), row = stp_max(floor(at.y), 0.0);
        const double right = column + 0.5 - at.x, down = row + 0.5 - at.y;
        const double up = stp_max(stp_dvec3_dot(n, frame->axes[2]), (double)STP_MAP_NORMAL_LEAST);
        const double slope =
            right * stp_dvec3_dot(n, frame->axes[0]) + down * stp_dvec3_dot(n, frame->axes[1]);
        const float height = (float)(at.z - slope / up);
        stp_field_square *s = &g->field->squares[(size_t)row * g->columns + (size_t)column];
        s->least = s->count == 0 ? height : fminf(s->least, height);
        s->most = s->count == 0 ? height : fmaxf(s->most, height);
        s->sum += height;
        s->count++;
    }
}

static float mean_of(const stp_field_square *s)
{
    return s->sum / (float)s->count;
}

static bool is_field(const grid *g)
{
    double jumps[STP_MAP_BESIDE];
    stp_map_jumps(g->field->cone_rad, jumps);
    for (int64_t row = 0; row < g->rows; row++)
        for (int64_t column = 0; column < g->columns; column++) {
            const stp_field_square *s = &g->field->squares[row * g->columns + column];
            if (s->count == 0)
                continue;
            if (s->most - s->least > (float)jumps[0])
                return false;
            for (int k = 0; k < STP_MAP_BESIDE; k++) {
                const int64_t c = column + stp_map_beside[k][0], r = row + stp_map_beside[k][1];
                if (c < 0 || c >= g->columns || r >= g->rows)
                    continue;
                const stp_field_square *t = &g->field->squares[r * g->columns + c];
                if (t->count > 0 && fabsf(mean_of(s) - mean_of(t)) > (float)jumps[k])
                    return false;
            }
        }
    return true;
}

stp_status stp_part_field_fits(stp_part_field *field, uint32_t a, uint32_t b,
                               const stp_normal_cone *cone, bool *fits, stp_error *err)
{
    stp_status status = STP_OK;
    grid g = {.field = field};
    stp_dbox box = stp_dbox_empty();
    double area = 0.0;
    *fits = false;
    walk first = {field, a, 0};
    stp_part_point p;
    if (!walk_next(&first, &p))
        return STP_OK;
    g.frame.origin = p.position;
    stp_dvec3_axes(g.frame.axes, cone->axis);
    const uint32_t count = measure(&g, a, &box, &area) + measure(&g, b, &box, &area);
    stp_cloud_stride(field->cloud->spill, field->seen_points, count);
    field->seen_points += count;
    g.frame.origin = stp_map_frame_world(&g.frame, box.min);
    g.frame.spacing = sqrt(area / count);
    const double columns = floor((box.max.x - box.min.x) / g.frame.spacing) + 2.0;
    const double rows = floor((box.max.y - box.min.y) / g.frame.spacing) + 2.0;
    if (!(g.frame.spacing > 0.0) || columns * rows > stp_map_squares_most(count))
        return STP_OK;
    g.columns = (uint32_t)columns;
    g.rows = (uint32_t)rows;
    const size_t squares = (size_t)g.columns * g.rows;
    STP_TRY(
        stp_grow(&field->squares, &field->capacity, squares, sizeof *field->squares, "maps", err));
    memset(field->squares, 0, squares * sizeof *field->squares);
    fill(&g, a);
    fill(&g, b);
    *fits = is_field(&g);
done:
    return status;
}

void stp_part_field_join(stp_part_field *field, uint32_t a, uint32_t b)
{
    field->next[field->last[a]] = b;
    field->last[a] = field->last[b];
}

stp_status stp_part_field_create(stp_part_field *out, const stp_cloud *cloud, stp_rank_part points,
                                 const uint32_t *numbers, uint32_t part_count,
                                 const uint64_t *firsts, double cone_rad, stp_error *err)
{
    stp_status status = STP_OK;
    stp_part_field made = {
        .cloud = cloud, .part_count = part_count, .firsts = firsts, .cone_rad = cone_rad};
    STP_TRY(stp_alloc(&made.begins, (size_t)part_count + 2, sizeof *made.begins, "maps", err));
    STP_TRY(stp_alloc(&made.next, part_count, sizeof *made.next, "maps", err));
    STP_TRY(stp_alloc(&made.last, part_count, sizeof *made.last, "maps", err));
    if (firsts)
        STP_TRY(stp_alloc(&made.copies, part_count, sizeof *made.copies, "maps", err));
    STP_TRY(stp_spill_alloc(cloud->spill, &made.places, points.end - points.begin,
                            sizeof *made.places, "maps", err));
    for (uint64_t i = points.begin; i < points.end; i++, stp_cloud_step(cloud->spill, i))
        if (numbers[i] != STP_PART_NONE)
            made.begins[numbers[i] + 2]++;
    for (uint32_t p = 0; p < part_count; p++) {
        made.begins[p + 2] += made.begins[p + 1];
        made.next[p] = STP_PART_NONE;
        made.last[p] = p;
    }
    for (uint32_t i = (uint32_t)points.begin; i < points.end; i++, stp_cloud_step(cloud->spill, i))
        if (numbers[i] != STP_PART_NONE)
            made.places[made.begins[numbers[i] + 1]++] = i;
    *out = made;
    made = (stp_part_field){0};
done:
    stp_part_field_clear(&made);
    return status;
}

void stp_part_field_clear(stp_part_field *field)
{
    if (field->cloud)
        stp_spill_free(field->cloud->spill, field->places);
    free(field->begins);
    free(field->next);
    free(field->last);
    free(field->squares);
    for (uint32_t p = 0; field->copies && p < field->part_count; p++)
        free(field->copies[p].points);
    free(field->copies);
    *field = (stp_part_field){0};
}
