/* Random mixtures of points: parts of any size and density, beside or inside each other,
 * duplicates, outliers, coordinates on a scale's steps or far from the origin, with random options
 * of prep. A seed gives the same mixture each time.
 *
 * A test tries many seeds. With STIPPLE_MIXTURE=SEED it tries that one alone, to repeat a failure.
 */
#ifndef STP_TESTS_MIXTURE_FIXTURE_H
#define STP_TESTS_MIXTURE_FIXTURE_H

#include "tests/prep_fixture.h"

#include <inttypes.h>

typedef struct mixture {
    prep_cloud cloud;
    stp_prep_params params;
    uint64_t seed, drawn;
    double size; /* of the largest part */
    char words[256];
} mixture;

typedef enum mixture_kind {
    MIXTURE_PLANE,
    MIXTURE_SPHERE,
    MIXTURE_CLUSTER,
    MIXTURE_LINE,
    MIXTURE_PILE, /* all at one place */
    MIXTURE_GRID,
    MIXTURE_OUTLIERS, /* as far out as the largest part is wide, and more */
    MIXTURE_KINDS
} mixture_kind;

static const char *const mixture_kind_names[MIXTURE_KINDS] = {"plane", "sphere", "cluster", "line",
                                                              "pile",  "grid",   "outliers"};

static inline double mixture_draw(mixture *m)
{
    return stp_random_unit(m->seed, m->drawn++);
}

/* 10^low to 10^high, logarithms evenly. */
static inline double mixture_octave(mixture *m, double low, double high)
{
    return pow(10.0, low + (high - low) * mixture_draw(m));
}

static inline size_t mixture_choice(mixture *m, size_t count)
{
    return (size_t)(mixture_draw(m) * (double)count);
}

/* In the cube of half-width 1. */
static inline stp_dvec3 mixture_cube(mixture *m)
{
    stp_dvec3 p;
    p.x = 2.0 * mixture_draw(m) - 1.0;
    p.y = 2.0 * mixture_draw(m) - 1.0;
    p.z = 2.0 * mixture_draw(m) - 1.0;
    return p;
}

/* The i-th of count points of a part whose half-width is 1; *normal: of the part there. */
static inline stp_dvec3 mixture_point(mixture *m, mixture_kind kind, size_t i, size_t count,
                                      stp_dvec3 *normal)
{
    const size_t side = (size_t)ceil(sqrt((double)count));
    stp_dvec3 p = mixture_cube(m), ball = stp_dvec3_normalize(p);
    *normal = (stp_dvec3){0.0, 0.0, 1.0};
    switch (kind) {
    case MIXTURE_PLANE:
        p.z = 0.0;
        break;
    case MIXTURE_SPHERE:
        p = *normal = ball;
        break;
    case MIXTURE_CLUSTER: /* denser to the middle, by many octaves */
        p = stp_dvec3_scale(ball, pow(10.0, -3.0 * mixture_draw(m)));
        *normal = ball;
        break;
    case MIXTURE_LINE:
        p.y = p.z = 0.0;
        break;
    case MIXTURE_GRID:
        p.x = 2.0 * (double)(i % side) / (double)side - 1.0;
        p.y = 2.0 * (double)(i / side) / (double)side - 1.0;
        p.z = 0.0;
        break;
    default:
        p = kind == MIXTURE_PILE ? (stp_dvec3){0.0, 0.0, 0.0} : p;
        *normal = ball;
    }
    return p;
}

