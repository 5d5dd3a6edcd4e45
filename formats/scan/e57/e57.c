/* Reads E57 files as a stream of points. */
#include "formats/scan/e57/e57.h"

#include "base/checked.h"
#include "base/memory.h"
#include "formats/scan/e57/e57_images.h"
#include "formats/scan/e57/e57_numbers.h"
#include "formats/scan/e57/e57_pose.h"
#include "formats/scan/e57/e57_prototype.h"
#include "formats/scan/e57/e57_ranges.h"
#include "formats/scan/e57/e57_vector.h"
#include "formats/scan/mesh/point_mesh.h"
#include "formats/scan/value_range.h"

#include <math.h>
#include <stdlib.h>

typedef struct reader {
    stp_e57_pages pages;
    stp_e57_document document;
    stp_e57_vector vector; /* of the scan that is being read */
    size_t next_scan;
    uint64_t point_count, points_left; /* of all scans */
    uint16_t station;                  /* of the scan that is being read; 0: unknown */
    stp_e57_pose pose;
    uint32_t attributes; /* STP_POINT_HAS_* */
    stp_e57_ranges ranges;
    stp_e57_numbers numbers;
    stp_e57_images images;
    stp_dvec3 *stations, *ups; /* positions and z axes of scans that have a station, in order */
    uint16_t station_count, stations_begun;
    stp_scan_note notes[2];
} reader;

static bool has_all(const stp_e57_scan *scan, stp_e57_target first, stp_e57_target last)
{
    for (int t = (int)first; t <= (int)last; t++)
        if (!scan->fields[t].present)
            return false;
    return true;
}

/* Marks the fields from first to last as not used. */
static void drop(reader *r, stp_e57_scan *scan, stp_e57_target first, stp_e57_target last)
{
    for (int t = (int)first; t <= (int)last; t++)
        stp_e57_leave_out(&r->document, scan, (stp_e57_target)t);
}

static bool has_extra_time(const reader *r, const stp_e57_scan *scan)
{
    for (uint32_t e = 0; e < scan->extra_count; e++)
        if (r->document.extras[scan->extra_first + e].invalid == STP_E57_TIME_INVALID)
            return true;
    return false;
}

/* Drops fields that cannot be used: a part is missing, there is a better field, or the field says
 * whether a missing field is valid. */
static void drop_useless(reader *r, stp_e57_scan *scan)
{
    if (!has_all(scan, STP_E57_X, STP_E57_Z)) {
        drop(r, scan, STP_E57_X, STP_E57_Z);
        drop(r, scan, STP_E57_CARTESIAN_INVALID, STP_E57_CARTESIAN_INVALID);
    }
    if (has_all(scan, STP_E57_X, STP_E57_Z) || !has_all(scan, STP_E57_RANGE, STP_E57_ELEVATION)) {
        drop(r, scan, STP_E57_RANGE, STP_E57_ELEVATION);
        drop(r, scan, STP_E57_SPHERICAL_INVALID, STP_E57_SPHERICAL_INVALID);
    }
    if (!has_all(scan, STP_E57_NX, STP_E57_NZ))
        drop(r, scan, STP_E57_NX, STP_E57_NZ);
    if (!has_all(scan, STP_E57_RED, STP_E57_BLUE))
        drop(r, scan, STP_E57_RED, STP_E57_COLOUR_INVALID);
    if (!scan->fields[STP_E57_INTENSITY].present)
        drop(r, scan, STP_E57_INTENSITY_INVALID, STP_E57_INTENSITY_INVALID);
    if (!r->document.keeps_numbers || !has_extra_time(r, scan))
        drop(r, scan, STP_E57_TIME_INVALID, STP_E57_TIME_INVALID);
}

static stp_status decide_scan(reader *r, stp_e57_scan *scan, stp_error *err)
{
    if (!scan->has_points)
        scan->record_count = 0;
    scan->has_grid |= scan->fields[STP_E57_RANGE].present;
    drop_useless(r, scan);
    if (scan->record_count == 0)
        return STP_OK;
    if (!scan->fields[STP_E57_X].present && !scan->fields[STP_E57_RANGE].present)
        return stp_error_set(
            err, STP_CORRUPT,
            "%s: the scan with points at byte %llu has neither all of cartesianX, "
            "Y and Z nor of sphericalRange, Azimuth and Elevation: export the file "
            "again",
            r->pages.path, (unsigned long long)scan->file_offset);
    if (scan->fields[STP_E57_NX].present)
        r->attributes |= STP_POINT_HAS_NORMAL;
    if (scan->fields[STP_E57_INTENSITY].present)
        r->attributes |= STP_POINT_HAS_INTENSITY;
    if (scan->fields[STP_E57_CLASS].present)
        r->attributes |= STP_POINT_HAS_CLASS;
    return STP_OK;
}

