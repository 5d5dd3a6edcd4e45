/* Options of the drawing commands. */
#include "tools/draw/draw_options.h"

#include "formats/attribute/where.h"
#include "formats/chunk/convert.h"
#include "runtime/class_legend.h"
#include "runtime/colour_range.h"
#include "runtime/gl/gpu_layout.h"
#include "tools/draw/draw_exaggerate.h"
#include "tools/draw/draw_filter.h"
#include "tools/draw/draw_light.h"
#include "tools/file/source_options.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PART_OPTIONS 6
/* Intensities show something if their middle half covers this much of 0 to 1. */
#define INTENSITIES_DIFFER 0.02
#define OWN_OPTIONS                                                                                \
    (DRAW_OPTION_COUNT - CAMERA_OPTION_COUNT - PART_OPTIONS - DRAW_SOURCE_OPTION_COUNT)

draw_options draw_options_default(void)
{
    return (draw_options){.camera = camera_options_default(),
                          .threshold_px = 1.0,
                          .aa = DRAW_AA_EDGES,
                          .exaggerate = 1.0,
                          .timeout_s = SOURCE_TIMEOUT_S,
                          .gpu_memory = UINT64_C(1) << 30,
                          .cpu_memory = UINT64_C(1) << 30,
                          .cache_bytes = UINT64_C(1) << 30};
}

/* Options of what is read and held. */
static void fill_sources(draw_options *o, cli_option out[DRAW_SOURCE_OPTION_COUNT])
{
    const cli_option options[DRAW_SOURCE_OPTION_COUNT] = {
        {"--allow-damage", 0, CLI_FLAG, &o->allow_damage, NULL,
         "if a chunk cannot be read, draw its parent instead and warn", NULL},
        {"--gpu-memory", 0, CLI_BYTES, &o->gpu_memory, "SIZE", "memory for samples on a GPU (1G)",
         NULL},
        {"--cpu-memory", 0, CLI_BYTES, &o->cpu_memory, "SIZE",
         "memory for chunks that are being decoded (1G)", NULL},
        {"--cache", 0, CLI_STRING, &o->cache_folder, "DIR",
         "folder that keeps prepared scans (~/.cache/stipple) and data from web servers (none)",
         NULL},
        {"--cache-size", 0, CLI_BYTES, &o->cache_bytes, "SIZE",
         "limit of each of both (16G of prepared scans, 1G of data)", &o->has_cache_bytes},
        {"--no-cache", 0, CLI_FLAG, &o->no_cache, NULL, "keep nothing, and use nothing kept", NULL},
        source_options_timeout(&o->timeout_s),
        {"--shaders", 0, CLI_STRING, &o->shader_folder, "DIR",
         "use shader files in DIR and its sub-folders instead of the built-in ones", NULL},
    };
    memcpy(out, options, sizeof options);
}

/* Options of what is left out. */
static void fill_parts(draw_options *o, cli_option out[PART_OPTIONS])
{
    const cli_option options[PART_OPTIONS] = {
        {"--clip", 0, CLI_STRING, &o->clip, "x0,y0,z0,x1,y1,z1", "draw only this box", NULL},
        {"--cull", 0, CLI_CHOICE, &o->cull, DRAW_CULLS,
         "leave out samples seen from behind: proven hidden ones, none, all (auto)", NULL},
        {"--occlusion", 0, CLI_CHOICE, &o->occlusion, DRAW_OCCLUSIONS,
         "neither read nor draw what other surfaces hide; same picture (auto: on in the viewer)",
         NULL},
        {"--classes", 0, CLI_STRING, &o->classes, "LIST",
         "draw only these classes: numbers or names, like 2,building", NULL},
        {"--hide-classes", 0, CLI_STRING, &o->hidden_classes, "LIST",
         "do not draw these classes, like 7,high-noise", NULL},
        {"--where", 0, CLI_STRING, &o->where, "CONDITION",
         "draw only samples that fulfil it, like 'return==1 && class!=7' (as export --where)",
         NULL},
    };
    memcpy(out, options, sizeof options);
}