/* Fills points [begin, end) with one part. */
static inline void mixture_add_part(mixture *m, size_t begin, size_t end, mixture_kind kind)
{
    const bool first = begin == 0;
    const double size = kind == MIXTURE_OUTLIERS ? m->size * mixture_octave(m, 0.0, 2.0)
                        : first                  ? m->size
                                                 : m->size * mixture_octave(m, -5.0, 0.0);
    const stp_dvec3 centre =
        first ? (stp_dvec3){0.0, 0.0, 0.0} : stp_dvec3_scale(mixture_cube(m), m->size);
    const stp_dvec3 axis = mixture_cube(m);
    const bool turned = mixture_choice(m, 2);
    for (size_t i = begin; i < end; i++) {
        stp_dvec3 normal, p = mixture_point(m, kind, i - begin, end - begin, &normal);
        if (turned) {
            p = stp_dvec3_rotate(p, stp_dvec3_normalize(axis), 1.0);
            normal = stp_dvec3_rotate(normal, stp_dvec3_normalize(axis), 1.0);
        }
        m->cloud.points[i].position = stp_dvec3_add(centre, stp_dvec3_scale(p, size));
        m->cloud.points[i].normal = stp_dvec3_to_float(normal);
    }
    size_t used = strlen(m->words);
    snprintf(m->words + used, sizeof m->words - used, "%zu %s of %.2g, ", end - begin,
             mixture_kind_names[kind], size);
}

/* One to six parts, some of a handful of points. */
static inline void mixture_add_parts(mixture *m)
{
    const size_t parts = 1 + mixture_choice(m, 6);
    size_t begin = 0;
    for (size_t part = 0; part < parts && begin < m->cloud.count; part++) {
        const mixture_kind kind = (mixture_kind)mixture_choice(m, MIXTURE_KINDS);
        const size_t left = m->cloud.count - begin;
        double share = kind == MIXTURE_OUTLIERS ? 0.01 : mixture_draw(m);
        size_t count = part + 1 == parts ? left : (size_t)(share * (double)left) + 1;
        mixture_add_part(m, begin, begin + count, kind);
        begin += count;
    }
}

/* Copies of other points, in places of others. */
static inline void mixture_repeat(mixture *m)
{
    const double share = mixture_choice(m, 3) == 0 ? mixture_draw(m) : 0.0;
    const size_t piled = mixture_choice(m, m->cloud.count); /* where many of them lie */
    for (size_t i = 0; i < m->cloud.count; i++) {
        if (mixture_draw(m) >= share)
            continue;
        const size_t from = mixture_draw(m) < 0.5 ? piled : mixture_choice(m, m->cloud.count);
        m->cloud.points[i].position = m->cloud.points[from].position;
        m->cloud.points[i].normal = m->cloud.points[from].normal;
    }
}

/* On a scale's steps where there is one, and where the world's origin is. */
static inline void mixture_place(mixture *m)
{
    static const stp_dvec3 origins[] = {
        {0.0, 0.0, 0.0}, {499981.0, 5418510.0, 240.0}, {-1e9, 3e8, 7.0}, {0.125, -1e-3, 1e5}};
    static const double steps[] = {0.0, 0.001, 0.01, 1.0, 1e-7};
    const stp_dvec3 origin = origins[mixture_choice(m, 4)];
    const double step = steps[mixture_choice(m, 5)];
    for (size_t i = 0; i < m->cloud.count; i++) {
        stp_dvec3 p = stp_dvec3_add(m->cloud.points[i].position, origin);
        if (step > 0.0)
            p = (stp_dvec3){nearbyint(p.x / step) * step, nearbyint(p.y / step) * step,
                            nearbyint(p.z / step) * step};
        m->cloud.points[i].position = p;
    }
    m->params.precision = 0.5 * step;
    size_t used = strlen(m->words);
    snprintf(m->words + used, sizeof m->words - used, "at %g,%g,%g in steps of %g", origin.x,
             origin.y, origin.z, step);
}

