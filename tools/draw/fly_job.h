/* Everything that determines the frames, as strings by name: two runs with the same job make the
 * same frames. Threads: the main thread only. */
#ifndef STP_TOOLS_DRAW_FLY_JOB_H
#define STP_TOOLS_DRAW_FLY_JOB_H

#include "runtime/camera/path.h"
#include "runtime/cut/model.h"
#include "tools/cli/cli.h"

typedef struct fly_job_params {
    const stp_model *model;
    const stp_path *path;
    double rate;
    uint64_t frame_count;
    const int *size;
    const cli_option *options; /* drawing options; those that change no pixel are skipped */
    size_t option_count;
    const char *gl_renderer;
} fly_job_params;

/* Makes an object of strings; NULL if memory is exhausted. Free with cJSON_Delete. */
struct cJSON *fly_job_create(const fly_job_params *params);

#endif
