/* Reads turns of a lidar in floats. */
#include "formats/scan/kitti/kitti.h"

#include "base/memory.h"
#include "formats/scan/source.h"
#include "formats/scan/value_range.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define LOOK_BYTES 65536u
#define FARTHEST 1000.0f
#define RECORDS_LEAST 16u
#define BLOCK_RECORDS 4096u

typedef struct reader {
    stp_source source;
    uint32_t floats; /* of a record, 4 or 5 */
    uint64_t count, next;
    double intensity_scale;
    stp_dvec3 station, up;
    stp_scan_note notes[2];
} reader;

static void take(float out[5], const char *bytes, uint32_t floats)
{
    memcpy(out, bytes, floats * sizeof *out);
}

/* Whether all records may be those of a lidar; most: their greatest intensity. It stands at the
 * origin, so that some coordinate is negative: heights and corners of meshes often have none. */
static bool are_records(const char *bytes, size_t length, uint32_t floats, float *most)
{
    const size_t count = length / (floats * sizeof(float));
    bool differ = false, negative = false;
    float v[5] = {0.0f}, first[5] = {0.0f};
    *most = 0.0f;
    for (size_t i = 0; i < count; i++) {
        take(v, bytes + i * floats * sizeof(float), floats);
        if (i == 0)
            memcpy(first, v, sizeof first);
        for (int k = 0; k < 3; k++) {
            if (!(fabsf(v[k]) < FARTHEST) || (v[k] != 0.0f && fabsf(v[k]) < FLT_MIN))
                return false;
            differ = differ || v[k] != first[k];
            negative = negative || v[k] < 0.0f;
        }
        if (!(v[3] >= 0.0f && v[3] <= 255.0f) ||
            (floats == 5 && !(v[4] >= 0.0f && v[4] < 256.0f && v[4] == floorf(v[4]))))
            return false;
        *most = fmaxf(*most, v[3]);
    }
    return count >= RECORDS_LEAST && differ && negative;
}

/* The floats of a record; 0: it is none of these. */
static uint32_t floats_of(const char *bytes, size_t length, uint64_t size, float *most)
{
    for (uint32_t floats = 5; floats >= 4; floats--)
        if (size % (floats * sizeof(float)) == 0 && are_records(bytes, length, floats, most))
            return floats;
    return 0;
}

bool stp_kitti_may_be(const char *bytes, size_t length, uint64_t file_size)
{
    float most;
    return floats_of(bytes, length, file_size, &most) > 0;
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    const unsigned char *bytes;
    size_t length;
    float most = 0.0f;
    (void)params;
    r->source.descriptor = -1;
    STP_TRY(stp_source_open(&r->source, path, err));
    STP_TRY(stp_source_peek(&r->source, LOOK_BYTES, &bytes, &length, err));
    r->floats = floats_of((const char *)bytes, length, r->source.size, &most);
    if (r->floats == 0)
        return stp_error_set(err, STP_CORRUPT,
                             "%s has no records of x y z intensity, or of these and a ring, as "
                             "floats: copy or export it again",
                             path);
    r->count = r->source.size / (r->floats * sizeof(float));
    const stp_value_range range = stp_value_range_guess(true, 4, (double)most);
    r->intensity_scale = stp_value_range_scale(range);
    r->up.z = 1.0;
    info->format = "KITTI frame";
    info->point_count = r->count;
    info->attributes = STP_POINT_HAS_INTENSITY | STP_POINT_HAS_STATION;
    info->intensity_full = range.high;
    info->heights = true;
    info->stations = &r->station;
    info->station_ups = &r->up;
    info->station_count = 1;
    info->station_word = STP_STATION_TOLD;
    info->seek_points = 1;
    r->notes[0] =
        (stp_scan_note){"columns", r->floats == 4 ? "x,y,z,intensity (by name and content)"
                                                  : "x,y,z,intensity,_ (by name and content)"};
    r->notes[1] = (stp_scan_note){"left_out", "ring"};
    info->notes = r->notes;
    info->note_count = r->floats - 3;
done:
    return status;
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    const unsigned char *records;
    size_t available, part = capacity < BLOCK_RECORDS ? capacity : BLOCK_RECORDS;
    const size_t bytes = r->floats * sizeof(float);
    part = r->count - r->next < part ? (size_t)(r->count - r->next) : part;
    STP_TRY(stp_source_peek(&r->source, part * bytes, &records, &available, err));
    if (available < part * bytes)
        return stp_error_set(err, STP_CORRUPT, "%s was cut while it was read: copy it again",
                             r->source.path);
    for (size_t i = 0; i < part; i++) {
        float v[5];
        take(v, (const char *)records + i * bytes, r->floats);
        points[i] =
            (stp_point){.position = {(double)v[0], (double)v[1], (double)v[2]},
                        .intensity = stp_value_range_map((double)v[3], 0.0, r->intensity_scale),
                        .station = 1};
    }
    stp_source_consume(&r->source, part * bytes);
    r->next += part;
    *count = part;
done:
    return status;
}

static stp_status seek_reader(void *state, uint64_t point, stp_error *err)
{
    reader *r = state;
    (void)err;
    r->source.narrow = true;
    stp_source_seek(&r->source, point * r->floats * sizeof(float), 0);
    r->next = point;
    return STP_OK;
}

static void close_reader(void *state)
{
    stp_source_close(&((reader *)state)->source);
}

const stp_scan_reader stp_kitti_reader = {sizeof(reader), open_reader, read_points,
                                          close_reader,   seek_reader, NULL};