void draw_options_fill(draw_options *o, cli_option out[DRAW_OPTION_COUNT])
{
    const cli_option options[OWN_OPTIONS] = {
        {"--view", 0, CLI_CHOICE, &o->home, DRAW_HOMES,
         "start view, unless eye, look or camera is given. first: from the scanner or inside, "
         "if the model knows that; whole: the whole model (first)",
         NULL},
        {"--threshold", 0, CLI_NUMBER, &o->threshold_px, "PX",
         "largest error on the screen (the model's, else 1); 0: draw every sample",
         &o->has_threshold},
        {"--radius-cap", 0, CLI_NUMBER, &o->radius_cap_px, "PX",
         "largest radius of coarse samples; times threshold squared, if above 1 (6; with --where "
         "1)",
         NULL},
        {"--error-terms", 0, CLI_STRING, &o->terms, "LIST",
         "errors that refine levels besides the surface's error: radius,colour,silhouette or "
         "none (radius,colour)",
         NULL},
        {"--lod", 0, CLI_CHOICE, &o->lod, DRAW_LODS,
         "what chooses levels: shaders or the CPU; full draws every sample (auto: the faster "
         "of both shaders)",
         NULL},
        {"--reconstruct", 0, CLI_CHOICE, &o->reconstruct, DRAW_RECONSTRUCTIONS,
         "method that closes gaps between samples (gauss)", NULL},
        {"--aa", 0, CLI_CHOICE, &o->aa, DRAW_AA,
         "edges: smooth edges by how far discs reach; N: average N x N pixels (edges)", NULL},
        {"--shade", 0, CLI_CHOICE, &o->shade, DRAW_SHADES,
         "shading; unlit: colours without light (the model's default, else phong)", &o->has_shade},
        {"--grid-draw", 0, CLI_CHOICE, &o->grid_draw, DRAW_GRIDS,
         "finest samples of grids; auto: triangles where they lie some pixels apart (auto)", NULL},
        {"--maps-as", 0, CLI_CHOICE, &o->maps_as, DRAW_MAPS,
         "finest samples of maps; auto: a mesh where they lie some pixels apart (auto)", NULL},
        {"--colour", 0, CLI_STRING, &o->colour_name, DRAW_COLOURS,
         "colour of samples; or the name of an attribute that prep kept, like gps_time (rgb; "
         "intensity or class, if the model has no colours)",
         NULL},
        {"--color", 0, CLI_STRING, &o->colour_name, DRAW_COLOURS, NULL, NULL},
        {"--palette", 0, CLI_CHOICE, &o->palette, DRAW_PALETTES,
         "palette; auto: grey for intensity, viridis for elevation (auto)", NULL},
        {"--colour-range", 0, CLI_STRING, &o->colour_range, "LOW,HIGH",
         "ends of the palette: intensity 0 to 1, elevation in z (2nd to 98th percentile)", NULL},
        {"--overlay", 0, CLI_NUMBER, &o->overlay, "AMOUNT",
         "share of an overlay (--shade level to primitive) in colours, up to 1 (0: alone)", NULL},
        {"--edl", 0, CLI_AMOUNT, &o->edl, "[STRENGTH]",
         "eye-dome lighting: darken edges in depth (1)", NULL},
        {"--light", 0, CLI_STRING, &o->light, "AZIMUTH,ALTITUDE",
         "light that stands still, in degrees clockwise from +y and above level: hill shading (it "
         "moves with the camera)",
         NULL},
        {"--contours", 0, CLI_STRING, &o->contours, "STEP[,BASE]",
         "lines of equal height (z), every STEP from BASE on (0); each fifth is wider", NULL},
        {"--exaggerate", 0, CLI_NUMBER, &o->exaggerate, "Z",
         "draw heights (z) Z times as high about the middle height, 0.01 to 100 (1)", NULL},
    };
    camera_options_fill(&o->camera, out);
    memcpy(out + CAMERA_OPTION_COUNT, options, sizeof options);
    fill_parts(o, out + CAMERA_OPTION_COUNT + OWN_OPTIONS);
    fill_sources(o, out + DRAW_OPTION_COUNT - DRAW_SOURCE_OPTION_COUNT);
}

