/* Reads files with one point per line. */
#include "formats/scan/text/xyz.h"

#include "base/memory.h"
#include "formats/scan/number.h"
#include "formats/scan/text/text.h"
#include "formats/scan/text/text_count.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct line_copy {
    char text[STP_TEXT_LINE_MAX];
    const char *end; /* NULL: the line does not exist */
    uint64_t line;
} line_copy;

/* The lines that can name the columns. */
typedef struct beginning {
    line_copy comment, header, row;
    uint64_t points, points_line; /* that a line says, after a comment with names; where; else 0 */
} beginning;

static stp_status copy_line(const stp_text *text, line_copy *copy, const char *begin,
                            const char *end, stp_error *err)
{
    const size_t length = (size_t)(end - begin);
    if (length > sizeof copy->text)
        return stp_error_set(
            err, STP_LIMIT,
            "%s: line %llu has %zu characters, where a header or the first point "
            "has at most %zu: is it the right file? (a matrix of heights: save it as TIFF)",
            text->source.path, (unsigned long long)text->source.line, length, sizeof copy->text);
    memcpy(copy->text, begin, length);
    copy->end = copy->text + length;
    copy->line = text->source.line;
    return STP_OK;
}

/* Whether the line names x, y and z. */
static bool names_axes(const line_copy *copy)
{
    return copy->end && stp_comment_names_axes(copy->text, copy->end);
}

/* Copies the names in a comment; names of axes are not lost to a later one. */
static void copy_comment(const stp_text *text, line_copy *copy, const char *begin, const char *end)
{
    if (names_axes(copy))
        return;
    while (begin < end && (stp_is_blank(*begin) || strchr("#/%!", *begin)))
        begin++;
    if ((size_t)(end - begin) <= sizeof copy->text)
        (void)copy_line(text, copy, begin, end, NULL);
}

static bool has_numbers(const line_copy *copy)
{
    return stp_fields_count(stp_separator_find(copy->text, copy->end), copy->text, copy->end)
               .numbers > 0;
}

/* As many lines without numbers may come before the points: titles, names of columns, units. */
#define WORD_LINES 20u

/* Reads to the first line of points and goes back to its begin. */
static stp_status read_beginning(stp_text *text, beginning *b, stp_error *err)
{
    stp_status status = STP_OK;
    const char *begin, *end;
    unsigned words = 0;
    while (!b->row.end) {
        const uint64_t offset = text->source.offset, line = text->source.line;
        STP_TRY(stp_source_line(&text->source, &begin, &end, err));
        text->first_offset = offset;
        text->first_line = line;
        if (!begin)
            break;
        if (!b->header.end && stp_line_is_comment(begin, end))
            copy_comment(text, &b->comment, begin, end);
        if (!stp_line_counts(begin, end))
            continue;
        STP_TRY(copy_line(text, &b->row, begin, end, err));
        if (names_axes(&b->comment) && b->points_line == 0 && stp_text_is_count(begin, end) &&
            stp_number_parse_u64(begin, end, &b->points)) {
            b->points_line = text->source.line;
            b->row.end = NULL;
            continue;
        }
        if (has_numbers(&b->row) || ++words > WORD_LINES)
            continue;
        if (!b->header.end || (!names_axes(&b->header) &&
                               names_axes(&b->row))) { /* a title comes before, units come after */
            b->header = b->row;
            b->header.end = b->header.text + (b->row.end - b->row.text);
        }
        b->row.end = NULL;
    }
    stp_text_rewind(text);
done:
    return status;
}

/* Finds the columns of a header for lines like this row, whose separator may differ. False if the
 * header does not name x, y and z, or the row does not fit it. */
static bool match_header(stp_columns *out, stp_separator *header_separator, const line_copy *header,
                         const line_copy *row)
{
    stp_columns columns;
    uint32_t most = 0;
    for (int h = 0; h < STP_SEPARATOR_COUNT; h++) {
        if (!stp_columns_from_header(&columns, (stp_separator)h, header->text, header->end))
            continue;
        for (int r = 0; r < STP_SEPARATOR_COUNT; r++) {
            const stp_field_count count =
                row->end ? stp_fields_count((stp_separator)r, row->text, row->end)
                         : (stp_field_count){columns.count, 3};
            const bool fits = columns.open_end ? count.fields >= columns.count
                                               : count.fields == columns.count ||
                                                     count.fields + 1 == columns.count;
            if (!fits || count.numbers < 3 || count.numbers <= most)
                continue;
            most = count.numbers;
            *out = columns;
            out->separator = (stp_separator)r;
            *header_separator = (stp_separator)h;
        }
    }
    return most > 0;
}

