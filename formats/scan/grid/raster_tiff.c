/* Reads TIFF by libtiff. */
#include "base/memory.h"
#include "formats/scan/grid/tiff_geo.h"

#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Channels that lie one after another are read in whole strips, of at most so many bytes. */
#define STRIP_BYTES_MOST (UINT64_C(1) << 28)

typedef struct tiff_raster tiff_raster;
struct tiff_raster {
    const char *path;
    TIFF *tiff;
    uint32_t width, height, channels;
    uint16_t bits, kind; /* SAMPLEFORMAT_* */
    bool apart;          /* each channel has tiles or strips of its own */
    tiff_raster *mask;   /* another image of the file, opened anew: 0 where there is no sample */
    double *mask_row;
    bool has_alpha;
    uint32_t tile_width, band_rows; /* tile_width 0: strips */
    uint32_t band_width;            /* that of all tiles */
    uint32_t strip_rows;            /* of packed strips; else 0 */
    unsigned char *band, *piece;    /* piece: one tile */
    uint32_t band_begin, band_end;
    uint16_t predictor; /* PREDICTOR_* that rows of the band still have; 0: none */
    char message[256];  /* libtiff's last error */
};

static int keep_error(TIFF *tiff, void *context, const char *module, const char *format,
                      va_list arguments)
{
    tiff_raster *t = context;
    (void)tiff;
    (void)module;
    vsnprintf(t->message, sizeof t->message, format, arguments);
    t->message[strcspn(t->message, "\n")] = '\0';
    return 1;
}

/* Warnings are about tags that nobody here asks for. */
static int drop_warning(TIFF *tiff, void *context, const char *module, const char *format,
                        va_list arguments)
{
    (void)tiff;
    (void)context;
    (void)module;
    (void)format;
    (void)arguments;
    return 1;
}

static stp_status damaged(const tiff_raster *t, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT, "%s: the TIFF is damaged: %s: copy or export it again",
                         t->path, t->message[0] ? t->message : "it ends early");
}

/* Whether numbers of this kind can be read: 1, 8, 16 or 32 bits, floats of 32 or 64. */
static bool is_read(const tiff_raster *t)
{
    if (t->kind == SAMPLEFORMAT_IEEEFP)
        return t->bits == 32 || t->bits == 64;
    return (t->kind == SAMPLEFORMAT_UINT || t->kind == SAMPLEFORMAT_INT) &&
           (t->bits == 8 || t->bits == 16 || t->bits == 32 || (t->bits == 1 && t->channels == 1));
}

/* Whether libtiff makes RGB of the image's colours, as JPEG has them. */
static bool makes_rgb(const tiff_raster *t)
{
    uint16_t compression = COMPRESSION_NONE;
    return TIFFGetField(t->tiff, TIFFTAG_COMPRESSION, &compression) &&
           compression == COMPRESSION_JPEG &&
           TIFFSetField(t->tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
}

static stp_status check_kind(const tiff_raster *t, uint16_t photometric, stp_error *err)
{
    if (photometric == PHOTOMETRIC_PALETTE || (photometric == PHOTOMETRIC_YCBCR && !makes_rgb(t)) ||
        photometric == PHOTOMETRIC_LOGLUV || photometric == PHOTOMETRIC_CIELAB)
        return stp_error_set(
            err, STP_UNSUPPORTED,
            "%s: its numbers are colours, but no RGB: it is no grid of heights; for "
            "--colour convert it (gdal_translate -expand rgb, or ImageMagick's "
            "convert -type TrueColor)",
            t->path);
    if (!is_read(t))
        return stp_error_set(
            err, STP_UNSUPPORTED,
            "%s: its numbers have %u bit%s: integers of 1, 8, 16, 32 and floats of 32, "
            "64 bits are read (gdal_translate -ot Float32 converts)",
            t->path, t->bits, t->bits == 1 ? " in each channel" : "s");
    return STP_OK;
}

/* Finds the mask of an image of this size: GDAL's, for all channels. 0: there is none, as the first
 * image of a file is no mask. */
static tdir_t find_mask(TIFF *tiff, uint32_t width, uint32_t height)
{
    const tdir_t here = TIFFCurrentDirectory(tiff);
    tdir_t found = 0;
    (void)TIFFSetDirectory(tiff, 0);
    while (found == 0 && TIFFReadDirectory(tiff)) {
        uint32_t type = 0, size[2] = {0, 0};
        (void)TIFFGetField(tiff, TIFFTAG_SUBFILETYPE, &type);
        (void)TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &size[0]);
        (void)TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &size[1]);
        if (type & FILETYPE_MASK && size[0] == width && size[1] == height)
            found = TIFFCurrentDirectory(tiff);
    }
    (void)TIFFSetDirectory(tiff, here);
    return found;
}

