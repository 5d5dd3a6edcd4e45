/* Reads images of numbers row by row: heights, depths, disparities, colours.
 *
 * TIFF and BigTIFF by libtiff, in a module that is loaded with the first (integers of 1, 8, 16 and
 * 32 bits, floats of 32 and 64; strips or tiles; GeoTIFF's place, GDAL's no-data and scale; a mask
 * of heights inside the file becomes alpha), PNG by libpng, PFM and PGM (raster_pnm.c), ESRI ASCII
 * grids (raster_esri.c), Surfer (raster_surfer.c), HGT (raster_hgt.c), raw squares (raster_raw.c),
 * Alicona AL3D (raster_al3d.c), EXR by OpenImageIO, and as colours whatever OpenImageIO reads.
 * Numbers are the file's own: nothing is scaled. Memory: a band of rows; JPEG, interlaced PNG are
 * held whole. Threads: one at a time per raster. */
#ifndef STP_FORMATS_SCAN_GRID_RASTER_H
#define STP_FORMATS_SCAN_GRID_RASTER_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_RASTER_CHANNELS_LIMIT 4u
/* Most columns, and most rows. */
#define STP_RASTER_SIDE_LIMIT (1u << 24)

/* What is wanted of a file that may hold both. */
typedef enum stp_raster_use { STP_RASTER_HEIGHTS, STP_RASTER_COLOURS } stp_raster_use;

typedef struct stp_raster_info {
    const char *format; /* "TIFF", ... */
    uint32_t width, height;
    uint32_t reduced;  /* each pixel stands for so many columns and rows of the file's own image */
    uint32_t channels; /* 1 or 3, one more with alpha */
    bool alpha;        /* the last channel: 0 means that there is no sample */
    bool floats;
    double full; /* of integers: the number for full colour or alpha, 255 or 65535; else 1 */
    double scale, offset; /* a height is scale * number + offset; 0, 0: the file tells neither */
    bool has_none;
    double none; /* the number, as read, that stands for no sample */
    bool spaced;
    double dx, dy;  /* a column adds dx to x, a row takes dy from y; one may be negative, or 0 */
    double skew[2]; /* of turned images: what a column adds to y, and a row to x */
    bool placed;
    double x, y;       /* of the middle of the first pixel of the first row */
    bool degrees;      /* x and y are longitude and latitude */
    uint32_t epsg;     /* of its coordinate system; 0: not told */
    uint32_t vertical; /* of the system of its heights; likewise */
} stp_raster_info;

typedef struct stp_raster_file stp_raster_file;

/* Whether a file that begins with these bytes is of a kind that may hold heights. 16 are enough. */
bool stp_raster_may_hold_heights(const char *bytes, size_t length);
/* Whether the name tells that a file holds heights. Only HGT begins with nothing that would. */
bool stp_raster_is_named(const char *path);
/* Whether name and size tell that a file is a height map without a header (raster_raw.c). */
bool stp_raster_is_raw(const char *path, uint64_t size);
/* step: only every so manieth column and row is of interest, so that a smaller copy of the image,
 * which the file may have for overviews, will do; info tells of that copy. 1: each is. path must
 * outlive the raster. Errors: NOT_FOUND, IO, FORMAT (no raster), CORRUPT, UNSUPPORTED (kinds of
 * numbers), LIMIT, OUT_OF_MEMORY. */
stp_status stp_raster_open(stp_raster_file **out, const char *path, stp_raster_use use,
                           uint32_t step, stp_error *err);
const stp_raster_info *stp_raster_get_info(const stp_raster_file *raster);
/* Reads a row below the last one that was read, row 0 is the top: width * channels numbers.
 * Errors: IO, CORRUPT. */
stp_status stp_raster_read(stp_raster_file *raster, uint32_t row, double *values, stp_error *err);
void stp_raster_close(stp_raster_file **raster);

/* ---- for the readers of formats ---- */

typedef struct stp_raster_reader {
    size_t state_bytes;
    bool each; /* every row is asked for; else rows may be left out */
    /* state is zero. Fills info. */
    stp_status (*open)(void *state, stp_raster_info *info, const char *path, stp_raster_use use,
                       uint32_t step, stp_error *err);
    /* Rows are asked for in order, none twice. */
    stp_status (*read)(void *state, uint32_t row, double *values, stp_error *err);
    void (*close)(void *state); /* also after a failed open */
} stp_raster_reader;

extern const stp_raster_reader stp_raster_tiff; /* in the module libstipple-tiff.so */
extern const stp_raster_reader stp_raster_png, stp_raster_pnm, stp_raster_esri, stp_raster_hgt,
    stp_raster_surfer, stp_raster_al3d, stp_raster_raw, stp_raster_image;

#endif