static stp_status wrong_header(const stp_text *text, const beginning *b, stp_error *err)
{
    const line_copy *header = &b->header;
    char shown[61]; /* without bytes that no terminal may know */
    stp_columns columns;
    stp_column_copy_name(shown, sizeof shown, (stp_field){header->text, header->end});
    for (int h = 0; h < STP_SEPARATOR_COUNT; h++)
        if (stp_columns_from_header(&columns, (stp_separator)h, header->text, header->end))
            return stp_error_set(
                err, STP_CORRUPT,
                "%s: the header, line %llu, names %u columns, but line %llu has other ones: mend "
                "the header, or name the columns with --columns",
                text->source.path, (unsigned long long)header->line, columns.count,
                (unsigned long long)b->row.line);
    return stp_error_set(err, STP_FORMAT,
                         "%s: line %llu, `%s`, is neither numbers nor names of columns with x, y "
                         "and z among them: name the columns with --columns, or put # before lines "
                         "that are neither",
                         text->source.path, (unsigned long long)header->line, shown);
}

/* The number of fields per line, as far as they are used. */
static uint32_t row_fields(const stp_text *text, const line_copy *row)
{
    const uint32_t count =
        row->end ? stp_fields_count(text->columns.separator, row->text, row->end).fields : 0;
    return count < STP_COLUMNS_MAX ? count : STP_COLUMNS_MAX;
}

/* Fewer columns or rows are no matrix of heights; the part of all heights by which neighbours in a
 * row differ on average. */
#define MATRIX_COLUMNS 16u
#define MATRIX_ROWS 8u
#define MATRIX_STEP 0.1

/* Whether a number follows a word and a bracket: in `v=(1, 2, 3)` it would be lost. */
static bool hides_number(stp_separator separator, const line_copy *row)
{
    stp_field field;
    double value;
    for (const char *at = row->text; stp_field_next(separator, &at, row->end, &field);)
        for (const char *open = field.begin + 1; open < field.end; open++)
            if (stp_is_opening(*open) &&
                stp_field_number(separator, (stp_field){open + 1, field.end}, &value))
                return true;
    return false;
}

/* Whether so many columns differ so little from one to the next as heights do. */
static bool is_smooth(const stp_columns_sample *s)
{
    double low = INFINITY, high = -INFINITY;
    if (s->count < MATRIX_COLUMNS || s->rows < MATRIX_ROWS)
        return false;
    for (uint32_t i = 0; i < s->count; i++) {
        low = fmin(low, s->ranges[i].min);
        high = fmax(high, s->ranges[i].max);
    }
    for (uint32_t i = 0; i < s->count; i++)
        if (s->ranges[i].count < s->rows ||
            (i + 1 < s->count &&
             !(s->ranges[i].step < MATRIX_STEP * (high - low) * (double)s->rows)))
            return false;
    return true;
}

/* Rows of so many numbers without names are a matrix: its first three columns are no x y z. */
static stp_status check_matrix(const stp_text *text, const line_copy *row,
                               const stp_columns_sample *sample, stp_error *err)
{
    const uint32_t fields = stp_fields_count(text->columns.separator, row->text, row->end).fields;
    if (fields <= STP_COLUMNS_MAX && !is_smooth(sample))
        return STP_OK;
    return stp_error_set(err, STP_UNSUPPORTED,
                         "%s: line %llu has %u numbers, as a matrix of heights: save heights as "
                         "TIFF or as an ESRI ASCII grid; if they are columns of points, name those "
                         "that count with --columns",
                         text->source.path, (unsigned long long)row->line, fields);
}

/* Points one after another in brackets, as in JSON, are not the columns of one. A point may have
 * its place, its normal and its colour in three of them. */