/* Reads --colour: a word, or the name of an attribute. */
static void choose_colour(draw_options *o)
{
    char word[16];
    if (!o->colour_name)
        return;
    for (int i = 0; i <= STP_COLOUR_FIT; i++) {
        draw_options_word(DRAW_COLOURS, i, word);
        if (strcmp(word, o->colour_name) == 0) {
            o->colour = i;
            return;
        }
    }
    o->attribute = o->colour_name;
    o->colour = STP_COLOUR_INTENSITY;
}

int draw_options_check(draw_options *o, const cli_command *command)
{
    stp_error error = {0};
    stp_where where;
    choose_colour(o);
    if (o->where && stp_where_parse(&where, o->where, &error) != STP_OK) /* before a scan is made */
        return cli_fail(command, &error);
    if (o->threshold_px < 0.0)
        return cli_usage(command, "--threshold is not negative");
    if (!(o->exaggerate >= STP_EXAGGERATE_LEAST && o->exaggerate <= STP_EXAGGERATE_MOST))
        return cli_usage(command, "--exaggerate is a number from %g to %g", STP_EXAGGERATE_LEAST,
                         STP_EXAGGERATE_MOST);
    return CLI_CONTINUE;
}

void draw_options_word(const char *words, int index, char out[16])
{
    while (index-- > 0)
        words += strcspn(words, "|") + 1;
    snprintf(out, 16, "%.*s", (int)strcspn(words, "|"), words);
}

open_scan_params draw_options_scan(const draw_options *o, const char *command,
                                   const cli_common *common)
{
    return (open_scan_params){.command = command,
                              .common = common,
                              .attributes = o->where ? "all" : o->attribute,
                              .cache_folder = o->cache_folder,
                              .cache_bytes = o->no_cache          ? 0
                                             : o->has_cache_bytes ? o->cache_bytes
                                                                  : OPEN_CACHE_BYTES};
}

/* The two numbers of --colour-range; NULL leaves them. */
static stp_status parse_range(const char *text, double range[2], stp_error *err)
{
    int used = 0;
    if (!text || (sscanf(text, "%lf,%lf%n", &range[0], &range[1], &used) == 2 && !text[used] &&
                  range[0] < range[1] && isfinite(range[1] - range[0])))
        return STP_OK;
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "--colour-range %s: give two numbers that rise, like 0.1,0.9", text);
}

stp_status draw_options_show(const draw_options *o, stp_model *model, stp_error *err)
{
    stp_status status = STP_OK;
    double range[2] = {0.0, 0.0};
    if (o->where)
        STP_TRY(stp_model_choose(model, o->where, err));
    if (!o->attribute)
        return STP_OK;
    STP_TRY(parse_range(o->colour_range, range, err));
    STP_TRY(stp_model_show_attribute(model, o->attribute, range, err));
done:
    return status;
}

stp_status draw_options_open_model(const draw_options *o, const char *path, stp_model **model,
                                   stp_error *err)
{
    stp_byte_source_params params =
        source_options_params(o->cache_folder, o->no_cache ? 0 : o->cache_bytes, o->timeout_s);
    stp_status status = stp_model_open_at(model, path, &params, err);
    if (status == STP_OK)
        status = draw_options_show(o, *model, err);
    if (status != STP_OK)
        stp_model_close(model);
    return status;
}

