/* Runs the sweep: view by view all settings and thresholds in turns, then the dollies, then the
 * discs. */
#include "tools/tune/tune_sweep.h"

#include "base/memory.h"
#include "base/sort.h"
#include "tools/draw/draw_fine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define REFERENCES_LIMIT_BYTES (UINT64_C(1) << 30)

static size_t pixels_of(const tune_sweep *s)
{
    const stp_view *view = &s->params->views->views[0];
    return (size_t)view->width * (size_t)view->height;
}

static size_t point_count(const tune_sweep *s)
{
    return s->params->setting_count * s->params->threshold_count;
}

tune_point *tune_sweep_point(const tune_sweep *s, size_t setting, size_t threshold)
{
    return &s->points[setting * s->params->threshold_count + threshold];
}

static stp_image image_of(const tune_sweep *s, uint8_t *rgba)
{
    const stp_view *view = &s->params->views->views[0];
    return (stp_image){view->width, view->height, rgba};
}

static stp_status step(tune_sweep *s, stp_error *err)
{
    return stp_progress_update(s->params->progress, "pictures", s->done++, s->total, err);
}

/* ---- pictures ---- */

static stp_draw_params at_threshold(const tune_setting *setting, double threshold_px)
{
    stp_draw_params params = setting->params;
    params.threshold_px = threshold_px;
    params.every_sample = threshold_px <= 0.0;
    return params;
}

static stp_draw_params full_params(const tune_sweep *s)
{
    stp_draw_params params = s->params->settings[0].params;
    params.lod = STP_LOD_FULL;
    return params;
}

/* Draws a picture as --aa asks: bottom row first, straight alpha. whole: the renderer's own last
 * picture must be the whole view. */
static stp_status draw(tune_sweep *s, const stp_view *view, const stp_draw_params *params,
                       bool whole, uint8_t *rgba, stp_draw_stats *stats, stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw_stats own;
    STP_TRY(step(s, err));
    STP_TRY(draw_picture_draw(&s->picture, s->params->renderer, view, params, whole, &own, err));
    if (stats != NULL)
        *stats = own;
    if (rgba == NULL)
        return STP_OK;
    if (s->picture.fine != NULL)
        memcpy(rgba, s->picture.fine, 4 * pixels_of(s));
    else
        STP_TRY(stp_renderer_read(s->params->renderer, rgba, err));
    stp_image image = image_of(s, rgba);
    draw_straighten(&image);
done:
    return status;
}

/* Keeps a picture for the page, if its view and threshold are shown. */
static stp_status keep_shot(tune_sweep *s, size_t view, size_t picture, const uint8_t *rgba,
                            stp_error *err)
{
    const tune_sweep_params *p = s->params;
    size_t row = 4 * (size_t)p->views->views[0].width, height = pixels_of(s) * 4 / row;
    bool shown = picture == TUNE_REFERENCE;
    for (size_t i = 0; i < p->shown_count; i++)
        shown |= p->shown[i] == picture; /* only pictures of the first setting */
    if (!shown || view >= TUNE_SHOT_VIEWS || s->shot_count == TUNE_SHOTS_LIMIT)
        return STP_OK;
    tune_shot *shot = &s->shots[s->shot_count];
    *shot = (tune_shot){view, picture, image_of(s, NULL)};
    stp_status status = stp_alloc(&shot->image.rgba, pixels_of(s), 4, "a picture", err);
    if (status != STP_OK)
        return status;
    for (size_t y = 0; y < height; y++)
        memcpy(shot->image.rgba + y * row, rgba + (height - 1 - y) * row, row);
    s->shot_count++;
    return STP_OK;
}

/* Draws the reference, the mean of finer pictures of every sample, and keeps it. */
static stp_status draw_reference(tune_sweep *s, size_t v, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = s->params;
    stp_draw_params params = full_params(s);
    stp_draw_stats stats;
    params.smooth_edges = false;
    STP_TRY(step(s, err));
    STP_TRY(stp_alloc(&s->references[v], pixels_of(s), 4, "a reference", err));
    STP_TRY(draw_fine(p->renderer, &p->views->views[v], &params, p->times, s->references[v], &stats,
                      err));
    stp_image image = image_of(s, s->references[v]);
    draw_straighten(&image);
    STP_TRY(keep_shot(s, v, TUNE_REFERENCE, s->references[v], err));
done:
    return status;
}

