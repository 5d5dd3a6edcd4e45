/* The camera options of gen, render and view: from where a picture is seen. Threads: the main
 * thread only. */
#ifndef STP_TOOLS_DRAW_CAMERA_OPTIONS_H
#define STP_TOOLS_DRAW_CAMERA_OPTIONS_H

#include "base/vec.h"
#include "runtime/camera/camera.h"
#include "tools/cli/cli.h"

typedef struct camera_options {
    const char *path; /* path of a JSON file, or NULL */
    double eye[3], look[3], up[3];
    double fovy_deg;
    int size[2];
    bool has_eye, has_look, has_up, has_fovy, has_size;
} camera_options;

#define CAMERA_OPTION_COUNT 6

/* The defaults, before parsing. */
camera_options camera_options_default(void);
/* Fills the first CAMERA_OPTION_COUNT options of a command. */
void camera_options_fill(camera_options *o, cli_option out[CAMERA_OPTION_COUNT]);
/* Gets the picture's size from the option, else from the file, else the default. Errors: those of
 * stp_camera_load. */
stp_status camera_options_size(const camera_options *o, int size[2], stp_error *err);
/* Replaces parts of *camera: first by what the file gives, then by what the options give. Errors:
 * those of stp_camera_load; *camera is untouched then. */
stp_status camera_options_apply(const camera_options *o, stp_camera *camera, stp_error *err);

#endif