static stp_status open_scans(const draw_options *o, open_scan *scan, stp_model **model,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    if (scan->found)
        status = draw_options_open_model(o, scan->path, model, &why);
    if (status == STP_INVALID_ARGUMENT) /* an option does not fit: another model would not either */
        return stp_error_set(err, status, "%s", why.message);
    /* what was found may be damaged, or removed meanwhile by another process */
    if (!scan->found || status != STP_OK) {
        STP_TRY(open_scan_prepare(scan, err));
        STP_TRY(draw_options_open_model(o, scan->path, model, err));
    }
    open_scan_opened(scan);
done:
    return status;
}

stp_status draw_options_open(const draw_options *o, const open_scan_params *params,
                             const char *const *paths, size_t count, stp_model **model,
                             stp_error *err)
{
    stp_status status = STP_OK;
    open_scan scan = {0};
    bool scans = false;
    for (size_t i = 0; i < count; i++) {
        STP_TRY(open_scan_is(&scans, paths[i], err));
        if (!scans && count > 1)
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "%s is no scan: give one model, or one or several scans",
                                 paths[i]);
    }
    if (!scans)
        return draw_options_open_model(o, paths[0], model, err);
    STP_TRY(open_scan_find(&scan, paths, count, params, err));
    STP_TRY(open_scans(o, &scan, model, err));
done:
    open_scan_clear(&scan);
    return status;
}

/* Without --colour, a model without colours shows its intensities, else its classes, if they
 * differ. */
static stp_status choose_own_colour(const draw_options *o, const stp_model *model,
                                    stp_draw_params *params, stp_error *err)
{
    const uint32_t has = model->info->attributes;
    stp_status status = STP_OK;
    double range[2];
    uint32_t classes[8] = {0}, bits = 0;
    if (o->colour_name || has & STP_HAS_COLOUR)
        return STP_OK;
    if (has & STP_HAS_INTENSITY) {
        STP_TRY(stp_model_colour_part(model, STP_COLOUR_INTENSITY, 0.25, range, err));
        if (range[1] - range[0] >= INTENSITIES_DIFFER) {
            params->colour = STP_COLOUR_INTENSITY;
            return STP_OK;
        }
    }
    if (has & STP_HAS_CLASS)
        STP_TRY(stp_model_classes(model, classes, err));
    for (int i = 0; i < 256; i++)
        bits += classes[i / 32] >> i % 32 & 1;
    if (bits > 1)
        params->colour = STP_COLOUR_CLASS;
done:
    return status;
}

/* Chooses the ends of the palette: those of the option, else those of the model. */
static stp_status choose_range(const draw_options *o, const stp_model *model,
                               stp_draw_params *params, stp_error *err)
{
    double *range = params->colour_range;
    if (o->attribute) { /* its range is on 0 to 1 already */
        range[1] = 1.0;
        return STP_OK;
    }
    if (params->colour == STP_COLOUR_INTENSITY && !(model->info->attributes & STP_HAS_INTENSITY))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--colour intensity: the model has none: give elevation or none");
    if (params->colour == STP_COLOUR_CLASS && !(model->info->attributes & STP_HAS_CLASS))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--colour class: the model has no classes: give elevation or none");
    if (params->colour == STP_COLOUR_OUTLIERS && !(model->info->attributes & STP_HAS_OUTLIERS))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--colour outliers: none are marked in the model: prepare it with "
                             "--outliers mark");
    if (o->colour_range)
        return parse_range(o->colour_range, range, err);
    if (params->colour == STP_COLOUR_INTENSITY || params->colour == STP_COLOUR_ELEVATION)
        return stp_model_colour_range(model, params->colour, range, err);
    return STP_OK;
}

