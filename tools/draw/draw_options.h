/* The options that render and view share: camera, quality and memory. Threads: the main thread
 * only. */
#ifndef STP_TOOLS_DRAW_DRAW_OPTIONS_H
#define STP_TOOLS_DRAW_DRAW_OPTIONS_H

#include "runtime/cut/model.h"
#include "runtime/stipple.h"
#include "tools/draw/camera_options.h"
#include "tools/draw/draw_fine.h"
#include "tools/open/open_scan.h"

typedef struct draw_options {
    camera_options camera;
    const char *shader_folder, *cache_folder;
    double threshold_px, radius_cap_px;
    int lod, reconstruct, aa, shade, cull, occlusion, grid_draw, maps_as, colour, palette, home;
    const char *colour_name, *attribute; /* --colour; the attribute that it names; NULL: none */
    const char *terms, *colour_range, *contours, *light, *clip, *classes, *hidden_classes, *where;
    double edl, overlay, exaggerate;
    double timeout_s; /* waiting for a server; infinite: for ever */
    uint64_t gpu_memory, cpu_memory, cache_bytes;
    bool has_threshold, has_shade, has_cache_bytes, no_cache, allow_damage;
} draw_options;

#define DRAW_OPTION_COUNT (CAMERA_OPTION_COUNT + 33)
#define DRAW_SOURCE_OPTION_COUNT 8 /* the last ones: of what is read and held */
/* Those in between, without --view, change the picture and leave the camera where it is. */
#define DRAW_LOOK_OPTION (CAMERA_OPTION_COUNT + 1)
#define DRAW_LOOK_OPTION_COUNT (DRAW_OPTION_COUNT - DRAW_LOOK_OPTION - DRAW_SOURCE_OPTION_COUNT)

#define DRAW_DAMAGE_BYTES 1100

/* The words of stp_lod, stp_reconstruct, stp_home and stp_shade, in the order of their numbers. */
#define DRAW_LODS "auto|geometry|compute|cpu|full"
#define DRAW_RECONSTRUCTIONS "gauss|box|template3|template5|template7|splat|points"
#define DRAW_COLOURS "rgb|none|intensity|class|elevation|outliers|fit"
#define DRAW_PALETTES "auto|grey|viridis|heat"
#define DRAW_CULLS "auto|none|back"
#define DRAW_OCCLUSIONS "auto|on|off"
#define DRAW_GRIDS "auto|points|triangles"
#define DRAW_MAPS "auto|mesh|splats|blend|plain|points"
#define DRAW_HOMES "first|whole"
#define DRAW_SHADES "phong|lambert|unlit|normal|depth|level|chunk|error|confidence|primitive"

/* The defaults, before parsing. */
draw_options draw_options_default(void);
/* Fills the first DRAW_OPTION_COUNT options of a command. */
void draw_options_fill(draw_options *o, cli_option out[DRAW_OPTION_COUNT]);
/* Checks the options by themselves and reads --colour. Returns CLI_CONTINUE, or prints a message
 * and returns CLI_USAGE, or CLI_FAILED for a condition that is none. */
int draw_options_check(draw_options *o, const cli_command *command);
/* Gets one word of DRAW_LODS and the like. */
void draw_options_word(const char *words, int index, char out[16]);
/* How scans are opened (open_scan.h). command: its name. */
open_scan_params draw_options_scan(const draw_options *o, const char *command,
                                   const cli_common *common);
/* Shows the attribute that --colour names, if it names one, and chooses what --where says. Errors:
 * those of stp_model_show_attribute and stp_model_choose. */
stp_status draw_options_show(const draw_options *o, stp_model *model, stp_error *err);
/* Opens a model by path or address, as draw_options_show shows it. Errors: those of
 * stp_model_open_at and draw_options_show. */
stp_status draw_options_open_model(const draw_options *o, const char *path, stp_model **model,
                                   stp_error *err);
/* Opens a model by path or address, or the model of one or several scans, which are prepared first
 * unless the cache has them. Errors: those of stp_model_open_at and open_scan.h; INVALID_ARGUMENT
 * (a model and something else). */
stp_status draw_options_open(const draw_options *o, const open_scan_params *params,
                             const char *const *paths, size_t count, stp_model **model,
                             stp_error *err);
/* Converts the options to the renderer's parameters. Errors: INVALID_ARGUMENT (the model lacks the
 * attribute, or a range, clip box, list of classes, overlay or strength is invalid), those of
 * reading the model's root. */
stp_status draw_options_params(const draw_options *o, const stp_model *model,
                               stp_draw_params *params, stp_error *err);
stp_renderer_params draw_options_renderer(const draw_options *o, const stp_model *model,
                                          const cli_common *common);
/* Writes a sentence about the damage that the renderer met and what it draws instead. False if
 * there is none. */
bool draw_options_damage(const stp_renderer *renderer, char out[DRAW_DAMAGE_BYTES]);
/* Fails if the picture lacks a chunk, unless --allow-damage is given. Errors: CORRUPT. */
stp_status draw_options_require_whole(const draw_options *o, const stp_renderer *renderer,
                                      stp_error *err);
/* Warns of damage on stderr, also with --quiet. command: its name. */
void draw_options_warn(const char *command, const stp_renderer *renderer);
/* The ball of a model as the picture shows it: larger if heights are exaggerated. */
stp_ball draw_options_ball(const draw_options *o, const stp_model *model);
/* The start view that --view and --exaggerate ask for. */
stp_camera draw_options_start(const draw_options *o, const stp_model *model, const int size[2]);
/* Gets the camera and the picture's size. The model's view of --view comes first, then the file of
 * --camera, then the options. Errors: those of stp_camera_load; INVALID_ARGUMENT. */
stp_status draw_options_camera(const draw_options *o, const stp_model *model, stp_camera *camera,
                               int size[2], stp_error *err);

#endif
