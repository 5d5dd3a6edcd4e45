/* The bytes of a raster and of the square that its first one counts from (SPEC.md, "Rasters").
 * Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_RASTER_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_RASTER_H

#include "formats/chunk/codec/square/square.h"

#define STP_RASTER_BYTES_MOST 65u

/* Writes at most STP_RASTER_BYTES_MOST. Returns the bytes. */
size_t stp_raster_put(const stp_raster *raster, const stp_square *first, uint8_t *out);
/* Returns the bytes; 0: there are not so many. Checks no number. first: column and row are set. */
size_t stp_raster_get(const uint8_t *bytes, size_t left, bool tilted, stp_raster *raster,
                      stp_square *first);

#endif
