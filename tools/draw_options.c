/* Options of the drawing commands. */
#include "tools/draw_options.h"

#include "tools/source_options.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

draw_options draw_options_default(void)
{
    return (draw_options){.camera = camera_options_default(),
                          .threshold_px = 1.0,
                          .radius_cap_px = STP_RADIUS_CAP_PX,
                          .gpu_memory = UINT64_C(1) << 30,
                          .cpu_memory = UINT64_C(1) << 30,
                          .cache_bytes = UINT64_C(1) << 30};
}

void draw_options_fill(draw_options *o, cli_option out[DRAW_OPTION_COUNT])
{
    const cli_option options[DRAW_OPTION_COUNT - CAMERA_OPTION_COUNT] = {
        {"--threshold", 0, CLI_NUMBER, &o->threshold_px, "PX",
         "greatest error on the screen (1); 0: every sample", &o->has_threshold},
        {"--radius-cap", 0, CLI_NUMBER, &o->radius_cap_px, "PX",
         "coarser samples are not drawn larger (6)", NULL},
        {"--lod", 0, CLI_CHOICE, &o->lod, DRAW_LODS,
         "who chooses levels: geometry shader (default), CPU, nobody, compute", NULL},
        {"--reconstruct", 0, CLI_CHOICE, &o->reconstruct, DRAW_RECONSTRUCTIONS,
         "how gaps are closed (gauss)", NULL},
        {"--shade", 0, CLI_CHOICE, &o->shade, DRAW_SHADES, "what is shown (phong)", NULL},
        {"--colour", 0, CLI_CHOICE, &o->colour, DRAW_COLOURS, "of the samples (rgb)", NULL},
        {"--color", 0, CLI_CHOICE, &o->colour, DRAW_COLOURS, NULL, NULL},
        {"--palette", 0, CLI_CHOICE, &o->palette, DRAW_PALETTES,
         "of intensity (grey) and elevation (viridis)", NULL},
        {"--colour-range", 0, CLI_STRING, &o->colour_range, "LOW,HIGH",
         "ends of the palette: intensity 0 to 1, elevation in z (2nd to 98th percentile)", NULL},
        {"--gpu-memory", 0, CLI_BYTES, &o->gpu_memory, "SIZE", "for samples on the GPU (1G)", NULL},
        {"--cpu-memory", 0, CLI_BYTES, &o->cpu_memory, "SIZE", "for chunks being decoded (1G)",
         NULL},
        {"--cache", 0, CLI_STRING, &o->cache_folder, "DIR",
         "keep there what is read of a model on a web server (nothing is kept)", NULL},
        {"--cache-size", 0, CLI_BYTES, &o->cache_bytes, "SIZE", "at most so much in all (1G)",
         NULL},
        {"--shaders", 0, CLI_STRING, &o->shader_folder, "DIR",
         "shader files there win over the built-in ones", NULL},
    };
    camera_options_fill(&o->camera, out);
    memcpy(out + CAMERA_OPTION_COUNT, options, sizeof options);
}

void draw_options_word(const char *words, int index, char out[16])
{
    while (index-- > 0)
        words += strcspn(words, "|") + 1;
    snprintf(out, 16, "%.*s", (int)strcspn(words, "|"), words);
}

stp_status draw_options_open(const draw_options *o, const char *path, stp_model **model,
                             stp_error *err)
{
    stp_byte_source_params params = source_options_params(o->cache_folder, o->cache_bytes);
    return stp_model_open_at(model, path, &params, err);
}

/* The ends of the palette: what is asked for, else what the model has. */
static stp_status choose_range(const draw_options *o, const stp_model *model,
                               stp_draw_params *params, stp_error *err)
{
    double *range = params->colour_range;
    int used = 0;
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
    if (o->colour_range) {
        if (sscanf(o->colour_range, "%lf,%lf%n", &range[0], &range[1], &used) == 2 &&
            !o->colour_range[used] && range[0] < range[1] && isfinite(range[1] - range[0]))
            return STP_OK;
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--colour-range %s: give two numbers that rise, like 0.1,0.9",
                             o->colour_range);
    }
    if (params->colour == STP_COLOUR_INTENSITY || params->colour == STP_COLOUR_ELEVATION)
        return stp_model_colour_range(model, params->colour, range, err);
    return STP_OK;
}

stp_status draw_options_params(const draw_options *o, const stp_model *model,
                               stp_draw_params *params, stp_error *err)
{
    *params = (stp_draw_params){
        .lod = (stp_lod)o->lod,
        .reconstruct = (stp_reconstruct)o->reconstruct,
        .shade = (stp_shade)o->shade,
        .threshold_px = o->threshold_px,
        .every_sample = o->threshold_px <= 0.0,
        .radius_cap_px = o->radius_cap_px,
        .colour = (stp_colour)o->colour,
        .palette = (stp_palette)o->palette,
    };
    return choose_range(o, model, params, err);
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

stp_status draw_options_camera(const draw_options *o, const stp_model *model, stp_camera *camera,
                               int size[2], stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(camera_options_size(&o->camera, size, err));
    stp_camera c = stp_camera_default(&model->info->box, &model->ball, size[0], size[1]);
    STP_TRY(camera_options_apply(&o->camera, &c, err));
    *camera = c;
done:
    return status;
}
