/* Computes points of a surface as a function of their index. */
#include "tools/gen/sampler.h"

#include "base/memory.h"
#include "base/random.h"
#include "tools/gen/curve.h"
#include "tools/gen/visibility.h"

#include <stdlib.h>

/* The part of its piece of the curve in which a point is jittered. */
static const double jitter_width = 0.7;

enum { SEEN_NONE, SEEN_PART, SEEN_ALL, TRIALS = 16, RETRIES = 64, TRIANGLES_PER_TASK = 1024 };

/* Independent streams of random numbers. */
enum {
    STREAM_JITTER = 1,
    STREAM_NOISE_A,
    STREAM_NOISE_B,
    STREAM_ORDER,
    STREAM_RETRY,
    STREAM_STATION,
    STREAM_COUNT
};

struct gen_sampler {
    const gen_surface *surface;
    uint64_t point_count;
    uint64_t keys[STREAM_COUNT];
    bool random_order;
    double sigma, area;
    gen_permutation order;
    size_t triangle_count;
    gen_triangle *triangles; /* along the curve */
    gen_mesh mesh;           /* for a surface that is its own mesh, else empty */
    uint32_t *sources;       /* the triangles' indices in mesh */
    double *cumulative;      /* sampled area before each triangle; triangle_count + 1 */
    uint32_t *guide; /* triangle at each 1/triangle_count of the area, where searches start */
    uint8_t *seen;   /* SEEN_*; NULL without stations */
    gen_visibility *visibility;
};

typedef struct keyed_triangle {
    uint64_t key;
    uint32_t index;
} keyed_triangle;

static int compare_keys(const void *a, const void *b)
{
    const keyed_triangle *p = a, *q = b;
    if (p->key != q->key)
        return p->key < q->key ? -1 : 1;
    return p->index < q->index ? -1 : p->index > q->index;
}

static gen_triangle mesh_triangle(const gen_mesh *mesh, size_t index)
{
    const uint32_t *corners = mesh->triangles[index];
    return (gen_triangle){
        {mesh->positions[corners[0]], mesh->positions[corners[1]], mesh->positions[corners[2]]}};
}

/* Copies the corner coordinates of the mesh's triangles in the order of the Hilbert curve. */
static stp_status sort_triangles(gen_sampler *s, const gen_mesh *mesh, stp_error *err)
{
    keyed_triangle *keys = NULL;
    stp_status status = STP_OK;
    stp_dvec3 low = s->surface->centre;
    double radius = s->surface->radius;
    STP_TRY(stp_alloc(&keys, mesh->triangle_count, sizeof *keys, "triangle order", err));
    STP_TRY(
        stp_alloc(&s->triangles, mesh->triangle_count, sizeof *s->triangles, "proxy mesh", err));
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        gen_triangle t = mesh_triangle(mesh, i);
        uint32_t place[3];
        for (int axis = 0; axis < 3; axis++) {
            double middle = ((double)t.corners[0].raw[axis] + (double)t.corners[1].raw[axis] +
                             (double)t.corners[2].raw[axis]) /
                            3.0;
            double centre = axis == 0 ? low.x : axis == 1 ? low.y : low.z;
            double unit = 0.5 + 0.45 * (middle - centre) / radius;
            place[axis] = (uint32_t)(fmin(fmax(unit, 0.0), 1.0) * 2097151.0);
        }
        keys[i] = (keyed_triangle){gen_hilbert_index(place), (uint32_t)i};
    }
    qsort(keys, mesh->triangle_count, sizeof *keys, compare_keys);
    for (size_t i = 0; i < mesh->triangle_count; i++)
        s->triangles[i] = mesh_triangle(mesh, keys[i].index);
    s->triangle_count = mesh->triangle_count;
    if (s->surface->project == NULL) {
        STP_TRY(stp_alloc(&s->sources, mesh->triangle_count, sizeof *s->sources, "triangle order",
                          err));
        for (size_t i = 0; i < mesh->triangle_count; i++)
            s->sources[i] = keys[i].index;
    }
done:
    free(keys);
    return status;
}

/* Gets the surface's point at a place of a triangle, given also by the corners' weights. */
static void surface_point(const gen_sampler *s, size_t triangle, stp_dvec3 place,
                          const float weights[3], gen_hit *hit)
{
    if (s->surface->project != NULL)
        s->surface->project(s->surface, place, hit);
    else
        gen_mesh_point(&s->mesh, s->sources[triangle], weights, hit);
}

static void triangle_point(const gen_sampler *s, size_t triangle, double t, gen_hit *hit)
{
    float w[3];
    gen_sierpinski_point(t, w);
    const vec3s *c = s->triangles[triangle].corners;
    stp_dvec3 start;
    start.x = (double)(w[0] * c[0].x + w[1] * c[1].x + w[2] * c[2].x);
    start.y = (double)(w[0] * c[0].y + w[1] * c[1].y + w[2] * c[2].y);
    start.z = (double)(w[0] * c[0].z + w[1] * c[1].z + w[2] * c[2].z);
    surface_point(s, triangle, start, w, hit);
}

