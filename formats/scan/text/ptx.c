/* Reads scans on a grid, each with a pose. */
#include "formats/scan/text/ptx.h"

#include "base/checked.h"
#include "base/memory.h"
#include "formats/scan/text/text.h"
#include "formats/scan/text/text_count.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STP_PTX_HEADER_LINES 10
/* Tolerance for zeros and ones as programs print them. */
#define STP_PTX_TOLERANCE 1e-6
#define STP_PTX_FIELDS_MAX 7
/* About this many points of each scan are sampled for the range of colours and intensities. */
#define STP_PTX_SAMPLE_POINTS 4096

typedef struct ptx_scan {
    double pose[3][4]; /* world = pose * (x, y, z, 1) */
    uint64_t columns, rows, point_count;
    uint32_t fields; /* numbers per point; 0: no point has a return */
} ptx_scan;

typedef struct ptx {
    stp_text text;
    ptx_scan *scans;
    size_t scan_count, scan_capacity;
    stp_dvec3 *stations, *ups; /* per scan: the position of its scanner, and its z axis */
    size_t station_capacity, up_capacity;
    stp_scan_image *images; /* of several scans, if they are wanted */
    uint64_t start;         /* byte of the first scan */
    size_t current;         /* scan that is being read, counted from 1; 0 before the first */
    uint64_t left;          /* points of that scan that are not read yet */
    bool has_colour;        /* at least one scan has colours */
    stp_columns_sample samples[STP_PTX_FIELDS_MAX + 1]; /* by count of numbers per point */
} ptx;

static stp_status ends_in_header(const stp_text *text, const char *what, stp_error *err)
{
    return stp_error_set(
        err, STP_CORRUPT,
        "%s: ends at line %llu within the header of a scan, before %s: the file was "
        "cut; copy or export it again",
        text->source.path, (unsigned long long)text->source.line, what);
}

/* Reads the next line: exactly `count` finite numbers. */
static stp_status read_numbers(stp_text *text, unsigned count, const char *what, double *out,
                               stp_error *err)
{
    stp_status status = STP_OK;
    const char *begin, *end;
    STP_TRY(stp_text_next(text, &begin, &end, err));
    if (!begin)
        return ends_in_header(text, what, err);
    stp_field field;
    const char *at = begin;
    unsigned found = 0;
    while (stp_field_next(STP_SEPARATOR_SPACE, &at, end, &field)) {
        double value = NAN;
        if (!stp_field_number(STP_SEPARATOR_SPACE, field, &value) || !isfinite(value) ||
            found == count)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: line %llu: expected %u numbers, %s, found `%.*s`: mend the "
                                 "header of the scan or export the file again",
                                 text->source.path, (unsigned long long)text->source.line, count,
                                 what, end - begin < 60 ? (int)(end - begin) : 60, begin);
        out[found++] = value;
    }
    if (found < count)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: line %llu: expected %u numbers, %s, found %u: mend the header of "
                             "the scan or export the file again",
                             text->source.path, (unsigned long long)text->source.line, count, what,
                             found);
done:
    return status;
}

static bool is_near(const double *values, double a, double b, double c, double d)
{
    return fabs(values[0] - a) <= STP_PTX_TOLERANCE && fabs(values[1] - b) <= STP_PTX_TOLERANCE &&
           fabs(values[2] - c) <= STP_PTX_TOLERANCE && fabs(values[3] - d) <= STP_PTX_TOLERANCE;
}

/* Converts the matrix of the file to one that multiplies a column vector. False if it is no pose.
 */
static bool decide_pose(double file[4][4], double pose[3][4])
{
    double m[4][4];
    const double last_column[4] = {file[0][3], file[1][3], file[2][3], file[3][3]};
    const bool rows = is_near(last_column, 0.0, 0.0, 0.0, 1.0);
    if (!rows && !is_near(file[3], 0.0, 0.0, 0.0, 1.0))
        return false;
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            m[i][k] = rows ? file[k][i] : file[i][k];
    memcpy(pose, m, sizeof(double[3][4]));
    const stp_dvec3 a = {m[0][0], m[0][1], m[0][2]}, b = {m[1][0], m[1][1], m[1][2]},
                    c = {m[2][0], m[2][1], m[2][2]};
    const double volume = fabs(stp_dvec3_dot(a, stp_dvec3_cross(b, c)));
    return volume > 0.0 && isfinite(volume);
}

