/* Options of the drawing commands. */
#include "tools/draw_options.h"

#include <stdio.h>
#include <string.h>

draw_options draw_options_default(void)
{
    return (draw_options){.fovy_deg = STP_CAMERA_FOVY_DEG,
                          .threshold_px = 1.0,
                          .radius_cap_px = STP_RADIUS_CAP_PX,
                          .size = {1024, 1024},
                          .gpu_memory = UINT64_C(1) << 30,
                          .cpu_memory = UINT64_C(1) << 30};
}

void draw_options_fill(draw_options *o, cli_option out[DRAW_OPTION_COUNT])
{
    const cli_option options[DRAW_OPTION_COUNT] = {
        {"--size", 0, CLI_EXTENT, o->size, "WxH", "of the picture in pixels (1024x1024)",
         &o->has_size},
        {"--camera", 0, CLI_STRING, &o->camera_path, "C.json", "eye look up fovy_deg (or height)",
         NULL},
        {"--eye", 0, CLI_VEC3, o->eye, "x,y,z", "where the eye is (default: sees the whole model)",
         &o->has_eye},
        {"--look", 0, CLI_VEC3, o->look, "x,y,z", "what it looks at", &o->has_look},
        {"--up", 0, CLI_VEC3, o->up, "x,y,z", "which way is up", &o->has_up},
        {"--fovy", 0, CLI_NUMBER, &o->fovy_deg, "DEG", "vertical angle of view (45)", &o->has_fovy},
        {"--threshold", 0, CLI_NUMBER, &o->threshold_px, "PX",
         "greatest error on the screen (1); 0: every sample", &o->has_threshold},
        {"--radius-cap", 0, CLI_NUMBER, &o->radius_cap_px, "PX",
         "coarser samples are not drawn larger (6)", NULL},
        {"--lod", 0, CLI_CHOICE, &o->lod, DRAW_LODS,
         "who chooses levels: geometry shader, CPU, or nobody", NULL},
        {"--reconstruct", 0, CLI_CHOICE, &o->reconstruct, DRAW_RECONSTRUCTIONS,
         "how gaps are closed", NULL},
        {"--shade", 0, CLI_CHOICE, &o->shade, DRAW_SHADES, "what is shown", NULL},
        {"--colour", 0, CLI_CHOICE, &o->colour, "rgb|none", "of the samples", NULL},
        {"--color", 0, CLI_CHOICE, &o->colour, "rgb|none", NULL, NULL},
        {"--gpu-memory", 0, CLI_BYTES, &o->gpu_memory, "SIZE", "for samples on the GPU (1G)", NULL},
        {"--cpu-memory", 0, CLI_BYTES, &o->cpu_memory, "SIZE", "for chunks being decoded (1G)",
         NULL},
        {"--shaders", 0, CLI_STRING, &o->shader_folder, "DIR",
         "shader files there win over the built-in ones", NULL},
    };
    memcpy(out, options, sizeof options);
}

void draw_options_word(const char *words, int index, char out[16])
{
    while (index-- > 0)
        words += strcspn(words, "|") + 1;
    snprintf(out, 16, "%.*s", (int)strcspn(words, "|"), words);
}

stp_draw_params draw_options_params(const draw_options *o)
{
    return (stp_draw_params){
        .lod = (stp_lod)o->lod,
        .reconstruct = (stp_reconstruct)o->reconstruct,
        .shade = (stp_shade)o->shade,
        .threshold_px = o->threshold_px,
        .every_sample = o->threshold_px <= 0.0,
        .radius_cap_px = o->radius_cap_px,
        .no_colour = o->colour == 1,
    };
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

static void take(stp_dvec3 *out, const double v[3], bool given)
{
    if (given)
        *out = (stp_dvec3){v[0], v[1], v[2]};
}

stp_status draw_options_camera(const draw_options *o, const stp_model *model, stp_camera *camera,
                               int size[2], stp_error *err)
{
    stp_camera file = {0};
    bool has_file = o->camera_path != NULL;
    size[0] = o->size[0];
    size[1] = o->size[1];
    if (has_file) { /* for its size alone: the default view depends on it */
        stp_status status = stp_camera_load(&file, o->camera_path, err);
        if (status != STP_OK)
            return status;
        for (int i = 0; i < 2; i++)
            if (!o->has_size && file.size[0] > 0 && file.size[1] > 0)
                size[i] = file.size[i];
    }
    stp_camera c = stp_camera_default(&model->info->box, &model->ball, size[0], size[1]);
    if (has_file) {
        stp_status status = stp_camera_load(&c, o->camera_path, err);
        if (status != STP_OK)
            return status;
    }
    take(&c.eye, o->eye, o->has_eye);
    take(&c.look, o->look, o->has_look);
    take(&c.up, o->up, o->has_up);
    if (o->has_fovy) {
        c.fovy_deg = o->fovy_deg;
        c.height = 0.0;
    }
    *camera = c;
    return STP_OK;
}