static stp_status check_brackets(const stp_text *text, const line_copy *row,
                                 const stp_columns_sample *sample, stp_error *err)
{
    const unsigned long long line = row->line;
    if (stp_bracket_groups(row->text, row->end) > (sample->rows > 1 ? 3 : 1))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: line %llu has several points in brackets: give each a line of "
                             "its own, or name the columns with --columns",
                             text->source.path, line);
    if (hides_number(text->columns.separator, row))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: line %llu has a word before a bracket and a number: leave out "
                             "such words, or name the columns with --columns",
                             text->source.path, line);
    return STP_OK;
}

static stp_status find_columns(stp_text *text, const beginning *b, const char *list,
                               stp_columns_sample *sample, stp_error *err)
{
    stp_status status = STP_OK;
    stp_separator separator = STP_SEPARATOR_SPACE;
    const line_copy *header = b->header.end ? &b->header : &b->comment, *row = &b->row;
    const char *from = "the header";
    if (list) {
        STP_TRY(stp_text_use_list(text, list, row->end ? row->text : NULL, row->end, err));
        from = "as given";
    } else if (!header->end || !match_header(&text->columns, &separator, header, row)) {
        if (b->header.end && !(row->end && stp_line_is_point_text(row->text, row->end)))
            return wrong_header(text, b, err);
        if (row->end)
            STP_TRY(stp_text_guess(text, row->text, row->end, false, sample, err));
        from = "by content";
    }
    if (row->end && sample->count == 0) {
        const uint32_t fields = row_fields(text, row), named = text->columns.count;
        sample->open_end = text->columns.open_end;
        sample->count = sample->open_end && named < fields ? named : fields;
        STP_TRY(stp_text_sample(text, text->columns.separator, sample, err));
    }
    if (row->end && from[0] == 'b') {
        STP_TRY(check_brackets(text, row, sample, err));
        STP_TRY(check_matrix(text, row, sample, err));
    }
    stp_text_decide(text, sample);
    const bool named = from[0] == 't';
    if (row->end || named)
        stp_text_note_columns(text, from, named ? header->text : NULL, header->end, separator,
                              row_fields(text, row));
done:
    return status;
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_text *text = state;
    beginning *b = NULL;
    stp_columns_sample *sample = NULL;
    uint64_t count = 0;
    text->source.descriptor = -1;
    text->numbers.keep = params->numbers;
    STP_TRY(stp_alloc(&b, 1, sizeof *b, "lines", err));
    STP_TRY(stp_alloc(&sample, 1, sizeof *sample, "columns", err));
    STP_TRY(stp_text_open(text, path, err));
    STP_TRY(read_beginning(text, b, err));
    STP_TRY(find_columns(text, b, params->columns, sample, err));
    STP_TRY(stp_text_count(text, &count, err));
    if (count < b->points) {
        status = stp_text_few_lines(text, b->points_line, b->points, count, err);
        goto done;
    }
    stp_text_rewind(text);
    stp_text_fill_info(text, sample, info);
    info->format = "XYZ text";
    info->y_down = strcmp(text->columns.names[0], "POINT3D_ID") == 0;
    info->point_count = count;
    info->counted = true;
    if (count > STP_TEXT_MARK_LINES)
        info->seek_points = STP_TEXT_MARK_LINES;
done:
    free(b);
    free(sample);
    return status;
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    stp_text *text = state;
    const char *begin, *end;
    size_t done_count = 0;
    STP_TRY(stp_text_numbers_begin(&text->numbers, capacity, err));
    while (done_count < capacity) {
        STP_TRY(stp_text_next(text, &begin, &end, err));
        if (!begin)
            break;
        STP_TRY(stp_text_point(text, begin, end, &points[done_count],
                               stp_text_numbers_at(&text->numbers, done_count), err));
        done_count++;
    }
    *count = done_count;
done:
    return status;
}

static stp_status seek_line(void *state, uint64_t point, stp_error *err)
{
    (void)err;
    stp_text_seek(state, point);
    return STP_OK;
}

static void close_reader(void *state)
{
    stp_text_close(state);
}

static const uint8_t *packed_numbers(const void *state)
{
    return ((const stp_text *)state)->numbers.packed;
}

const stp_scan_reader stp_xyz_reader = {sizeof(stp_text), open_reader, read_points,
                                        close_reader,     seek_line,   packed_numbers};
