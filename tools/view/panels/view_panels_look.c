/* Draws the panel's sections about the look of the picture: quality, colour, surface and light. */
#include "runtime/class_legend.h"
#include "runtime/draw/filter.h"
#include "tools/draw/draw_light.h"
#include "tools/view/panels/view_panels.h"
#include "tools/view/view_wishes.h"

#include <math.h>
#include <stdio.h>

#define ALL 0xffffffffu
#define FPS_AT_FIRST 24.0

/* Shows the rate that --fps holds, and the state of the picture. */
static void pace_rows(viewer *v)
{
    char text[120];
    bool holds = v->fps > 0.0;
    if (stp_ui_check("hold a frame rate", &holds)) {
        v->fps = holds ? FPS_AT_FIRST : 0.0;
        v->control.changed = true;
    }
    stp_ui_hint("coarser and with fewer pixels while the camera moves; at rest finer, up to every "
                "sample");
    if (holds)
        stp_ui_slider("frames a second", &v->fps, 5.0, 120.0, "%.0f", true);
    if (holds && v->pace.fps > 0.0 && !stp_pace_holds(&v->pace))
        stp_ui_note("This rate cannot be held: nothing coarser or smaller is drawn faster.");
    if (view_is_small(v))
        snprintf(text, sizeof text, "%d x %d, at %.3g px", v->drawn.width, v->drawn.height,
                 v->drawn_px);
    else if (v->loading)
        snprintf(text, sizeof text, "loading");
    else if (v->resting)
        snprintf(text, sizeof text, "being refined");
    else if (!v->stats.cut_complete)
        snprintf(text, sizeof text, "%u chunks are missing", v->stats.chunks_missing);
    else if (v->stats.every_sample)
        snprintf(text, sizeof text, "complete, every sample");
    else
        snprintf(text, sizeof text, "complete, at %.3g px", v->drawn_px);
    stp_ui_row("picture", text);
}

void view_panel_quality(viewer *v)
{
    stp_draw_params *p = &v->control.params;
    int lod = (int)p->lod;
    bool changed = false;
    stp_ui_disable_begin(p->every_sample || p->lod == STP_LOD_FULL);
    changed |= stp_ui_slider("threshold", &p->threshold_px, VIEW_THRESHOLD_LEAST_PX,
                             VIEW_THRESHOLD_MOST_PX, "%.2f px", true);
    stp_ui_disable_end();
    stp_ui_hint("no sample is drawn further from the surface it stands for");
    changed |= stp_ui_check("every sample", &p->every_sample);
    if (stp_ui_choice("levels", &lod, "auto|geometry shader|compute shader|cpu|full", ALL)) {
        p->lod = (stp_lod)lod;
        changed = true;
    }
    changed |= stp_ui_slider("largest disc", &p->radius_cap_px, 1.0, 32.0, "%.1f px", true);
    stp_ui_hint("coarser samples are not drawn larger than this");
    pace_rows(v);
    v->control.changed |= changed;
}

/* ---- colour ---- */

static void palette_rows(viewer *v)
{
    stp_draw_params *p = &v->control.params;
    bool elevation = p->colour == STP_COLOUR_ELEVATION;
    int palette = (int)p->palette;
    double low = elevation ? v->scene.box.min.z : 0.0;
    double high = elevation ? v->scene.box.max.z : 1.0;
    if (stp_ui_choice("palette", &palette, DRAW_PALETTES, ALL)) {
        p->palette = (stp_palette)palette;
        v->control.changed = true;
    }
    if (!(low < high))
        return;
    v->control.changed |= stp_ui_slider("from", &p->colour_range[0], low, high, "%.3f", false);
    v->control.changed |= stp_ui_slider("to", &p->colour_range[1], low, high, "%.3f", false);
    if (stp_ui_button("fit to the model"))
        v->control.wants |= VIEW_WANTS_RANGE;
}

static bool has(const uint32_t bits[8], int c)
{
    return (bits[c / 32] >> c % 32 & 1u) != 0;
}

