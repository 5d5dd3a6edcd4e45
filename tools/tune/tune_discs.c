/* Records drawn discs and measures them. */
#include "tools/tune/tune_discs.h"

#include "base/memory.h"
#include "base/random.h"
#include "formats/chunk/measure/patch_bounds.h"
#include "runtime/cut/level_rule.h"

#include <math.h>
#include <stdlib.h>

#define POINTS (TUNE_RIM_POINTS + 1)
/* Number of discs whose points are searched for at once; bounds the memory. */
#define BATCH 20000u

/* ---- what was drawn ---- */

/* A part of a patch that chose its level by itself. */
typedef struct part {
    uint64_t before; /* number of discs in the parts before it */
    uint32_t chunk, patch;
    uint16_t begin, count;
    uint8_t level;
    float predicted_px;
    float scale, sin_alpha, error[2];
} part;

typedef struct parts {
    part *list;
    size_t count, capacity;
    uint64_t discs;
} parts;

/* The errors of a quarter's level, as the rule reads them. */
static void errors_of(const stp_mirror_patch *patch, int level, unsigned quarter, float out[2])
{
    for (int kind = 0; kind < 2; kind++)
        out[kind] = level == 0   ? patch->finest_error[kind]
                    : level == 3 ? patch->vertex_error[kind]
                                 : patch->quarter_error[2 - level][kind][quarter];
}

/* State while one picture is recorded. */
typedef struct noting {
    const stp_inspection *look;
    const stp_model *model;
    tune_cut *cut;
    parts parts;
} noting;

static stp_status note_part(noting *n, const part *found, bool exact, bool disc, stp_error *err)
{
    stp_status status = STP_OK;
    n->cut->points += found->count;
    if (exact) {
        n->cut->exact += found->count;
        return STP_OK;
    }
    n->cut->max_error_px = fmax(n->cut->max_error_px, (double)found->predicted_px);
    if (!disc || found->scale < 0.0f)
        return STP_OK;
    parts *p = &n->parts;
    STP_TRY(stp_grow(&p->list, &p->capacity, p->count + 1, sizeof *p->list, "drawn discs", err));
    p->list[p->count] = *found;
    p->list[p->count++].before = p->discs;
    p->discs += found->count;
done:
    return status;
}

static stp_status note_patch(noting *n, const stp_gpu_chunk *chunk, const stp_resident *resident,
                             uint32_t p, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_mirror_patch *patch = &resident->mirror.patches[p];
    uint32_t first = n->look->looked.scene->blocks[resident->block].first_patch;
    stp_levels levels = stp_levels_choose(n->look->frame, chunk, patch);
    stp_rule_bound bound = stp_patch_bound(&resident->mirror.briefs[p], chunk);
    stp_rule_sight sight = stp_rule_look(n->look->frame, &bound);
    bool leaf = n->model->entries[chunk->id].child_count == 0;
    n->cut->patches++;
    for (unsigned q = 0; q < STP_PATCH_QUARTERS && levels.of[q] != STP_LEVEL_SKIP; q++) {
        int level = levels.of[q];
        unsigned begin = stp_quarter_begin(patch->count, level, q);
        part found = {.chunk = chunk->id,
                      .patch = first + p,
                      .begin = (uint16_t)begin,
                      .count = (uint16_t)(stp_quarter_begin(patch->count, level, q + 1) - begin),
                      .level = (uint8_t)level,
                      .scale = sight.scale,
                      .sin_alpha = sight.sin_alpha};
        errors_of(patch, level, q, found.error);
        found.predicted_px = stp_level_error_px(n->look->frame, chunk, patch, level, (int)q);
        STP_TRY(note_part(n, &found, leaf && level == 0, !(patch->flags & STP_PATCH_SHAPES), err));
    }
done:
    return status;
}

static stp_status note_block(noting *n, const stp_draw *draw, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_block *block = &n->look->looked.scene->blocks[draw->block];
    const stp_block_cache *cache = n->look->cache;
    n->cut->chunks++;
    n->cut->file_bytes += stp_block_payload_bytes(block, draw->finest < 2 ? draw->finest : 2);
    n->cut->gpu_bytes += block->patch_count * (uint64_t)sizeof(stp_gpu_patch);
    for (int l = draw->finest < 2 ? draw->finest : 2; l < STP_LEVEL_COUNT; l++)
        n->cut->gpu_bytes += block->sample_count[l] * (uint64_t)sizeof(stp_sample);
    if (stp_block_cache_finest(cache, draw->block) > draw->finest)
        return STP_OK; /* it was drawn in an earlier pass and is no longer resident */
    const stp_resident *resident =
        stp_block_cache_get(cache, stp_block_cache_slot(cache, draw->block));
    stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(n->look->looked.scene, draw, n->look->eye);
    for (uint32_t p = 0; p < block->patch_count; p++)
        if (stp_patch_in_sight(n->look->sight, &n->look->looked, draw, resident->mirror.briefs, p))
            STP_TRY(note_patch(n, &chunk, resident, p, err));
done:
    return status;
}