/* True if the scan was seen from its pose: see e57.h. */
static bool has_station(const stp_e57_scan *scan, const stp_e57_pose *pose)
{
    return scan->record_count > 0 && scan->has_pose && (!pose->is_identity || scan->has_grid);
}

/* Rejects a wrong section before the first point is read, and scans that share their bytes:
 * together they may not be larger than the file. *bits is the sum so far. */
static stp_status check_section(reader *r, const stp_e57_scan *scan, uint64_t *bits, stp_error *err)
{
    stp_status status = STP_OK;
    if (scan->record_count == 0)
        return STP_OK;
    STP_TRY(stp_e57_vector_open(&r->vector, &r->pages, scan, err));
    /* No overflow: the vector's section holds this many bits. */
    if (!stp_add_u64(*bits, scan->record_count * scan->record_bits, bits) ||
        *bits / 8 > r->pages.size)
        return stp_error_set(
            err, STP_CORRUPT,
            "%s: the scans up to that with points at byte %llu declare more points "
            "than the file holds: it is damaged; copy or export it again",
            r->pages.path, (unsigned long long)scan->file_offset);
    r->points_left += scan->record_count;
done:
    return status;
}

/* Drops a scan's colours if they are all zero: a program wrote them for want of any. */
static stp_status decide_colours(reader *r, stp_e57_scan *scan, stp_error *err)
{
    stp_status status = STP_OK;
    stp_e57_vector *v = &r->vector;
    if (!scan->fields[STP_E57_RED].present || scan->record_count == 0)
        return STP_OK;
    STP_TRY(stp_e57_vector_open(v, &r->pages, scan, err));
    bool coloured = false;
    while (!coloured && v->index < scan->record_count) {
        const uint64_t left = scan->record_count - v->index;
        const size_t count = left < STP_E57_BLOCK_POINTS ? (size_t)left : STP_E57_BLOCK_POINTS;
        coloured = stp_e57_vector_read(v, count, NULL) != STP_OK; /* reading the points says why */
        for (size_t i = 0; !coloured && i < count; i++)
            for (int t = STP_E57_RED; t <= STP_E57_BLUE; t++)
                coloured |= v->columns[t][i] != 0.0;
    }
    if (coloured)
        r->attributes |= STP_POINT_HAS_COLOUR;
    else
        drop(r, scan, STP_E57_RED, STP_E57_COLOUR_INVALID);
done:
    return status;
}

static stp_status decide_scans(reader *r, stp_error *err)
{
    stp_status status = STP_OK;
    stp_e57_pose pose;
    uint64_t bits = 0;
    STP_TRY(stp_alloc(&r->stations, r->document.scan_count, sizeof *r->stations, "stations", err));
    STP_TRY(stp_e57_vector_create(&r->vector, &r->document, err));
    STP_TRY(stp_alloc(&r->ups, r->document.scan_count, sizeof *r->ups, "stations", err));
    for (size_t i = 0; i < r->document.scan_count; i++) {
        stp_e57_scan *scan = &r->document.scans[i];
        STP_TRY(decide_scan(r, scan, err));
        STP_TRY(stp_e57_pose_of(&pose, scan, r->pages.path, err));
        const bool stands = has_station(scan, &pose);
        if (stands) {
            r->ups[r->station_count] = stp_e57_rotate(&pose, (stp_dvec3){0.0, 0.0, 1.0});
            r->stations[r->station_count++] = pose.translation;
        }
        const uint64_t first = r->points_left;
        STP_TRY(check_section(r, scan, &bits, err));
        STP_TRY(decide_colours(r, scan, err));
        if (stands)
            STP_TRY(stp_e57_images_add(&r->images, scan, first, r->station_count, &r->vector,
                                       &r->pages, err));
    }
    if (r->station_count > 0)
        r->attributes |= STP_POINT_HAS_STATION;
    STP_TRY(stp_e57_ranges_find(&r->ranges, &r->document, &r->vector, &r->pages, err));
    stp_e57_numbers_find(&r->numbers, &r->document, &r->ranges);
done:
    return status;
}

/* The finest scale of whole coordinates; 0 if a scan has others. */
static double coordinate_step(const stp_e57_document *document)
{
    double step = INFINITY;
    for (size_t i = 0; i < document->scan_count; i++) {
        const stp_e57_scan *scan = &document->scans[i];
        for (int t = STP_E57_X; t <= STP_E57_Z && scan->record_count > 0; t++) {
            const stp_e57_field *field = &scan->fields[t];
            if (!field->present || field->type != STP_E57_INTEGER)
                return 0.0;
            step = fmin(step, fabs(field->scale));
        }
    }
    return isfinite(step) ? step : 0.0;
}