static void class_row(viewer *v, int c)
{
    stp_draw_params *p = &v->control.params;
    const char *name = stp_class_name((uint8_t)c);
    bool shown = !has(p->hidden_classes, c);
    char text[64];
    float rgb[3];
    stp_class_colour((uint8_t)c, rgb);
    const uint8_t bytes[3] = {(uint8_t)(255.0f * rgb[0]), (uint8_t)(255.0f * rgb[1]),
                              (uint8_t)(255.0f * rgb[2])};
    stp_ui_push_id(c);
    stp_ui_swatch(bytes);
    stp_ui_same_line();
    snprintf(text, sizeof text, "%d  %s", c, name != NULL ? name : "");
    if (stp_ui_check(text, &shown)) {
        p->hidden_classes[c / 32] ^= 1u << c % 32;
        v->control.changed = true;
    }
    stp_ui_pop_id();
}

/* Shows the models' classes, each with a box that hides it. */
static void legend(viewer *v)
{
    uint32_t *hidden = v->control.params.hidden_classes;
    for (int c = 0; c < 256; c++)
        if (has(v->model_classes, c) || has(hidden, c))
            class_row(v, c);
    if (stp_filter_hides_classes(&v->control.params) && stp_ui_button("show all classes")) {
        for (int k = 0; k < 8; k++)
            hidden[k] = 0;
        v->control.changed = true;
    }
}

void view_panel_colour(viewer *v)
{
    stp_draw_params *p = &v->control.params;
    int colour = (int)p->colour;
    if (stp_ui_choice("of samples", &colour, DRAW_COLOURS, v->control.colours)) {
        p->colour = (stp_colour)colour;
        v->control.wants |= VIEW_WANTS_RANGE;
        v->control.changed = true;
    }
    if (p->colour == STP_COLOUR_INTENSITY || p->colour == STP_COLOUR_ELEVATION)
        palette_rows(v);
    if (v->scene.attributes & STP_HAS_CLASS)
        legend(v);
}

/* ---- surface and light ---- */

/* Explains the colours of an overlay. */
static void overlay_legend(stp_shade shade)
{
    static const struct {
        stp_shade shade;
        const char *text;
    } texts[] = {
        {STP_SHADE_LEVEL, "the level of detail that each sample is of"},
        {STP_SHADE_CHUNK, "a colour for each chunk of the file"},
        {STP_SHADE_ERROR, "projected error, from none, black, to the threshold, white"},
        {STP_SHADE_CONFIDENCE, "green: measured; yellow to red: interpolated, from how coarse a "
                               "level of the pyramid"},
        {STP_SHADE_PRIMITIVE, "blue: points; yellow: lines; green: ribbons; orange: triangles; "
                              "red: cells of grids and maps"},
    };
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        if (texts[i].shade == shade)
            stp_ui_note(texts[i].text);
}

/* A round step that gives the models some twelve contours. */
static double usual_contour_step(const viewer *v)
{
    double rise = 0.0;
    for (size_t i = 0; i < v->scene.count; i++) {
        const stp_dbox *box = &v->scene.models[i].model->info->box;
        rise = fmax(rise, box->max.z - box->min.z);
    }
    const double raw = fmax(rise / 12.0, 1e-9), tens = pow(10.0, floor(log10(raw)));
    return tens * (raw < 2.0 * tens ? 1.0 : raw < 5.0 * tens ? 2.0 : 5.0);
}

static bool light_rows(stp_draw_params *p)
{
    double azimuth = 0.0, altitude = 0.0;
    bool fixed = draw_light_get(p, &azimuth, &altitude);
    bool changed = stp_ui_check("light stands still", &fixed);
    stp_ui_hint(
        "hill shading: the light of maps, from the upper left; else it moves with the camera");
    if (fixed) {
        changed |= stp_ui_slider("from", &azimuth, 0.0, 360.0, "%.0f deg", false);
        changed |= stp_ui_slider("above level", &altitude, 0.0, 90.0, "%.0f deg", false);
    }
    if (changed && fixed)
        draw_light_set(p, azimuth, altitude);
    else if (changed)
        p->light[0] = p->light[1] = p->light[2] = 0.0;
    return changed;
}

