/* Guesses that an image without a place is a depth camera's, and its pinhole.
 *
 * All of this must hold:
 * - integers of 9 to 16 bits, or floats, in one channel; no spacing, place, scale or no-data;
 * - the size is one of usual depth cameras;
 * - 0.2 to 95 % of the pixels are zero, and nearly all pixels beside a zero are far above it;
 * - the least depths are at least 100, and a fortieth of the greatest: heights begin at small
 *   numbers, or lie close together;
 * - at most a tenth of the pixels beside each other jump by a twentieth of the depth;
 * - planes are seen in perspective. A window is a tenth of the width long, and its ends differ by a
 *   sixth. In perspective 1 / depth is linear in it, on a slope depth is. Twice as many windows
 * must be the former. If fewer than 500 windows are either, this must hold instead: 0.05 % of the
 *   pixels jump as above, 80 % of the zeros lie in runs of 8 or more, and depths are within 10 m.
 *
 * Floats are metres, and NaN counts as zero.
 *
 * Whoever gives several images of one size decides for all of them (`series`): half of them
 * suffice.
 *
 * Does not look at disparities or colours. Threads: any. */
#ifndef STP_FORMATS_SCAN_GRID_DEPTH_GUESS_H
#define STP_FORMATS_SCAN_GRID_DEPTH_GUESS_H

#include "formats/scan/scan.h"

/* What an image is by itself. focal, in pixels, 0: it can't be a depth camera's. scale 0: it is
 * not. */
typedef struct stp_depth_look {
    double focal;
    uint32_t width, height;
    bool floats;
    double scale;
} stp_depth_look;

/* Reads the whole file, if it has such a size. Errors: those of raster.h. */
stp_status stp_depth_look_at(stp_depth_look *out, const char *path, stp_error *err);

/* Fills in the pinhole and, where it is 0, the scale of params (metres), and `note`, a sentence
 * that says so and how to say otherwise; leaves both as they are if it is no depth image, or if a
 * pinhole or a spacing is given. Reads the whole file, unless the series is known. Errors: those of
 * raster.h. */
stp_status stp_depth_guess(stp_grid_params *params, char *note, size_t note_bytes, const char *path,
                           stp_error *err);

#endif
