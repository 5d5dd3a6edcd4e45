/* Writes figures as text, CSV and JSON. */
#include "tools/tune/tune_table.h"

#include "base/json.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

tune_figure tune_figure_write(double value, int decimals)
{
    tune_figure out;
    if (isnan(value))
        snprintf(out.text, sizeof out.text, "-");
    else
        snprintf(out.text, sizeof out.text, "%.*f", decimals, value);
    return out;
}

tune_figure tune_figure_count(double value)
{
    tune_figure digits = tune_figure_write(value, 0), out = {""};
    size_t length = strlen(digits.text), used = 0;
    for (size_t i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0)
            out.text[used++] = ',';
        out.text[used++] = digits.text[i];
    }
    return out;
}

tune_figure tune_figure_goal(tune_goal_kind kind, double value)
{
    return kind == TUNE_GOAL_BYTES ? tune_figure_count(value) : tune_figure_write(value, 2);
}

/* ---- the legend ---- */

const tune_term tune_legend[TUNE_LEGEND_COUNT] = {
    {"threshold", "greatest error that a picture may have on the screen; 0: every sample is drawn"},
    {"PSNR, SSIM", "likeness to every sample, drawn with more pixels; higher is better"},
    {"normals", "angle between the normals of the picture and those of every sample"},
    {"outline", "distance of outlines from those of every sample"},
    {"holes", "covered pixels that are missing"},
    {"points", "samples that are drawn"},
    {"ms", "time that a picture takes"},
    {"GPU MiB", "memory that the samples of a view take on the GPU"},
    {"predicted", "error on the screen by the level rule; never above the threshold"},
    {"measured", "how far drawn discs really lie from the surface on the screen"},
    {"ratio", "predicted / measured; the nearer to 1, the less is drawn in vain"},
    {"popping",
     "what changes from frame to frame beyond the change of every sample; of 255 levels"},
    {"spill", "pixels that are covered, but not in the reference"},
    {"patches", "groups of up to 64 samples that are drawn"},
    {"file MiB", "size of what a view reads of the model's file"},
    {"flicker", "holes that open or close from frame to frame"},
};

const char tune_legend_zero[] =
    "Why 0 px may score below 0.5 px: of several samples in one pixel, only the nearest is seen.\n"
    "A coarser sample is their mean, and so is a pixel of what pictures are judged against.";

bool tune_is_default(const tune_sweep *sweep, size_t setting, double threshold_px)
{
    return threshold_px == sweep->params->settings[setting].params.threshold_px;
}

/* ---- stdout ---- */

static void print_legend(FILE *out)
{
    fprintf(out, "\n");
    for (size_t i = 0; i < TUNE_LEGEND_PRINTED; i++)
        fprintf(out, "%-10s  %s\n", tune_legend[i].name, tune_legend[i].meaning);
    fprintf(out, "\n%s\n", tune_legend_zero);
}

static void print_answer(const tune_answer *answer, FILE *out)
{
    if (answer->kind == TUNE_GOAL_NONE)
        return;
    fprintf(out, "\nthreshold %.4g px: %s %s, asked for %s (%u thresholds measured besides)\n",
            answer->found.threshold_px, tune_goal_word(answer->kind),
            tune_figure_goal(answer->kind, answer->found.value).text,
            tune_figure_goal(answer->kind, answer->target).text, answer->found.measured);
}

static void print_equal(const tune_sweep *sweep, FILE *out)
{
    const tune_sweep_params *p = sweep->params;
    if (p->setting_count < 2)
        return;
    fprintf(out, "\nat equal points        setting  threshold   PSNR     SSIM  normals  outline"
                 "       ms\n");
    for (size_t t = 0; t < p->threshold_count; t++) {
        double points = tune_summarise(sweep, 0, t).points;
        for (size_t k = 0; k < p->setting_count; k++) {
            tune_summary s;
            if (!tune_at_points(sweep, k, points, &s))
                continue;
            fprintf(out, "%15s %14s %10.4g %6.2f %8.4f %8.3f %8.3f %8.1f\n",
                    tune_figure_count(points).text, p->settings[k].name, s.threshold_px, s.psnr_db,
                    s.ssim, s.angle_mean_deg, s.shift_mean_px, s.ms);
        }
    }
}

