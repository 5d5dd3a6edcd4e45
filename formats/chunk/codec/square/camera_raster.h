/* Rasters of cameras that look along an axis: all their numbers follow from where the camera is and
 * from its rays, which takes half the bytes. formats/SPEC.md, "Rasters", has the layout.
 * Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_CAMERA_RASTER_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_CAMERA_RASTER_H

#include "formats/chunk/codec/square/square.h"

/* Beside the axis, in the first byte of a raster. */
#define STP_CAMERA_RASTER 12u
#define STP_CAMERA_RASTER_BYTES 38u

/* Writes a raster and its first square. Returns the bytes, at most STP_CAMERA_RASTER_BYTES; 0: the
 * raster would not come back as it is. */
size_t stp_camera_raster_put(const stp_raster *raster, const stp_square *first, uint8_t *to);
/* Reads them. Returns the bytes; 0: there are not so many. */
size_t stp_camera_raster_get(const uint8_t *bytes, size_t left, stp_raster *raster,
                             stp_square *first);

#endif