static bool is_identity(const ptx_scan *scan)
{
    return is_near(scan->pose[0], 1.0, 0.0, 0.0, 0.0) &&
           is_near(scan->pose[1], 0.0, 1.0, 0.0, 0.0) && is_near(scan->pose[2], 0.0, 0.0, 1.0, 0.0);
}

/* Reads the pose that follows the two numbers. */
static stp_status read_pose(stp_text *text, ptx_scan *scan, stp_dvec3 *station, stp_error *err)
{
    static const char *const axes[] = {"the scanner's x axis", "the scanner's y axis",
                                       "the scanner's z axis"};
    stp_status status = STP_OK;
    double position[3], axis[3], matrix[4][4];
    STP_TRY(read_numbers(text, 3, "the scanner's position", position, err));
    for (int i = 0; i < 3; i++)
        STP_TRY(read_numbers(text, 3, axes[i], axis, err));
    for (int i = 0; i < 4; i++)
        STP_TRY(read_numbers(text, 4, "a row of the pose", matrix[i], err));
    if (!decide_pose(matrix, scan->pose))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: the pose in lines %llu to %llu is none: expected three axes, a "
                             "translation and 0 0 0 1; mend the header of the scan or export the "
                             "file again",
                             text->source.path, (unsigned long long)text->source.line - 3,
                             (unsigned long long)text->source.line);
    if (is_identity(scan))
        *station = (stp_dvec3){position[0], position[1], position[2]};
    else
        *station = (stp_dvec3){scan->pose[0][3], scan->pose[1][3], scan->pose[2][3]};
done:
    return status;
}

/* True if the line is a ray without a return. */
static bool is_missing(const char *begin, const char *end)
{
    stp_field field;
    double value;
    const char *at = begin;
    for (int i = 0; i < 3; i++)
        if (!stp_field_next(STP_SEPARATOR_SPACE, &at, end, &field) ||
            !stp_field_number(STP_SEPARATOR_SPACE, field, &value) || value != 0.0)
            return false;
    return true;
}

/* Reads a scan's points once. Line header_line declared their number. */
static stp_status survey_points(ptx *p, ptx_scan *scan, uint64_t header_line, stp_error *err)
{
    stp_status status = STP_OK;
    stp_text *text = &p->text;
    const char *begin, *end;
    const uint64_t stride = scan->point_count / STP_PTX_SAMPLE_POINTS + 1;
    for (uint64_t i = 0; i < scan->point_count; i++) {
        STP_TRY(stp_text_next(text, &begin, &end, err));
        if (!begin || stp_text_is_count(begin, end))
            return stp_text_few_lines(text, header_line, scan->point_count, i, err);
        if ((scan->fields > 0 && i % stride > 0) || is_missing(begin, end))
            continue;
        const uint32_t fields = stp_fields_count(STP_SEPARATOR_SPACE, begin, end).fields;
        if (scan->fields == 0 && fields != 3 && fields != 4 && fields != 6 && fields != 7)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: line %llu has %u numbers, where a point of a PTX file has 3, "
                                 "4, 6 or 7: mend the line or export the file again",
                                 text->source.path, (unsigned long long)text->source.line, fields);
        scan->fields = scan->fields > 0 ? scan->fields : fields;
        if (fields == scan->fields)
            stp_columns_sample_add(&p->samples[fields], STP_SEPARATOR_SPACE, begin, end);
    }
done:
    return status;
}