static double triangle_area(const gen_triangle *t)
{
    stp_dvec3 a = stp_dvec3_from_float(t->corners[0]);
    stp_dvec3 ab = stp_dvec3_sub(stp_dvec3_from_float(t->corners[1]), a);
    stp_dvec3 ac = stp_dvec3_sub(stp_dvec3_from_float(t->corners[2]), a);
    return 0.5 * stp_dvec3_length(stp_dvec3_cross(ab, ac));
}

/* True if the k-th of TRIALS fixed places of a triangle is seen. */
static bool trial_seen(const gen_sampler *s, size_t triangle, int k, gen_hit *hit)
{
    triangle_point(s, triangle, ((double)k + 0.5) / (double)TRIALS, hit);
    return gen_visibility_sees(s->visibility, hit);
}

/* True if a corner or the middle of the triangle, projected onto the surface, is seen. */
static bool probe_seen(const gen_sampler *s, size_t triangle, int probe)
{
    const vec3s *c = s->triangles[triangle].corners;
    vec3s p = c[probe % 3];
    float w[3] = {0.0f, 0.0f, 0.0f};
    w[probe % 3] = 1.0f;
    if (probe == 3)
        for (int axis = 0; axis < 3; axis++)
            p.raw[axis] = (c[0].raw[axis] + c[1].raw[axis] + c[2].raw[axis]) / 3.0f;
    if (probe == 3)
        w[0] = w[1] = w[2] = 1.0f / 3.0f;
    gen_hit hit;
    surface_point(s, triangle, stp_dvec3_from_float(p), w, &hit);
    return gen_visibility_sees(s->visibility, &hit);
}

/* For a run of triangles, sets seen and sets cumulative[i + 1] to the seen area. */
static stp_status see_triangles(void *context, size_t index, unsigned worker, stp_error *err)
{
    (void)worker;
    (void)err;
    gen_sampler *s = context;
    size_t end = (index + 1) * TRIANGLES_PER_TASK;
    for (size_t i = index * TRIANGLES_PER_TASK; i < end && i < s->triangle_count; i++) {
        int corners = 0;
        for (int probe = 0; probe < 4; probe++)
            corners += probe_seen(s, i, probe);
        s->seen[i] = corners == 4 ? SEEN_ALL : corners == 0 ? SEEN_NONE : SEEN_PART;
        int count = corners == 4 ? TRIALS : 0;
        gen_hit hit;
        if (s->seen[i] == SEEN_PART)
            for (int k = 0; k < TRIALS; k++)
                count += trial_seen(s, i, k, &hit);
        s->cumulative[i + 1] *= (double)count / (double)TRIALS;
    }
    return STP_OK;
}

/* Turns areas into running sums and makes the guide. */
static stp_status sum_areas(gen_sampler *s, stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t i = 0; i < s->triangle_count; i++)
        s->cumulative[i + 1] += s->cumulative[i];
    s->area = s->cumulative[s->triangle_count];
    if (!(s->area > 0.0)) {
        status = stp_error_set(err, STP_EMPTY, "no station sees the surface; ask for more");
        goto done;
    }
    STP_TRY(stp_alloc(&s->guide, s->triangle_count + 1, sizeof *s->guide, "triangle guide", err));
    uint32_t triangle = 0;
    for (size_t i = 0; i <= s->triangle_count; i++) {
        double place = s->area * (double)i / (double)s->triangle_count;
        while (triangle + 1 < s->triangle_count && s->cumulative[triangle + 1] <= place)
            triangle++;
        s->guide[i] = triangle;
    }
done:
    return status;
}

stp_status gen_sampler_create(gen_sampler **out, const gen_sampler_params *params, stp_pool *pool,
                              stp_error *err)
{
    stp_status status = STP_OK;
    gen_sampler *s = NULL;
    gen_mesh mesh = {0};
    const gen_surface *surface = params->surface;
    if (params->point_count == 0)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "no points are asked for; -n must be 1 or "
                             "more");
    STP_TRY(stp_alloc(&s, 1, sizeof *s, "sampler", err));
    s->surface = surface;
    s->point_count = params->point_count;
    s->random_order = params->random_order;
    for (uint64_t stream = 0; stream < STREAM_COUNT; stream++)
        s->keys[stream] = stp_random_u64(params->seed, stream);
    gen_permutation_init(&s->order, params->point_count, s->keys[STREAM_ORDER]);
    STP_TRY(surface->mesh(surface, surface->proxy_triangles, pool, &mesh, err));
    STP_TRY(sort_triangles(s, &mesh, err));
    if (surface->project == NULL) {
        s->mesh = mesh;
        mesh = (gen_mesh){0};
    }
    STP_TRY(stp_alloc(&s->cumulative, s->triangle_count + 1, sizeof *s->cumulative,
                      "triangle areas", err));
    for (size_t i = 0; i < s->triangle_count; i++)
        s->cumulative[i + 1] = triangle_area(&s->triangles[i]);
    if (params->station_count > 0) {
        STP_TRY(gen_visibility_create(&s->visibility, surface, s->triangles, s->triangle_count,
                                      (size_t)params->station_count, err));
        STP_TRY(stp_alloc(&s->seen, s->triangle_count, sizeof *s->seen, "visibility", err));
        size_t tasks = (s->triangle_count + TRIANGLES_PER_TASK - 1) / TRIANGLES_PER_TASK;
        STP_TRY(stp_pool_run(pool, tasks, see_triangles, s, err));
    }
    STP_TRY(sum_areas(s, err));
    s->sigma = params->noise_spacings * gen_sampler_spacing(s);
    *out = s;
    s = NULL;
