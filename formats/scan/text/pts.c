/* Reads lists of points that begin with their number. */
#include "formats/scan/text/pts.h"

#include "base/checked.h"
#include "base/memory.h"
#include "formats/scan/text/text.h"
#include "formats/scan/text/text_count.h"

#include <stdlib.h>
#include <string.h>

typedef struct pts {
    stp_text text;
    uint64_t left;       /* points of the list that are not read yet */
    uint64_t *mark_left; /* the same at text.marks */
    size_t mark_left_capacity;
} pts;

/* The text of the first line of points, and where it is. */
typedef struct first_point {
    char text[STP_TEXT_LINE_MAX];
    size_t length; /* 0: not found yet */
} first_point;

static stp_status keep_first(stp_text *text, first_point *first, uint64_t offset, uint64_t line,
                             const char *begin, const char *end, stp_error *err)
{
    const size_t length = (size_t)(end - begin);
    if (length > sizeof first->text)
        return stp_error_set(err, STP_LIMIT,
                             "%s: line %llu has %zu characters, where the first point has at most "
                             "%zu: is it the right file?",
                             text->source.path, (unsigned long long)text->source.line, length,
                             sizeof first->text);
    memcpy(first->text, begin, length);
    first->length = length;
    text->first_offset = offset;
    text->first_line = line;
    return STP_OK;
}

/* Marks every so manieth point. left: of its list, from this one on. */
static stp_status mark(pts *p, uint64_t point, stp_text_mark here, uint64_t left, stp_error *err)
{
    stp_status status = STP_OK;
    stp_text *text = &p->text;
    if (point % STP_TEXT_MARK_LINES > 0)
        return STP_OK;
    STP_TRY(stp_grow(&text->marks, &text->mark_capacity, text->mark_count + 1, sizeof *text->marks,
                     "lines", err));
    STP_TRY(stp_grow(&p->mark_left, &p->mark_left_capacity, text->mark_count + 1,
                     sizeof *p->mark_left, "lines", err));
    p->mark_left[text->mark_count] = left;
    text->marks[text->mark_count++] = here;
done:
    return status;
}

/* Reads all lists: counts and marks their points and keeps the first one. */
static stp_status survey(pts *p, uint64_t *point_count, first_point *first, stp_error *err)
{
    stp_status status = STP_OK;
    stp_text *text = &p->text;
    const char *begin, *end;
    uint64_t total = 0, count = 0;
    for (;;) {
        STP_TRY(stp_text_next_count(text, "the number of points", &count, err));
        if (count == STP_TEXT_NO_COUNT)
            break;
        if (!stp_add_u64(total, count, &total))
            return stp_text_few_lines(text, text->source.line, count, 0, err);
        const uint64_t count_line = text->source.line;
        for (uint64_t i = 0; i < count; i++) {
            const stp_text_mark here = {text->source.offset, text->source.line};
            STP_TRY(stp_text_next(text, &begin, &end, err));
            if (!begin || stp_text_is_count(begin, end))
                return stp_text_few_lines(text, count_line, count, i, err);
            if (first->length == 0)
                STP_TRY(keep_first(text, first, here.offset, here.line, begin, end, err));
            STP_TRY(mark(p, total - count + i, here, count - i, err));
        }
    }
    *point_count = total;
done:
    return status;
}

static stp_status find_columns(stp_text *text, const first_point *first, const char *list,
                               stp_columns_sample *sample, stp_error *err)
{
    stp_status status = STP_OK;
    const char *begin = first->text, *end = begin + first->length;
    stp_text_rewind(text);
    if (list) {
        STP_TRY(stp_text_use_list(text, list, begin, end, err));
        const uint32_t fields = stp_fields_count(text->columns.separator, begin, end).fields;
        sample->count = fields < STP_COLUMNS_MAX ? fields : STP_COLUMNS_MAX;
        STP_TRY(stp_text_sample(text, text->columns.separator, sample, err));
    } else {
        STP_TRY(stp_text_guess(text, begin, end, true, sample, err));
    }
    stp_text_decide(text, sample);
    stp_text_note_columns(text, list ? "as given" : "by content", NULL, NULL, STP_SEPARATOR_SPACE,
                          sample->count);
done:
    return status;
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    pts *p = state;
    stp_text *text = &p->text;
    first_point *first = NULL;
    stp_columns_sample *sample = NULL;
    text->source.descriptor = -1;
    text->numbers.keep = params->numbers;
    STP_TRY(stp_alloc(&first, 1, sizeof *first, "lines", err));
    STP_TRY(stp_alloc(&sample, 1, sizeof *sample, "columns", err));
    STP_TRY(stp_text_open(text, path, err));
    const uint64_t start = text->source.offset;
    STP_TRY(survey(p, &info->point_count, first, err));
    if (first->length > 0)
        STP_TRY(find_columns(text, first, params->columns, sample, err));
    stp_text_fill_info(text, sample, info);
    info->format = "PTS";
    info->counted = true;
    if (info->point_count > STP_TEXT_MARK_LINES)
        info->seek_points = STP_TEXT_MARK_LINES;
    stp_source_seek(&text->source, start, 0);
done:
    free(first);
    free(sample);
    return status;
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    pts *p = state;
    const char *begin, *end;
    size_t done_count = 0;
    STP_TRY(stp_text_numbers_begin(&p->text.numbers, capacity, err));
    while (done_count < capacity) {
        while (p->left == 0)
            STP_TRY(stp_text_next_count(&p->text, "the number of points", &p->left, err));
        if (p->left == STP_TEXT_NO_COUNT)
            break;
        STP_TRY(stp_text_next(&p->text, &begin, &end, err));
        if (!begin)
            return stp_text_few_lines(&p->text, 1, p->left, 0, err);
        STP_TRY(stp_text_point(&p->text, begin, end, &points[done_count],
                               stp_text_numbers_at(&p->text.numbers, done_count), err));
        done_count++;
        p->left--;
    }
    *count = done_count;
done:
    return status;
}

static stp_status seek_point(void *state, uint64_t point, stp_error *err)
{
    pts *p = state;
    (void)err;
    stp_text_seek(&p->text, point);
    p->left = p->mark_left[point / STP_TEXT_MARK_LINES];
    return STP_OK;
}

static void close_reader(void *state)
{
    pts *p = state;
    free(p->mark_left);
    stp_text_close(&p->text);
}

static const uint8_t *packed_numbers(const void *state)
{
    return ((const pts *)state)->text.numbers.packed;
}

const stp_scan_reader stp_pts_reader = {sizeof(pts),  open_reader, read_points,
                                        close_reader, seek_point,  packed_numbers};