/* Sets the clip box and the classes. */
static stp_status choose_filter(const draw_options *o, const stp_model *model,
                                stp_draw_params *params, stp_error *err)
{
    const char *list = o->classes ? o->classes : o->hidden_classes;
    const char *option = o->classes ? "--classes" : "--hide-classes";
    stp_status status = STP_OK;
    if (o->clip)
        STP_TRY(draw_filter_clip(o->clip, &model->info->box, &params->clip, err));
    if (!list)
        return STP_OK;
    if (o->classes && o->hidden_classes)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--classes and --hide-classes: give one of them");
    if (!(model->info->attributes & STP_HAS_CLASS))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: the model has no classes: leave it out", option);
    STP_TRY(draw_filter_classes(option, list, params->hidden_classes, err));
    for (int i = 0; o->classes && i < STP_CLASS_WORDS; i++)
        params->hidden_classes[i] = ~params->hidden_classes[i];
done:
    return status;
}

static stp_status choose_contours(const draw_options *o, stp_draw_params *params, stp_error *err)
{
    double step = 0.0, base = 0.0;
    int used = 0;
    if (!o->contours)
        return STP_OK;
    int count = sscanf(o->contours, "%lf%n,%lf%n", &step, &used, &base, &used);
    if (count < 1 || o->contours[used] || !(step > 0.0) || !isfinite(step) || !isfinite(base))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--contours %s: give a positive STEP, or STEP,BASE", o->contours);
    params->contour_step = step;
    params->contour_base = base;
    return STP_OK;
}

static stp_status check_amounts(const draw_options *o, stp_error *err)
{
    if (!(o->overlay >= 0.0 && o->overlay <= 1.0))
        return stp_error_set(err, STP_INVALID_ARGUMENT, "--overlay %g: give a number from 0 to 1",
                             o->overlay);
    if (o->overlay > 0.0 && o->shade < (int)STP_SHADE_LEVEL)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--overlay: nothing to lay over the colours: give --shade level, "
                             "chunk, error, confidence or primitive, too");
    if (o->edl < 0.0)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "--edl %g: give a number from 0 on",
                             o->edl);
    return STP_OK;
}

/* Parses words of stp_term, each at most once, or "none" alone. */
static bool parse_terms(const char *text, uint32_t *terms)
{
    static const char *const words[] = {"radius", "colour", "silhouette"};
    if (text == NULL)
        return true;
    if (strcmp(text, "none") == 0) {
        *terms = STP_TERM_NONE;
        return true;
    }
    for (;;) {
        size_t length = strcspn(text, ",");
        uint32_t found = 0;
        for (uint32_t i = 0; i < sizeof words / sizeof *words; i++)
            if (strlen(words[i]) == length && strncmp(words[i], text, length) == 0)
                found = 1u << i;
        if (found == 0 || (*terms & found) != 0)
            return false;
        *terms |= found;
        text += length;
        if (*text == '\0')
            return true;
        text++;
    }
}

stp_status draw_options_params(const draw_options *o, const stp_model *model,
                               stp_draw_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    const double noted_px = stp_chunk_file_threshold(stp_chunk_file_get_info(model->file));
    const double threshold_px = o->has_threshold || noted_px == 0.0 ? o->threshold_px : noted_px;
    uint32_t terms = 0;
    if (!parse_terms(o->terms, &terms))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--error-terms %s: give words of radius,colour,silhouette, or none",
                             o->terms);
    stp_draw_params p = {
        .lod = (stp_lod)o->lod,
        .reconstruct = (stp_reconstruct)o->reconstruct,
        .shade = o->has_shade ? (stp_shade)o->shade : stp_model_shade(model),
        .threshold_px = threshold_px,
        .every_sample = threshold_px <= 0.0,
        .radius_cap_px = o->radius_cap_px > 0.0 ? o->radius_cap_px
                         : o->where             ? STP_RADIUS_CAP_CHOSEN_PX
                                                : STP_RADIUS_CAP_PX,
        .terms = terms,
        .colour = (stp_colour)o->colour,
        .palette = o->attribute && o->palette == STP_PALETTE_OWN ? STP_PALETTE_VIRIDIS
                                                                 : (stp_palette)o->palette,
        .overlay = o->overlay,
        .edl = o->edl,
        .smooth_edges = o->aa == DRAW_AA_EDGES,
        .cull = (stp_cull)o->cull,
        .occlusion = (stp_occlusion_use)o->occlusion,
        .grid_draw = (stp_grid_draw)o->grid_draw,
        .maps_as = (stp_maps_as)o->maps_as,
    };
    draw_exaggerate_set(&p, o->exaggerate, &model->info->box);
    STP_TRY(check_amounts(o, err));
    STP_TRY(choose_filter(o, model, &p, err));
    STP_TRY(choose_own_colour(o, model, &p, err));
    STP_TRY(choose_range(o, model, &p, err));
    STP_TRY(choose_contours(o, &p, err));
    if (o->light)
        STP_TRY(draw_light_parse(o->light, &p, err));
    *params = p;