done:
    gen_mesh_clear(&mesh);
    gen_sampler_destroy(&s);
    return status;
}

void gen_sampler_destroy(gen_sampler **sampler)
{
    gen_sampler *s = *sampler;
    if (s == NULL)
        return;
    free(s->triangles);
    gen_mesh_clear(&s->mesh);
    free(s->sources);
    free(s->cumulative);
    free(s->guide);
    free(s->seen);
    gen_visibility_destroy(&s->visibility);
    free(s);
    *sampler = NULL;
}

double gen_sampler_spacing(const gen_sampler *sampler)
{
    return sqrt(sampler->area / (double)sampler->point_count);
}

const stp_dvec3 *gen_sampler_stations(const gen_sampler *sampler)
{
    return gen_visibility_stations(sampler->visibility);
}

static size_t find_triangle(const gen_sampler *s, double place)
{
    double unit = place / s->area * (double)s->triangle_count;
    size_t triangle = s->guide[(size_t)fmin(unit, (double)s->triangle_count)];
    while (triangle + 1 < s->triangle_count && s->cumulative[triangle + 1] <= place)
        triangle++;
    return triangle;
}

static uint16_t draw_station(const gen_sampler *s, uint64_t piece, const gen_hit *hit)
{
    return gen_visibility_station(s->visibility, hit, s->keys[STREAM_STATION], piece);
}

/* Moves the point to other places of its triangle until it is seen; shadows may be narrower than
 * the places tried before. Returns the station, counted from 1; 0 if no station sees any of the
 * places. */
static uint16_t move_into_sight(const gen_sampler *s, size_t triangle, uint64_t piece, gen_hit *hit)
{
    for (uint64_t retry = 0; retry < RETRIES; retry++) {
        uint16_t station = draw_station(s, piece, hit);
        if (station > 0)
            return station;
        double t = stp_random_unit(s->keys[STREAM_RETRY], piece * RETRIES + retry);
        triangle_point(s, triangle, t, hit);
    }
    for (int k = 0; k < TRIALS; k++)
        if (trial_seen(s, triangle, k, hit))
            return draw_station(s, piece, hit);
    return 0;
}

/* Returns the point's station, counted from 1; 0 without stations. */
static uint16_t sample(const gen_sampler *s, uint64_t piece, gen_hit *hit)
{
    double jitter = jitter_width * (stp_random_unit(s->keys[STREAM_JITTER], piece) - 0.5);
    double place = ((double)piece + 0.5 + jitter) / (double)s->point_count * s->area;
    size_t triangle = find_triangle(s, place);
    double before = s->cumulative[triangle], length = s->cumulative[triangle + 1] - before;
    double t = length > 0.0 ? (place - before) / length : 0.5;
    triangle_point(s, triangle, fmin(fmax(t, 0.0), 0.999999999), hit);
    return s->seen != NULL ? move_into_sight(s, triangle, piece, hit) : 0;
}

/* A standard normal number. Source: Box and Muller 1958. */
static double gaussian(const gen_sampler *s, uint64_t piece)
{
    double u = 1.0 - stp_random_unit(s->keys[STREAM_NOISE_A], piece);
    double v = stp_random_unit(s->keys[STREAM_NOISE_B], piece);
    return sqrt(-2.0 * log(u)) * cos(6.283185307179586 * v);
}

void gen_sampler_fill(const gen_sampler *s, uint64_t first, size_t count, stp_point *points,
                      gen_hit *truth)
{
    for (size_t i = 0; i < count; i++) {
        uint64_t piece = first + i;
        if (s->random_order)
            piece = gen_permutation_at(&s->order, piece);
        gen_hit hit;
        uint16_t station = sample(s, piece, &hit);
        if (truth != NULL)
            truth[i] = hit;
        stp_point *p = &points[i];
        *p = gen_hit_point(&hit);
        p->station = station;
        if (s->sigma > 0.0) {
            stp_dvec3 n = stp_dvec3_from_float(hit.normal);
            double away = s->sigma * gaussian(s, piece);
            p->position = stp_dvec3_add(p->position, stp_dvec3_scale(n, away));
        }
    }
}
