/* Reads the public header of a LAS file. */
#include "formats/scan/las/las_header.h"

#include "formats/scan/las/las_bytes.h"

#include <math.h>
#include <stdio.h>

/* Set in the byte of the point format if the file is compressed. Early LASzip set the next bit,
 * too. */
#define STP_LAS_COMPRESSED_BITS 0xc0u

/* Of the global encoding: GPS times are counted from the header's offset. */
#define STP_LAS_TIME_OFFSET_BIT 0x40u

/* Offsets of fields in the header. */
enum {
    AT_ENCODING = 6,
    AT_MAJOR = 24,
    AT_MINOR = 25,
    AT_HEADER_BYTES = 94,
    AT_POINT_OFFSET = 96,
    AT_VLR_COUNT = 100,
    AT_FORMAT = 104,
    AT_RECORD_BYTES = 105,
    AT_COUNT_32 = 107,
    AT_SCALE = 131,
    AT_OFFSET = 155,
    AT_EVLR_OFFSET = 235,
    AT_EVLR_COUNT = 243,
    AT_COUNT_64 = 247,
    AT_TIME_OFFSET = 391
};

const stp_las_format *stp_las_format_get(unsigned number)
{
    static const stp_las_format formats[STP_LAS_FORMAT_COUNT] = {
        {20, false, 0, 0, 0, 0},   {28, false, 20, 0, 0, 0},  {26, false, 0, 20, 0, 0},
        {34, false, 20, 28, 0, 0}, {57, false, 20, 0, 0, 28}, {63, false, 20, 28, 0, 34},
        {30, true, 22, 0, 0, 0},   {36, true, 22, 30, 0, 0},  {38, true, 22, 30, 36, 0},
        {59, true, 22, 0, 0, 30},  {67, true, 22, 30, 36, 38}};
    return &formats[number];
}

/* Makes an error about the header's number at this byte. */
static stp_status wrong(const stp_source *s, unsigned at, const char *what, uint64_t found,
                        const char *expected, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: byte %u of the LAS header gives %s %llu, expected %s: the file was "
                         "cut or damaged; copy or export it again",
                         s->path, at, what, (unsigned long long)found, expected);
}

static stp_status too_short(const stp_source *s, size_t needed, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: ends at byte %llu, within its LAS header of %zu bytes: the file was "
                         "cut; copy or export it again",
                         s->path, (unsigned long long)s->size, needed);
}

static stp_status read_version(stp_las_header *h, const stp_source *s, const unsigned char *b,
                               stp_error *err)
{
    h->minor_version = b[AT_MINOR];
    if (b[AT_MAJOR] == 1 && b[AT_MINOR] <= 5)
        return STP_OK;
    return stp_error_set(err, STP_VERSION,
                         "%s: byte %d of the LAS header says version %u.%u, and 1.0 to 1.5 are "
                         "read: convert it to LAS 1.4",
                         s->path, AT_MAJOR, b[AT_MAJOR], b[AT_MINOR]);
}

static stp_status read_layout(stp_las_header *h, const stp_source *s, const unsigned char *b,
                              stp_error *err)
{
    char expected[96];
    h->compressed = (b[AT_FORMAT] & STP_LAS_COMPRESSED_BITS) != 0;
    h->point_format = b[AT_FORMAT] & ~STP_LAS_COMPRESSED_BITS;
    if (h->point_format >= STP_LAS_FORMAT_COUNT)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: byte %d of the LAS header says point format %u, and 0 to %u are "
                             "read: convert it to one of them",
                             s->path, AT_FORMAT, h->point_format, STP_LAS_FORMAT_COUNT - 1);
    h->format = stp_las_format_get(h->point_format);
    h->record_bytes = stp_las_u16(b + AT_RECORD_BYTES);
    if (h->record_bytes < h->format->bytes) {
        snprintf(expected, sizeof expected, "at least %u for point format %u", h->format->bytes,
                 h->point_format);
        return wrong(s, AT_RECORD_BYTES, "a record length of", h->record_bytes, expected, err);
    }
    h->point_offset = stp_las_u32(b + AT_POINT_OFFSET);
    if (h->point_offset < h->header_bytes || h->point_offset > s->size) {
        snprintf(expected, sizeof expected, "%u (the header's end) to %llu (the file's)",
                 h->header_bytes, (unsigned long long)s->size);
        return wrong(s, AT_POINT_OFFSET, "the offset to the points as", h->point_offset, expected,
                     err);
    }
    return STP_OK;
}

/* Reads scale and offset. Coordinates must be finite for every integer. */
static stp_status read_transform(stp_las_header *h, const stp_source *s, const unsigned char *b,
                                 stp_error *err)
{
    for (int axis = 0; axis < 3; axis++) {
        const int at[2] = {AT_SCALE + 8 * axis, AT_OFFSET + 8 * axis};
        h->scale[axis] = stp_las_double(b + at[0]);
        h->offset[axis] = stp_las_double(b + at[1]);
        if (!isfinite(h->scale[axis]))
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: byte %d of the LAS header gives %c a scale of %g, expected a "
                                 "finite number: the file is damaged; export it again",
                                 s->path, at[0], "xyz"[axis], h -> scale[axis]);
        if (h->scale[axis] == 0.0) {
            h->scale[axis] = STP_LAS_SCALE_ASSUMED;
            h->scales_assumed |= 1u << axis;
        }
        if (!isfinite(ldexp(fabs(h->scale[axis]), 31) + fabs(h->offset[axis])))
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: byte %d of the LAS header gives %c an offset of %g, with "
                                 "which (scale %g) coordinates are not finite: the file is "
                                 "damaged; export it again",
                                 s->path, at[1], "xyz"[axis], h -> offset[axis], h -> scale[axis]);
    }
    return STP_OK;
}