static stp_status add_scan(ptx *p, const ptx_scan *scan, stp_dvec3 station, stp_error *err)
{
    stp_status status = STP_OK;
    if (p->scan_count == STP_STATION_LIMIT)
        return stp_error_set(err, STP_LIMIT, "%s: more than %u scans, by line %llu: split the file",
                             p->text.source.path, STP_STATION_LIMIT,
                             (unsigned long long)p->text.source.line);
    STP_TRY(
        stp_grow(&p->scans, &p->scan_capacity, p->scan_count + 1, sizeof *p->scans, "scans", err));
    STP_TRY(stp_grow(&p->stations, &p->station_capacity, p->scan_count + 1, sizeof *p->stations,
                     "stations", err));
    STP_TRY(stp_grow(&p->ups, &p->up_capacity, p->scan_count + 1, sizeof *p->ups, "stations", err));
    p->scans[p->scan_count] = *scan;
    p->ups[p->scan_count] = (stp_dvec3){scan->pose[0][2], scan->pose[1][2], scan->pose[2][2]};
    p->stations[p->scan_count++] = station;
done:
    return status;
}

static stp_status survey(ptx *p, uint64_t *point_count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_text *text = &p->text;
    uint64_t total = 0;
    for (;;) {
        ptx_scan scan = {.fields = 0};
        stp_dvec3 station = {0.0, 0.0, 0.0};
        STP_TRY(stp_text_next_count(text, "the number of columns of a scan", &scan.columns, err));
        if (scan.columns == STP_TEXT_NO_COUNT)
            break;
        const uint64_t line = text->source.line;
        STP_TRY(stp_text_next_count(text, "the number of rows of a scan", &scan.rows, err));
        if (scan.rows == STP_TEXT_NO_COUNT)
            return ends_in_header(text, "the number of rows", err);
        if (!stp_mul_u64(scan.columns, scan.rows, &scan.point_count) ||
            !stp_add_u64(total, scan.point_count, &total))
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: line %llu: a scan of %llu columns and %llu rows: no file has "
                                 "so many points; mend the header or export the file again",
                                 text->source.path, (unsigned long long)line,
                                 (unsigned long long)scan.columns, (unsigned long long)scan.rows);
        STP_TRY(read_pose(text, &scan, &station, err));
        STP_TRY(survey_points(p, &scan, line, err));
        STP_TRY(add_scan(p, &scan, station, err));
    }
    *point_count = total;
done:
    return status;
}

/* The columns of points with this count of numbers. */
static stp_columns columns_of(uint32_t fields)
{
    stp_columns c = {.separator = STP_SEPARATOR_SPACE, .count = fields};
    for (uint32_t i = 0; i < 3; i++)
        c.targets[i] = (uint8_t)i;
    uint32_t at = 3;
    if (fields == 4 || fields == 7)
        c.targets[at++] = STP_COLUMN_INTENSITY;
    for (uint32_t k = 0; at < fields; k++)
        c.targets[at++] = (uint8_t)(STP_COLUMN_RED + k);
    return c;
}

/* Sets the attributes of all scans, and the scales from the points with the most numbers. */
static void decide_columns(ptx *p)
{
    stp_text *text = &p->text;
    uint32_t all = 0;
    for (uint32_t fields = 3; fields <= STP_PTX_FIELDS_MAX; fields++) {
        if (p->samples[fields].rows == 0)
            continue;
        text->columns = columns_of(fields);
        stp_text_decide(text, &p->samples[fields]);
        all |= text->attributes;
    }
    text->attributes = all | STP_POINT_HAS_STATION;
    p->has_colour = all & STP_POINT_HAS_COLOUR;
}

