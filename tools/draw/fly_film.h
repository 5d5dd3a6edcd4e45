/* Makes a film: sends frames to an installed ffmpeg through a socket, without a shell.
 *
 * The film appears whole or not at all: ffmpeg writes to a file beside the name, and a film that is
 * not committed is removed. H.264 in yuv420p for .mp4 .mov .mkv, VP9 for .webm. If the picture has
 * an odd number of rows or columns, one more of background is added. Threads: the main thread only.
 */
#ifndef STP_TOOLS_DRAW_FLY_FILM_H
#define STP_TOOLS_DRAW_FLY_FILM_H

#include "base/error.h"
#include "base/progress.h"

#include <stdint.h>

typedef struct fly_film fly_film;

typedef struct fly_film_params {
    const char *path;
    int width, height;
    double rate; /* frames a second */
    bool force;
} fly_film_params;

/* True if the name's ending is that of a film. */
bool fly_film_is_name(const char *path);

/* Starts ffmpeg. Errors: EXISTS, IO, NOT_FOUND (no ffmpeg), UNSUPPORTED (unknown ending),
 * OUT_OF_MEMORY. */
stp_status fly_film_create(fly_film **out, const fly_film_params *params, stp_error *err);
/* Sends one frame: width * height * 4 bytes, top row first. Waits for ffmpeg and asks progress only
 * whether to cancel. Errors: IO (with ffmpeg's last message), CANCELLED. */
stp_status fly_film_write(fly_film *film, const uint8_t *rgba, const stp_progress *progress,
                          stp_error *err);
/* Waits until ffmpeg is done and makes the film appear. Destroys *film in any case. Errors: IO,
 * EXISTS, CANCELLED. */
stp_status fly_film_commit(fly_film **film, const stp_progress *progress, stp_error *err);
/* Ends ffmpeg and removes what it wrote. */
void fly_film_destroy(fly_film **film);

#endif