static inline void mixture_choose_options(mixture *m)
{
    static const stp_codec codecs[] = {STP_CODEC_DRACO, STP_CODEC_ZSTD, STP_CODEC_ZSTD,
                                       STP_CODEC_RAW};
    static const stp_orient_mode orients[] = {STP_ORIENT_AUTO, STP_ORIENT_NONE,
                                              STP_ORIENT_PROPAGATE};
    static const stp_outlier_mode outliers[] = {STP_OUTLIERS_KEEP, STP_OUTLIERS_KEEP,
                                                STP_OUTLIERS_MARK, STP_OUTLIERS_DROP};
    m->params.codec = codecs[mixture_choice(m, 4)];
    m->params.orient = orients[mixture_choice(m, 3)];
    m->params.outliers = outliers[mixture_choice(m, 4)];
    m->params.neighbour_count = mixture_choice(m, 2) ? 0 : 4 + (unsigned)mixture_choice(m, 24);
    m->params.lambda = mixture_choice(m, 3) ? 0.0 : mixture_octave(m, -0.5, 1.0);
    if (mixture_choice(m, 3) == 0)
        m->params.precision = m->size * mixture_octave(m, -8.0, -2.0);
    if (mixture_choice(m, 2))
        for (size_t i = 0; i < m->cloud.count; i++)
            m->cloud.points[i].normal = (vec3s){{0.0f, 0.0f, 0.0f}};
}

/* Of least to most points; free(m.cloud.points). */
static inline mixture mixture_make(uint64_t seed, double least, double most)
{
    mixture m = {.seed = seed};
    m.cloud = prep_cloud_make((size_t)mixture_octave(&m, log10(least), log10(most)));
    m.size = mixture_octave(&m, -4.0, 5.0);
    mixture_add_parts(&m);
    mixture_repeat(&m);
    mixture_place(&m);
    mixture_choose_options(&m);
    return m;
}

/* Numbers of 10^low to 10^high, of either sign, some 0, and points that repeat: some at single
 * places, some one beside the other. */
static inline mixture mixture_make_extreme(uint64_t seed, double low, double high)
{
    mixture m = {.seed = seed};
    m.cloud = prep_cloud_make((size_t)mixture_octave(&m, 0.0, 1.5));
    m.size = mixture_octave(&m, low, high);
    const size_t kind = mixture_choice(&m, 3);
    for (size_t i = 0; i < m.cloud.count; i++) {
        double v[3];
        for (int axis = 0; axis < 3; axis++) {
            v[axis] = kind == 0   ? mixture_octave(&m, low, high)
                      : kind == 1 ? m.size * mixture_octave(&m, -8.0, 0.0)
                                  : m.size * (1.0 + mixture_octave(&m, -17.0, -10.0));
            v[axis] *= kind < 2 && mixture_choice(&m, 2) ? -1.0 : 1.0;
            v[axis] *= mixture_choice(&m, 4) ? 1.0 : 0.0;
        }
        m.cloud.points[i].position = (stp_dvec3){v[0], v[1], v[2]};
        if (i > 0 && mixture_choice(&m, 5) == 0)
            m.cloud.points[i].position = m.cloud.points[mixture_choice(&m, i)].position;
        m.cloud.points[i].normal = stp_dvec3_to_float(mixture_cube(&m));
    }
    mixture_choose_options(&m);
    snprintf(m.words, sizeof m.words, "numbers of 10^%g to 10^%g", low, high);
    return m;
}

/* A survey: a dense plane and a few points far about it, all on a scale's steps. */
static inline mixture mixture_make_survey(uint64_t seed, size_t plane, size_t far)
{
    mixture m = {.seed = seed, .size = 3000.0, .params = {.precision = 0.0005}};
    m.cloud = prep_cloud_make(plane + far);
    for (size_t i = 0; i < m.cloud.count; i++) {
        const stp_dvec3 p = mixture_cube(&m);
        const bool near = i < plane;
        const double wide = near ? 50.0 : 1500.0, high = near ? 0.0 : 150.0;
        m.cloud.points[i].position = (stp_dvec3){nearbyint(p.x * wide / 0.001) * 0.001,
                                                 nearbyint(p.y * wide / 0.001) * 0.001,
                                                 nearbyint(p.z * high / 0.001) * 0.001};
    }
    snprintf(m.words, sizeof m.words, "%zu points on a plane and %zu far about it", plane, far);
    return m;
}

