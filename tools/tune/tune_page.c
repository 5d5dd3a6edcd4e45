/* Writes the report's page: one HTML file that contains its charts and pictures. */
#include "base/file.h"
#include "base/memory.h"
#include "tools/tune/tune_report.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Factor that brightens differences. */
#define DIFFERENCE_TIMES 4

static const char head[] =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n"
    "<title>stipple tune</title>\n<style>\n"
    "body{font:16px/1.5 system-ui,sans-serif;max-width:76rem;margin:2rem auto;padding:0 1rem;"
    "color:#222;background:#fff}\n"
    "h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2.5rem}\n"
    "table{border-collapse:collapse;font-size:.85rem;font-variant-numeric:tabular-nums}\n"
    "th,td{padding:.2rem .55rem;text-align:right;border-bottom:1px solid #ddd}\n"
    "th{font-weight:600;vertical-align:bottom}.wide{overflow-x:auto}\n"
    ".charts{display:flex;flex-wrap:wrap;gap:1rem}.charts svg{max-width:100%;height:auto}\n"
    ".grid{display:flex;flex-wrap:wrap;gap:.7rem}figure{margin:0;width:15rem}\n"
    "figure img,.pair img{background:#888;display:block;width:100%}\n"
    "figcaption{font-size:.85rem}\n"
    ".pair{position:relative;max-width:36rem;margin:.5rem 0}\n"
    ".pair img+img{position:absolute;top:0;left:0;clip-path:inset(0 0 0 var(--cut,50%))}\n"
    "input[type=range]{width:100%;max-width:36rem;display:block}\n"
    "</style>\n</head>\n<body>\n";

/* Compares pictures. Without this script the pictures still stand side by side. */
static const char script[] =
    "<script>\n"
    "document.querySelectorAll('section.view').forEach(function(s){\n"
    "  var pair=s.querySelector('.pair'),images=pair.querySelectorAll('img');\n"
    "  var range=s.querySelector('input'),list=s.querySelector('select');\n"
    "  var shots=s.querySelectorAll('figure img');\n"
    "  function show(){images[0].src=shots[0].src;images[1].src=shots[+list.value].src;\n"
    "    pair.style.setProperty('--cut',range.value+'%');}\n"
    "  range.oninput=list.onchange=show;s.querySelector('.look').hidden=false;show();\n"
    "});\n</script>\n";

/* ---- pictures ---- */

