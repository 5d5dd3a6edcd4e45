/* Reads TIFF by libtiff, and what GeoTIFF says of its place (OGC GeoTIFF 1.1, 7.3 to 7.5). */
#include "base/memory.h"
#include "formats/scan/grid/raster.h"
#include "formats/scan/number.h"

#include <tiffio.h>

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    TAG_SCALE = 33550,
    TAG_TIE = 33922,
    TAG_TRANSFORM = 34264,
    TAG_KEYS = 34735,
    TAG_METADATA = 42112, /* GDAL's */
    TAG_NO_DATA = 42113
};
enum {
    KEY_MODEL = 1024,
    MODEL_GEOGRAPHIC = 2,
    KEY_RASTER = 1025,
    RASTER_IS_POINT = 2,
    KEY_GEOGRAPHIC = 2048, /* EPSG codes of coordinate systems */
    KEY_PROJECTED = 3072,
    KEY_VERTICAL = 4096
};

typedef struct tiff_raster {
    const char *path;
    TIFF *tiff;
    uint32_t width, height, channels;
    uint16_t bits, kind;            /* SAMPLEFORMAT_* */
    uint32_t tile_width, band_rows; /* tile_width 0: strips */
    uint32_t band_width;            /* that of all tiles */
    unsigned char *band, *piece;    /* piece: one tile */
    uint32_t band_begin, band_end;
    uint16_t predictor; /* PREDICTOR_* that rows of the band still have; 0: none */
    char message[256];  /* libtiff's last error */
} tiff_raster;

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
    return stp_error_set(err, STP_CORRUPT, "%s: the TIFF is damaged: %s", t->path,
                         t->message[0] ? t->message : "it ends early");
}

static TIFFExtendProc next_extender;

/* Names tags of GeoTIFF and GDAL, which libtiff does not know by itself, to each file that is
 * opened. */
static void name_tags(TIFF *tiff)
{
    static const TIFFFieldInfo fields[] = {
        {TAG_SCALE, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, (char *)"ModelPixelScale"},
        {TAG_TIE, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, (char *)"ModelTiepoint"},
        {TAG_TRANSFORM, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, (char *)"ModelTransformation"},
        {TAG_KEYS, -1, -1, TIFF_SHORT, FIELD_CUSTOM, 1, 1, (char *)"GeoKeyDirectory"},
        {TAG_METADATA, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, (char *)"GDALMetadata"},
        {TAG_NO_DATA, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, (char *)"GDALNoData"},
    };
    TIFFMergeFieldInfo(tiff, fields, sizeof fields / sizeof *fields);
    if (next_extender != NULL)
        next_extender(tiff);
}

static void set_extender(void)
{
    next_extender = TIFFSetTagExtender(name_tags);
}

/* The value of a GeoTIFF key that is one short; 0 if it is not there. */
static unsigned find_key(TIFF *tiff, unsigned key)
{
    uint16_t count = 0;
    uint16_t *keys = NULL;
    if (!TIFFGetField(tiff, TAG_KEYS, &count, &keys) || count < 4)
        return 0;
    for (unsigned i = 4; i + 3 < count; i += 4)
        if (keys[i] == key && keys[i + 1] == 0)
            return keys[i + 3];
    return 0;
}

/* The number that GDAL's metadata have for the first channel, as
 * <Item name="SCALE" sample="0" role="scale">0.1</Item>; `otherwise` if they have none. */
static double find_item(const char *metadata, const char *role, double otherwise)
{
    double number;
    const char *at = strstr(metadata, role), *item = metadata;
    if (at == NULL)
        return otherwise;
    for (const char *next = metadata; next != NULL && next < at; next = strstr(next + 1, "<Item "))
        item = next;
    const char *first = strstr(item, "sample=\"0\""), *begin = strchr(at, '>');
    const char *end = begin != NULL ? strchr(begin, '<') : NULL;
    const bool found = first != NULL && first < begin && end != NULL;
    return found && stp_number_parse(begin + 1, end, &number) && isfinite(number) ? number
                                                                                  : otherwise;
}

/* What GDAL says of the numbers. singles: they are floats of 32 bits. */
static void find_meaning(TIFF *tiff, bool singles, stp_raster_info *info)
{
    const char *text = NULL;
    if (TIFFGetField(tiff, TAG_NO_DATA, &text)) {
        const char *end = text + strlen(text);
        while (end > text && isspace((unsigned char)end[-1]))
            end--;
        while (text < end && isspace((unsigned char)*text))
            text++;
        info->has_none = stp_number_parse(text, end, &info->none);
        /* the text has other digits than the numbers have bits */
        if (singles && fabs(info->none) <= (double)FLT_MAX)
            info->none = (double)(float)info->none;
    }
    if (TIFFGetField(tiff, TAG_METADATA, &text)) {
        info->scale = find_item(text, "role=\"scale\"", 1.0);
        info->offset = find_item(text, "role=\"offset\"", 0.0);
    }
}