void tune_table_print(const tune_sweep *sweep, const tune_answer *answer, FILE *out)
{
    const tune_sweep_params *p = sweep->params;
    for (size_t k = 0; k < p->setting_count; k++) {
        if (p->setting_count > 1)
            fprintf(out, "%s%s\n", k > 0 ? "\n" : "", p->settings[k].name);
        fprintf(out,
                "threshold   PSNR    SSIM normals outline   holes      points       ms  GPU MiB"
                " predicted measured  ratio  popping\n");
        fprintf(out,
                "       px     dB             deg      px  a view      a view  a frame     most"
                "   most px  most px median   levels\n");
        for (size_t t = 0; t < p->threshold_count; t++) {
            tune_summary s = tune_summarise(sweep, k, t);
            fprintf(out,
                    "%9.4g %6.2f %7.4f %7.3f %7.3f %7.1f %11s %8.1f %8.1f %9.3f %8s %6s "
                    "%8.2f%s\n",
                    s.threshold_px, s.psnr_db, s.ssim, s.angle_mean_deg, s.shift_mean_px, s.holes,
                    tune_figure_count(s.points).text, s.ms, s.gpu_bytes / 1048576.0, s.predicted_px,
                    tune_figure_write(s.measured_px, 3).text,
                    tune_figure_write(s.ratios.median, 2).text, s.extra,
                    tune_is_default(sweep, k, s.threshold_px) ? "  default" : "");
        }
    }
    print_equal(sweep, out);
    print_legend(out);
    char advice[240];
    tune_advice_of(sweep, advice);
    if (advice[0] != '\0')
        fprintf(out, "\n%s\n", advice);
    print_answer(answer, out);
}

/* ---- CSV ---- */

static const char csv_head[] =
    "setting,threshold_px,view,name,psnr_db,psnr_inside_db,ssim,coverage,coverage_reference,holes,"
    "spill,outline_mean_px,outline_p95_px,outline_max_px,normal_mean_deg,normal_median_deg,"
    "normal_p95_deg,points,exact_points,patches,chunks,file_bytes,gpu_bytes,ms,passes,max_error_px,"
    "discs_measured,predicted_px,measured_px\n";

static stp_status write_row(const tune_sweep *s, const tune_setting *setting, double threshold_px,
                            size_t v, const tune_row *r, stp_output *out, stp_error *err)
{
    char text[1024], measured[64] = ","; /* empty fields if there are no discs */
    const compare_metrics *m = &r->compared;
    const tune_cut *c = &r->cut;
    if (r->discs > 0)
        snprintf(measured, sizeof measured, "%.6f,%.6f", r->predicted_px, r->measured_px);
    int length = snprintf(
        text, sizeof text,
        "%s,%.9g,%zu,%s,%.4f,%.4f,%.6f,%.6f,%.6f,%" PRIu64 ",%" PRIu64 ",%.4f,%.4f,%.4f,%.4f,%.4f,"
        "%.4f,%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%" PRIu64 ",%.3f,%" PRIu32
        ",%.6f,%" PRIu64 ",%s\n",
        setting->name, threshold_px, v, s->params->views->list[v].name, m->psnr_db,
        m->psnr_inside_db, m->ssim, m->coverage_a, m->coverage_b, m->holes, m->spill,
        r->shift.mean_px, r->shift.p95_px, r->shift.max_px, r->angles.mean_deg,
        r->angles.median_deg, r->angles.p95_deg, c->points, c->exact, c->patches, c->chunks,
        c->file_bytes, c->gpu_bytes, r->ms, r->passes, c->max_error_px, r->discs, measured);
    return stp_output_write(out, text, (size_t)length, err);
}

stp_status tune_csv_write(const tune_sweep *sweep, stp_output *out, stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = sweep->params;
    STP_TRY(stp_output_write(out, csv_head, sizeof csv_head - 1, err));
    for (size_t k = 0; k < p->setting_count; k++)
        for (size_t t = 0; t < p->threshold_count; t++) {
            const tune_point *point = tune_sweep_point(sweep, k, t);
            for (size_t v = 0; v < p->views->count; v++)
                STP_TRY(write_row(sweep, &p->settings[k], point->threshold_px, v, &point->rows[v],
                                  out, err));
        }
done:
    return status;
}

/* ---- JSON ---- */

typedef struct named {
    const char *name;
    double value;
} named;

/* Adds a number; NaN becomes null. */
static void add_figure(cJSON *json, const char *name, double value)
{
    if (isnan(value))
        cJSON_AddNullToObject(json, name);
    else
        stp_json_add_number(json, name, value);
}

static void add_all(cJSON *json, const named *list, size_t count)
{
    for (size_t i = 0; i < count; i++)
        add_figure(json, list[i].name, list[i].value);
}

