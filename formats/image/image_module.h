/* The shim of OpenImageIO as a module that is loaded at its first use. Threads: any. */
#ifndef STP_FORMATS_IMAGE_IMAGE_MODULE_H
#define STP_FORMATS_IMAGE_IMAGE_MODULE_H

#include "base/error.h"
#include "formats/image/image_shim.h"

typedef struct stp_image_module {
    stp_oiio_result (*load)(const char *path, int *width, int *height, uint8_t **rgba,
                            char *message, size_t message_bytes);
    stp_oiio_result (*open_heights)(stp_oiio_heights **out, const char *path, int *width,
                                    int *height, int *band, char *message, size_t message_bytes);
    stp_oiio_result (*read_heights)(stp_oiio_heights *image, int begin, int end, float *heights,
                                    char *message, size_t message_bytes);
    void (*close_heights)(stp_oiio_heights *image);
    stp_oiio_result (*save)(const char *path, const char *format_name, int width, int height,
                            const uint8_t *rgba, char *message, size_t message_bytes);
    stp_oiio_result (*save_floats)(const char *path, const char *format_name,
                                   const stp_float_image *image, char *message,
                                   size_t message_bytes);
} stp_image_module;

/* Errors: UNSUPPORTED (the module, or a library that it needs, is missing; the message names it).
 */
stp_status stp_image_module_get(stp_image_module *out, stp_error *err);

#endif