static void fill_info(reader *r, stp_scan_info *info)
{
    info->format = "E57";
    info->point_count = r->point_count = r->points_left;
    info->seek_points = info->point_count > 0;
    info->seek_reads = true;
    info->attributes = r->attributes;
    info->heights = true;
    info->coordinate_step = coordinate_step(&r->document);
    info->stations = r->stations;
    info->station_ups = r->ups;
    info->station_count = r->station_count;
    info->images = r->images.list;
    info->image_count = r->images.count;
    info->pixels_told = r->images.count > 0;
    info->extra = r->numbers.all.list.count > 0 ? &r->numbers.all.list : NULL;
    info->notes = r->notes;
    info->note_count = 0;
    if (r->document.wkt)
        r->notes[info->note_count++] = (stp_scan_note){"wkt", r->document.wkt};
    if (r->document.left_out.text[0])
        r->notes[info->note_count++] = (stp_scan_note){"left_out", r->document.left_out.text};
}

/* Sets the records' positions, in the scan's own coordinates. */
static void set_positions(const reader *r, stp_point *points, size_t count)
{
    const double(*c)[STP_E57_BLOCK_POINTS] = r->vector.columns;
    if (r->vector.scan->fields[STP_E57_X].present) {
        for (size_t i = 0; i < count; i++)
            points[i].position = (stp_dvec3){c[STP_E57_X][i], c[STP_E57_Y][i], c[STP_E57_Z][i]};
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const double range = c[STP_E57_RANGE][i];
        const double azimuth = c[STP_E57_AZIMUTH][i], elevation = c[STP_E57_ELEVATION][i];
        points[i].position =
            (stp_dvec3){range * cos(elevation) * cos(azimuth),
                        range * cos(elevation) * sin(azimuth), range * sin(elevation)};
    }
}

/* Sets rejects from the records' states: 0 valid, 1 only the direction, 2 nothing. The scanner
 * stands at the origin of the scan's own coordinates, so it saw no point there. */
static void set_rejects(const reader *r, stp_point *points, size_t count)
{
    const stp_e57_scan *scan = r->vector.scan;
    const stp_e57_target target =
        scan->fields[STP_E57_X].present ? STP_E57_CARTESIAN_INVALID : STP_E57_SPHERICAL_INVALID;
    const double *states = scan->fields[target].present ? r->vector.columns[target] : NULL;
    for (size_t i = 0; i < count; i++)
        if (states && states[i] != 0.0)
            points[i].reject = states[i] == 1.0 ? STP_REJECT_NO_RETURN : STP_REJECT_INVALID;
        else if (scan->has_grid && stp_dvec3_equal(points[i].position, (stp_dvec3){0.0, 0.0, 0.0}))
            points[i].reject = STP_REJECT_ORIGIN;
}

static void apply_pose(const reader *r, stp_point *points, size_t count)
{
    if (r->pose.is_identity)
        return;
    for (size_t i = 0; i < count; i++)
        points[i].position =
            stp_dvec3_add(stp_e57_rotate(&r->pose, points[i].position), r->pose.translation);
}

static void set_normals(const reader *r, stp_point *points, size_t count)
{
    const double(*c)[STP_E57_BLOCK_POINTS] = r->vector.columns;
    if (!r->vector.scan->fields[STP_E57_NX].present)
        return;
    for (size_t i = 0; i < count; i++)
        points[i].normal = stp_unit_normal(stp_e57_rotate(
            &r->pose, (stp_dvec3){c[STP_E57_NX][i], c[STP_E57_NY][i], c[STP_E57_NZ][i]}));
}

/* True if the record's value is valid according to the field `invalid`. */
static bool is_valid(const reader *r, stp_e57_target invalid, size_t i)
{
    return !r->vector.scan->fields[invalid].present || r->vector.columns[invalid][i] == 0.0;
}

static void set_colours(const reader *r, stp_point *points, size_t count)
{
    const bool present = r->vector.scan->fields[STP_E57_RED].present;
    const double low = r->ranges.colour.low, scale = stp_value_range_scale(r->ranges.colour);
    for (size_t i = 0; i < count; i++) {
        const bool valid = present && is_valid(r, STP_E57_COLOUR_INVALID, i);
        for (int k = 0; k < 3; k++)
            points[i].rgb[k] =
                valid ? stp_value_range_map(r->vector.columns[STP_E57_RED + k][i], low, scale)
                      : STP_POINT_GREY;
    }
}

