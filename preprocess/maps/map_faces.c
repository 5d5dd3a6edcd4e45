/* The triangles of meshes over the grid of a map. */
#include "preprocess/maps/map_faces.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* A triangle farther than so many spacings from the surface through the points is of another sheet.
 */
#define NEAR_MOST 1.5
/* Sides of triangles count as inside, for all rounding. */
#define SIDE_ROUNDING 1e-9

/* Twice the area over the plane; its sign tells the side. */
static double turn_of(const stp_dvec3 at[3])
{
    return (at[1].x - at[0].x) * (at[2].y - at[0].y) - (at[2].x - at[0].x) * (at[1].y - at[0].y);
}

static stp_map_face face_of(const stp_mesh *mesh, uint32_t triangle, const stp_map_points *points,
                            const stp_map_frame *frame)
{
    stp_map_face out = {.own = false};
    for (int k = 0; k < 3; k++) {
        const stp_dvec3 p = stp_map_frame_local(frame, stp_face_corner(mesh, triangle, k));
        out.at[k] = stp_dvec3_scale(p, 1.0 / frame->spacing);
        out.own = out.own || stp_map_points_has(points, p, frame);
    }
    return out;
}

stp_status stp_map_faces_create(stp_map_faces *out, const stp_face_tree *tree,
                                const stp_map_points *points, const stp_map_frame *frame,
                                const stp_dbox *box, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_faces made = {0};
    uint32_t *found = NULL;
    size_t count = 0;
    double turns = 0.0;
    if (!tree)
        return STP_OK;
    STP_TRY(stp_face_tree_find(tree, box, &found, &count, err));
    STP_TRY(stp_alloc(&made.list, count, sizeof *made.list, "triangles", err));
    for (size_t i = 0; i < count; i++) {
        const stp_map_face face = face_of(tree->mesh, found[i], points, frame);
        made.list[i] = face;
        turns += face.own ? turn_of(face.at) : 0.0;
    }
    for (size_t i = 0; i < count; i++)
        if (turn_of(made.list[i].at) * (turns < 0.0 ? -1.0 : 1.0) > 0.0)
            made.list[made.count++] = made.list[i];
    *out = made;
    made = (stp_map_faces){0};
done:
    free(found);
    stp_map_faces_clear(&made);
    return status;
}

void stp_map_faces_clear(stp_map_faces *faces)
{
    free(faces->list);
    *faces = (stp_map_faces){0};
}

/* The columns or rows under a triangle: low to high, none if low > high. */
static void span(double a, double b, double c, uint32_t count, int64_t *low, int64_t *high)
{
    const double first = fmax(fmin(a, fmin(b, c)) - SIDE_ROUNDING, 0.0);
    const double last = fmin(fmax(a, fmax(b, c)) + SIDE_ROUNDING, (double)count - 1.0);
    *low = (int64_t)ceil(fmin(first, (double)count));
    *high = (int64_t)floor(fmax(last, -1.0));
}

/* The triangle's height over a place. False if the place is not under it. */
static bool height_at(const stp_dvec3 at[3], double x, double y, double *height)
{
    const double turn = turn_of(at);
    double sum = 0.0;
    for (int k = 0; k < 3; k++) {
        const stp_dvec3 *b = &at[(k + 1) % 3], *c = &at[(k + 2) % 3];
        const double weight = ((b->x - x) * (c->y - y) - (c->x - x) * (b->y - y)) / turn;
        if (!(weight >= -SIDE_ROUNDING))
            return false;
        sum += weight * at[k].z;
    }
    *height = sum;
    return true;
}

void stp_map_faces_cover(const stp_map_faces *faces, uint32_t columns, uint32_t rows,
                         uint8_t *covered)
{
    for (size_t i = 0; i < faces->count; i++) {
        const stp_dvec3 *at = faces->list[i].at;
        int64_t left, right, top, bottom;
        double height;
        span(at[0].x, at[1].x, at[2].x, columns, &left, &right);
        span(at[0].y, at[1].y, at[2].y, rows, &top, &bottom);
        for (int64_t r = top; faces->list[i].own && r <= bottom; r++)
            for (int64_t c = left; c <= right; c++)
                if (height_at(at, (double)c, (double)r, &height))
                    covered[r * columns + c] = 1;
    }
}

/* Takes a triangle's heights where they are the nearest so far. */
static void lift(const stp_dvec3 at[3], uint32_t columns, uint32_t rows, const float *slopes,
                 const float *heights, float *lifted)
{
    int64_t left, right, top, bottom;
    double height;
    span(at[0].x, at[1].x, at[2].x, columns, &left, &right);
    span(at[0].y, at[1].y, at[2].y, rows, &top, &bottom);
    for (int64_t r = top; r <= bottom; r++)
        for (int64_t c = left; c <= right; c++) {
            const size_t p = (size_t)r * columns + (size_t)c;
            const double base = (double)heights[p];
            if (isnan(base) || !height_at(at, (double)c, (double)r, &height))
                continue;
            const double off = fabs(height - base);
            if (off <= NEAR_MOST * sqrt(1.0 + (double)slopes[p]) &&
                !(off >= fabs((double)lifted[p] - base)))
                lifted[p] = (float)height;
        }
}

/* Drops the lifted heights of neighbours that jump; false if there are none. */
static bool drop_jumps(uint32_t columns, uint32_t rows, const double jumps[STP_MAP_BESIDE],
                       const float *heights, float *lifted)
{
    bool dropped = false;
    for (int64_t p = 0; p < (int64_t)columns * rows; p++)
        for (int k = 0; k < STP_MAP_BESIDE; k++) {
            const int64_t c = p % columns + stp_map_beside[k][0];
            const int64_t r = p / columns + stp_map_beside[k][1];
            const int64_t q = r * columns + c;
            if (c < 0 || c >= columns || r >= rows || (isnan(lifted[p]) && isnan(lifted[q])))
                continue;
            const float a = isnan(lifted[p]) ? heights[p] : lifted[p];
            const float b = isnan(lifted[q]) ? heights[q] : lifted[q];
            if (fabsf(a - b) > (float)jumps[k] &&
                fabsf(heights[p] - heights[q]) <= (float)jumps[k]) {
                lifted[p] = lifted[q] = NAN;
                dropped = true;
            }
        }
    return dropped;
}

void stp_map_faces_lift(const stp_map_faces *faces, uint32_t columns, uint32_t rows,
                        const float *slopes, const double jumps[STP_MAP_BESIDE], float *heights,
                        float *lifted)
{
    const size_t all = (size_t)columns * rows;
    for (size_t i = 0; i < all; i++)
        lifted[i] = NAN;
    for (size_t i = 0; i < faces->count; i++)
        lift(faces->list[i].at, columns, rows, slopes, heights, lifted);
    while (drop_jumps(columns, rows, jumps, heights, lifted))
        ;
    for (size_t i = 0; i < all; i++)
        if (!isnan(lifted[i]))
            heights[i] = lifted[i];
}