/* Where a grid lies. tied: pixel (column, row) lies at (x, y). */
typedef struct placing {
    double dx, dy; /* 0: not told */
    bool tied;
    double column, row, x, y;
} placing;

/* By the spacing and a tie point, or by a matrix. Errors: UNSUPPORTED (the grid is turned or
 * mirrored). */
static stp_status find_placing(const tiff_raster *t, placing *out, stp_error *err)
{
    uint16_t count = 0;
    double *scale = NULL, *tie = NULL, *m = NULL;
    bool turned = false;
    *out = (placing){0};
    if (TIFFGetField(t->tiff, TAG_SCALE, &count, &scale) && count >= 2) {
        *out = (placing){.dx = scale[0], .dy = scale[1]};
        if (TIFFGetField(t->tiff, TAG_TIE, &count, &tie) && count >= 6)
            *out = (placing){scale[0], scale[1], true, tie[0], tie[1], tie[3], tie[4]};
        turned = scale[0] < 0.0 || scale[1] < 0.0;
    } else if (TIFFGetField(t->tiff, TAG_TRANSFORM, &count, &m) && count >= 8) {
        *out = (placing){m[0], -m[5], true, 0.0, 0.0, m[3], m[7]};
        turned = m[1] != 0.0 || m[4] != 0.0 || !(out->dx > 0.0) || !(out->dy > 0.0);
    }
    if (turned)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: its rows do not run along x, the top row first: turn it "
                             "(gdalwarp)",
                             t->path);
    return STP_OK;
}

static stp_status find_place(const tiff_raster *t, stp_raster_info *info, stp_error *err)
{
    placing p;
    const stp_status status = find_placing(t, &p, err);
    if (status != STP_OK || !(p.dx > 0.0) || !(p.dy > 0.0) || !isfinite(p.dx) || !isfinite(p.dy))
        return status;
    info->spaced = true;
    info->dx = p.dx;
    info->dy = p.dy;
    info->degrees = find_key(t->tiff, KEY_MODEL) == MODEL_GEOGRAPHIC;
    info->epsg = find_key(t->tiff, info->degrees ? KEY_GEOGRAPHIC : KEY_PROJECTED);
    info->vertical = find_key(t->tiff, KEY_VERTICAL);
    /* A pixel's place is its corner, or its middle. */
    const double middle = find_key(t->tiff, KEY_RASTER) == RASTER_IS_POINT ? 0.0 : 0.5;
    info->x = p.x + (middle - p.column) * p.dx;
    info->y = p.y - (middle - p.row) * p.dy;
    info->placed = p.tied && isfinite(info->x) && isfinite(info->y);
    return STP_OK;
}

/* Whether numbers of this kind can be read: 8, 16 or 32 bits, floats of 32 or 64. */
static bool is_read(const tiff_raster *t)
{
    if (t->kind == SAMPLEFORMAT_IEEEFP)
        return t->bits == 32 || t->bits == 64;
    return (t->kind == SAMPLEFORMAT_UINT || t->kind == SAMPLEFORMAT_INT) &&
           (t->bits == 8 || t->bits == 16 || t->bits == 32);
}

/* Whether libtiff makes RGB of the image's colours, as JPEG has them. */
static bool makes_rgb(const tiff_raster *t)
{
    uint16_t compression = COMPRESSION_NONE;
    return TIFFGetField(t->tiff, TIFFTAG_COMPRESSION, &compression) &&
           compression == COMPRESSION_JPEG &&
           TIFFSetField(t->tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
}

static stp_status check_kind(const tiff_raster *t, uint16_t planar, uint16_t photometric,
                             stp_error *err)
{
    if (photometric == PHOTOMETRIC_PALETTE || (photometric == PHOTOMETRIC_YCBCR && !makes_rgb(t)) ||
        photometric == PHOTOMETRIC_LOGLUV || photometric == PHOTOMETRIC_CIELAB)
        return stp_error_set(
            err, STP_UNSUPPORTED,
            "%s: its numbers are colours, but no RGB: it is no grid of heights; for "
            "--colour convert it (gdal_translate -expand rgb, or ImageMagick's "
            "convert -type TrueColor)",
            t->path);
    if (planar == PLANARCONFIG_SEPARATE && t->channels > 1)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: its channels lie one after another: interleave them "
                             "(gdal_translate -co INTERLEAVE=PIXEL)",
                             t->path);
    if (!is_read(t))
        return stp_error_set(
            err, STP_UNSUPPORTED,
            "%s: its numbers have %u bit%s: integers of 8, 16, 32 and floats of 32, "
            "64 bits are read (gdal_translate -ot Float32 converts)",
            t->path, t->bits, t->bits == 1 ? "" : "s");
    return STP_OK;
}