static cJSON *summary_json(const tune_summary *s)
{
    static const char *const factors[TUNE_FACTOR_COUNT] = {TUNE_FACTOR_NAMES};
    const named list[] = {
        {"threshold_px", s->threshold_px},
        {"psnr_db", s->psnr_db},
        {"ssim", s->ssim},
        {"normal_mean_deg", s->angle_mean_deg},
        {"normal_median_deg", s->angle_median_deg},
        {"normal_p95_deg", s->angle_p95_deg},
        {"outline_mean_px", s->shift_mean_px},
        {"outline_p95_px", s->shift_p95_px},
        {"outline_max_px", s->shift_max_px},
        {"holes", s->holes},
        {"spill", s->spill},
        {"points", s->points},
        {"patches", s->patches},
        {"file_bytes", s->file_bytes},
        {"gpu_bytes", s->gpu_bytes},
        {"ms", s->ms},
        {"predicted_px", s->predicted_px},
        {"measured_px", s->measured_px},
        {"discs_measured", (double)s->discs},
        {"discs_beyond_threshold", (double)s->ratios.broken},
        {"frame_change", s->change},
        {"frame_change_full", s->change_full},
        {"frame_change_extra", s->extra},
        {"holes_flicker", s->flicker},
    };
    cJSON *json = cJSON_CreateObject();
    add_all(json, list, sizeof list / sizeof *list);
    cJSON *ratio = cJSON_AddObjectToObject(json, "predicted_over_measured");
    const named of_ratio[] = {{"discs", (double)s->ratios.discs},
                              {"p10", s->ratios.p10},
                              {"median", s->ratios.median},
                              {"p90", s->ratios.p90},
                              {"view_median", s->view_ratio}};
    add_all(ratio, of_ratio, sizeof of_ratio / sizeof *of_ratio);
    cJSON *because = cJSON_AddObjectToObject(ratio, "factors");
    for (int k = 0; k < TUNE_FACTOR_COUNT; k++)
        add_figure(because, factors[k], s->ratios.factor[k]);
    return json;
}

static void add_views(cJSON *json, const tune_views *views)
{
    cJSON *list = cJSON_AddArrayToObject(json, "views");
    for (size_t v = 0; v < views->count; v++) {
        cJSON *view = cJSON_CreateObject();
        cJSON_AddStringToObject(view, "name", views->list[v].name);
        stp_json_add_vector(view, "eye", views->list[v].camera.eye);
        stp_json_add_vector(view, "look", views->list[v].camera.look);
        stp_json_add_vector(view, "up", views->list[v].camera.up);
        if (views->list[v].camera.height > 0.0)
            stp_json_add_number(view, "height", views->list[v].camera.height);
        else
            stp_json_add_number(view, "fovy_deg", views->list[v].camera.fovy_deg);
        cJSON_AddItemToArray(list, view);
    }
}

static void add_equal(cJSON *json, const tune_sweep *sweep)
{
    const tune_sweep_params *p = sweep->params;
    cJSON *list = cJSON_AddArrayToObject(json, "equal_points");
    for (size_t t = 0; t < p->threshold_count; t++) {
        cJSON *at = cJSON_CreateObject();
        double points = tune_summarise(sweep, 0, t).points;
        stp_json_add_number(at, "points", points);
        for (size_t k = 0; k < p->setting_count; k++) {
            tune_summary s;
            if (!tune_at_points(sweep, k, points, &s))
                continue;
            const named figures[] = {{"threshold_px", s.threshold_px},
                                     {"psnr_db", s.psnr_db},
                                     {"ssim", s.ssim},
                                     {"normal_mean_deg", s.angle_mean_deg},
                                     {"outline_mean_px", s.shift_mean_px},
                                     {"outline_p95_px", s.shift_p95_px},
                                     {"holes", s.holes},
                                     {"ms", s.ms},
                                     {"frame_change_extra", s.extra}};
            cJSON *one = cJSON_AddObjectToObject(at, p->settings[k].name);
            add_all(one, figures, sizeof figures / sizeof *figures);
        }
        cJSON_AddItemToArray(list, at);
    }
}

cJSON *tune_json(const tune_sweep *sweep, const tune_answer *answer, const char *path,
                 const char *gl_renderer)
{
    const tune_sweep_params *p = sweep->params;
    const int size[2] = {p->views->views[0].width, p->views->views[0].height};
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "model", path);
    cJSON_AddStringToObject(json, "gl_renderer", gl_renderer);
    cJSON_AddItemToObject(json, "size", cJSON_CreateIntArray(size, 2));
    stp_json_add_number(json, "reference_pixels", (double)(p->times * p->times));
    stp_json_add_number(json, "repeat", (double)p->repeat);
    cJSON *settings = cJSON_AddArrayToObject(json, "settings");
    for (size_t k = 0; k < p->setting_count; k++) {
        cJSON *setting = cJSON_CreateObject();
        cJSON_AddStringToObject(setting, "name", p->settings[k].name);
        cJSON *list = cJSON_AddArrayToObject(setting, "thresholds");
        for (size_t t = 0; t < p->threshold_count; t++) {
            tune_summary s = tune_summarise(sweep, k, t);
            cJSON_AddItemToArray(list, summary_json(&s));
        }
        cJSON_AddItemToArray(settings, setting);
    }
    if (p->setting_count > 1)
        add_equal(json, sweep);
    if (answer->kind != TUNE_GOAL_NONE) {
        cJSON *solved = cJSON_AddObjectToObject(json, "solved");
        cJSON_AddStringToObject(solved, "for", tune_goal_word(answer->kind));
        const named figures[] = {{"target", answer->target},
                                 {"value", answer->found.value},
                                 {"threshold_px", answer->found.threshold_px}};
        add_all(solved, figures, sizeof figures / sizeof *figures);
    }
    add_views(json, p->views);
    return json;
}