/* ---- the sample ---- */

static stp_status add_disc(tune_discs *discs, const part *p, uint32_t sample, tune_disc of,
                           stp_error *err)
{
    stp_status status = stp_grow(&discs->list, &discs->capacity, discs->count + 1,
                                 sizeof *discs->list, "drawn discs", err);
    if (status != STP_OK)
        return status;
    of.chunk = p->chunk;
    of.patch = p->patch;
    of.sample = sample;
    of.level = p->level;
    of.predicted_px = p->predicted_px;
    of.scale = p->scale;
    of.sin_alpha = p->sin_alpha;
    of.error[0] = p->error[0];
    of.error[1] = p->error[1];
    discs->list[discs->count++] = of;
    return STP_OK;
}

/* The part that has the i-th disc. */
static const part *part_of(const parts *p, uint64_t i)
{
    size_t low = 0, high = p->count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        if (p->list[middle].before <= i)
            low = middle;
        else
            high = middle;
    }
    return &p->list[low];
}

static int compare_predictions(const void *a, const void *b)
{
    const part *x = a, *y = b;
    if (x->predicted_px != y->predicted_px)
        return x->predicted_px < y->predicted_px ? 1 : -1;
    return (x->before > y->before) - (x->before < y->before);
}

static stp_status choose(tune_discs *discs, parts *p, tune_disc of, size_t random, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t seed = ((uint64_t)of.picture << 32) + of.view;
    of.random = true;
    for (uint64_t i = 0; i < random && p->discs > 0; i++) {
        /* if there are few discs, take each once; if there are many, some may come twice */
        uint64_t k = p->discs <= random ? i : stp_random_u64(seed, i) % p->discs;
        if (k >= p->discs)
            break;
        const part *found = part_of(p, k);
        STP_TRY(add_disc(discs, found, found->begin + (uint32_t)(k - found->before), of, err));
    }
    if (p->discs <= random)
        return STP_OK;
    qsort(p->list, p->count, sizeof *p->list, compare_predictions);
    of.random = false;
    for (size_t i = 0; i < random / 2 && i < p->count; i++) {
        uint32_t k = (uint32_t)(stp_random_u64(seed, random + i) % p->list[i].count);
        STP_TRY(add_disc(discs, &p->list[i], p->list[i].begin + k, of, err));
    }
done:
    return status;
}

stp_status tune_discs_note(tune_discs *discs, const stp_renderer *renderer, const stp_model *model,
                           uint32_t picture, uint32_t view, size_t random, tune_cut *cut,
                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_inspection look = stp_renderer_inspect(renderer);
    noting n = {.look = &look, .model = model, .cut = cut};
    *cut = (tune_cut){0};
    for (size_t i = 0; i < look.cut->draw_count; i++)
        STP_TRY(note_block(&n, &look.cut->draws[i], err));
    if (discs != NULL)
        STP_TRY(
            choose(discs, &n.parts, (tune_disc){.picture = picture, .view = view}, random, err));
done:
    free(n.parts.list);
    return status;
}

/* ---- measuring ---- */

/* A disc in the world: its size, its points and their nearest surface points. */
typedef struct traced {
    stp_dvec3 normal, centre;
    tune_probe probes[POINTS];
} traced;

static void place_probes(traced *t, const stp_chunk_entry *entry, const stp_patch *patch,
                         const stp_sample *sample, stp_dvec3 eye)
{
    stp_dvec3 u, v;
    double radius = stp_sample_radius(sample, patch);
    t->centre = stp_dvec3_add(entry->origin, stp_sample_position(sample, patch));
    t->normal = sample->flags & STP_SAMPLE_HAS_NORMAL
                    ? stp_dvec3_from_float(stp_normal_decode(sample->normal))
                    : stp_dvec3_sub(eye, t->centre);
    t->normal = stp_dvec3_normalize(t->normal);
    stp_disc_axes(t->normal, &u, &v);
    t->probes[0].at = t->centre;
    for (int i = 0; i < TUNE_RIM_POINTS; i++) {
        double angle = 2.0 * M_PI * i / TUNE_RIM_POINTS;
        stp_dvec3 rim = stp_dvec3_add(stp_dvec3_scale(u, radius * cos(angle)),
                                      stp_dvec3_scale(v, radius * sin(angle)));
        t->probes[i + 1].at = stp_dvec3_add(t->centre, rim);
    }
}

static int compare_chunks(const void *a, const void *b)
{
    const tune_disc *x = a, *y = b;
    if (x->chunk != y->chunk)
        return x->chunk < y->chunk ? -1 : 1;
    return (x->level > y->level) - (x->level < y->level);
}

