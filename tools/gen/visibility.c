/* Tests rays from stations against the implicit tree over curve-sorted triangles. */
#include "tools/gen/visibility.h"

#include "base/memory.h"
#include "base/random.h"

#include <stdlib.h>

enum { LEAF_TRIANGLES = 4 };

/* Scanners get no return at grazing angles (beyond about 85 degrees). */
#define GRAZING_COSINE 0.08

typedef struct box {
    vec3s min, max;
} box;

struct gen_visibility {
    const gen_triangle *triangles;
    size_t triangle_count;
    size_t leaf_count; /* a power of two; node i has the children 2 i and 2 i + 1; the root is 1 */
    box *boxes;
    size_t station_count;
    stp_dvec3 *stations;
    double tolerance;
};

static box box_join(box a, box b)
{
    for (int axis = 0; axis < 3; axis++) {
        a.min.raw[axis] = fminf(a.min.raw[axis], b.min.raw[axis]);
        a.max.raw[axis] = fmaxf(a.max.raw[axis], b.max.raw[axis]);
    }
    return a;
}

static box leaf_box(const gen_visibility *v, size_t leaf)
{
    box result = {{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
    for (size_t i = leaf * LEAF_TRIANGLES; i < (leaf + 1) * LEAF_TRIANGLES; i++)
        if (i < v->triangle_count)
            for (int corner = 0; corner < 3; corner++) {
                vec3s p = v->triangles[i].corners[corner];
                result = box_join(result, (box){p, p});
            }
    return result;
}

/* Places stations evenly around the surface, the golden angle apart: on a sphere; for the terrain
 * on a cap above it; for the sheet above and below in turns, because nothing is seen from within
 * its plane. */
static void place_stations(gen_visibility *v, const gen_surface *surface)
{
    for (size_t i = 0; i < v->station_count; i++) {
        double height = 1.0 - (2.0 * (double)i + 1.0) / (double)v->station_count;
        if (surface->closed)
            height *= 0.75; /* scanners stand around an object rather than above it */
        else if (surface->shape == GEN_SHEET)
            height = (i % 2 == 0 ? 1.0 : -1.0) * (0.55 + 0.2 * height);
        else
            height = 0.35 + 0.3 * height;
        double across = sqrt(1.0 - height * height), angle = 2.399963229728653 * (double)i;
        double c = across * cos(angle), s = across * sin(angle);
        stp_dvec3 direction =
            surface->closed ? (stp_dvec3){s, height, c} : (stp_dvec3){c, s, height};
        v->stations[i] =
            stp_dvec3_add(surface->centre, stp_dvec3_scale(direction, 2.5 * surface->radius));
    }
}

stp_status gen_visibility_create(gen_visibility **out, const gen_surface *surface,
                                 const gen_triangle *triangles, size_t triangle_count,
                                 size_t station_count, stp_error *err)
{
    stp_status status = STP_OK;
    gen_visibility *v = NULL;
    if (station_count > GEN_STATION_LIMIT)
        return stp_error_set(err, STP_LIMIT, "%zu stations are too many; at most %d are possible",
                             station_count, GEN_STATION_LIMIT);
    STP_TRY(stp_alloc(&v, 1, sizeof *v, "visibility", err));
    v->triangles = triangles;
    v->triangle_count = triangle_count;
    v->leaf_count = 1;
    while (v->leaf_count * LEAF_TRIANGLES < triangle_count)
        v->leaf_count *= 2;
    STP_TRY(stp_alloc(&v->boxes, 2 * v->leaf_count, sizeof *v->boxes, "visibility", err));
    v->station_count = station_count;
    STP_TRY(stp_alloc(&v->stations, station_count, sizeof *v->stations, "stations", err));
    place_stations(v, surface);
    double area = 0.0;
    for (size_t i = 0; i < triangle_count; i++) {
        stp_dvec3 a = stp_dvec3_from_float(triangles[i].corners[0]);
        stp_dvec3 b = stp_dvec3_sub(stp_dvec3_from_float(triangles[i].corners[1]), a);
        stp_dvec3 c = stp_dvec3_sub(stp_dvec3_from_float(triangles[i].corners[2]), a);
        area += 0.5 * stp_dvec3_length(stp_dvec3_cross(b, c));
    }
    /* The proxy deviates from the true surface by much less than a triangle's side. The sheet's
     * sides are nearer to each other than that, but each is flat and hides nothing of itself. */
    v->tolerance = surface->shape == GEN_SHEET ? 1e-3 * surface->separation
                                               : 0.5 * sqrt(area / (double)triangle_count);
    for (size_t i = 0; i < v->leaf_count; i++)
        v->boxes[v->leaf_count + i] = leaf_box(v, i);
    for (size_t i = v->leaf_count; i-- > 1;)
        v->boxes[i] = box_join(v->boxes[2 * i], v->boxes[2 * i + 1]);
    *out = v;
    v = NULL;
done:
    gen_visibility_destroy(&v);
    return status;
}

void gen_visibility_destroy(gen_visibility **visibility)
{
    gen_visibility *v = *visibility;
    if (v == NULL)
        return;
    free(v->boxes);
    free(v->stations);
    free(v);
    *visibility = NULL;
}

const stp_dvec3 *gen_visibility_stations(const gen_visibility *visibility)
{
    return visibility->stations;
}

typedef struct ray {
    vec3s origin, direction, inverse; /* the segment from parameter 0 to 1 */
} ray;

static bool ray_meets_box(const ray *r, const box *b)
{
    float near = 0.0f, far = 1.0f;
    if (b->min.x > b->max.x)
        return false; /* the box of a leaf without triangles */
    for (int axis = 0; axis < 3; axis++) {
        float t0 = (b->min.raw[axis] - r->origin.raw[axis]) * r->inverse.raw[axis];
        float t1 = (b->max.raw[axis] - r->origin.raw[axis]) * r->inverse.raw[axis];
        near = fmaxf(near, fminf(t0, t1));
        far = fminf(far, fmaxf(t0, t1));
    }
    return near <= far;
}

/* Source: Moeller and Trumbore 1997. */
static bool ray_meets_triangle(const ray *r, const gen_triangle *t)
{
    stp_dvec3 a = stp_dvec3_from_float(t->corners[0]);
    stp_dvec3 ab = stp_dvec3_sub(stp_dvec3_from_float(t->corners[1]), a);
    stp_dvec3 ac = stp_dvec3_sub(stp_dvec3_from_float(t->corners[2]), a);
    stp_dvec3 d = stp_dvec3_from_float(r->direction);
    stp_dvec3 p = stp_dvec3_cross(d, ac);
    double determinant = stp_dvec3_dot(ab, p);
    if (determinant == 0.0)
        return false;
    stp_dvec3 s = stp_dvec3_sub(stp_dvec3_from_float(r->origin), a);
    double u = stp_dvec3_dot(s, p) / determinant;
    stp_dvec3 q = stp_dvec3_cross(s, ab);
    double v = stp_dvec3_dot(d, q) / determinant;
    double along = stp_dvec3_dot(ac, q) / determinant;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && along >= 0.0 && along <= 1.0;
}

static bool blocked(const gen_visibility *v, const ray *r)
{
    size_t stack[64], depth = 0;
    stack[depth++] = 1;
    while (depth > 0) {
        size_t node = stack[--depth];
        if (!ray_meets_box(r, &v->boxes[node]))
            continue;
        if (node < v->leaf_count) {
            stack[depth++] = 2 * node;
            stack[depth++] = 2 * node + 1;
            continue;
        }
        size_t first = (node - v->leaf_count) * LEAF_TRIANGLES;
        for (size_t i = first; i < first + LEAF_TRIANGLES && i < v->triangle_count; i++)
            if (ray_meets_triangle(r, &v->triangles[i]))
                return true;
    }
    return false;
}

/* The cosine of the angle at which a station is seen from the point. */
static double facing(const gen_visibility *v, size_t station, const gen_hit *hit, double *distance)
{
    stp_dvec3 to = stp_dvec3_sub(v->stations[station], hit->position);
    *distance = stp_dvec3_length(to);
    return stp_dvec3_dot(to, stp_dvec3_from_float(hit->normal)) / *distance;
}

/* True if nothing is between a station and a point that faces it. */
static bool reaches(const gen_visibility *v, size_t station, const gen_hit *hit)
{
    stp_dvec3 to = stp_dvec3_sub(v->stations[station], hit->position);
    stp_dvec3 lift = stp_dvec3_add(stp_dvec3_scale(stp_dvec3_from_float(hit->normal), v->tolerance),
                                   stp_dvec3_scale(to, v->tolerance / stp_dvec3_length(to)));
    stp_dvec3 origin = stp_dvec3_add(hit->position, lift);
    ray r = {stp_dvec3_to_float(origin),
             stp_dvec3_to_float(stp_dvec3_sub(v->stations[station], origin)),
             {{0}}};
    for (int axis = 0; axis < 3; axis++)
        r.inverse.raw[axis] = 1.0f / r.direction.raw[axis];
    return !blocked(v, &r);
}

bool gen_visibility_sees(const gen_visibility *v, const gen_hit *hit)
{
    double distance;
    for (size_t i = 0; i < v->station_count; i++)
        if (facing(v, i, hit, &distance) >= GRAZING_COSINE && reaches(v, i, hit))
            return true;
    return false;
}

/* A weighted draw: each station has an exponential clock whose rate is its weight, and the first to
 * ring wins. A station that does not see the point is removed and the next one is taken, so few
 * rays are cast. */
uint16_t gen_visibility_station(const gen_visibility *v, const gen_hit *hit, uint64_t key,
                                uint64_t counter)
{
    double waits[GEN_STATION_LIMIT], distance;
    for (size_t i = 0; i < v->station_count; i++) {
        double cosine = facing(v, i, hit, &distance);
        double wait = -log(1.0 - stp_random_unit(key, counter * GEN_STATION_LIMIT + i));
        waits[i] = cosine < GRAZING_COSINE ? INFINITY : wait * distance * distance / cosine;
    }
    for (;;) {
        size_t first = 0;
        double least = INFINITY;
        for (size_t i = 0; i < v->station_count; i++) {
            first = waits[i] < least ? i : first;
            least = fmin(waits[i], least);
        }
        if (least == INFINITY)
            return 0;
        if (reaches(v, first, hit))
            return (uint16_t)(first + 1);
        waits[first] = INFINITY;
    }
}
