/* Compares the coarser levels of a strip with its vertices. */
#include "formats/chunk/measure/strip.h"

#include <string.h>

/* Where the segment's point nearest to the vertex lies, 0 to 1. */
static double nearest_on(const stp_disc *vertex, const stp_disc *a, stp_dvec3 way)
{
    double squared = stp_dvec3_dot(way, way);
    double along = stp_dvec3_dot(stp_dvec3_sub(vertex->centre, a->centre), way);
    return squared > 0.0 ? stp_max(0.0, stp_min(1.0, along / squared)) : 0.0;
}

/* How far an edge of a ribbon moves if the vertex gets the segment's normal. Normals have no sign.
 * A tube's vertices have no normals. */
static double turned(const stp_disc *vertex, const stp_disc *a, const stp_disc *b, double t)
{
    double sign = stp_dvec3_dot(a->normal, b->normal) < 0.0 ? -1.0 : 1.0;
    stp_dvec3 n = stp_dvec3_normalize(
        stp_dvec3_add(stp_dvec3_scale(a->normal, 1.0 - t), stp_dvec3_scale(b->normal, sign * t)));
    double same = stp_dvec3_length(stp_dvec3_sub(vertex->normal, n));
    double opposed = stp_dvec3_length(stp_dvec3_add(vertex->normal, n));
    return vertex->radius * stp_min(same, opposed);
}

static void lose(const stp_disc *vertex, const stp_disc *a, const stp_disc *b, stp_strip_loss *out)
{
    stp_dvec3 way = stp_dvec3_sub(b->centre, a->centre);
    double t = nearest_on(vertex, a, way);
    stp_dvec3 off =
        stp_dvec3_sub(vertex->centre, stp_dvec3_add(a->centre, stp_dvec3_scale(way, t)));
    double radius = a->radius + t * (b->radius - a->radius);
    double error = stp_dvec3_length(off) + fabs(vertex->radius - radius) + turned(vertex, a, b, t);
    out->error = stp_max(out->error, error);
    for (int c = 0; c < 3; c++) {
        double colour = a->rgb[c] + t * (b->rgb[c] - a->rgb[c]);
        out->colour_error = stp_max(out->colour_error, fabs(vertex->rgb[c] - colour));
    }
}

/* What a segment from vertex `from` to vertex `to` loses of the vertices between. */
static stp_strip_loss lost_between(const stp_disc *vertices, unsigned from, unsigned to)
{
    stp_strip_loss out = {0};
    for (unsigned i = from + 1; i < to; i++)
        lose(&vertices[i], &vertices[from], &vertices[to], &out);
    return out;
}

stp_strip_loss stp_strip_choose(const stp_disc *vertices, const stp_strip_choice *choices,
                                unsigned count, uint8_t *chosen)
{
    double least[STP_STRIP_CANDIDATES][STP_STRIP_CANDIDATES] = {{0}}; /* error of best path */
    uint8_t before[STP_STRIP_CANDIDATES][STP_STRIP_CANDIDATES] = {{0}};
    stp_strip_loss out = {0};
    for (unsigned j = 1; j < count; j++) {
        for (unsigned k = 0; k < choices[j].count; k++) {
            least[j][k] = INFINITY;
            for (unsigned i = 0; i < choices[j - 1].count; i++) {
                stp_strip_loss e =
                    lost_between(vertices, choices[j - 1].vertex[i], choices[j].vertex[k]);
                double error = stp_max(least[j - 1][i], e.error);
                if (error < least[j][k]) {
                    least[j][k] = error;
                    before[j][k] = (uint8_t)i;
                }
            }
        }
    }
    unsigned at = 0;
    for (unsigned k = 1; k < choices[count - 1].count; k++)
        at = least[count - 1][k] < least[count - 1][at] ? k : at;
    for (unsigned j = count; j-- > 0; at = before[j][at])
        chosen[j] = choices[j].vertex[at];
    for (unsigned j = 1; j < count; j++) {
        stp_strip_loss e = lost_between(vertices, chosen[j - 1], chosen[j]);
        out.error = stp_max(out.error, e.error);
        out.colour_error = stp_max(out.colour_error, e.colour_error);
    }
    return out;
}

double stp_strip_reach(const stp_disc *vertices, unsigned count, stp_dvec3 centre)
{
    double reach = 0.0;
    for (unsigned i = 0; i < count; i++)
        reach = stp_max(reach, stp_dvec3_length(stp_dvec3_sub(vertices[i].centre, centre)) +
                                   vertices[i].radius);
    return reach;
}

stp_strip_loss stp_strip_disc_lost(const stp_disc *vertices, unsigned count, const stp_disc *disc)
{
    stp_strip_loss out = {.error = 2.0 * disc->radius};
    for (unsigned i = 0; i < count; i++)
        for (int c = 0; c < 3; c++)
            out.colour_error = stp_max(out.colour_error, fabs(vertices[i].rgb[c] - disc->rgb[c]));
    return out;
}