/* *is_masked: whether the file has a mask of its heights. */
static stp_status check_heights(const tiff_raster *t, uint16_t photometric, bool *is_masked,
                                stp_error *err)
{
    if (photometric == PHOTOMETRIC_RGB || photometric == PHOTOMETRIC_YCBCR)
        return STP_OK; /* whoever wants heights refuses them */
    *is_masked = find_mask(t->tiff, t->width, t->height) > 0;
    if (t->channels > (t->has_alpha ? 2u : 1u))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s has %u bands, and none of them is named the heights: "
                             "gdal_translate -b 1 takes the first",
                             t->path, t->channels);
    return STP_OK;
}

/* ---- bands of rows ---- */

/* Bytes of so many pixels of a row. */
static uint64_t row_bytes(const tiff_raster *t, uint64_t pixels)
{
    return (pixels * t->channels * t->bits + 7) / 8;
}

static uint64_t piece_row_bytes(const tiff_raster *t, uint64_t pixels)
{
    return t->apart ? pixels * t->bits / 8 : row_bytes(t, pixels);
}

/* Finds how many rows a band has and how large its pieces are. */
static stp_status find_pieces(tiff_raster *t, uint64_t *piece_bytes, stp_error *err)
{
    t->band_width = t->width;
    t->band_rows = 1;
    if (TIFFIsTiled(t->tiff)) {
        (void)TIFFGetField(t->tiff, TIFFTAG_TILEWIDTH, &t->tile_width);
        (void)TIFFGetField(t->tiff, TIFFTAG_TILELENGTH, &t->band_rows);
        if (t->tile_width == 0 || t->tile_width > 2 * STP_RASTER_SIDE_LIMIT ||
            t->tile_width * t->bits % 8 != 0 || t->band_rows == 0)
            return stp_error_set(err, STP_CORRUPT, "%s: its tiles have no size, or are too wide",
                                 t->path);
        t->band_width = (t->width + t->tile_width - 1) / t->tile_width * t->tile_width;
        *piece_bytes = (uint64_t)TIFFTileSize64(t->tiff);
    } else if (t->apart) {
        (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_ROWSPERSTRIP, &t->band_rows);
        t->band_rows = t->band_rows < t->height ? t->band_rows : t->height;
        *piece_bytes = (uint64_t)TIFFStripSize64(t->tiff);
        if (t->band_rows == 0 || *piece_bytes > STRIP_BYTES_MOST)
            return stp_error_set(err, STP_UNSUPPORTED,
                                 "%s: its channels lie one after another, in strips of %u rows: "
                                 "interleave them (gdal_translate -co INTERLEAVE=PIXEL)",
                                 t->path, t->band_rows);
    } else {
        uint16_t packed = COMPRESSION_NONE;
        (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_COMPRESSION, &packed);
        if (packed != COMPRESSION_NONE)
            (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_ROWSPERSTRIP, &t->strip_rows);
        *piece_bytes = (uint64_t)TIFFScanlineSize64(t->tiff);
    }
    return STP_OK;
}

/* Bands of rows: those of a row of tiles, or of a strip. */
static stp_status make_band(tiff_raster *t, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t piece_bytes = 0;
    STP_TRY(find_pieces(t, &piece_bytes, err));
    const uint64_t band = t->band_rows * row_bytes(t, t->band_width);
    const uint64_t needed =
        t->band_rows * piece_row_bytes(t, t->tile_width > 0 ? t->tile_width : t->width);
    if (piece_bytes < needed || t->band_rows > STP_RASTER_SIDE_LIMIT || band > UINT64_C(1) << 31)
        return stp_error_set(err, STP_CORRUPT, "%s: its tiles or rows have a wrong size", t->path);
    STP_TRY(stp_alloc(&t->band, band, 1, "rows of an image", err));
    STP_TRY(stp_alloc(&t->piece, piece_bytes, 1, "a tile of an image", err));
done:
    return status;
}

