/* Draws the viewer's frames: the scene, then panels and marks over it; sets the title. */
#include "tools/view/view_draw.h"

#include "tools/view/panels/view_marks.h"
#include "tools/view/panels/view_panels.h"
#include "tools/view/view_say.h"
#include "tools/view/view_wishes.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define TITLE_BYTES 1024
#define LOD_BYTES 36
#define THRESHOLD_BYTES 64
/* After this time a level change has faded to a third. */
#define FADE_S 0.12
#define FADE_LEAST 0.05
/* With --fps, a view rests after this time without a change: pauses between two events of a drag
 * are shorter. */
#define REST_S 0.25

/* Writes the colour mode; nothing for the samples' own colours. */
static void colour_words(const viewer *v, char out[80])
{
    const stp_draw_params *p = &v->control.params;
    char colour[STP_ATTRIBUTE_NAME_BYTES], palette[16];
    draw_options_word(DRAW_COLOURS, (int)p->colour, colour);
    if (p->colour == STP_COLOUR_INTENSITY && v->options->attribute)
        snprintf(colour, sizeof colour, "%s", v->options->attribute);
    draw_options_word(DRAW_PALETTES, (int)p->palette, palette);
    bool graded = p->colour == STP_COLOUR_INTENSITY || p->colour == STP_COLOUR_ELEVATION;
    out[0] = '\0';
    if (p->colour != STP_COLOUR_RGB)
        snprintf(out, 80, ", %s%s%s", colour, graded ? " in " : "", graded ? palette : "");
}

/* Writes the modes that the user switched on beyond drawing: ", fly, orthographic, clipped". */
static void mode_words(const viewer *v, char out[240])
{
    static const char *const navigations[] = {"", ", fly", ", walk"};
    const view_control *c = &v->control;
    const stp_dvec3 *line = view_measure_last(&v->measure);
    char measured[80] = "", heights[40] = "", contours[40] = "", marks[60] = "";
    if (c->params.contour_step > 0.0)
        snprintf(contours, sizeof contours, ", contours (%d labels)", v->labels.count);
    if (v->marked.count > 0)
        snprintf(marks, sizeof marks, ", marks: %zu (%d hidden)", v->marked.count, v->marks_hidden);
    if (c->params.exaggerate > 0.0)
        snprintf(heights, sizeof heights, ", heights x %.3g", c->params.exaggerate);
    if (line != NULL) {
        snprintf(measured, sizeof measured, " %.5g", view_measure_length(line));
        view_add_unit(v, VIEW_UNIT_ANY, measured, sizeof measured);
    }
    snprintf(out, 240, "%s%s%s%s%s%s%s%s%s%s", navigations[c->navigation], heights,
             c->camera.height > 0.0 ? ", orthographic" : "",
             c->params.edl > 0.0 ? ", eye-dome" : "", contours,
             c->params.clip.enabled ? ", clipped" : "", c->measuring ? ", measuring" : "",
             c->measuring ? measured : "", v->record.on ? ", recording" : "", marks);
}

/* Writes what chooses levels; for auto, also the road that it took. */
static void lod_words(const viewer *v, char text[LOD_BYTES])
{
    char taken[16], asked[16];
    draw_options_word(DRAW_LODS, (int)v->control.params.lod, asked);
    draw_options_word(DRAW_LODS, (int)v->stats.lod, taken);
    if (v->control.params.lod == STP_LOD_AUTO && v->stats.lod != STP_LOD_AUTO)
        snprintf(text, LOD_BYTES, "%s (%s)", asked, taken);
    else
        snprintf(text, LOD_BYTES, "%s", asked);
}

/* Writes what the frame on the screen was drawn with. */
static void threshold_words(const viewer *v, char text[THRESHOLD_BYTES])
{
    int used = v->drawn_px > 0.0 && !v->stats.every_sample
                   ? snprintf(text, THRESHOLD_BYTES, "threshold %.4g px", v->drawn_px)
                   : snprintf(text, THRESHOLD_BYTES, "every sample");
    if (view_is_small(v))
        snprintf(text + used, THRESHOLD_BYTES - (size_t)used, " at %d x %d", v->drawn.width,
                 v->drawn.height);
}