static stp_status draw_full_normals(tune_sweep *s, size_t v, stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw_params params = full_params(s);
    params.keep_pixels = true;
    STP_TRY(step(s, err));
    STP_TRY(
        stp_renderer_draw(s->params->renderer, &s->params->views->views[v], &params, NULL, err));
    STP_TRY(stp_renderer_read_normals(s->params->renderer, s->full_normals, err));
done:
    return status;
}

/* ---- one picture ---- */

/* Compares a picture with the reference. Pictures without any covered pixel count as equal. */
static stp_status compare(tune_sweep *s, size_t v, uint8_t *rgba, compare_metrics *out,
                          stp_error *err)
{
    stp_image judged = image_of(s, rgba), reference = image_of(s, s->references[v]);
    stp_error own;
    stp_status status = compare_metrics_compute(&judged, &reference, out, &own);
    if (status == STP_EMPTY) {
        *out = (compare_metrics){.psnr_db = COMPARE_PSNR_IDENTICAL,
                                 .psnr_inside_db = COMPARE_PSNR_IDENTICAL,
                                 .ssim = 1.0};
        return STP_OK;
    }
    if (status != STP_OK)
        return stp_error_set(err, status, "%s", own.message);
    return STP_OK;
}

static stp_status judge(tune_sweep *s, size_t v, size_t number, const tune_setting *setting,
                        stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = s->params;
    tune_point *point = &s->points[number];
    tune_row *row = &point->rows[v];
    stp_draw_params params = at_threshold(setting, point->threshold_px);
    stp_draw_stats stats;
    params.keep_pixels = true;
    STP_TRY(draw(s, &p->views->views[v], &params, true, s->rgba, &stats, err));
    row->passes = stats.passes;
    STP_TRY(stp_renderer_read_normals(p->renderer, s->normals, err));
    STP_TRY(tune_discs_note(point->threshold_px > 0.0 ? &s->discs : NULL, p->renderer, p->model,
                            (uint32_t)number, (uint32_t)v, p->discs, &row->cut, err));
    if (stats.passes > 1 &&
        p->aa <= DRAW_AA_EDGES) /* chunks of earlier passes are no longer resident */
        row->cut.points = stats.points_drawn;
    STP_TRY(compare(s, v, s->rgba, &row->compared, err));
    stp_image judged = image_of(s, s->rgba), reference = image_of(s, s->references[v]);
    STP_TRY(tune_shift_compute(&judged, &reference, &row->shift, err));
    STP_TRY(tune_angles_compute(s->normals, s->full_normals, pixels_of(s), &row->angles, err));
    STP_TRY(keep_shot(s, v, number, s->rgba, err));
done:
    return status;
}

static stp_status time_one(tune_sweep *s, size_t v, const tune_setting *setting,
                           double threshold_px, double *ms, stp_error *err)
{
    stp_draw_params params = at_threshold(setting, threshold_px);
    stp_draw_stats stats;
    stp_status status = draw(s, &s->params->views->views[v], &params, false, NULL, &stats, err);
    if (status == STP_OK)
        *ms = stats.frame_ms;
    return status;
}