/* What of an image of heights says which samples there are, or which channel is the heights. */
static stp_status check_heights(const tiff_raster *t, uint16_t photometric, bool alpha,
                                stp_error *err)
{
    uint32_t type = 0;
    if (photometric == PHOTOMETRIC_RGB || photometric == PHOTOMETRIC_YCBCR)
        return STP_OK; /* whoever wants heights refuses them */
    if (t->channels > (alpha ? 2u : 1u))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s has %u bands, and none of them is named the heights: "
                             "gdal_translate -b 1 takes the first",
                             t->path, t->channels);
    while (TIFFReadDirectory(t->tiff))
        if (TIFFGetField(t->tiff, TIFFTAG_SUBFILETYPE, &type) && type == FILETYPE_MASK)
            return stp_error_set(err, STP_UNSUPPORTED,
                                 "%s has a mask inside, which is not read: gdalwarp -dstnodata "
                                 "-9999 makes it numbers",
                                 t->path);
    return TIFFSetDirectory(t->tiff, 0) ? STP_OK : damaged(t, err);
}

/* Bands of rows: those of a row of tiles, or of a strip. */
static stp_status make_band(tiff_raster *t, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t rows = 0;
    t->band_width = t->width;
    uint64_t piece_bytes;
    if (TIFFIsTiled(t->tiff)) {
        (void)TIFFGetField(t->tiff, TIFFTAG_TILEWIDTH, &t->tile_width);
        (void)TIFFGetField(t->tiff, TIFFTAG_TILELENGTH, &rows);
        if (t->tile_width == 0 || t->tile_width > 2 * STP_RASTER_SIDE_LIMIT || rows == 0)
            return stp_error_set(err, STP_CORRUPT, "%s: its tiles have no size, or are too wide",
                                 t->path);
        t->band_width = (t->width + t->tile_width - 1) / t->tile_width * t->tile_width;
        piece_bytes = (uint64_t)TIFFTileSize64(t->tiff);
    } else {
        rows = 1;
        piece_bytes = (uint64_t)TIFFScanlineSize64(t->tiff);
    }
    const uint64_t pixel = (uint64_t)t->channels * (t->bits / 8),
                   band = rows * pixel * t->band_width;
    const uint64_t needed = t->tile_width > 0 ? rows * pixel * t->tile_width : pixel * t->width;
    if (piece_bytes < needed || rows > STP_RASTER_SIDE_LIMIT || band > UINT64_C(1) << 31)
        return stp_error_set(err, STP_CORRUPT, "%s: its tiles or rows have a wrong size", t->path);
    t->band_rows = rows;
    STP_TRY(stp_alloc(&t->band, band, 1, "rows of an image", err));
    STP_TRY(stp_alloc(&t->piece, piece_bytes, 1, "a tile of an image", err));
done:
    return status;
}

/* Of the image that libtiff is at. */
static void read_size(tiff_raster *t)
{
    uint16_t channels = 1;
    t->bits = 1;
    t->kind = SAMPLEFORMAT_UINT;
    (void)TIFFGetField(t->tiff, TIFFTAG_IMAGEWIDTH, &t->width);
    (void)TIFFGetField(t->tiff, TIFFTAG_IMAGELENGTH, &t->height);
    (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_SAMPLESPERPIXEL, &channels);
    (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_BITSPERSAMPLE, &t->bits);
    (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_SAMPLEFORMAT, &t->kind);
    t->channels = channels;
}

/* Goes to the smallest copy of the image of which each pixel stands for at most step columns and
 * rows. Copies come after the image, as GDAL writes overviews. */
static void choose_copy(tiff_raster *t, uint32_t step, stp_raster_info *info)
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
            t->channels == whole.channels && t->bits == whole.bits && t->kind == whole.kind) {
            info->reduced = by;
            best = TIFFCurrentDirectory(t->tiff);
        }
    }
    (void)TIFFSetDirectory(t->tiff, best);
    read_size(t);
    info->width = t->width;
    info->height = t->height;
    info->x += 0.5 * (info->reduced - 1) * info->dx;
    info->y -= 0.5 * (info->reduced - 1) * info->dy;
    info->dx *= info->reduced;
    info->dy *= info->reduced;
}

/* For packed tiles of floats, half of the time goes into undoing the predictor, which rows that are
 * left out do not need. So libtiff leaves that to unfold, except where it swaps numbers' bytes. */