/* A file's points stand column by column, an image's pixels row by row. */
static stp_status list_images(ptx *p, stp_scan_info *info, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t first = 0;
    STP_TRY(stp_alloc(&p->images, p->scan_count, sizeof *p->images, "images", err));
    for (size_t i = 0; i < p->scan_count; first += p->scans[i++].point_count) {
        const ptx_scan *s = &p->scans[i];
        if (s->point_count == 0 || s->point_count >= UINT32_MAX)
            continue;
        p->images[info->image_count++] = (stp_scan_image){.first = first,
                                                          .count = s->point_count,
                                                          .columns = (uint32_t)s->rows,
                                                          .rows = (uint32_t)s->columns,
                                                          .station = (uint16_t)(i + 1)};
    }
    info->images = p->images;
done:
    return status;
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    ptx *p = state;
    stp_text *text = &p->text;
    text->source.descriptor = -1;
    text->numbers.keep = params->numbers;
    for (uint32_t fields = 0; fields <= STP_PTX_FIELDS_MAX; fields++)
        p->samples[fields].count = fields;
    STP_TRY(stp_text_open(text, path, err));
    p->start = text->source.offset;
    STP_TRY(survey(p, &info->point_count, err));
    decide_columns(p);
    stp_text_fill_info(text, NULL, info);
    info->format = "PTX";
    info->heights = true;
    info->stations = p->stations;
    info->station_ups = p->ups;
    info->station_count = (uint32_t)p->scan_count;
    const ptx_scan *s = p->scans;
    if (params->keep_grid && p->scan_count == 1 && s->columns <= UINT32_MAX &&
        s->rows <= UINT32_MAX)
        info->grid = (stp_scan_grid){.columns = (uint32_t)s->rows, .rows = (uint32_t)s->columns};
    else if (params->keep_grid)
        STP_TRY(list_images(p, info, err));
    stp_source_seek(&text->source, p->start, 0);
done:
    return status;
}

/* Goes to the points of the next scan. After the last scan, p->current stays. */
static stp_status next_scan(ptx *p, stp_error *err)
{
    stp_status status = STP_OK;
    const char *begin, *end;
    if (p->current == p->scan_count)
        return STP_OK;
    for (int i = 0; i < STP_PTX_HEADER_LINES; i++)
        STP_TRY(stp_text_next(&p->text, &begin, &end, err));
    const ptx_scan *scan = &p->scans[p->current++];
    p->left = scan->point_count;
    p->text.columns = columns_of(scan->fields < 3 ? 3 : scan->fields);
    p->text.attributes = stp_columns_attributes(&p->text.columns);
    const uint32_t intensity = stp_columns_find(&p->text.columns, STP_COLUMN_INTENSITY);
    if (intensity < STP_COLUMNS_MAX) /* the only attribute there may be */
        p->text.columns.extras[intensity] = (uint8_t)p->text.numbers.list.count;
done:
    return status;
}

static void to_world(const ptx_scan *scan, stp_dvec3 *position)
{
    const stp_dvec3 p = *position;
    const double(*m)[4] = scan->pose;
    position->x = m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z + m[0][3];
    position->y = m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z + m[1][3];
    position->z = m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z + m[2][3];
}

static stp_status read_point(ptx *p, stp_point *out, uint8_t *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    const char *begin, *end;
    STP_TRY(stp_text_next(&p->text, &begin, &end, err));
    if (!begin)
        return stp_text_few_lines(&p->text, 1, p->left, 0, err);
    if (p->scans[p->current - 1].fields == 0 || is_missing(begin, end)) {
        *out = (stp_point){.reject = STP_REJECT_NO_RETURN};
    } else {
        STP_TRY(stp_text_point(&p->text, begin, end, out, numbers, err));
        to_world(&p->scans[p->current - 1], &out->position);
        if (p->has_colour && !(p->text.attributes & STP_POINT_HAS_COLOUR))
            out->rgb[0] = out->rgb[1] = out->rgb[2] = STP_POINT_GREY;
    }
    out->station = (uint16_t)p->current;
done:
    return status;
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    ptx *p = state;
    size_t done_count = 0;
    STP_TRY(stp_text_numbers_begin(&p->text.numbers, capacity, err));
    while (done_count < capacity && (p->left > 0 || p->current < p->scan_count)) {
        if (p->left == 0) {
            STP_TRY(next_scan(p, err));
            continue;
        }
        STP_TRY(read_point(p, &points[done_count],
                           stp_text_numbers_at(&p->text.numbers, done_count), err));
        done_count++;
        p->left--;
    }
    *count = done_count;
done:
    return status;
}

static void close_reader(void *state)
{
    ptx *p = state;
    stp_text_close(&p->text);
    free(p->scans);
    free(p->stations);
    free(p->ups);
    free(p->images);
}

static const uint8_t *packed_numbers(const void *state)
{
    return ((const ptx *)state)->text.numbers.packed;
}

const stp_scan_reader stp_ptx_reader = {sizeof(ptx),  open_reader, read_points,
                                        close_reader, NULL,        packed_numbers};