done:
    return status;
}

stp_renderer_params draw_options_renderer(const draw_options *o, const stp_model *model,
                                          const cli_common *common)
{
    return (stp_renderer_params){
        .model = model,
        .gpu_memory_bytes = o->gpu_memory,
        .cpu_memory_bytes = o->cpu_memory,
        .thread_count = (unsigned)common->threads,
        .shader_folder = o->shader_folder,
    };
}

bool draw_options_damage(const stp_renderer *renderer, char out[DRAW_DAMAGE_BYTES])
{
    const char *damage = stp_renderer_damage(renderer);
    bool any = damage[0] != '\0';
    snprintf(out, DRAW_DAMAGE_BYTES, "%s%s", damage, any ? "; its parent is drawn instead" : "");
    return any;
}

stp_status draw_options_require_whole(const draw_options *o, const stp_renderer *renderer,
                                      stp_error *err)
{
    const char *damage = stp_renderer_damage(renderer);
    if (damage[0] == '\0' || o->allow_damage)
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: repair the model (stipple verify --repair), or draw its parent "
                         "instead (--allow-damage)",
                         damage);
}

void draw_options_warn(const char *command, const stp_renderer *renderer)
{
    char text[DRAW_DAMAGE_BYTES];
    if (draw_options_damage(renderer, text))
        fprintf(stderr, "stipple %s: warning: %s\n", command, text);
}

/* The view that --view asks for. If an eye or a camera is given, the start is the view of the whole
 * model. */
static stp_home home_of(const draw_options *o)
{
    const camera_options *c = &o->camera;
    return c->path || c->has_eye || c->has_look ? STP_HOME_WHOLE : (stp_home)o->home;
}

stp_ball draw_options_ball(const draw_options *o, const stp_model *model)
{
    stp_draw_params p = {0};
    draw_exaggerate_set(&p, o->exaggerate, &model->info->box);
    return draw_exaggerate_ball(&p, &model->ball, &model->info->box);
}

stp_camera draw_options_start(const draw_options *o, const stp_model *model, const int size[2])
{
    const stp_home home = home_of(o);
    const bool whole = home == STP_HOME_WHOLE || !model->has_first;
    const stp_ball ball = draw_options_ball(o, model);
    stp_camera c = stp_model_camera(model, home, size[0], size[1]);
    stp_draw_params p = {0};
    draw_exaggerate_set(&p, o->exaggerate, &model->info->box);
    if (whole && o->exaggerate != 1.0)
        return stp_camera_around(&ball, stp_dvec3_sub(c.eye, c.look), c.up, c.fovy_deg, size[0],
                                 size[1]);
    draw_exaggerate_camera(&p, NULL, &c);
    return c;
}

stp_status draw_options_camera(const draw_options *o, const stp_model *model, stp_camera *camera,
                               int size[2], stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(camera_options_size(&o->camera, size, err));
    stp_camera c = draw_options_start(o, model, size);
    STP_TRY(camera_options_apply(&o->camera, &c, err));
    *camera = c;
done:
    return status;
}
