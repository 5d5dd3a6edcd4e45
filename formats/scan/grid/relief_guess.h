/* Guesses how far the samples of heights are apart if their file does not tell.
 *
 * Landscapes for games are saved as whole numbers that use all 16 bits, or as floats from 0 to 1,
 * and the spacing is known to the engine alone. With a spacing of 1 the former are needles, and the
 * latter are flat. The relief is the difference of heights, without 1 of 1000 at either end. A
 * spacing is guessed if the file tells no spacing, place or scale, has 32 columns and rows, and
 * - its numbers have more than 8 bits, and the relief exceeds the longer side; or
 * - they are floats from 0 to 1, and the longer side exceeds the relief FLAT times.
 * It is the least power of two by which the relief is a quarter of the longer side at most. Numbers
 * stay as they are. Threads: any. */
#ifndef STP_FORMATS_SCAN_GRID_RELIEF_GUESS_H
#define STP_FORMATS_SCAN_GRID_RELIEF_GUESS_H

#include "formats/scan/scan.h"

/* Sets dx and dy of params, and `note`, a sentence that says so and how to say otherwise. Leaves
 * both if nothing is guessed, or if a pinhole, a spacing or a scale is given. Reads up to a quarter
 * of a thousand rows, of a PNG or PGM all. Errors: those of raster.h. */
stp_status stp_relief_guess(stp_grid_params *params, char *note, size_t note_bytes,
                            const char *path, stp_error *err);

#endif