/* Of the image that libtiff is at. */
static void read_size(tiff_raster *t)
{
    uint16_t channels = 1, planar = PLANARCONFIG_CONTIG;
    t->bits = 1;
    t->kind = SAMPLEFORMAT_UINT;
    (void)TIFFGetField(t->tiff, TIFFTAG_IMAGEWIDTH, &t->width);
    (void)TIFFGetField(t->tiff, TIFFTAG_IMAGELENGTH, &t->height);
    (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_SAMPLESPERPIXEL, &channels);
    (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_BITSPERSAMPLE, &t->bits);
    (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_SAMPLEFORMAT, &t->kind);
    (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_PLANARCONFIG, &planar);
    t->channels = channels;
    t->apart = planar == PLANARCONFIG_SEPARATE && channels > 1;
}

/* Goes to the smallest copy of the image of which each pixel stands for at most step columns and
 * rows, and which has a mask if the image has. Copies come after the image, as GDAL writes
 * overviews. */
static void choose_copy(tiff_raster *t, uint32_t step, bool is_masked, stp_raster_info *info)
{
    const tiff_raster whole = *t;
    tdir_t best = 0;
    while (TIFFReadDirectory(t->tiff)) {
        uint32_t type = 0;
        (void)TIFFGetField(t->tiff, TIFFTAG_SUBFILETYPE, &type);
        read_size(t);
        const uint32_t by = t->width > 0 ? (whole.width + t->width / 2) / t->width : 0;
        if (type == FILETYPE_REDUCEDIMAGE && by > info->reduced && by <= step &&
            t->width == (whole.width + by - 1) / by && t->height == (whole.height + by - 1) / by &&
            t->channels == whole.channels && t->bits == whole.bits && t->kind == whole.kind &&
            (!is_masked || find_mask(t->tiff, t->width, t->height) > 0)) {
            info->reduced = by;
            best = TIFFCurrentDirectory(t->tiff);
        }
    }
    (void)TIFFSetDirectory(t->tiff, best);
    read_size(t);
    info->width = t->width;
    info->height = t->height;
    const double middle = 0.5 * (info->reduced - 1);
    info->x += middle * info->dx + middle * info->skew[1];
    info->y += middle * info->skew[0] - middle * info->dy;
    info->dx *= info->reduced;
    info->dy *= info->reduced;
    info->skew[0] *= info->reduced;
    info->skew[1] *= info->reduced;
}

/* For packed tiles of floats, half of the time goes into undoing the predictor, which rows that are
 * left out do not need. So libtiff leaves that to unfold, except where it swaps numbers' bytes. */
static void take_predictor(tiff_raster *t)
{
    uint16_t predictor = PREDICTOR_NONE;
    if (t->tile_width > 0 && t->bits >= 8 && !t->apart && !TIFFIsByteSwapped(t->tiff) &&
        TIFFGetField(t->tiff, TIFFTAG_PREDICTOR, &predictor) &&
        (predictor == PREDICTOR_HORIZONTAL || predictor == PREDICTOR_FLOATINGPOINT) &&
        TIFFSetField(t->tiff, TIFFTAG_PREDICTOR, PREDICTOR_NONE))
        t->predictor = predictor;
}

static stp_status open_file(tiff_raster *t, const char *path, stp_error *err)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    t->path = path;
    (void)pthread_once(&once, stp_tiff_name_tags);
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (options == NULL)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to open %s", path);
    TIFFOpenOptionsSetErrorHandlerExtR(options, keep_error, t);
    TIFFOpenOptionsSetWarningHandlerExtR(options, drop_warning, NULL);
    t->tiff = TIFFOpenExt(path, "r", options);
    TIFFOpenOptionsFree(options);
    return t->tiff == NULL ? damaged(t, err) : STP_OK;
}

/* Opens the mask of the image that libtiff is at. */
static stp_status open_mask(tiff_raster *t, stp_raster_info *info, stp_error *err)
{
    stp_status status = STP_OK;
    const tdir_t directory = find_mask(t->tiff, t->width, t->height);
    STP_TRY(stp_alloc(&t->mask, 1, sizeof *t->mask, "a mask", err));
    STP_TRY(stp_alloc(&t->mask_row, t->width, sizeof *t->mask_row, "a row of a mask", err));
    STP_TRY(open_file(t->mask, t->path, err));
    if (!TIFFSetDirectory(t->mask->tiff, directory))
        return damaged(t->mask, err);
    read_size(t->mask);
    if (!is_read(t->mask) || t->mask->channels != 1)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s has a mask of %u bits and %u channels inside: masks of 1 or 8 "
                             "bits are read; gdalwarp -dstnodata -9999 makes it numbers",
                             t->path, t->mask->bits, t->mask->channels);
    STP_TRY(make_band(t->mask, err));
    info->channels = t->channels + (t->has_alpha ? 0 : 1);
    info->alpha = true;
