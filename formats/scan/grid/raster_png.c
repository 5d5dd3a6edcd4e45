/* Reads PNG of 8 or 16 bits row by row by libpng. */
#include "base/memory.h"
#include "formats/scan/grid/raster.h"

#include <png.h>

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Bytes: files whose rows do not come in order are held whole. */
#define INTERLACED_LIMIT ((size_t)1 << 31)

typedef struct png_raster {
    const char *path;
    FILE *file;
    png_structp png;
    png_infop info;
    unsigned char *row;   /* one, or all of an interlaced file */
    unsigned char **rows; /* of an interlaced file */
    size_t row_bytes, row_values;
    bool wide; /* 16 bits */
    char message[128];
} png_raster;

static void fail(png_structp png, png_const_charp message)
{
    png_raster *p = png_get_error_ptr(png);
    snprintf(p->message, sizeof p->message, "%s", message);
    png_longjmp(png, 1);
}

static void warn(png_structp png, png_const_charp message)
{
    (void)png;
    (void)message;
}

static stp_status damaged(const png_raster *p, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT, "%s: the PNG is damaged: %s: copy or export it again",
                         p->path, p->message);
}

/* Reads the header and asks for whole bytes, no palettes. False: it is damaged. */
static bool read_header(png_raster *p, stp_raster_info *info, int *passes)
{
    if (setjmp(png_jmpbuf(p->png)) != 0)
        return false;
    png_init_io(p->png, p->file);
    png_read_info(p->png, p->info);
    const png_byte bits = png_get_bit_depth(p->png, p->info);
    const png_byte kind = png_get_color_type(p->png, p->info);
    if (kind == PNG_COLOR_TYPE_PALETTE)
        png_set_palette_to_rgb(p->png);
    if (png_get_valid(p->png, p->info, PNG_INFO_tRNS))
        png_set_tRNS_to_alpha(p->png);
    if (bits < 8)
        png_set_packing(p->png); /* heights of 1 to 4 bits stay as they are */
    *passes = png_set_interlace_handling(p->png);
    png_read_update_info(p->png, p->info);
    p->wide = png_get_bit_depth(p->png, p->info) == 16;
    p->row_bytes = png_get_rowbytes(p->png, p->info);
    *info = (stp_raster_info){
        .format = "PNG",
        .width = png_get_image_width(p->png, p->info),
        .height = png_get_image_height(p->png, p->info),
        .channels = png_get_channels(p->png, p->info),
        .alpha = (png_get_color_type(p->png, p->info) & PNG_COLOR_MASK_ALPHA) != 0,
        .full = p->wide                                   ? 65535.0
                : bits < 8 && kind == PNG_COLOR_TYPE_GRAY ? (double)((1 << bits) - 1)
                                                          : 255.0};
    p->row_values = (size_t)info->width * info->channels;
    return p->row_bytes >= p->row_values * (p->wide ? 2 : 1);
}

static bool read_all(png_raster *p)
{
    if (setjmp(png_jmpbuf(p->png)) != 0)
        return false;
    png_read_image(p->png, p->rows);
    return true;
}

static bool read_one(png_raster *p)
{
    if (setjmp(png_jmpbuf(p->png)) != 0)
        return false;
    png_read_row(p->png, p->row, NULL);
    return true;
}

static stp_status open_png(void *state, stp_raster_info *info, const char *path, stp_raster_use use,
                           uint32_t step, stp_error *err)
{
    png_raster *p = state;
    stp_status status = STP_OK;
    int passes = 1;
    (void)use;
    (void)step;
    p->path = path;
    p->file = fopen(path, "rb");
    if (p->file == NULL)
        return stp_error_set(err, STP_IO, "%s cannot be read: %s", path, strerror(errno));
    p->png = png_create_read_struct(PNG_LIBPNG_VER_STRING, p, fail, warn);
    p->info = p->png != NULL ? png_create_info_struct(p->png) : NULL;
    if (p->info == NULL)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to open %s", path);
    if (!read_header(p, info, &passes))
        return damaged(p, err);
    if (passes == 1) {
        STP_TRY(stp_alloc(&p->row, p->row_bytes, 1, "a row of an image", err));
        goto done;
    }
    if (info->height > INTERLACED_LIMIT / p->row_bytes)
        return stp_error_set(err, STP_LIMIT,
                             "%s is interlaced and %u x %u, too large to be held whole: save it "
                             "without interlacing",
                             path, info->width, info->height);
    STP_TRY(stp_alloc(&p->row, info->height, p->row_bytes, "an interlaced image", err));
    STP_TRY(stp_alloc(&p->rows, info->height, sizeof *p->rows, "an interlaced image", err));
    for (uint32_t i = 0; i < info->height; i++)
        p->rows[i] = p->row + i * p->row_bytes;
    if (!read_all(p))
        status = damaged(p, err);
done:
    return status;
}

static stp_status read_png(void *state, uint32_t row, double *values, stp_error *err)
{
    png_raster *p = state;
    if (p->rows == NULL && !read_one(p))
        return damaged(p, err);
    const unsigned char *in = p->rows != NULL ? p->rows[row] : p->row;
    for (size_t i = 0; i < p->row_values; i++)
        values[i] = p->wide ? (double)(in[2 * i] << 8 | in[2 * i + 1]) : (double)in[i];
    return STP_OK;
}

static void close_png(void *state)
{
    png_raster *p = state;
    if (p->png != NULL)
        png_destroy_read_struct(&p->png, &p->info, NULL);
    if (p->file != NULL)
        fclose(p->file);
    free(p->row);
    free(p->rows);
}

const stp_raster_reader stp_raster_png = {.state_bytes = sizeof(png_raster),
                                          .each = true,
                                          .open = open_png,
                                          .read = read_png,
                                          .close = close_png};