static double median_of(double *values, size_t count)
{
    stp_sort_doubles(values, count);
    return count == 0       ? 0.0
           : count % 2 == 1 ? values[count / 2]
                            : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

/* Measures all settings and thresholds in turns, so that disturbances of the machine fall on all of
 * them. */
static stp_status measure_view(tune_sweep *s, size_t v, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = s->params;
    double unused;
    STP_TRY(draw_reference(s, v, err));
    STP_TRY(draw_full_normals(s, v, err));
    for (uint64_t r = 0; r <= p->repeat; r++)
        for (size_t k = 0; k < p->setting_count; k++) {
            const tune_setting *setting = &p->settings[k];
            if (r > 0 && p->setting_count > 1) /* an uncounted frame, because programs are compiled
                                                  again for this setting */
                STP_TRY(time_one(s, v, setting, p->thresholds[0], &unused, err));
            for (size_t t = 0; t < p->threshold_count; t++) {
                size_t number = k * p->threshold_count + t;
                if (r == 0)
                    STP_TRY(judge(s, v, number, setting, err));
                else
                    STP_TRY(time_one(s, v, setting, p->thresholds[t],
                                     &s->times[number * p->repeat + r - 1], err));
            }
        }
    for (size_t i = 0; i < point_count(s); i++)
        s->points[i].rows[v].ms = median_of(s->times + i * p->repeat, p->repeat);
done:
    return status;
}

/* ---- dollies ---- */

static stp_status film_point(tune_sweep *s, size_t d, tune_point *point,
                             const tune_setting *setting, stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw_params params = at_threshold(setting, point->threshold_px);
    for (int i = 0; i < TUNE_DOLLY_FRAMES; i++) {
        stp_image now = image_of(s, s->judged[i % 2]), last = image_of(s, s->judged[1 - i % 2]);
        if (params.every_sample &&
            setting == s->params->settings) { /* the film itself is of every sample */
            STP_TRY(step(s, err));
            memcpy(now.rgba, s->film[i], 4 * pixels_of(s));
        } else {
            STP_TRY(draw(s, &s->params->views->dollies[d][i], &params, true, now.rgba, NULL, err));
        }
        if (i == 0)
            continue;
        stp_image full_last = image_of(s, s->film[i - 1]), full_now = image_of(s, s->film[i]);
        tune_change_add(&point->change[d], &last, &now, &full_last, &full_now);
    }
done:
    return status;
}

static stp_status film_dolly(tune_sweep *s, size_t d, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = s->params;
    stp_draw_params full = full_params(s);
    for (int i = 0; i < TUNE_DOLLY_FRAMES; i++)
        STP_TRY(draw(s, &p->views->dollies[d][i], &full, true, s->film[i], NULL, err));
    for (size_t i = 0; i < point_count(s); i++)
        STP_TRY(film_point(s, d, &s->points[i], &p->settings[i / p->threshold_count], err));
done:
    return status;
}

/* ---- discs ---- */

static void note_measured(tune_sweep *s, const tune_disc *disc)
{
    tune_point *point = &s->points[disc->picture];
    tune_row *row = &point->rows[disc->view];
    if (disc->measured_px < 0.0)
        return;
    row->discs++;
    row->predicted_px = fmax(row->predicted_px, (double)disc->predicted_px);
    row->measured_px = fmax(row->measured_px, disc->measured_px);
    point->ratios.broken += disc->measured_px > point->threshold_px;
}

/* Quantiles of one quotient over the random discs of a point; NaN if there are none. k: a factor,
 * or the whole quotient. */
static void find_quantiles(tune_sweep *s, size_t number, int k, double *values, double out[3])
{
    static const double shares[3] = {0.1, 0.5, 0.9};
    size_t count = 0;
    for (size_t i = 0; i < s->discs.count; i++) {
        const tune_disc *disc = &s->discs.list[i];
        if (disc->picture != number || !disc->random || disc->measured_px < TUNE_ON_SURFACE_PX)
            continue;
        double whole = (double)disc->predicted_px / disc->measured_px;
        values[count++] = fmin(k < TUNE_FACTOR_COUNT ? disc->factor[k] : whole, 1e6);
    }
    stp_sort_doubles(values, count);
    for (int i = 0; i < 3; i++)
        out[i] = count > 0 ? values[(size_t)(shares[i] * (double)(count - 1) + 0.5)] : NAN;
    s->points[number].ratios.discs = count;
}

static stp_status measure_discs(tune_sweep *s, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = s->params;
    double *values = NULL, q[3];
    tune_nearest_params nearest = {.file = p->model->file,
                                   .entries = p->model->entries,
                                   .chunk_count = p->model->info->chunk_count,
                                   .pool = p->pool,
                                   .progress = p->progress};
    STP_TRY(tune_discs_measure(&s->discs, &nearest, p->views->views, err));
    STP_TRY(stp_alloc(&values, s->discs.count, sizeof *values, "drawn discs", err));
    for (size_t i = 0; i < s->discs.count; i++)
        note_measured(s, &s->discs.list[i]);
    for (size_t i = 0; i < point_count(s); i++) {
        tune_ratios *ratios = &s->points[i].ratios;
        for (int k = 0; k < TUNE_FACTOR_COUNT; k++) {
            find_quantiles(s, i, k, values, q);
            ratios->factor[k] = q[1];
        }
        find_quantiles(s, i, TUNE_FACTOR_COUNT, values, q);
        ratios->p10 = q[0];
        ratios->median = q[1];
        ratios->p90 = q[2];
    }
done:
    free(values);
    return status;
}

/* ---- all of it ---- */

static stp_status allot(tune_sweep *s, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = s->params;
    size_t pixels = pixels_of(s), views = p->views->count;
    if (views * pixels * 4 > REFERENCES_LIMIT_BYTES)
        return stp_error_set(err, STP_LIMIT,
                             "the references of %zu views are more than 1 GiB: give a smaller "
                             "--size or fewer --views",
                             views);
    STP_TRY(stp_alloc(&s->points, point_count(s), sizeof *s->points, "a sweep", err));
    for (size_t i = 0; i < point_count(s); i++) {
        s->points[i].threshold_px = p->thresholds[i % p->threshold_count];
        STP_TRY(stp_alloc(&s->points[i].rows, views, sizeof *s->points[i].rows, "a sweep", err));
    }
    STP_TRY(stp_alloc(&s->references, views, sizeof *s->references, "references", err));
    STP_TRY(stp_alloc(&s->times, point_count(s) * p->repeat, sizeof *s->times, "times", err));
    STP_TRY(stp_alloc(&s->rgba, pixels, 4, "a picture", err));
    STP_TRY(stp_alloc(&s->normals, pixels, 3 * sizeof *s->normals, "normals", err));
    STP_TRY(stp_alloc(&s->full_normals, pixels, 3 * sizeof *s->normals, "normals", err));
    for (int i = 0; i < TUNE_DOLLY_FRAMES; i++)
        STP_TRY(stp_alloc(&s->film[i], pixels, 4, "a picture", err));
    for (int i = 0; i < 2; i++)
        STP_TRY(stp_alloc(&s->judged[i], pixels, 4, "a picture", err));
done:
    return status;
}

stp_status tune_sweep_run(tune_sweep *s, const tune_sweep_params *p, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t settings = p->setting_count, points = settings * p->threshold_count;
    *s = (tune_sweep){.params = p, .picture = {.aa = p->aa}};
    uint64_t again = settings > 1 ? settings * p->repeat : 0;
    s->total = p->views->count * (2 + points * (1 + p->repeat) + again) +
               p->views->dolly_count * TUNE_DOLLY_FRAMES * (1 + points);
    STP_TRY(allot(s, err));
    for (size_t v = 0; v < p->views->count; v++)
        STP_TRY(measure_view(s, v, err));
    for (size_t d = 0; d < p->views->dolly_count; d++)
        STP_TRY(film_dolly(s, d, err));
    STP_TRY(measure_discs(s, err));
done:
    return status;
}

/* Measures one view at a threshold outside the sweep. */
static stp_status probe_one(tune_sweep *s, size_t v, double threshold_px, bool compares,
                            tune_row *row, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = s->params;
    stp_draw_params params = at_threshold(&p->settings[0], threshold_px);
    *row = (tune_row){0};
    STP_TRY(draw(s, &p->views->views[v], &params, true, s->rgba, NULL, err));
    STP_TRY(tune_discs_note(NULL, p->renderer, p->model, 0, (uint32_t)v, 0, &row->cut, err));
    if (compares)
        STP_TRY(compare(s, v, s->rgba, &row->compared, err));
done:
    return status;
}

stp_status tune_sweep_probe(tune_sweep *s, const double *thresholds, size_t count, bool compares,
                            uint64_t repeat, tune_row *rows, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = s->params;
    const tune_setting *setting = &p->settings[0];
    double *times = NULL;
    s->done = 0;
    s->total = p->views->count * count * (1 + repeat);
    STP_TRY(stp_alloc(&times, count * repeat, sizeof *times, "times", err));
    for (size_t v = 0; v < p->views->count; v++) {
        for (uint64_t r = 0; r <= repeat; r++)
            for (size_t t = 0; t < count; t++)
                STP_TRY(r == 0 ? probe_one(s, v, thresholds[t], compares,
                                           &rows[t * p->views->count + v], err)
                               : time_one(s, v, setting, thresholds[t], &times[t * repeat + r - 1],
                                          err));
        for (size_t t = 0; t < count; t++)
            rows[t * p->views->count + v].ms = median_of(times + t * repeat, repeat);
    }
done:
    free(times);
    return status;
}

void tune_sweep_clear(tune_sweep *s)
{
    for (size_t i = 0; s->points != NULL && i < point_count(s); i++)
        free(s->points[i].rows);
    for (size_t v = 0; s->references != NULL && v < s->params->views->count; v++)
        free(s->references[v]);
    for (size_t i = 0; i < s->shot_count; i++)
        stp_image_destroy(&s->shots[i].image);
    for (int i = 0; i < TUNE_DOLLY_FRAMES; i++)
        free(s->film[i]);
    free(s->judged[0]);
    free(s->judged[1]);
    free(s->points);
    free(s->references);
    free(s->times);
    free(s->rgba);
    free(s->normals);
    free(s->full_normals);
    free(s->picture.fine);
    tune_discs_clear(&s->discs);
    *s = (tune_sweep){0};
}