static void show_title(const viewer *v)
{
    const stp_draw_params *p = &v->control.params;
    const stp_draw_stats stats = view_beside_stats(v);
    char title[TITLE_BYTES], lod[LOD_BYTES], reconstruct[16], shade[16], threshold[THRESHOLD_BYTES],
        colour[80], modes[240], missing[40] = "", more[40] = "", preparing[40] = "", side[16] = "";
    if (view_beside_where(v)[0] != '\0')
        snprintf(side, sizeof side, " (%s)", view_beside_where(v));
    lod_words(v, lod);
    draw_options_word(DRAW_RECONSTRUCTIONS, (int)p->reconstruct, reconstruct);
    draw_options_word(DRAW_SHADES, (int)p->shade, shade);
    colour_words(v, colour);
    mode_words(v, modes);
    threshold_words(v, threshold);
    if (stats.chunks_missing > 0)
        snprintf(missing, sizeof missing, ", %u chunks missing", stats.chunks_missing);
    if (v->said_damage)
        snprintf(missing, sizeof missing, ", DAMAGED: see stipple verify");
    if (v->scene.count > 1)
        snprintf(more, sizeof more, " and %zu more", v->scene.count - 1);
    if (v->prepare.state == VIEW_PREPARE_FAILED)
        snprintf(preparing, sizeof preparing, ", coarse");
    else if (v->prepare.state != VIEW_PREPARE_NONE)
        snprintf(preparing, sizeof preparing, ", coarse: preparing, %.0f %%",
                 floor(100.0 * v->prepare.done));
    snprintf(title, sizeof title, "%.160s%s%s: %.1f ms, %llu points, %s, %s, %s, %s%s%s%s%s",
             v->scene.models[0].name, more, side, stats.frame_ms,
             (unsigned long long)stats.points_drawn, threshold, lod, reconstruct, shade, colour,
             modes, missing, preparing);
    stp_window_set_title(v->window, title);
}

static void show_damage(viewer *v)
{
    char text[DRAW_DAMAGE_BYTES];
    if (v->said_damage || !draw_options_damage(v->renderer, text))
        return;
    view_note(v, "%s", text);
    draw_options_warn("view", v->renderer);
    v->said_damage = true;
}

static void note_frame(viewer *v)
{
    view_chart *chart = &v->chart;
    const stp_draw_stats stats = view_beside_stats(v);
    chart->frame_ms[chart->next] = (float)stats.frame_ms;
    chart->points[chart->next] = (float)stats.points_drawn;
    chart->next = (chart->next + 1) % VIEW_HISTORY;
    chart->count += chart->count < VIEW_HISTORY;
}

static bool is_moving(const viewer *v)
{
    return v->fps > 0.0 && v->now_s - v->moved_s < REST_S;
}

/* Whether the next frame is to hold --fps. */
static bool is_paced(const viewer *v)
{
    const stp_draw_params *p = &v->control.params;
    return is_moving(v) && !p->every_sample && p->lod != STP_LOD_FULL;
}

/* At rest the threshold is the requested one. */
static stp_draw_params params_of(const viewer *v)
{
    stp_draw_params p = v->control.params;
    p.stream = true;
    p.hidden_models = view_scene_hidden(&v->scene);
    p.refine = v->fps > 0.0 && !is_moving(v);
    p.every_sample |= p.lod == STP_LOD_FULL;
    p.fade = fmax(exp(-(v->now_s - v->last_frame_s) / FADE_S), FADE_LEAST);
    if (is_paced(v))
        p.threshold_px = fmax(p.threshold_px, v->pace.threshold_px);
    return p;
}

/* Makes the view. A camera that sees nothing, for whatever reason, goes home. */
static stp_status make_view(viewer *v, stp_error *err)
{
    view_control *c = &v->control;
    const int width = v->layout.picture_width, height = v->layout.picture_height;
    stp_error why = {0};
    if (stp_view_create(&c->view, &c->camera, &c->ball, width, height, &why) == STP_OK)
        return STP_OK;
    view_note(v, "%s", why.message);
    stp_status status = view_go_home(v, err);
    if (status == STP_OK)
        status = stp_view_create(&c->view, &c->camera, &c->ball, width, height, err);
    return status;
}

static stp_status draw_side(viewer *v, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_draw_params params = params_of(v);
    v->stats = (stp_draw_stats){0};
    if (!view_beside_is_shown(v))
        return STP_OK;
    STP_TRY(stp_renderer_draw(v->renderer, &v->drawn, &params, &v->stats, err));
    v->drawn_px = params.every_sample ? 0.0 : params.threshold_px;
    v->loading |= v->stats.chunks_loading > 0 || stp_renderer_trouble(v->renderer)[0] != '\0';
    v->resting |= v->stats.more;
    v->labels.fresh = false;
    show_damage(v);
done:
    return status;
}

static stp_status draw_scene(viewer *v, stp_error *err)
{
    stp_status status = STP_OK;
    view_control *c = &v->control;
    v->moved_s = c->changed ? v->now_s : v->moved_s;
    const bool paced = is_paced(v);
    STP_TRY(make_view(v, err));
    v->drawn = c->view;
    if (paced) { /* threshold and resolution become those that hold --fps */
        stp_pace_ask(&v->pace, v->fps, view_beside_finest_px(v));
        v->drawn = stp_view_scaled(&v->drawn, v->pace.scale);
    }
    v->loading = false;
    v->resting = is_moving(v);
    STP_TRY(view_beside_both(v, draw_side, err));
    v->last_frame_s = v->now_s;
    const stp_draw_stats stats = view_beside_stats(v);
    if (paced && c->changed)
        stp_pace_follow(&v->pace, stats.frame_ms, stats.points_drawn);
    note_frame(v);
    c->changed = false;
    v->ui_turns = v->ui_turns > 1 ? v->ui_turns : 1;
done:
    return status;
}