static void take_predictor(tiff_raster *t)
{
    uint16_t predictor = PREDICTOR_NONE;
    if (t->tile_width > 0 && !TIFFIsByteSwapped(t->tiff) &&
        TIFFGetField(t->tiff, TIFFTAG_PREDICTOR, &predictor) &&
        (predictor == PREDICTOR_HORIZONTAL || predictor == PREDICTOR_FLOATINGPOINT) &&
        TIFFSetField(t->tiff, TIFFTAG_PREDICTOR, PREDICTOR_NONE))
        t->predictor = predictor;
}

static stp_status open_tiff(void *state, stp_raster_info *info, const char *path,
                            stp_raster_use use, uint32_t step, stp_error *err)
{
    tiff_raster *t = state;
    uint16_t planar = PLANARCONFIG_CONTIG, photometric = PHOTOMETRIC_MINISBLACK;
    uint16_t extra = 0, *extras = NULL;
    t->path = path;
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    (void)pthread_once(&once, set_extender);
    TIFFOpenOptions *options = TIFFOpenOptionsAlloc();
    if (options == NULL)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to open %s", path);
    TIFFOpenOptionsSetErrorHandlerExtR(options, keep_error, t);
    TIFFOpenOptionsSetWarningHandlerExtR(options, drop_warning, NULL);
    t->tiff = TIFFOpenExt(path, "r", options);
    TIFFOpenOptionsFree(options);
    if (t->tiff == NULL)
        return damaged(t, err);
    read_size(t);
    (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_PLANARCONFIG, &planar);
    (void)TIFFGetField(t->tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    (void)TIFFGetFieldDefaulted(t->tiff, TIFFTAG_EXTRASAMPLES, &extra, &extras);
    *info = (stp_raster_info){.format = "TIFF",
                              .width = t->width,
                              .height = t->height,
                              .reduced = 1,
                              .channels = t->channels,
                              .alpha = extra == 1 && extras[0] != EXTRASAMPLE_UNSPECIFIED &&
                                       (t->channels == 2 || t->channels == 4),
                              .floats = t->kind == SAMPLEFORMAT_IEEEFP,
                              .full = 1.0};
    if (!info->floats)
        info->full = ldexp(1.0, t->bits) - 1.0;
    find_meaning(t->tiff, info->floats && t->bits == 32, info);
    stp_status status = find_place(t, info, err);
    if (status == STP_OK)
        status = check_kind(t, planar, photometric, err);
    if (status == STP_OK && use == STP_RASTER_HEIGHTS)
        status = check_heights(t, photometric, info->alpha, err);
    if (status == STP_OK && step > 1)
        choose_copy(t, step, info);
    if (status == STP_OK && t->width > 0 && t->width <= STP_RASTER_SIDE_LIMIT)
        status = make_band(t, err);
    if (status == STP_OK && step > 1)
        take_predictor(t);
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

/* Reads the tiles or the strip's row that hold a row. */
static stp_status read_band(tiff_raster *t, uint32_t row, stp_error *err)
{
    const size_t pixel = (size_t)t->channels * (t->bits / 8), tile = pixel * t->tile_width;
    const size_t stride = pixel * t->band_width;
    t->band_begin = row / t->band_rows * t->band_rows;
    t->band_end = t->band_begin + t->band_rows;
    if (t->tile_width == 0) {
        if (TIFFReadScanline(t->tiff, t->piece, row, 0) != 1)
            return damaged(t, err);
        memcpy(t->band, t->piece, stride);
        return STP_OK;
    }
    for (uint32_t x = 0; x < t->width; x += t->tile_width) {
        if (TIFFReadTile(t->tiff, t->piece, x, t->band_begin, 0, 0) < 0)
            return damaged(t, err);
        for (uint32_t y = 0; y < t->band_rows; y++)
            memcpy(t->band + y * stride + x * pixel, t->piece + y * tile, tile);
    }
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
    else if (is_signed)
        CONVERT(int8_t)
    else
        CONVERT(uint8_t)
}

static stp_status read_tiff(void *state, uint32_t row, double *values, stp_error *err)
{
    tiff_raster *t = state;
    stp_status status = STP_OK;
    const size_t pixel = (size_t)t->channels * (t->bits / 8);
    if (row < t->band_begin || row >= t->band_end)
        STP_TRY(read_band(t, row, err));
    unsigned char *in = t->band + (row - t->band_begin) * pixel * t->band_width;
    for (uint32_t x = 0; t->predictor != 0 && x < t->width; x += t->tile_width)
        unfold(t, in + x * pixel, t->piece);
    convert(t, in, (size_t)t->width * t->channels, values);
done:
    return status;
}

static void close_tiff(void *state)
{
    tiff_raster *t = state;
    if (t->tiff != NULL)
        TIFFClose(t->tiff);
    free(t->band);
    free(t->piece);
}

const stp_raster_reader stp_raster_tiff = {
    .state_bytes = sizeof(tiff_raster), .open = open_tiff, .read = read_tiff, .close = close_tiff};
