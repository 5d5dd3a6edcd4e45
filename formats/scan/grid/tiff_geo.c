/* Reads the tags of GeoTIFF (OGC GeoTIFF 1.1, 7.3 to 7.5) and of GDAL. */
#include "formats/scan/grid/tiff_geo.h"

#include "formats/scan/number.h"

#include <ctype.h>
#include <float.h>
#include <math.h>
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

void stp_tiff_name_tags(void)
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

void stp_tiff_find_meaning(TIFF *tiff, bool singles, stp_raster_info *info)
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
    double dx, dy; /* 0, without skew: not told */
    double skew[2];
    bool tied;
    double column, row, x, y;
} placing;

/* By the spacing and a tie point, or by a matrix. GDAL, too, takes no notice of the sign of a
 * spacing along y. */
static placing find_placing(TIFF *tiff)
{
    uint16_t count = 0;
    double *scale = NULL, *tie = NULL, *m = NULL;
    placing out = {0};
    if (TIFFGetField(tiff, TAG_SCALE, &count, &scale) && count >= 2) {
        out = (placing){.dx = scale[0], .dy = fabs(scale[1])};
        if (TIFFGetField(tiff, TAG_TIE, &count, &tie) && count >= 6)
            out = (placing){scale[0], fabs(scale[1]), {0.0, 0.0}, true,
                            tie[0],   tie[1],         tie[3],     tie[4]};
    } else if (TIFFGetField(tiff, TAG_TRANSFORM, &count, &m) && count >= 8) {
        out = (placing){m[0], -m[5], {m[4], m[1]}, true, 0.0, 0.0, m[3], m[7]};
    }
    return out;
}

/* Whether pixels have an area. */
static bool has_area(const placing *p)
{
    const double area = p->dx * p->dy + p->skew[0] * p->skew[1];
    return isfinite(area) && area != 0.0;
}

void stp_tiff_find_place(TIFF *tiff, stp_raster_info *info)
{
    const placing p = find_placing(tiff);
    if (!has_area(&p))
        return;
    info->spaced = true;
    info->dx = p.dx;
    info->dy = p.dy;
    memcpy(info->skew, p.skew, sizeof info->skew);
    info->degrees = find_key(tiff, KEY_MODEL) == MODEL_GEOGRAPHIC;
    info->epsg = find_key(tiff, info->degrees ? KEY_GEOGRAPHIC : KEY_PROJECTED);
    info->vertical = find_key(tiff, KEY_VERTICAL);
    /* A pixel's place is its corner, or its middle. */
    const double middle = find_key(tiff, KEY_RASTER) == RASTER_IS_POINT ? 0.0 : 0.5;
    const double columns = middle - p.column, rows = middle - p.row;
    info->x = p.x + columns * p.dx + rows * p.skew[1];
    info->y = p.y - rows * p.dy + columns * p.skew[0];
    info->placed = p.tied && isfinite(info->x) && isfinite(info->y);
}