done:
    return status;
}

/* Tells of the image that libtiff is at. */
static void describe(tiff_raster *t, stp_raster_info *info)
{
    uint16_t extra = 0, *extras = NULL;
    (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_EXTRASAMPLES, &extra, &extras);
    t->has_alpha = extra == 1 && extras[0] != EXTRASAMPLE_UNSPECIFIED &&
                   (t->channels == 2 || t->channels == 4);
    *info = (stp_raster_info){.format = "TIFF",
                              .width = t->width,
                              .height = t->height,
                              .reduced = 1,
                              .channels = t->channels,
                              .alpha = t->has_alpha,
                              .floats = t->kind == SAMPLEFORMAT_IEEEFP,
                              .full = 1.0};
    if (!info->floats)
        info->full = ldexp(1.0, t->bits) - 1.0;
    stp_tiff_find_meaning(t->tiff, info->floats && t->bits == 32, info);
    stp_tiff_find_place(t->tiff, info);
}

static stp_status open_tiff(void *state, stp_raster_info *info, const char *path,
                            stp_raster_use use, uint32_t step, stp_error *err)
{
    tiff_raster *t = state;
    stp_status status = STP_OK;
    uint16_t photometric = PHOTOMETRIC_MINISBLACK;
    bool is_masked = false;
    STP_TRY(open_file(t, path, err));
    read_size(t);
    (void)TIFFGetField(t->tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    describe(t, info);
    STP_TRY(check_kind(t, photometric, err));
    if (use == STP_RASTER_HEIGHTS)
        STP_TRY(check_heights(t, photometric, &is_masked, err));
    if (step > 1)
        choose_copy(t, step, is_masked, info);
    if (t->width == 0 || t->width > STP_RASTER_SIDE_LIMIT)
        goto done; /* whoever opens it refuses it */
    STP_TRY(make_band(t, err));
    if (is_masked)
        STP_TRY(open_mask(t, info, err));
    if (step > 1)
        take_predictor(t);
done:
    return status;
}

/* Undoes the predictor in a tile's row (TIFF 6.0, section 14, and Adobe's Photoshop TIFF Technical
 * Note 3): numbers are differences to the one before; of floats bytes are, all first ones before
 * all second ones. scratch: as long as the row. */
static void unfold(const tiff_raster *t, unsigned char *row, unsigned char *scratch)
{
    const size_t bytes = t->bits / 8, count = (size_t)t->tile_width * t->channels;
    if (t->predictor == PREDICTOR_HORIZONTAL) {
        for (size_t i = t->channels; i < count; i++) {
            uint64_t number = 0, before = 0; /* little-endian: the low bytes */
            memcpy(&number, row + i * bytes, bytes);
            memcpy(&before, row + (i - t->channels) * bytes, bytes);
            number += before;
            memcpy(row + i * bytes, &number, bytes);
        }
        return;
    }
    for (size_t i = t->channels; i < count * bytes; i++)
        row[i] = (unsigned char)(row[i] + row[i - t->channels]);
    memcpy(scratch, row, count * bytes);
    for (size_t k = 0; k < bytes; k++)
        for (size_t i = 0; i < count; i++)
            row[i * bytes + bytes - 1 - k] = scratch[k * count + i];
}

/* Puts a piece's rows into the band, at column x. channel: of a piece that has but one. */
static void place_piece(tiff_raster *t, uint32_t x, uint32_t columns, uint32_t rows,
                        unsigned channel)
{
    const size_t stride = row_bytes(t, t->band_width), own = piece_row_bytes(t, columns);
    const size_t number = t->bits / 8, pixel = t->channels * number;
    for (uint32_t y = 0; y < rows; y++) {
        unsigned char *to = t->band + y * stride + row_bytes(t, x);
        const unsigned char *from = t->piece + y * own;
        if (!t->apart)
            memcpy(to, from, own);
        for (uint32_t i = 0; t->apart && i < columns; i++)
            memcpy(to + i * pixel + channel * number, from + i * number, number);
    }
}

/* Reads a row of strips. Rows of a packed strip are not read unless all above are. */
static bool read_scanline(tiff_raster *t, uint32_t row)
{
    uint32_t first = row, strip = 0;
    if (t->strip_rows > 0) {
        strip = row / t->strip_rows * t->strip_rows;
        first = t->band_end > strip && t->band_end <= row ? t->band_end : strip;
    }
    for (; first <= row; first++)
        if (TIFFReadScanline(t->tiff, t->piece, first, 0) != 1)
            return false;
    return true;
}

/* Reads a tile or strip. x: its first column. */
static bool read_piece(tiff_raster *t, uint32_t row, uint32_t begin, uint32_t x, uint16_t channel)
{
    if (t->tile_width > 0)
        return TIFFReadTile(t->tiff, t->piece, x, begin, 0, channel) >= 0;
    if (t->apart)
        return TIFFReadEncodedStrip(t->tiff, TIFFComputeStrip(t->tiff, begin, channel), t->piece,
                                    -1) >= 0;
    return read_scanline(t, row);
}

/* Reads the tiles or the strip's row that hold a row. */
static stp_status read_band(tiff_raster *t, uint32_t row, stp_error *err)
{
    const uint32_t begin = row / t->band_rows * t->band_rows, left = t->height - begin;
    const uint32_t rows = left < t->band_rows ? left : t->band_rows;
    const uint32_t wide = t->tile_width > 0 ? t->tile_width : t->width;
    const uint16_t pieces = t->apart ? (uint16_t)t->channels : 1;
    for (uint16_t c = 0; c < pieces; c++)
        for (uint32_t x = 0; x < t->width; x += wide) {
            if (!read_piece(t, row, begin, x, c))
                return damaged(t, err);
            place_piece(t, x, wide, rows, c);
        }
    t->band_begin = begin;
    t->band_end = begin + t->band_rows;
    return STP_OK;
}

#define CONVERT(type)                                                                              \
    for (size_t i = 0; i < count; i++) {                                                           \
        type value;                                                                                \
        memcpy(&value, in + i * sizeof value, sizeof value);                                       \
        out[i] = (double)value;                                                                    \
    }

/* libtiff has put the bytes in this machine's order. */
static void convert(const tiff_raster *t, const unsigned char *in, size_t count, double *out)
{
    const bool is_signed = t->kind == SAMPLEFORMAT_INT;
    if (t->kind == SAMPLEFORMAT_IEEEFP && t->bits == 64)
        CONVERT(double)
    else if (t->kind == SAMPLEFORMAT_IEEEFP)
        CONVERT(float)
    else if (t->bits == 32 && is_signed)
        CONVERT(int32_t)
    else if (t->bits == 32)
        CONVERT(uint32_t)
    else if (t->bits == 16 && is_signed)
        CONVERT(int16_t)
    else if (t->bits == 16)
        CONVERT(uint16_t)
    else if (t->bits == 1)
        for (size_t i = 0; i < count; i++)
            out[i] = in[i / 8] >> (7 - i % 8) & 1;
    else if (is_signed)
        CONVERT(int8_t)
    else
        CONVERT(uint8_t)
}

/* Reads a row as the file has it. */
static stp_status read_own(tiff_raster *t, uint32_t row, double *values, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t pixel = (size_t)t->channels * (t->bits / 8);
    if (row < t->band_begin || row >= t->band_end)
        STP_TRY(read_band(t, row, err));
    unsigned char *in = t->band + (row - t->band_begin) * row_bytes(t, t->band_width);
    for (uint32_t x = 0; t->predictor != 0 && x < t->width; x += t->tile_width)
        unfold(t, in + x * pixel, t->piece);
    convert(t, in, (size_t)t->width * t->channels, values);
done:
    return status;
}

static stp_status read_tiff(void *state, uint32_t row, double *values, stp_error *err)
{
    tiff_raster *t = state;
    stp_status status = STP_OK;
    const size_t own = t->channels, all = own + (t->has_alpha ? 0 : 1);
    STP_TRY(read_own(t, row, values, err));
    if (t->mask == NULL)
        goto done;
    STP_TRY(read_own(t->mask, row, t->mask_row, err));
    for (size_t x = t->width; x-- > 0;) { /* makes room for the mask, from the last pixel on */
        double *pixel = values + x * all;
        memmove(pixel, values + x * own, own * sizeof *pixel);
        if (!t->has_alpha || t->mask_row[x] == 0.0)
            pixel[all - 1] = t->mask_row[x];
    }
done:
    return status;
}

static void close_tiff(void *state)
{
    tiff_raster *t = state;
    if (t->mask != NULL)
        close_tiff(t->mask);
    if (t->tiff != NULL)
        TIFFClose(t->tiff);
    free(t->mask);
    free(t->mask_row);
    free(t->band);
    free(t->piece);
}

const stp_raster_reader stp_raster_tiff = {
    .state_bytes = sizeof(tiff_raster), .open = open_tiff, .read = read_tiff, .close = close_tiff};
