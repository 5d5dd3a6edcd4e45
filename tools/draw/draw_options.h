/* What render and view share: options of the camera, the quality and the budgets.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_DRAW_DRAW_OPTIONS_H
#define STP_TOOLS_DRAW_DRAW_OPTIONS_H

#include "runtime/cut/model.h"
#include "runtime/stipple.h"
#include "tools/draw/camera_options.h"
#include "tools/draw/draw_fine.h"

typedef struct draw_options {
    camera_options camera;
    const char *shader_folder, *cache_folder;
    double threshold_px, radius_cap_px;
    int lod, reconstruct, aa, shade, cull, colour, palette, home;
    const char *terms, *colour_range, *clip, *classes, *hidden_classes;
    double edl, overlay;
    double timeout_s; /* for a server; infinite: for ever */
    uint64_t gpu_memory, cpu_memory, cache_bytes;
    bool has_threshold, has_shade, allow_damage;
} draw_options;

#define DRAW_OPTION_COUNT (CAMERA_OPTION_COUNT + 25)

#define DRAW_DAMAGE_BYTES 1100

/* The words of stp_lod, stp_reconstruct, stp_home and stp_shade, in the order of their numbers. */
#define DRAW_LODS "auto|geometry|compute|cpu|full"
#define DRAW_RECONSTRUCTIONS "gauss|box|template3|template5|template7|splat|points"
#define DRAW_COLOURS "rgb|none|intensity|class|elevation|outliers|fit"
#define DRAW_PALETTES "auto|grey|viridis|heat"
#define DRAW_CULLS "auto|none|back"
#define DRAW_HOMES "first|whole"
#define DRAW_SHADES "phong|lambert|unlit|normal|depth|level|chunk|error|confidence"

/* The defaults, before parsing. */
draw_options draw_options_default(void);
/* Fills the first DRAW_OPTION_COUNT options of a command. */
void draw_options_fill(draw_options *o, cli_option out[DRAW_OPTION_COUNT]);
/* CLI_CONTINUE where the options make sense by themselves, else CLI_USAGE, and it is said. */
int draw_options_check(const draw_options *o, const cli_command *command);
/* One word of DRAW_LODS and the like. */
void draw_options_word(const char *words, int index, char out[16]);
/* Opens a model, a path or an address. Errors: those of stp_model_open_at. */
stp_status draw_options_open(const draw_options *o, const char *path, stp_model **model,
                             stp_error *err);
/* What the renderer wants of them. Errors: INVALID_ARGUMENT (the model has no such attribute, or a
 * range, clip box, list of classes, overlay or strength is none), those of reading the model's
 * root. */
stp_status draw_options_params(const draw_options *o, const stp_model *model,
                               stp_draw_params *params, stp_error *err);
stp_renderer_params draw_options_renderer(const draw_options *o, const stp_model *model,
                                          const cli_common *common);
/* The damage that the renderer met and what it draws instead, as a sentence; false if none. */
bool draw_options_damage(const stp_renderer *renderer, char out[DRAW_DAMAGE_BYTES]);
/* A picture that lacks a chunk is no picture unless --allow-damage says so. Errors: CORRUPT. */
stp_status draw_options_require_whole(const draw_options *o, const stp_renderer *renderer,
                                      stp_error *err);
/* Warns of damage on stderr, quiet or not. command: its name. */
void draw_options_warn(const char *command, const stp_renderer *renderer);
/* Which view --view asks for: eyes and cameras that are given begin from the whole model's. */
stp_home draw_options_home(const draw_options *o);
/* The camera: the model's view that --view asks for, then what --camera's file says, then the
 * options; and the picture's size. Errors: those of stp_camera_load; INVALID_ARGUMENT. */
stp_status draw_options_camera(const draw_options *o, const stp_model *model, stp_camera *camera,
                               int size[2], stp_error *err);

#endif
