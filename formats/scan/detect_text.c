/* Finds which text format of points a file has. */
#include "formats/scan/detect_text.h"

#include "base/file.h"
#include "formats/scan/text/columns.h"
#include "formats/scan/text/text_count.h"

#include <string.h>

/* Enough lines to see the first row of a pose. */
#define STP_LINES 7

/* The first lines that count. */
typedef struct first_lines {
    stp_field lines[STP_LINES];
    stp_field_count counts[STP_LINES]; /* counted with the separator that suits each line best */
    size_t count;
    bool named; /* a comment before them names x, y and z */
} first_lines;

/* True if no byte is one that text does not have. */
static bool is_text(const char *bytes, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        const unsigned char c = (unsigned char)bytes[i];
        const bool is_space = (c >= '\t' && c <= '\r') || c == 0x1a; /* end of file on DOS */
        if ((c < ' ' && !is_space) || c == 0x7f)
            return false;
    }
    return true;
}

static first_lines find_lines(const char *bytes, size_t length)
{
    first_lines out = {.count = 0};
    const char *at = bytes, *end = bytes + length;
    if (length >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0)
        at += 3;
    while (at < end && out.count < STP_LINES) {
        const char *stop = memchr(at, '\n', (size_t)(end - at));
        stop = stop ? stop : end;
        if (out.count == 0 && stp_line_is_comment(at, stop))
            out.named = out.named || stp_comment_names_axes(at, stop);
        if (stp_line_counts(at, stop)) {
            out.lines[out.count] = (stp_field){at, stop};
            out.counts[out.count++] = stp_fields_count(stp_separator_find(at, stop), at, stop);
        }
        at = stop < end ? stop + 1 : end;
    }
    return out;
}

static bool is_count(const first_lines *f, size_t line)
{
    return f->count > line && stp_text_is_count(f->lines[line].begin, f->lines[line].end);
}

static bool is_row(const first_lines *f, size_t line)
{
    return f->count > line && f->counts[line].numbers >= 3;
}

static bool is_numbers(const first_lines *f, size_t line)
{
    return is_row(f, line) && f->counts[line].numbers == f->counts[line].fields;
}

/* Two lines of one number, four vectors, and a row of a pose. */
static bool is_ptx(const first_lines *f)
{
    if (!is_count(f, 0) || !is_count(f, 1) || !is_numbers(f, 6) || f->counts[6].fields != 4)
        return false;
    for (size_t i = 2; i < 6; i++)
        if (!is_numbers(f, i) || f->counts[i].fields != 3)
            return false;
    return true;
}

static bool is_header(const first_lines *f)
{
    stp_columns columns;
    if (f->count == 0 || f->counts[0].numbers > 0)
        return false;
    for (int i = 0; i < STP_SEPARATOR_COUNT; i++)
        if (stp_columns_from_header(&columns, (stp_separator)i, f->lines[0].begin, f->lines[0].end))
            return true;
    return false;
}

/* Whether lines have the same number of fields, all but one or two of them numbers: names of points
 * and what they are. */
static bool are_named_rows(const first_lines *f)
{
    for (size_t i = 0; i < f->count; i++)
        if (!is_row(f, i) || f->counts[i].fields != f->counts[0].fields ||
            f->counts[i].fields - f->counts[i].numbers > 2)
            return false;
    return f->count >= 3;
}

bool stp_detect_text(const char *bytes, size_t length, stp_scan_format *format)
{
    if (!is_text(bytes, length))
        return false;
    const first_lines f = find_lines(bytes, length);
    const bool one_line = f.count == 1 && is_numbers(&f, 0);
    if (is_ptx(&f))
        *format = STP_SCAN_PTX;
    else if (is_count(&f, 0) && is_row(&f, 1))
        *format = f.named ? STP_SCAN_XYZ : STP_SCAN_PTS;
    else if (one_line || (is_header(&f) && is_row(&f, 1)) ||
             (is_numbers(&f, 0) && is_numbers(&f, 1) && f.counts[0].fields == f.counts[1].fields) ||
             are_named_rows(&f))
        *format = STP_SCAN_XYZ;
    else
        return false;
    return true;
}

bool stp_detect_text_name(const char *path, const char *bytes, size_t length,
                          stp_scan_format *format)
{
    static const struct {
        const char *ending;
        stp_scan_format format;
    } endings[] = {
        {".xyz", STP_SCAN_XYZ},    {".txt", STP_SCAN_XYZ},  {".csv", STP_SCAN_XYZ},
        {".asc", STP_SCAN_XYZ},    {".xyzi", STP_SCAN_XYZ}, {".xyzn", STP_SCAN_XYZ},
        {".xyzrgb", STP_SCAN_XYZ}, {".pts", STP_SCAN_PTS},  {".ptx", STP_SCAN_PTX},
    };
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        if (!stp_path_ends_in(path, endings[i].ending))
            continue;
        *format = endings[i].format;
        if (*format == STP_SCAN_PTS && length > 0) {
            const first_lines f = find_lines(bytes, length);
            *format = is_row(&f, 0) || f.named ? STP_SCAN_XYZ : STP_SCAN_PTS;
        }
        return is_text(bytes, length);
    }
    return false;
}