static void add_base64(chart_text *out, const uint8_t *bytes, size_t count)
{
    static const char letters[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char line[257];
    size_t used = 0;
    for (size_t i = 0; i < count; i += 3) {
        uint32_t word = (uint32_t)bytes[i] << 16;
        word |= i + 1 < count ? (uint32_t)bytes[i + 1] << 8 : 0u;
        word |= i + 2 < count ? (uint32_t)bytes[i + 2] : 0u;
        for (int k = 0; k < 4; k++)
            line[used++] = letters[word >> (18 - 6 * k) & 63];
        if (i + 1 >= count)
            line[used - 2] = '=';
        if (i + 2 >= count)
            line[used - 1] = '=';
        if (used == 256 || i + 3 >= count) {
            line[used] = '\0';
            chart_text_add(out, "%s", line);
            used = 0;
        }
    }
}

/* Adds a picture as PNG. It goes through a file, because pictures can only be written to files. */
static stp_status add_picture(tune_folder *folder, const stp_image *image, const char *caption,
                              chart_text *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    size_t size = 0;
    const char *path = tune_folder_file(folder, "picture.png");
    STP_TRY(stp_image_save(image, path, true, err));
    STP_TRY(stp_file_load(path, &bytes, &size, err));
    chart_text_add(out, "<figure><img alt=\"%s\" src=\"data:image/png;base64,", caption);
    add_base64(out, bytes, size);
    chart_text_add(out, "\"/><figcaption>%s</figcaption></figure>\n", caption);
done:
    if (unlink(path) != 0 && status == STP_OK) /* else it would stay in the report */
        status = stp_error_set(err, STP_IO, "%s: cannot be removed: %s", path, strerror(errno));
    free(bytes);
    return status;
}

static int over_black(const uint8_t *p, int component)
{
    return (p[component] * p[3] + 127) / 255;
}

static stp_status difference(const stp_image *a, const stp_image *b, stp_image *out, stp_error *err)
{
    size_t pixels = (size_t)a->width * (size_t)a->height;
    *out = (stp_image){a->width, a->height, NULL};
    stp_status status = stp_alloc(&out->rgba, pixels, 4, "a picture", err);
    for (size_t i = 0; status == STP_OK && i < pixels; i++) {
        for (int k = 0; k < 3; k++) {
            int d = abs(over_black(a->rgba + 4 * i, k) - over_black(b->rgba + 4 * i, k));
            d *= DIFFERENCE_TIMES;
            out->rgba[4 * i + (size_t)k] = (uint8_t)(d < 255 ? d : 255);
        }
        out->rgba[4 * i + 3] = 255;
    }
    return status;
}

static const tune_shot *shot_of(const tune_sweep *sweep, size_t view, size_t picture)
{
    for (size_t i = 0; i < sweep->shot_count; i++)
        if (sweep->shots[i].view == view && sweep->shots[i].picture == picture)
            return &sweep->shots[i];
    return NULL;
}

/* Adds the reference, then the shown thresholds, then their differences from the reference. */
static stp_status add_view(const tune_report *r, tune_folder *folder, size_t view, chart_text *out,
                           stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = r->sweep->params;
    const tune_shot *reference = shot_of(r->sweep, view, TUNE_REFERENCE);
    stp_image differs = {0};
    char caption[128];
    if (reference == NULL)
        return STP_OK;
    chart_text_add(out,
                   "<section class=\"view\">\n<h3>%s</h3>\n<div class=\"look\" hidden=\"\">\n"
                   "<label>left every sample, right <select>",
                   p->views->list[view].name);
    for (size_t i = 0; i < p->shown_count; i++)
        chart_text_add(out, "<option value=\"%zu\">%g px</option>", i + 1,
                       p->thresholds[p->shown[i]]);
    chart_text_add(out, "</select></label>\n<div class=\"pair\"><img alt=\"every sample\"/>"
                        "<img alt=\"the threshold chosen\"/></div>\n"
                        "<input type=\"range\" min=\"0\" max=\"100\" value=\"50\" "
                        "aria-label=\"where the two meet\"/>\n</div>\n<div class=\"grid\">\n");
    snprintf(caption, sizeof caption, "every sample, %d x %d a pixel", p->times, p->times);
    STP_TRY(add_picture(folder, &reference->image, caption, out, err));
    for (int pass = 0; pass < 2; pass++)
        for (size_t i = 0; i < p->shown_count; i++) {
            const tune_shot *shot = shot_of(r->sweep, view, p->shown[i]);
            const tune_row *row = &tune_sweep_point(r->sweep, 0, p->shown[i])->rows[view];
            if (shot == NULL)
                continue;
            snprintf(caption, sizeof caption,
                     pass == 0 ? "%g px: %.2f dB, %s points" : "%g px: differences, times 4",
                     p->thresholds[p->shown[i]], row->compared.psnr_db,
                     tune_figure_count((double)row->cut.points).text);
            if (pass == 0) {
                STP_TRY(add_picture(folder, &shot->image, caption, out, err));
                continue;
            }
            STP_TRY(difference(&shot->image, &reference->image, &differs, err));
            STP_TRY(add_picture(folder, &differs, caption, out, err));
            stp_image_destroy(&differs);
        }
    chart_text_add(out, "</div>\n</section>\n");
done:
    stp_image_destroy(&differs);
    return status;
}

/* ---- figures ---- */

static void add_table(const tune_report *r, size_t setting, chart_text *out)
{
    static const char *const names[TUNE_FACTOR_COUNT] = {TUNE_FACTOR_NAMES};
    const tune_sweep_params *p = r->sweep->params;
    chart_text_add(
        out, "<div class=\"wide\"><table>\n<tr><th>threshold px</th><th>PSNR dB</th><th>SSIM</th>"
             "<th>normals mean / p95 deg</th><th>outline mean / p95 / max px</th><th>holes</th>"
             "<th>spill</th><th>points</th><th>patches</th><th>file MiB</th><th>GPU MiB</th>"
             "<th>ms</th><th>predicted px</th><th>measured px</th><th>popping levels</th>"
             "<th>flicker a frame</th></tr>\n");
    for (size_t t = 0; t < p->threshold_count; t++) {
        tune_summary s = tune_summarise(r->sweep, setting, t);
        chart_text_add(
            out,
            "<tr><td>%g%s</td><td>%.2f</td><td>%.4f</td><td>%.2f / %.2f</td>"
            "<td>%.3f / %.2f / %.1f</td><td>%.1f</td><td>%.1f</td><td>%s</td>"
            "<td>%s</td><td>%.1f</td><td>%.1f</td><td>%.1f</td><td>%.3f</td>"
            "<td>%s</td><td>%.2f</td><td>%.2f</td></tr>\n",
            s.threshold_px, tune_is_default(r->sweep, setting, s.threshold_px) ? " (default)" : "",
            s.psnr_db, s.ssim, s.angle_mean_deg, s.angle_p95_deg, s.shift_mean_px, s.shift_p95_px,
            s.shift_max_px, s.holes, s.spill, tune_figure_count(s.points).text,
            tune_figure_count(s.patches).text, s.file_bytes / 1048576.0, s.gpu_bytes / 1048576.0,
            s.ms, s.predicted_px, tune_figure_write(s.measured_px, 3).text, s.extra, s.flicker);
    }
    chart_text_add(out, "</table></div>\n<h3>What stands between predicted and measured</h3>\n"
                        "<div class=\"wide\"><table>\n<tr><th>threshold px</th><th>discs</th>"
                        "<th>beyond it</th><th>p10</th><th>median</th><th>p90</th>"
                        "<th>of the views' greatest</th>");
    for (int k = 0; k < TUNE_FACTOR_COUNT; k++)
        chart_text_add(out, "<th>%s</th>", names[k]);
    chart_text_add(out, "</tr>\n");
    for (size_t t = 0; t < p->threshold_count; t++) {
        tune_summary s = tune_summarise(r->sweep, setting, t);
        if (s.discs == 0)
            continue;
        chart_text_add(out, "<tr><td>%g</td><td>%s</td><td>%s</td>", s.threshold_px,
                       tune_figure_count((double)s.discs).text,
                       tune_figure_count((double)s.ratios.broken).text);
        const double of_ratio[] = {s.ratios.p10, s.ratios.median, s.ratios.p90, s.view_ratio};
        for (int k = 0; k < 4; k++)
            chart_text_add(out, "<td>%s</td>", tune_figure_write(of_ratio[k], 2).text);
        for (int k = 0; k < TUNE_FACTOR_COUNT; k++)
            chart_text_add(out, "<td>%s</td>", tune_figure_write(s.ratios.factor[k], 2).text);
        chart_text_add(out, "</tr>\n");
    }
    chart_text_add(out, "</table></div>\n");
}

static void add_intro(const tune_report *r, chart_text *out)
{
    const tune_sweep_params *p = r->sweep->params;
    chart_text_add(out, "%s<h1>Thresholds of ", head);
    chart_text_escape(out, r->model_path);
    chart_text_add(out, "</h1>\n<p>%zu views of %d x %d pixels, ", p->views->count,
                   p->views->views[0].width, p->views->views[0].height);
    chart_text_escape(out, r->gl_renderer);
    chart_text_add(out,
                   ". Pictures are judged against every sample drawn with %d x %d pixels for one; "
                   "normals and changes along dollies against the plain picture of every sample."
                   "</p>\n",
                   p->times, p->times);
    char advice[240];
    tune_advice_of(r->sweep, advice);
    if (advice[0] != '\0')
        chart_text_add(out, "<p><strong>%s.</strong></p>\n", advice);
    if (r->answer->kind != TUNE_GOAL_NONE)
        chart_text_add(out,
                       "<p><strong>Solved: threshold %.4g px</strong> gives %s %s; asked "
                       "for was %s.</p>\n",
                       r->answer->found.threshold_px, tune_goal_word(r->answer->kind),
                       tune_figure_goal(r->answer->kind, r->answer->found.value).text,
                       tune_figure_goal(r->answer->kind, r->answer->target).text);
}

static void add_legend(chart_text *out)
{
    chart_text_add(out, "<h2>What the columns say</h2>\n<ul>\n");
    for (size_t i = 0; i < TUNE_LEGEND_COUNT; i++)
        chart_text_add(out, "<li><strong>%s</strong>: %s</li>\n", tune_legend[i].name,
                       tune_legend[i].meaning);
    chart_text_add(out, "</ul>\n<p>%s</p>\n", tune_legend_zero);
}

static const char notes[] =
    "<h2>How it is measured</h2>\n<ul>\n"
    "<li>PSNR is of the squared RGB differences, over black, of all views' pixels that either "
    "picture covers, taken together. SSIM, normals and outlines are means weighted by what there "
    "is of each; points are means of the views; bytes, predicted and measured the greatest.</li>\n"
    "<li>Outline: from each point where coverage crosses one half to the nearest such point of "
    "the other picture; uncovered parts of fewer than 16 pixels are holes instead.</li>\n"
    "<li>Predicted is what the level rule says of what it drew. Measured is, of a sample of drawn "
    "discs and of those with the greatest prediction, how far centre and 16 rim points lie on the "
    "screen from the nearest points of the discs of level 0; lines and triangles are not measured. "
    "The ratio is of the discs that do not lie on those of level 0; its factors: nearest depth "
    "of a patch's bound (depth), its cone of normals (cone), its perpendicular error (span) and "
    "overhang for this disc's own, and the rest.</li>\n"
    "<li>Popping: root mean square of what changes from frame to frame otherwise than in the same "
    "dolly of every sample. Flicker: holes that open or close.</li>\n"
    "<li>Times are medians of repeats, all thresholds in turns view by view, then of the views."
    "</li>\n</ul>\n";

stp_status tune_report_page(const tune_report *r, tune_folder *folder, chart_text *out,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const tune_sweep_params *p = r->sweep->params;
    add_intro(r, out);
    for (size_t k = 0; k < p->setting_count; k++) {
        chart_text_add(out, "<h2>%s</h2>\n", p->settings[k].name);
        add_table(r, k, out);
    }
    add_legend(out);
    chart_text_add(out, "<h2>Charts</h2>\n<div class=\"charts\">\n");
    for (int i = 0; i < TUNE_CHARTS; i++)
        STP_TRY(tune_report_chart(r, i, out, err));
    chart_text_add(out, "</div>\n<h2>Pictures</h2>\n");
    for (size_t v = 0; v < TUNE_SHOT_VIEWS && v < p->views->count; v++)
        STP_TRY(add_view(r, folder, v, out, err));
    chart_text_add(out, "%s%s</body>\n</html>\n", notes, script);
done:
    return status;
}