/* The byte where the points must end: the begin of the EVLRs or the end of the file. */
static uint64_t points_limit(const stp_las_header *h, const stp_source *s)
{
    const bool bounded = h->evlr_count > 0 && h->evlr_offset >= h->point_offset;
    return bounded && h->evlr_offset < s->size ? h->evlr_offset : s->size;
}

static stp_status check_room(stp_las_header *h, const stp_source *s, bool salvage, stp_error *err)
{
    const uint64_t left = points_limit(h, s) - h->point_offset, fit = left / h->record_bytes;
    if (h->point_count > fit && salvage && stp_salvage_count(&h->point_count, fit, &h->lost_count))
        return STP_OK;
    if (h->point_count > fit)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: the LAS header declares %llu points, but the %llu bytes from "
                             "byte %llu on hold %llu: the file was cut or its header is wrong; "
                             "copy or export it again",
                             s->path, (unsigned long long)h->point_count, (unsigned long long)left,
                             (unsigned long long)h->point_offset, (unsigned long long)fit);
    if (h->point_count == 0 && fit > 0)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: byte %d of the LAS header declares no points, but the %llu bytes "
                             "from byte %llu on would hold %llu: its writer may not have finished; "
                             "repair the header (e.g. lasinfo -repair) or export it again",
                             s->path, AT_COUNT_32, (unsigned long long)left,
                             (unsigned long long)h->point_offset, (unsigned long long)fit);
    return STP_OK;
}

static stp_status read_counts(stp_las_header *h, const stp_source *s, const unsigned char *b,
                              bool salvage, stp_error *err)
{
    h->vlr_count = stp_las_u32(b + AT_VLR_COUNT);
    h->count_32 = stp_las_u32(b + AT_COUNT_32);
    if (h->minor_version >= 4) {
        h->count_64 = stp_las_u64(b + AT_COUNT_64);
        h->evlr_count = stp_las_u32(b + AT_EVLR_COUNT);
        h->evlr_offset = stp_las_u64(b + AT_EVLR_OFFSET);
    }
    h->point_count = h->count_64 > 0 ? h->count_64 : h->count_32;
    stp_status status = h->compressed ? STP_OK : check_room(h, s, salvage, err);
    if (status != STP_OK)
        return status;
    const bool outside = h->evlr_offset < h->point_offset || h->evlr_offset > s->size;
    if (outside && salvage)
        h->evlr_count = 0;
    if (h->evlr_count > 0 && outside) {
        char expected[96];
        snprintf(expected, sizeof expected, "%llu (the points' begin) to %llu (the file's end)",
                 (unsigned long long)h->point_offset, (unsigned long long)s->size);
        return wrong(s, AT_EVLR_OFFSET, "the offset to the extended records as", h->evlr_offset,
                     expected, err);
    }
    return STP_OK;
}

stp_status stp_las_header_read(stp_las_header *out, stp_source *source, bool salvage,
                               stp_error *err)
{
    stp_status status = STP_OK;
    stp_las_header h = {0};
    const unsigned char *bytes;
    size_t available;
    stp_source_seek(source, 0, 0);
    STP_TRY(stp_source_peek(source, STP_LAS_HEADER_BYTES, &bytes, &available, err));
    if (available < STP_LAS_HEADER_BYTES)
        return too_short(source, STP_LAS_HEADER_BYTES, err);
    STP_TRY(read_version(&h, source, bytes, err));
    const unsigned least = h.minor_version >= 5   ? STP_LAS_HEADER_BYTES_1_5
                           : h.minor_version >= 4 ? STP_LAS_HEADER_BYTES_1_4
                                                  : STP_LAS_HEADER_BYTES;
    h.header_bytes = stp_las_u16(bytes + AT_HEADER_BYTES);
    if (h.header_bytes < least) {
        char expected[64];
        snprintf(expected, sizeof expected, "at least %u for LAS 1.%u", least, h.minor_version);
        return wrong(source, AT_HEADER_BYTES, "a header size of", h.header_bytes, expected, err);
    }
    STP_TRY(stp_source_peek(source, h.header_bytes, &bytes, &available, err));
    if (available < h.header_bytes)
        return too_short(source, h.header_bytes, err);
    h.has_time_offset =
        h.minor_version >= 5 && (stp_las_u16(bytes + AT_ENCODING) & STP_LAS_TIME_OFFSET_BIT);
    h.time_offset = h.has_time_offset ? stp_las_u16(bytes + AT_TIME_OFFSET) : 0;
    STP_TRY(read_layout(&h, source, bytes, err));
    STP_TRY(read_transform(&h, source, bytes, err));
    STP_TRY(read_counts(&h, source, bytes, salvage, err));
    *out = h;
done:
    return status;
}
