/* OpenImageIO as C: 8-bit RGBA pixels, straight alpha, and floats; top row first. */
#ifndef STP_FORMATS_IMAGE_IMAGE_SHIM_H
#define STP_FORMATS_IMAGE_IMAGE_SHIM_H

#include "formats/image/image.h"

#include <stddef.h>
#include <stdint.h>

typedef struct stp_oiio_heights stp_oiio_heights;

typedef enum stp_oiio_result {
    STP_OIIO_OK = 0,
    STP_OIIO_UNKNOWN_FORMAT,
    STP_OIIO_DAMAGED,
    STP_OIIO_NO_MEMORY,
    STP_OIIO_DISK_FULL,
    STP_OIIO_FAILED
} stp_oiio_result;

/* *rgba is malloc'ed. message (message_bytes > 0) gets the library's reason in one line. */
stp_oiio_result stp_oiio_load(const char *path, int *width, int *height, uint8_t **rgba,
                              char *message, size_t message_bytes);
/* Opens an image for one channel of floats: the only one, or that named Z, depth or height. *band:
 * rows that the file has together, from a multiple of it on. Close *out with
 * stp_oiio_close_heights. */
stp_oiio_result stp_oiio_open_heights(stp_oiio_heights **out, const char *path, int *width,
                                      int *height, int *band, char *message, size_t message_bytes);
/* Reads rows begin to end - 1 into heights. */
stp_oiio_result stp_oiio_read_heights(stp_oiio_heights *image, int begin, int end, float *heights,
                                      char *message, size_t message_bytes);
void stp_oiio_close_heights(stp_oiio_heights *image);
/* The ending of format_name chooses the format. The file is written to path. */
stp_oiio_result stp_oiio_save(const char *path, const char *format_name, int width, int height,
                              const uint8_t *rgba, char *message, size_t message_bytes);
/* The same for 32-bit floats, with the names of their channels and with notes. */
stp_oiio_result stp_oiio_save_floats(const char *path, const char *format_name,
                                     const stp_float_image *image, char *message,
                                     size_t message_bytes);

#endif
