/* Sums up one setting at one threshold over all views. */
#include "base/sort.h"
#include "tools/tune/tune_advice.h"
#include "tools/tune/tune_table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

double tune_pooled_psnr(const tune_row *rows, size_t count)
{
    double squares = 0.0, pixels = 0.0;
    for (size_t v = 0; v < count; v++) {
        const compare_metrics *m = &rows[v].compared;
        bool same = m->psnr_db >= COMPARE_PSNR_IDENTICAL;
        pixels += (double)m->either;
        squares += same ? 0.0 : (double)m->either * pow(10.0, -0.1 * m->psnr_db);
    }
    return squares > 0.0 ? 10.0 * log10(pixels / squares) : COMPARE_PSNR_IDENTICAL;
}

double tune_median_ms(const tune_row *rows, size_t count)
{
    double ms[TUNE_VIEWS_LIMIT];
    if (count == 0)
        return 0.0;
    for (size_t v = 0; v < count; v++)
        ms[v] = rows[v].ms;
    stp_sort_doubles(ms, count);
    return count % 2 == 1 ? ms[count / 2] : 0.5 * (ms[count / 2 - 1] + ms[count / 2]);
}

double tune_greatest_bytes(const tune_row *rows, size_t count)
{
    double most = 0.0;
    for (size_t v = 0; v < count; v++)
        most = fmax(most, (double)rows[v].cut.gpu_bytes);
    return most;
}

/* Adds a row to the weighted means. */
static void add_row(tune_summary *sum, const tune_row *row, double weights[3])
{
    double covered = (double)row->compared.either, outline = (double)row->shift.points;
    double normals = (double)row->angles.pixels;
    weights[0] += covered;
    weights[1] += outline;
    weights[2] += normals;
    sum->ssim += covered * row->compared.ssim;
    sum->shift_mean_px += outline * row->shift.mean_px;
    sum->shift_p95_px += outline * row->shift.p95_px;
    sum->angle_mean_deg += normals * row->angles.mean_deg;
    sum->angle_median_deg += normals * row->angles.median_deg;
    sum->angle_p95_deg += normals * row->angles.p95_deg;
    sum->shift_max_px = fmax(sum->shift_max_px, row->shift.max_px);
    sum->holes += (double)row->compared.holes;
    sum->spill += (double)row->compared.spill;
    sum->points += (double)row->cut.points;
    sum->patches += (double)row->cut.patches;
    sum->file_bytes = fmax(sum->file_bytes, (double)row->cut.file_bytes);
    sum->predicted_px = fmax(sum->predicted_px, row->cut.max_error_px);
    sum->measured_px = fmax(sum->measured_px, row->measured_px);
    sum->discs += row->discs;
}

static double share(double value, double of)
{
    return of > 0.0 ? value / of : 0.0;
}

static void add_changes(tune_summary *sum, const tune_point *point, size_t dollies)
{
    tune_change all = {0};
    for (size_t d = 0; d < dollies; d++) {
        const tune_change *c = &point->change[d];
        all.pixels += c->pixels;
        all.squares_a += c->squares_a;
        all.squares_b += c->squares_b;
        all.squares_extra += c->squares_extra;
        all.opened += c->opened;
        all.closed += c->closed;
        all.steps += c->steps;
    }
    sum->change = tune_change_level(&all, all.squares_a);
    sum->change_full = tune_change_level(&all, all.squares_b);
    sum->extra = tune_change_level(&all, all.squares_extra);
    sum->flicker = share((double)(all.opened + all.closed), (double)all.steps);
}

tune_summary tune_summarise(const tune_sweep *sweep, size_t setting, size_t threshold)
{
    const tune_point *point = tune_sweep_point(sweep, setting, threshold);
    size_t views = sweep->params->views->count, ratios = 0;
    tune_summary sum = {.threshold_px = point->threshold_px, .ratios = point->ratios};
    double weights[3] = {0.0}, of_views[TUNE_VIEWS_LIMIT];
    for (size_t v = 0; v < views; v++) {
        const tune_row *row = &point->rows[v];
        add_row(&sum, row, weights);
        if (row->measured_px >= TUNE_ON_SURFACE_PX)
            of_views[ratios++] = row->predicted_px / row->measured_px;
    }
    stp_sort_doubles(of_views, ratios);
    sum.view_ratio = ratios > 0 ? of_views[ratios / 2] : NAN;
    sum.measured_px = sum.discs > 0 ? sum.measured_px : NAN;
    sum.ssim = weights[0] > 0.0 ? sum.ssim / weights[0] : 1.0;
    sum.shift_mean_px = share(sum.shift_mean_px, weights[1]);
    sum.shift_p95_px = share(sum.shift_p95_px, weights[1]);
    sum.angle_mean_deg = share(sum.angle_mean_deg, weights[2]);
    sum.angle_median_deg = share(sum.angle_median_deg, weights[2]);
    sum.angle_p95_deg = share(sum.angle_p95_deg, weights[2]);
    sum.holes /= (double)views;
    sum.spill /= (double)views;
    sum.points /= (double)views;
    sum.patches /= (double)views;
    sum.psnr_db = tune_pooled_psnr(point->rows, views);
    sum.gpu_bytes = tune_greatest_bytes(point->rows, views);
    sum.ms = tune_median_ms(point->rows, views);
    add_changes(&sum, point, sweep->params->views->dolly_count);
    return sum;
}

void tune_advice_of(const tune_sweep *sweep, char out[240])
{
    tune_choice choices[TUNE_THRESHOLDS_LIMIT];
    const size_t count = sweep->params->threshold_count;
    tune_advice advice;
    out[0] = '\0';
    for (size_t t = 0; t < count; t++) {
        const tune_summary s = tune_summarise(sweep, 0, t);
        choices[t] = (tune_choice){s.threshold_px, s.psnr_db, s.points, s.ms};
    }
    if (!tune_advise(choices, count, &advice))
        return;
    tune_advice_words(&advice, choices, out);
    const size_t length = strlen(out);
    if (sweep->params->setting_count > 1)
        snprintf(out + length, 240 - length, " (%s)", sweep->params->settings[0].name);
}

/* ---- at equal points ---- */

static double between(double a, double b, double t)
{
    return a + t * (b - a);
}

bool tune_at_points(const tune_sweep *sweep, size_t setting, double points, tune_summary *out)
{
    for (size_t t = 0; t + 1 < sweep->params->threshold_count; t++) {
        tune_summary a = tune_summarise(sweep, setting, t);
        tune_summary b = tune_summarise(sweep, setting, t + 1);
        if (!(a.points >= points && points >= b.points && b.points > 0.0))
            continue;
        double way = log(a.points / b.points), k = way > 0.0 ? log(a.points / points) / way : 0.0;
        *out = (tune_summary){
            .threshold_px = between(a.threshold_px, b.threshold_px, k),
            .points = points,
            .psnr_db = between(a.psnr_db, b.psnr_db, k),
            .ssim = between(a.ssim, b.ssim, k),
            .angle_mean_deg = between(a.angle_mean_deg, b.angle_mean_deg, k),
            .shift_mean_px = between(a.shift_mean_px, b.shift_mean_px, k),
            .shift_p95_px = between(a.shift_p95_px, b.shift_p95_px, k),
            .holes = between(a.holes, b.holes, k),
            .ms = between(a.ms, b.ms, k),
            .extra = between(a.extra, b.extra, k),
        };
        return true;
    }
    return false;
}
