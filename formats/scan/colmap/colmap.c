/* Reads the points of COLMAP's sparse models. */
#include "formats/scan/colmap/colmap.h"

#include "formats/scan/las/las_bytes.h"
#include "formats/scan/source.h"

#include <inttypes.h>
#include <math.h>

/* Places in the file and in a point's record. */
enum { COUNT_BYTES = 8, AT_XYZ = 8, AT_RGB = 32, AT_ERROR = 35, AT_TRACK = 43, RECORD_BYTES = 51 };

#define TRACK_BYTES 8u /* of each picture */
#define TRACK_LIMIT (UINT64_C(1) << 32)

typedef struct reader {
    stp_source source;
    uint64_t count, next;
    stp_scan_note notes[2];
} reader;

/* Whether these bytes are a point; *size: of its record and its track. */
static bool is_record(const unsigned char *bytes, uint64_t *size)
{
    const uint64_t track = stp_las_u64(bytes + AT_TRACK);
    for (int k = 0; k < 3; k++)
        if (!isfinite(stp_las_double(bytes + AT_XYZ + 8 * k)))
            return false;
    *size = RECORD_BYTES + track * TRACK_BYTES;
    return track < TRACK_LIMIT && isfinite(stp_las_double(bytes + AT_ERROR));
}

bool stp_colmap_may_be(const char *bytes, size_t length, uint64_t file_size)
{
    const unsigned char *b = (const unsigned char *)bytes;
    if (length < COUNT_BYTES + RECORD_BYTES)
        return false;
    const uint64_t count = stp_las_u64(b);
    uint64_t at = COUNT_BYTES, size = 0, points = 0;
    if (count == 0 || count > (file_size - COUNT_BYTES) / RECORD_BYTES)
        return false;
    for (; points < count && at + RECORD_BYTES <= length; points++, at += size)
        if (!is_record(b + at, &size))
            return false;
    return points < count ? at < file_size : at == file_size;
}

static stp_status cut(const reader *r, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: ends at byte %" PRIu64 ", after %" PRIu64 " of %" PRIu64
                         " points: the file was cut; copy it again",
                         r->source.path, r->source.size, r->next, r->count);
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    const unsigned char *bytes;
    size_t available;
    (void)params;
    r->source.descriptor = -1;
    STP_TRY(stp_source_open(&r->source, path, err));
    STP_TRY(stp_source_peek(&r->source, COUNT_BYTES, &bytes, &available, err));
    r->count = available < COUNT_BYTES ? 0 : stp_las_u64(bytes);
    if (available < COUNT_BYTES || r->count > (r->source.size - COUNT_BYTES) / RECORD_BYTES)
        return cut(r, err);
    stp_source_consume(&r->source, COUNT_BYTES);
    info->format = "COLMAP points";
    info->point_count = r->count;
    info->attributes = STP_POINT_HAS_COLOUR;
    info->y_down = true;
    r->notes[0] = (stp_scan_note){"columns", "_,x,y,z,red,green,blue,_ (by content)"};
    r->notes[1] = (stp_scan_note){"left_out", "POINT3D_ID, ERROR, TRACK"};
    info->notes = r->notes;
    info->note_count = 2;
done:
    return status;
}

static stp_status read_point(reader *r, stp_point *point, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *b;
    size_t available;
    STP_TRY(stp_source_peek(&r->source, RECORD_BYTES, &b, &available, err));
    if (available < RECORD_BYTES)
        return cut(r, err);
    *point = (stp_point){.position = {stp_las_double(b + AT_XYZ), stp_las_double(b + AT_XYZ + 8),
                                      stp_las_double(b + AT_XYZ + 16)}};
    for (int k = 0; k < 3; k++)
        point->rgb[k] = (uint16_t)(257u * b[AT_RGB + k]);
    const uint64_t track = stp_las_u64(b + AT_TRACK);
    stp_source_consume(&r->source, RECORD_BYTES);
    if (track > (r->source.size - r->source.offset) / TRACK_BYTES)
        return cut(r, err);
    stp_source_skip(&r->source, track * TRACK_BYTES);
    r->next++;
done:
    return status;
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    size_t done_count = 0;
    for (; done_count < capacity && r->next < r->count; done_count++)
        STP_TRY(read_point(r, &points[done_count], err));
    *count = done_count;
done:
    return status;
}

static void close_reader(void *state)
{
    stp_source_close(&((reader *)state)->source);
}

const stp_scan_reader stp_colmap_reader = {sizeof(reader), open_reader, read_points,
                                           close_reader,   NULL,        NULL};