/* Whether the seed is to be tried. */
static inline bool mixture_wanted(uint64_t seed)
{
    const char *only = getenv("STIPPLE_MIXTURE");
    return !only || strtoull(only, NULL, 10) == seed;
}

/* How far a stored point is from where it was, and whether its patch's error holds that. */
static inline bool mixture_holds_point(const mixture *m, const stp_chunk_entry *entry,
                                       const stp_patch *patch, const stp_sample *sample)
{
    const uint32_t number = prep_number_of(sample);
    if (number >= m->cloud.count)
        return false;
    const stp_dvec3 is = stp_dvec3_add(entry->origin, stp_sample_position(sample, patch));
    const stp_dvec3 was = m->cloud.points[number].position;
    return stp_dvec3_length(stp_dvec3_sub(is, was)) <=
           stp_error_decode(patch->error[0], patch->exponent) * (1.0 + 1e-6) +
               1e-15 * stp_dvec3_length(was);
}

typedef struct mixture_search {
    const mixture *m;
    uint8_t *seen; /* by number */
    uint64_t found;
} mixture_search;

static inline void mixture_find_point(void *context, const stp_chunk_entry *entry,
                                      const stp_patch *patch, const stp_sample *sample)
{
    mixture_search *search = context;
    if (!mixture_holds_point(search->m, entry, patch, sample) ||
        search->seen[prep_number_of(sample)]++)
        fail_msg("mixture %" PRIu64 ": point %" PRIu32 " is stored elsewhere or twice",
                 search->m->seed, prep_number_of(sample));
    search->found++;
}

/* Fails unless every point that was not dropped is stored once, where its patch says. */
static inline void mixture_assert_stored(const mixture *m, stp_chunk_file *file, uint64_t expected)
{
    mixture_search search = {.m = m, .seen = calloc(m->cloud.count, 1)};
    assert_non_null(search.seen);
    prep_visit_points(file, mixture_find_point, &search);
    if (search.found != expected)
        fail_msg("mixture %" PRIu64 ": %" PRIu64 " points are stored, not %" PRIu64, m->seed,
                 search.found, expected);
    free(search.seen);
}

/* Fails unless the file, of what is left after so many points were dropped, is sound. */
static inline void mixture_assert_sound(const mixture *m, const char *path, uint64_t dropped)
{
    char what[sizeof m->words + 32];
    snprintf(what, sizeof what, "mixture %" PRIu64 " (%s)", m->seed, m->words);
    stp_chunk_file *file = prep_open_verified_of(path, what);
    mixture_assert_stored(m, file, m->cloud.count - dropped);
    stp_chunk_file_close(&file);
}

/* Whether prep takes the points: no coordinate beyond 10^15, and a box of at least 10^-15 unless
 * all points are at one place. */
static inline bool mixture_within_limits(const mixture *m)
{
    double far = 0.0, side = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < m->cloud.count; i++) {
            const stp_dvec3 p = m->cloud.points[i].position;
            const double value = axis == 0 ? p.x : axis == 1 ? p.y : p.z;
            low = fmin(low, value);
            high = fmax(high, value);
        }
        far = fmax(far, fmax(fabs(low), fabs(high)));
        side = fmax(side, high - low);
    }
    return far <= 1e15 && (side == 0.0 || side >= 1e-15);
}

/* prep, then verify; frees the points. Beyond the limits of numbers prep has to refuse them. */
static inline void mixture_try(mixture *m, const char *path)
{
    stp_prep_stats stats;
    stp_error err = {0};
    const bool within = mixture_within_limits(m);
    const stp_status status = prep_cloud_run(&m->cloud, path, 2, &m->params, &stats, &err);
    if (status != (within ? STP_OK : STP_LIMIT))
        fail_msg("mixture %" PRIu64 " (%s), %s limits: prep: %s", m->seed, m->words,
                 within ? "within" : "beyond", status == STP_OK ? "took it" : err.message);
    if (within)
        mixture_assert_sound(m, path, stats.rejected[STP_REJECT_OUTLIER]);
    free(m->cloud.points);
}

#endif
