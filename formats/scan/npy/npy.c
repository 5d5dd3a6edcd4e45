/* Reads points from arrays that NumPy saved. */
#include "formats/scan/npy/npy.h"

#include "base/memory.h"
#include "formats/scan/npy/npy_header.h"
#include "formats/scan/text/text.h"
#include "formats/scan/value_range.h"

#include <float.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK_POINTS 512u
#define SAMPLE_BLOCKS 64u

typedef struct reader {
    stp_npy_header header;
    stp_text text; /* what the columns mean, and the file */
    uint64_t next, lost_count;
    double values[STP_COLUMNS_MAX][BLOCK_POINTS]; /* of the points read last, by column */
} reader;

static double number_of(const stp_npy_column *c, const unsigned char *bytes)
{
    uint64_t bits = 0, sign = 0x80;
    for (unsigned i = 0; i < c->bytes; i++) {
        bits = bits << 8 | bytes[c->big ? i : c->bytes - 1u - i];
        sign = i > 0 ? sign << 8 : sign;
    }
    const uint32_t low = (uint32_t)bits;
    float single;
    double value;
    if (c->kind != 'f')
        return c->kind == 'i' ? (double)(int64_t)((bits ^ sign) - sign) : (double)bits;
    memcpy(&single, &low, sizeof single);
    memcpy(&value, &bits, sizeof value);
    return c->bytes == 8 ? value : (double)single;
}

static stp_status cut(const reader *r, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: its header declares %" PRIu64 " points, which do not fit behind byte "
                         "%" PRIu64 " of %" PRIu64 ": the file was cut; copy it again",
                         r->text.source.path, r->header.points, r->header.begin,
                         r->text.source.size);
}

/* Reads the next count points of one column, or of all that lie together. */
static stp_status read_bytes(reader *r, uint64_t offset, size_t count, const unsigned char **bytes,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const size_t size = count * r->header.stride;
    size_t available;
    stp_source_seek(&r->text.source, r->header.begin + offset + r->next * r->header.stride, 0);
    STP_TRY(stp_source_peek(&r->text.source, size, bytes, &available, err));
    if (available < size)
        return cut(r, err);
done:
    return status;
}

/* Reads the next count points. */
static stp_status read_block(reader *r, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *bytes = NULL;
    for (uint32_t k = 0; k < r->header.column_count; k++) {
        const stp_npy_column *c = &r->header.columns[k];
        if (r->header.apart || k == 0)
            STP_TRY(read_bytes(r, r->header.apart ? c->offset : 0, count, &bytes, err));
        const unsigned char *first = bytes + (r->header.apart ? 0 : c->offset);
        for (size_t i = 0; i < count; i++)
            r->values[k][i] = number_of(c, first + i * r->header.stride);
    }
    r->next += count;
done:
    return status;
}

static size_t block_of(const reader *r, size_t most)
{
    const uint64_t left = r->header.points - r->next;
    most = most < BLOCK_POINTS ? most : BLOCK_POINTS;
    return left < most ? (size_t)left : most;
}

/* Writes a point as a line of numbers, so that those without names are judged as lines are. */
static size_t write_line(const reader *r, size_t i, char line[STP_COLUMNS_MAX * 32])
{
    size_t used = 0;
    for (uint32_t k = 0; k < r->header.column_count; k++)
        used += (size_t)snprintf(line + used, 32, "%.*g ", r->header.columns[k].bytes > 4 ? 17 : 9,
                                 r->values[k][i]);
    return used;
}

static stp_status sample_points(reader *r, stp_columns_sample *sample, stp_error *err)
{
    stp_status status = STP_OK;
    char line[STP_COLUMNS_MAX * 32];
    uint64_t end = 0;
    sample->count = r->header.column_count;
    for (uint64_t b = 0; b < SAMPLE_BLOCKS; b++) {
        r->next = stp_spread_begin(r->header.points, b, SAMPLE_BLOCKS);
        r->next = r->next > end ? r->next : end; /* else blocks of small files would overlap */
        const size_t count = block_of(r, BLOCK_POINTS);
        STP_TRY(read_block(r, count, err));
        for (size_t i = 0; i < count; i++)
            stp_columns_sample_add(sample, STP_SEPARATOR_SPACE, line,
                                   line + write_line(r, i, line));
        end = r->next;
    }
    for (uint32_t k = 0; k < sample->count; k++) /* digits of floats say nothing */
        if (r->header.columns[k].kind == 'f')
            sample->ranges[k].decimals = UINT32_MAX;
    r->next = 0;
done:
    return status;
}

/* A float that holds the bytes of a colour, as PCL writes them, is read as those: as a number, an
 * opaque one whose red is 128 or more is none, and would lose bits. */
static void decide(reader *r, stp_columns_sample *sample)
{
    stp_text *text = &r->text;
    const uint32_t place = stp_columns_find(&text->columns, STP_COLUMN_PACKED);
    stp_npy_column *c = &r->header.columns[place < sample->count ? place : 0];
    const bool floats = place < sample->count && c->kind == 'f' && c->bytes == 4;
    if (floats && sample->ranges[place].count == 0)
        sample->ranges[place] =
            (stp_column_range){.count = 1, .min = -FLT_MAX, .max = -FLT_MAX, .whole = true};
    stp_text_decide(text, sample);
    if (floats && text->columns.targets[place] == STP_COLUMN_PACKED)
        c->kind = 'u';
}

