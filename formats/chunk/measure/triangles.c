/* Compares discs with the triangles that they replace. */
#include "formats/chunk/measure/triangles.h"

/* A place in a disc's plane. */
typedef struct flat {
    double x, y;
} flat;

void stp_triangles_under(const uint8_t counts[STP_LEVEL_COUNT], int level, unsigned j,
                         unsigned *first, unsigned *end)
{
    *first = stp_covered_begin(counts, level, j, 0) / 3;
    *end = (stp_covered_begin(counts, level, j + 1, 0) + 2) / 3;
}

static flat flatten(stp_dvec3 p, const stp_disc *disc, stp_dvec3 u, stp_dvec3 v)
{
    stp_dvec3 d = stp_dvec3_sub(p, disc->centre);
    return (flat){stp_dvec3_dot(d, u), stp_dvec3_dot(d, v)};
}

/* Twice the area of a, b, c, with its sign. */
static double turn(flat a, flat b, flat c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

static double off_edge(flat p, flat a, flat b)
{
    const flat way = {b.x - a.x, b.y - a.y};
    const double squared = way.x * way.x + way.y * way.y;
    double t = squared > 0.0 ? ((p.x - a.x) * way.x + (p.y - a.y) * way.y) / squared : 0.0;
    t = stp_max(0.0, stp_min(1.0, t));
    return hypot(p.x - a.x - t * way.x, p.y - a.y - t * way.y);
}

static double off_triangle(flat p, const flat t[3])
{
    const double a = turn(t[0], t[1], p), b = turn(t[1], t[2], p), c = turn(t[2], t[0], p);
    if ((a > 0.0 && b > 0.0 && c > 0.0) || (a < 0.0 && b < 0.0 && c < 0.0))
        return 0.0;
    return stp_min(off_edge(p, t[0], t[1]),
                   stp_min(off_edge(p, t[1], t[2]), off_edge(p, t[2], t[0])));
}

/* How far the disc's farthest point lies from its nearest triangle, in the disc's plane. */
static double farthest_point(const stp_disc *disc, const stp_disc *corners, unsigned first,
                             unsigned end)
{
    stp_dvec3 u, v, points[STP_DISC_POINTS];
    double farthest = 0.0;
    const unsigned count = stp_disc_points(disc, points);
    stp_disc_axes(disc->normal, &u, &v);
    for (unsigned i = 0; i < count; i++) {
        const flat p = flatten(points[i], disc, u, v);
        double least = INFINITY;
        for (unsigned t = first; t < end; t++) {
            flat triangle[3];
            for (unsigned k = 0; k < 3; k++)
                triangle[k] = flatten(corners[3 * t + k].centre, disc, u, v);
            least = stp_min(least, off_triangle(p, triangle));
        }
        farthest = stp_max(farthest, least);
    }
    return farthest;
}

stp_triangles_loss stp_triangles_lost(const stp_disc *disc, const stp_disc *corners, unsigned first,
                                      unsigned end)
{
    stp_triangles_loss out = {0};
    const bool flat_disc = stp_dvec3_length(disc->normal) > 0.0;
    double low = 0.0, high = 0.0;
    for (unsigned i = 3 * first; i < 3 * end; i++) {
        double height = stp_dvec3_dot(stp_dvec3_sub(corners[i].centre, disc->centre), disc->normal);
        low = stp_min(low, height);
        high = stp_max(high, height);
        for (int c = 0; c < 3; c++)
            out.colour_error = stp_max(out.colour_error, fabs(corners[i].rgb[c] - disc->rgb[c]));
    }
    out.error = flat_disc ? stp_max(high, -low) : 2.0 * disc->radius;
    if (flat_disc)
        out.tangential_error = farthest_point(disc, corners, first, end);
    return out;
}

/* ---- as stored ---- */

/* Whether the disc reaches all corners of its triangles, in its plane. */
static bool covers(const stp_disc *disc, const stp_disc *corners, unsigned first, unsigned end)
{
    for (unsigned i = 3 * first; i < 3 * end; i++) {
        stp_dvec3 d = stp_dvec3_sub(corners[i].centre, disc->centre);
        double height = stp_dvec3_dot(d, disc->normal);
        double across = sqrt(stp_max(0.0, stp_dvec3_dot(d, d) - height * height));
        if (across > disc->radius * STP_STORED_SLACK + 1e-6 * fabs(height))
            return false;
    }
    return true;
}

static const char *check_sample(const stp_patch *patch, const stp_sample *sample, int level,
                                unsigned j, const stp_disc *corners)
{
    unsigned first, end;
    const stp_disc disc = stp_disc_from_sample(sample, patch);
    stp_triangles_under(patch->counts, level, j, &first, &end);
    const stp_triangles_loss lost = stp_triangles_lost(&disc, corners, first, end);
    if (stp_sample_kind_of(sample) != STP_KIND_SURFACE)
        return "a sample that stands for triangles is no surface";
    if (!covers(&disc, corners, first, end))
        return "a disc does not reach the corners of the triangles that it stands for";
    if (lost.error > stp_error_held(patch->error[level], patch))
        return "the perpendicular error of a disc over triangles exceeds the stored one";
    if (lost.tangential_error > stp_error_held(patch->tangential_error[level], patch))
        return "the tangential error of a disc over triangles exceeds the stored one";
    if (lost.colour_error > (double)patch->colour_error[level] + 1e-9)
        return "the colour error of a disc over triangles exceeds the stored one";
    return NULL;
}

const char *stp_triangles_fault(const stp_chunk *chunk, uint32_t patch)
{
    const stp_patch *p = &chunk->patches[patch];
    stp_disc corners[STP_PATCH_SAMPLES];
    const char *fault = NULL;
    for (unsigned i = 0; i < p->counts[0]; i++)
        corners[i] = stp_disc_from_sample(&chunk->samples[0][chunk->level_begin[0][patch] + i], p);
    for (int l = 1; l < STP_LEVEL_COUNT; l++)
        for (unsigned j = 0; j < p->counts[l] && !fault; j++)
            fault = check_sample(p, &chunk->samples[l][chunk->level_begin[l][patch] + j], l, j,
                                 corners);
    return fault;
}