/* Finds what is under the cursor, if the cursor is over the picture. */
static void look_under(viewer *v)
{
    int x = (int)floor(v->control.x), y = (int)floor(v->control.y), column = x, row = y;
    bool inside = x >= 0 && y >= 0 && x < v->layout.picture_width && y < v->layout.picture_height;
    v->under = (stp_pick){0};
    if (!inside || v->control.drag != VIEW_REST)
        return;
    stp_renderer *renderer = view_beside_renderer(v, x);
    view_drawn_pixel(v, &column, &row);
    if (!v->resting && !v->loading) {
        stp_renderer_pick(renderer, column, row, &v->under, NULL);
        return;
    }
    /* picking would restart the refinement */
    float depth = 0.0f;
    stp_renderer_depth_at(renderer, column, row, &depth, NULL);
    v->under = (stp_pick){.hit = depth > 0.0f, .level = -1, .chunk = STP_PICK_NO_CHUNK};
    v->under.position = stp_unexaggerated(
        &v->control.params, stp_view_unproject(&v->control.view, x + 0.5, y + 0.5, (double)depth));
}

/* Finds the labels of contours once the picture is at rest; until then those of before stay. */
static stp_status find_labels(viewer *v, stp_error *err)
{
    const stp_draw_params *p = &v->control.params;
    if (v->labels.step != p->contour_step || v->labels.base != p->contour_base)
        v->labels.count = 0;
    if (v->labels.fresh || v->resting || v->loading || v->control.drag != VIEW_REST ||
        view_is_small(v) || !view_beside_is_shown(v))
        return STP_OK;
    (void)view_labels_find(&v->labels, v->renderer, &v->drawn, p, stp_ui_scale(v->ui), err);
    return STP_OK;
}

static void draw_shot(viewer *v)
{
    char text[80];
    double middle[2] = {0.5 * v->layout.picture_width, 0.5 * v->layout.picture_height};
    snprintf(text, sizeof text, "screenshot %d x %d: %.0f %% drawn, Esc gives up",
             v->shot.image.width, v->shot.image.height, 100.0 * view_shot_done(&v->shot));
    stp_ui_draw_label(middle[0], middle[1], text, 0xffffffff, true);
}

/* Shows the last picture and draws ImGui over it. */
static void draw_panels(viewer *v)
{
    const view_layout *l = &v->layout;
    bool drawing = v->shot.state == VIEW_SHOT_DRAWING; /* then the renderer holds another picture */
    view_stripe stripes[2];
    const int stripe_count = view_beside_stripes(v, drawing ? 0 : l->picture_width, stripes);
    stp_ui_begin(v->ui, l->width, l->height, v->now_s - v->last_ui_s);
    v->last_ui_s = v->now_s;
    if (!drawing) {
        if (v->layout.panel.width > 0.0 || v->help || v->control.measuring)
            look_under(v);
        (void)view_beside_both(v, find_labels, NULL);
        view_marks_draw(v);
    } else {
        draw_shot(v);
    }
    if (l->panel.width > 0.0)
        view_panels_draw(v);
    for (int i = 0; i < stripe_count; i++)
        stp_renderer_present_columns(stripes[i].renderer, 0, l->picture_width, l->picture_height,
                                     stripes[i].begin, stripes[i].end);
    stp_ui_end(v->ui);
    stp_window_present(v->window);
    show_title(v);
}

/* Draws one part of a screenshot. A failure does not end the viewer. */
static void draw_part(viewer *v)
{
    stp_error err = {0};
    view_stripe stripes[2];
    const int count = view_beside_stripes(v, v->shot.image.width, stripes);
    v->ui_turns = 1;
    v->control.changed = true; /* the viewer's picture was overwritten */
    if (view_shot_draw(&v->shot, stripes, count, &err) != STP_OK)
        view_note(v, "%s", err.message);
}

/* True if chunks have arrived, or it is time to request again what could not be read. */
static bool has_come(const viewer *v)
{
    view_stripe stripes[2];
    bool come = false;
    for (int i = view_beside_stripes(v, v->layout.picture_width, stripes); i-- > 0;)
        come |= stp_renderer_has_news(stripes[i].renderer) ||
                stp_renderer_trouble(stripes[i].renderer)[0] != '\0';
    return come;
}

stp_status view_draw(viewer *v, stp_error *err)
{
    stp_status status = STP_OK;
    if (v->layout.width < 1) /* a minimised window waits */
        return STP_OK;
    if (v->shot.state == VIEW_SHOT_DRAWING)
        draw_part(v);
    else if (v->control.changed || v->resting || (v->loading && has_come(v)))
        STP_TRY(draw_scene(v, err));
    if (v->ui_turns > 0) {
        draw_panels(v);
        v->ui_turns--;
    }
    if (stp_ui_is_exhausted())
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the panels");
done:
    return status;
}