/* Finds the columns by the user's list, by the fields' names, or by their numbers. */
static stp_status find_columns(reader *r, const char *list, stp_columns_sample *sample,
                               stp_error *err)
{
    stp_status status = STP_OK;
    stp_text *text = &r->text;
    bool is_number[STP_COLUMNS_MAX];
    const char *names = r->header.names, *names_end = names + strlen(names);
    text->given = list != NULL;
    text->columns.separator = STP_SEPARATOR_SPACE;
    memset(is_number, true, sizeof is_number);
    if (list)
        STP_TRY(stp_columns_from_list(&text->columns, list, text->numbers.keep, err));
    else if (names[0] == '\0')
        (void)stp_columns_guess(&text->columns, sample, is_number, false);
    else if (!stp_columns_from_header(&text->columns, STP_SEPARATOR_COMMA, names, names_end))
        return stp_error_set(err, STP_FORMAT,
                             "%s: none of its fields are named x, y and z: name the columns with "
                             "--columns",
                             text->source.path);
    if (text->columns.count > r->header.column_count)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--columns %.200s: names %u columns, but the points of %s have %u: "
                             "name those alone",
                             list, text->columns.count, text->source.path, r->header.column_count);
    decide(r, sample);
    const bool named = !list && names[0] != '\0';
    stp_text_note_columns(text,
                          list    ? "as given"
                          : named ? "by name"
                                  : "by content",
                          named ? names : NULL, names_end, STP_SEPARATOR_COMMA,
                          r->header.column_count);
done:
    return status;
}

/* Lowers the number of points to those that are there, if the rest may be lost. */
static stp_status check_room(reader *r, bool salvage, stp_error *err)
{
    const stp_npy_header *h = &r->header;
    const uint64_t left = r->text.source.size - h->begin;
    const uint64_t bytes = h->apart ? h->stride * h->column_count : h->stride, fit = left / bytes;
    if (h->points <= fit ||
        (salvage && !h->apart && stp_salvage_count(&r->header.points, fit, &r->lost_count)))
        return STP_OK;
    return cut(r, err);
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    stp_columns_sample *sample = NULL;
    r->text.source.descriptor = -1;
    r->text.numbers.keep = params->numbers;
    STP_TRY(stp_alloc(&sample, 1, sizeof *sample, "columns", err));
    STP_TRY(stp_source_open(&r->text.source, path, err));
    STP_TRY(stp_npy_header_read(&r->header, &r->text.source, err));
    STP_TRY(check_room(r, params->salvage, err));
    r->text.source.narrow = true;
    STP_TRY(sample_points(r, sample, err));
    STP_TRY(find_columns(r, params->columns, sample, err));
    stp_text_fill_info(&r->text, sample, info);
    info->format = "NumPy array";
    info->point_count = r->header.points;
    info->lost_count = r->lost_count;
    info->seek_points = 1;
done:
    free(sample);
    return status;
}

/* The meaning of a point's numbers. */
static void take_point(const reader *r, size_t i, stp_point *point, uint8_t *numbers)
{
    const stp_columns *c = &r->text.columns;
    double v[STP_COLUMN_PACKED + 1] = {0.0};
    for (uint32_t k = 0; k < c->count; k++) {
        const double value = r->values[k][i];
        const float single = (float)value;
        uint32_t bits;
        memcpy(&bits, &single, sizeof bits);
        v[c->targets[k]] = value;
        if (c->targets[k] == STP_COLUMN_PACKED && r->header.columns[k].kind == 'f')
            v[STP_COLUMN_PACKED] = bits; /* as PCL writes them */
        if (numbers && c->extras[k] > 0) {
            uint64_t word;
            memcpy(&word, &value, sizeof word);
            stp_attribute_put(STP_ATTRIBUTE_F64, word, numbers + (c->extras[k] - 1u) * sizeof word);
        }
    }
    stp_text_take(&r->text, v, point);
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    size_t done_count = 0;
    STP_TRY(stp_text_numbers_begin(&r->text.numbers, capacity, err));
    while (done_count < capacity && r->next < r->header.points) {
        const size_t part = block_of(r, capacity - done_count);
        STP_TRY(read_block(r, part, err));
        for (size_t i = 0; i < part; i++, done_count++)
            take_point(r, i, &points[done_count],
                       stp_text_numbers_at(&r->text.numbers, done_count));
    }
    *count = done_count;
done:
    return status;
}

static stp_status seek_point(void *state, uint64_t point, stp_error *err)
{
    (void)err;
    ((reader *)state)->next = point;
    return STP_OK;
}

static void close_reader(void *state)
{
    stp_text_close(&((reader *)state)->text);
}

static const uint8_t *packed_numbers(const void *state)
{
    return ((const reader *)state)->text.numbers.packed;
}

const stp_scan_reader stp_npy_reader = {sizeof(reader), open_reader, read_points,
                                        close_reader,   seek_point,  packed_numbers};
