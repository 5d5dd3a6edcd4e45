/* A folder of numbered frames and the job that they belong to.
 *
 * The folder has frame_000001.png and so on and, if wanted, frame_000001_depth.exr and
 * frame_000001_normals.exr. fly.json says which model, cameras and options made the frames. A
 * frame's picture is written last, and each file appears whole, so a frame whose picture exists is
 * done. Threads: the main thread only. */
#ifndef STP_TOOLS_DRAW_FLY_FOLDER_H
#define STP_TOOLS_DRAW_FLY_FOLDER_H

#include "tools/draw/draw_save.h"

#include <stdbool.h>
#include <stdint.h>

struct cJSON;

typedef struct fly_folder fly_folder;

typedef struct fly_folder_params {
    const char *path;
    const struct cJSON *job; /* an object of strings; used only while opening */
    bool depth, normals;     /* also write these */
    bool force;              /* remove all frames in this folder, whatever job made them */
} fly_folder_params;

/* Makes the folder, or continues in one whose fly.json has the same job. Errors: EXISTS (frames of
 * another or an unknown job; the message names the difference), IO, FORMAT (fly.json),
 * OUT_OF_MEMORY. */
stp_status fly_folder_open(fly_folder **out, const fly_folder_params *params, stp_error *err);
void fly_folder_close(fly_folder **folder);

/* The names of a frame's files, valid until the next call. Frames count from 1. */
draw_outputs fly_folder_files(fly_folder *folder, uint64_t number);
/* True if all files of the frame exist. */
bool fly_folder_has(fly_folder *folder, uint64_t number);

#endif