/* Reads the chunks of the discs, which are sorted by chunk, and places their points. */
static stp_status trace(const tune_nearest_params *p, const tune_disc *discs, size_t count,
                        const stp_view *views, traced *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    for (size_t i = 0; i < count; i++) {
        const tune_disc *d = &discs[i];
        if (chunk == NULL || chunk->id != d->chunk) { /* the finest level comes first */
            stp_chunk_destroy(&chunk);
            STP_TRY(
                stp_chunk_file_read(p->file, d->chunk, d->level < 2 ? d->level : 2, &chunk, err));
        }
        const stp_sample *samples =
            chunk->samples[d->level] + chunk->level_begin[d->level][d->patch];
        place_probes(&out[i], &p->entries[d->chunk], &chunk->patches[d->patch], &samples[d->sample],
                     views[d->view].eye);
    }
done:
    stp_chunk_destroy(&chunk);
    return status;
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

/* Measures the greatest distance of a disc's points from the surface: on the screen, along its
 * normal and across it. */
static void measure(tune_disc *d, const traced *t, const stp_view *view, double along_across[2])
{
    d->measured_px = -1.0;
    along_across[0] = along_across[1] = 0.0;
    for (int i = 0; i < POINTS; i++) {
        double p[2], q[2];
        stp_dvec3 way = stp_dvec3_sub(t->probes[i].at, t->probes[i].nearest);
        double along = stp_dvec3_dot(way, t->normal);
        stp_dvec3 across = stp_dvec3_sub(way, stp_dvec3_scale(t->normal, along));
        if (isinf(t->probes[i].distance) || !project(view, t->probes[i].at, p) ||
            !project(view, t->probes[i].nearest, q))
            continue;
        d->measured_px = fmax(d->measured_px, hypot(p[0] - q[0], p[1] - q[1]));
        along_across[0] = fmax(along_across[0], fabs(along));
        along_across[1] = fmax(along_across[1], stp_dvec3_length(across));
    }
}

static double rule(double scale, double sin_alpha, double error, double tangential)
{
    return (double)stp_rule_error((float)scale, (float)sin_alpha, (float)error, (float)tangential);
}

static double quotient(double a, double b)
{
    return a / fmax(b, 1e-12);
}

/* Replaces each conservative input of the rule by the disc's own value, one after the other. */
static void explain(tune_disc *d, const traced *t, const stp_view *view)
{
    double own[2];
    measure(d, t, view, own);
    stp_dvec3 p = stp_dvec3_sub(t->centre, view->eye);
    double depth = -stp_dvec3_dot(view->back, p), range = stp_dvec3_length(p);
    double scale = view->orthographic ? view->f : view->f * range / (depth * depth);
    stp_dvec3 ray = view->orthographic ? view->back : stp_dvec3_normalize(p);
    double cosine = stp_dvec3_dot(ray, t->normal);
    double sine = sqrt(fmax(0.0, 1.0 - cosine * cosine));
    const double e = (double)d->error[0], et = (double)d->error[1];
    const double steps[TUNE_FACTOR_COUNT + 1] = {
        (double)d->predicted_px,           rule(scale, (double)d->sin_alpha, e, et),
        rule(scale, sine, e, et),          rule(scale, sine, own[0], et),
        rule(scale, sine, own[0], own[1]), d->measured_px};
    for (int k = 0; k < TUNE_FACTOR_COUNT; k++)
        d->factor[k] = quotient(steps[k], steps[k + 1]);
}

static stp_status measure_batch(tune_disc *discs, size_t count, const tune_nearest_params *p,
                                const stp_view *views, stp_error *err)
{
    stp_status status = STP_OK;
    traced *traces = NULL;
    tune_probe *probes = NULL;
    STP_TRY(stp_alloc(&traces, count, sizeof *traces, "drawn discs", err));
    STP_TRY(stp_alloc(&probes, count * POINTS, sizeof *probes, "drawn discs", err));
    STP_TRY(trace(p, discs, count, views, traces, err));
    for (size_t i = 0; i < count * POINTS; i++)
        probes[i] = traces[i / POINTS].probes[i % POINTS];
    STP_TRY(tune_nearest_find(p, probes, count * POINTS, err));
    for (size_t i = 0; i < count; i++) {
        for (size_t k = 0; k < POINTS; k++)
            traces[i].probes[k] = probes[i * POINTS + k];
        explain(&discs[i], &traces[i], &views[discs[i].view]);
    }
done:
    free(traces);
    free(probes);
    return status;
}

stp_status tune_discs_measure(tune_discs *discs, const tune_nearest_params *params,
                              const stp_view *views, stp_error *err)
{
    stp_status status = STP_OK;
    if (discs->count > 0)
        qsort(discs->list, discs->count, sizeof *discs->list, compare_chunks);
    for (size_t begin = 0; begin < discs->count; begin += BATCH) {
        size_t left = discs->count - begin;
        STP_TRY(
            measure_batch(discs->list + begin, left < BATCH ? left : BATCH, params, views, err));
    }
done:
    return status;
}

void tune_discs_clear(tune_discs *discs)
{
    free(discs->list);
    *discs = (tune_discs){0};
}