static void set_scalars(const reader *r, stp_point *points, size_t count)
{
    const stp_e57_scan *scan = r->vector.scan;
    const double low = r->ranges.intensity.low;
    const double *intensity = r->vector.columns[STP_E57_INTENSITY];
    const double *class_id = r->vector.columns[STP_E57_CLASS];
    if (scan->fields[STP_E57_INTENSITY].present) {
        const double scale = stp_value_range_scale(r->ranges.intensity);
        for (size_t i = 0; i < count; i++)
            if (is_valid(r, STP_E57_INTENSITY_INVALID, i))
                points[i].intensity = stp_value_range_map(intensity[i], low, scale);
    }
    if (scan->fields[STP_E57_CLASS].present)
        for (size_t i = 0; i < count; i++)
            points[i].class_id = stp_class_of(class_id[i]);
}

static void columns_to_points(const reader *r, stp_point *points, size_t count)
{
    for (size_t i = 0; i < count; i++)
        points[i] = (stp_point){.station = r->station};
    set_positions(r, points, count);
    set_rejects(r, points, count);
    apply_pose(r, points, count);
    set_normals(r, points, count);
    if (r->attributes & STP_POINT_HAS_COLOUR)
        set_colours(r, points, count);
    set_scalars(r, points, count);
    if (r->images.count > 0)
        stp_e57_images_tell(&r->images, &r->vector, r->station, points, count);
}

/* Goes to the next scan that has points. The caller knows that there is one. */
static stp_status begin_scan(reader *r, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_e57_scan *scan = &r->document.scans[r->next_scan];
    while (scan->record_count == 0)
        scan++;
    r->next_scan = (size_t)(scan - r->document.scans) + 1;
    STP_TRY(stp_e57_vector_open(&r->vector, &r->pages, scan, err));
    stp_e57_numbers_begin(&r->numbers, &r->document, scan);
    STP_TRY(stp_e57_pose_of(&r->pose, scan, r->pages.path, err));
    r->station = 0;
    if (has_station(scan, &r->pose))
        r->station = ++r->stations_begun;
done:
    return status;
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    stp_e57_vector *v = &r->vector;
    size_t got = 0;
    if (r->document.keeps_numbers)
        STP_TRY(stp_e57_numbers_reserve(&r->numbers, capacity, err));
    while (got < capacity && r->points_left > 0) {
        if (!v->scan || v->index == v->scan->record_count)
            STP_TRY(begin_scan(r, err));
        size_t part = capacity - got;
        const uint64_t left = v->scan->record_count - v->index;
        part = part < STP_E57_BLOCK_POINTS ? part : STP_E57_BLOCK_POINTS;
        part = part < left ? part : (size_t)left;
        STP_TRY(stp_e57_vector_read(v, part, err));
        columns_to_points(r, points + got, part);
        if (r->document.keeps_numbers)
            stp_e57_numbers_pack(&r->numbers, v, got, part);
        got += part;
        r->points_left -= part;
    }
    *count = got;
done:
    return status;
}

static stp_status seek_record(void *state, uint64_t point, stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    r->points_left = r->point_count - point;
    r->next_scan = 0;
    r->stations_begun = 0;
    STP_TRY(begin_scan(r, err));
    while (point >= r->vector.scan->record_count) {
        point -= r->vector.scan->record_count;
        STP_TRY(begin_scan(r, err));
    }
    STP_TRY(stp_e57_vector_seek(&r->vector, point, err));
done:
    return status;
}

static void close_reader(void *state)
{
    reader *r = state;
    stp_e57_pages_close(&r->pages);
    stp_e57_vector_free(&r->vector);
    stp_e57_numbers_clear(&r->numbers);
    stp_e57_images_clear(&r->images);
    stp_e57_document_free(&r->document);
    free(r->stations);
    free(r->ups);
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    r->pages.descriptor = -1;
    r->document.keeps_numbers = params->numbers;
    r->document.keeps_grid = params->keep_grid;
    STP_TRY(stp_e57_pages_open(&r->pages, path, err));
    STP_TRY(stp_e57_xml_read(&r->document, &r->pages, err));
    STP_TRY(decide_scans(r, err));
    r->vector.scan = NULL; /* finding the ranges moved the vector */
    fill_info(r, info);
done:
    return status;
}

static const uint8_t *packed_numbers(const void *state)
{
    return ((const reader *)state)->numbers.packed;
}

const stp_scan_reader stp_e57_reader = {sizeof(reader), open_reader, read_points,
                                        close_reader,   seek_record, packed_numbers};
