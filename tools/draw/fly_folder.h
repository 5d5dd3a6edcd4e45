/* A folder of numbered frames and the job they belong to.
 *
 * frame_000001.png and so on, with frame_000001_depth.exr and frame_000001_normals.exr where they
 * are wanted, and fly.json, which says of what model, cameras and options they are. A frame's
 * picture is written last, and each file appears whole: a frame that is there is done. Threads: the
 * main thread only. */
#ifndef STP_TOOLS_DRAW_FLY_FOLDER_H
#define STP_TOOLS_DRAW_FLY_FOLDER_H

#include "tools/draw/draw_save.h"

#include <stdbool.h>
#include <stdint.h>

struct cJSON;

typedef struct fly_folder fly_folder;

typedef struct fly_folder_params {
    const char *path;
    const struct cJSON *job; /* an object of texts; only used while opening */
    bool depth, normals;     /* beside the pictures */
    bool force;              /* frames of this folder go, whatever they are of */
} fly_folder_params;

/* Makes the folder, or goes on in one whose fly.json says the same job. Errors: EXISTS (frames of
 * another job, or of none known: what differs is named), IO, FORMAT (fly.json), OUT_OF_MEMORY. */
stp_status fly_folder_open(fly_folder **out, const fly_folder_params *params, stp_error *err);
void fly_folder_close(fly_folder **folder);

/* Names of a frame's files, numbered from 1; valid until the next call. */
draw_outputs fly_folder_files(fly_folder *folder, uint64_t number);
/* Whether all of them are there. */
bool fly_folder_has(fly_folder *folder, uint64_t number);

#endif
