/* Reads floats from an image file with another reader than ours (OpenImageIO's). */
#ifndef STP_TESTS_SUPPORT_EXR_SHIM_H
#define STP_TESTS_SUPPORT_EXR_SHIM_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define EXR_TEXT_BYTES 1024

typedef struct exr_image {
    int width, height, channel_count;
    char channels[64];           /* names, separated by spaces */
    char camera[EXR_TEXT_BYTES]; /* the note stipple:camera */
    float *values;               /* free with free(); top row first */
} exr_image;

/* Returns 0, or -1 if the file is no image of 32-bit floats. */
int exr_image_read(const char *path, exr_image *out);

#ifdef __cplusplus
}
#endif

#endif