/* ---- a strip as stored ---- */

typedef struct stored_strip {
    const stp_patch *patch;
    const stp_sample *samples[STP_LEVEL_COUNT];
    stp_disc vertices[STP_PATCH_SAMPLES];
} stored_strip;

static bool is_same(const stp_sample *a, const stp_sample *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

/* Whether a sample is one of its children: at the ends the first or the last. */
static bool is_a_child(const stored_strip *s, int level, unsigned j)
{
    const uint8_t *counts = s->patch->counts;
    const stp_sample *finer = s->samples[level - 1], *sample = &s->samples[level][j];
    unsigned begin = stp_level_children_begin(j, counts[level], counts[level - 1]);
    unsigned end = stp_level_children_begin(j + 1, counts[level], counts[level - 1]);
    if (j == 0)
        return is_same(sample, &finer[0]);
    if (j + 1u == counts[level])
        return is_same(sample, &finer[counts[level - 1] - 1u]);
    for (unsigned i = begin; i < end; i++)
        if (is_same(sample, &finer[i]))
            return true;
    return false;
}

/* The level-0 vertices that a sample may be. There are several if vertices are equal. */
static stp_strip_choice find_choice(const stored_strip *s, int level, unsigned j)
{
    const uint8_t *counts = s->patch->counts;
    const unsigned last = counts[0] - 1u;
    stp_strip_choice out = {0};
    unsigned begin = j + 1u == counts[level] ? last : stp_covered_begin(counts, level, j, 0);
    unsigned end = j == 0 ? 1 : stp_covered_begin(counts, level, j + 1, 0);
    for (unsigned i = begin; i < end && out.count < STP_STRIP_CANDIDATES; i++)
        if (is_same(&s->samples[level][j], &s->samples[0][i]))
            out.vertex[out.count++] = (uint8_t)i;
    return out;
}

static const char *compare_loss(const stp_patch *patch, int level, stp_strip_loss lost)
{
    if (lost.error > stp_error_held(patch->error[level], patch))
        return "the error of a strip's level exceeds the stored one";
    if (lost.colour_error > (double)patch->colour_error[level] + 1e-9)
        return "the colour error of a strip's level exceeds the stored one";
    return NULL;
}

/* Checks a level of two vertices or more. */
static const char *check_polyline(const stored_strip *s, int level)
{
    stp_strip_choice choices[STP_STRIP_CANDIDATES] = {{0}};
    uint8_t chosen[STP_STRIP_CANDIDATES] = {0};
    const unsigned count = s->patch->counts[level];
    for (unsigned j = 0; j < count; j++) {
        if (!is_a_child(s, level, j))
            return "a vertex of a coarser level of a strip is none of those that it covers";
        choices[j] = find_choice(s, level, j);
        if (choices[j].count == 0)
            return "a vertex of a coarser level of a strip is none of those that it covers";
    }
    return compare_loss(s->patch, level, stp_strip_choose(s->vertices, choices, count, chosen));
}

/* Checks a level of one disc. */
static const char *check_disc(const stored_strip *s, int level)
{
    const unsigned count = s->patch->counts[0];
    if (count == 1)
        return is_same(s->samples[level], s->samples[0])
                   ? NULL
                   : "a strip of one vertex has another one at a coarser level";
    stp_disc disc = stp_disc_from_sample(s->samples[level], s->patch);
    double reach = stp_strip_reach(s->vertices, count, disc.centre);
    if (reach > disc.radius * STP_STORED_SLACK)
        return "the disc that stands for a strip does not hold it";
    return compare_loss(s->patch, level, stp_strip_disc_lost(s->vertices, count, &disc));
}

static bool has_kind(const stored_strip *s)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        for (unsigned i = 0; i < s->patch->counts[l]; i++)
            if (stp_sample_kind_of(&s->samples[l][i]) != stp_sample_kind_of(s->samples[0]) ||
                s->samples[l][i].flags & STP_SAMPLE_ORIENTED)
                return false;
    return true;
}

const char *stp_strip_fault(const stp_chunk *chunk, uint32_t patch)
{
    stored_strip s;
    const char *fault = NULL;
    s.patch = &chunk->patches[patch];
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        s.samples[l] = chunk->samples[l] + chunk->level_begin[l][patch];
    for (unsigned i = 0; i < s.patch->counts[0]; i++)
        s.vertices[i] = stp_disc_from_sample(&s.samples[0][i], s.patch);
    if (!has_kind(&s))
        return "the samples of a strip are of several kinds, or say which side is the outside";
    for (int l = 1; l < STP_LEVEL_COUNT && !fault; l++)
        fault = s.patch->counts[l] > 1 ? check_polyline(&s, l) : check_disc(&s, l);
    return fault;
}