static bool contour_rows(const viewer *v, stp_draw_params *p)
{
    bool lines = p->contour_step > 0.0, changed = false;
    if (stp_ui_check("contours", &lines)) {
        p->contour_step = lines ? usual_contour_step(v) : 0.0;
        changed = true;
    }
    stp_ui_hint("lines of equal height; each fifth is wider");
    if (lines) {
        const double usual = usual_contour_step(v);
        changed |=
            stp_ui_slider("every", &p->contour_step, 0.05 * usual, 10.0 * usual, "%.4g", true);
    }
    return changed;
}

static void height_rows(viewer *v)
{
    const double is = v->control.params.exaggerate;
    double times = is > 0.0 ? is : 1.0;
    if (stp_ui_slider("heights", &times, STP_EXAGGERATE_LEAST, STP_EXAGGERATE_MOST, "%.3g times",
                      true))
        view_exaggerate(v, fabs(times - 1.0) < 0.02 ? 1.0 : times);
    stp_ui_hint("draws heights so many times as high; coordinates and lengths stay what they are");
}

void view_panel_surface(viewer *v)
{
    stp_draw_params *p = &v->control.params;
    int reconstruct = (int)p->reconstruct, shade = (int)p->shade;
    bool lit = p->edl > 0.0, changed = false;
    if (stp_ui_choice("gaps", &reconstruct,
                      "gauss|box|template 3|template 5|template 7|splat|left open: points", ALL)) {
        p->reconstruct = (stp_reconstruct)reconstruct;
        changed = true;
    }
    stp_ui_disable_begin(p->reconstruct == STP_RECONSTRUCT_POINTS);
    changed |= stp_ui_check("smooth edges", &p->smooth_edges);
    stp_ui_disable_end();
    stp_ui_hint("at rest, outlines cover their pixels in part, as far as the discs reach");
    if (stp_ui_choice("shows", &shade, DRAW_SHADES, ALL)) {
        p->shade = (stp_shade)shade;
        changed = true;
    }
    overlay_legend(p->shade);
    if (p->shade >= STP_SHADE_LEVEL)
        changed |= stp_ui_slider("mixed in", &p->overlay, 0.0, 1.0,
                                 p->overlay > 0.0 ? "%.2f" : "alone, unlit", false);
    if (stp_ui_check("eye-dome lighting", &lit)) {
        p->edl = lit ? 1.0 : 0.0;
        changed = true;
    }
    if (lit)
        changed |= stp_ui_slider("strength", &p->edl, 0.1, 5.0, "%.2f", true);
    changed |= light_rows(p);
    changed |= contour_rows(v, p);
    height_rows(v);
    int cull = (int)p->cull, grid_draw = (int)p->grid_draw, maps_as = (int)p->maps_as;
    if (stp_ui_choice("grids", &grid_draw, DRAW_GRIDS, ALL)) {
        p->grid_draw = (stp_grid_draw)grid_draw;
        changed = true;
    }
    stp_ui_hint("their finest samples as points or triangles; auto: triangles where they are some "
                "pixels apart");
    if (stp_ui_choice("maps", &maps_as, DRAW_MAPS, ALL)) {
        p->maps_as = (stp_maps_as)maps_as;
        changed = true;
    }
    stp_ui_hint(
        "their finest samples as a mesh, splats or points; auto: a mesh where they are some "
        "pixels apart");
    if (stp_ui_choice("seen from behind", &cull, DRAW_CULLS, ALL)) {
        p->cull = (stp_cull)cull;
        changed = true;
    }
    stp_ui_hint(
        "auto leaves out what is proven hidden, none nothing, back all that is known to face away");
    v->control.changed |= changed;
}
