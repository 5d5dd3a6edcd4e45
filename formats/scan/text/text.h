/* Reads points from lines of text: the shared part of the readers of XYZ, PTS and PTX.
 *
 * Lines that are blank or begin with # or // are skipped, and so is a byte order mark. Colours and
 * intensities are scaled to 0..65535. A sample of up to 4 MiB, 64 blocks spread over the file,
 * decides how (m: the greatest value seen; values outside the range are clamped):
 *   - Colours up to 1 are fractions: times 65535. Up to 255: times 257. Others stay.
 *   - Intensities without negative values: the same, but if m > 65535: times 65535 / m.
 *   - Whole intensities with negative values within -2048..2047 (Leica's programs): -2048 becomes 0
 *     and 2047 becomes 65535.
 *   - Other intensities with negative values (decibels): the least becomes 0, the greatest 65535.
 *
 * x and y are degrees of longitude and latitude if their names say so, or if their numbers do: both
 * have at least 5 digits after the point and 2 more than z, within 180 and 90, and z has 20 times
 * their extent. Nobody writes x and y in metres more finely than z. If only the second number can
 * be a longitude, it is x.
 *
 * If a column is named depth, and none z or a height, the depth is z, downwards if any is above 0.
 *
 * A least z of -9999, -32767, -32768 or -99999, if all others are more than a tenth higher, is no
 * height: such points are rejected.
 *
 * A line with too few, too many or unreadable numbers is an error that names the line: a
 * silent loss would be found too late. A number may be missing (stp_field_is_missing): without a
 * coordinate the point is rejected. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_TEXT_TEXT_H
#define STP_FORMATS_SCAN_TEXT_TEXT_H

#include "formats/scan/name_list.h"
#include "formats/scan/scan.h"
#include "formats/scan/source.h"
#include "formats/scan/text/columns.h"
#include "formats/scan/text/text_numbers.h"

/* A header line and the first line of numbers are shorter than this. */
#define STP_TEXT_LINE_MAX 8192u

/* Reading may go on at every so manieth line that counts. */
#define STP_TEXT_MARK_LINES 16384u

/* Where such a line begins, or a comment before it; number of the line before. */
typedef struct stp_text_mark {
    uint64_t offset, line;
} stp_text_mark;

typedef struct stp_text {
    stp_source source;
    stp_text_mark *marks; /* set by stp_text_count */
    size_t mark_count, mark_capacity;
    uint64_t first_offset, first_line; /* where points begin; number of the line before */
    stp_columns columns;
    uint32_t attributes;                                 /* STP_POINT_HAS_* of the columns */
    double colour_scale, intensity_scale, intensity_low; /* (value - low) * scale */
    stp_text_numbers numbers;
    bool given;       /* the user named the columns */
    bool packed;      /* colours are in one piece */
    bool degrees;     /* x and y are longitude and latitude */
    bool z_down;      /* z is a depth: downwards */
    double no_height; /* the z of points that were not measured; NaN: none */
    stp_name_list left_out;
    char order[STP_COLUMNS_MAX * STP_ATTRIBUTE_NAME_BYTES + 64]; /* all names and their origin */
    stp_scan_note notes[4];
} stp_text;

/* path must outlive it. Errors: as stp_source_open, UNSUPPORTED (lines without \n). */
stp_status stp_text_open(stp_text *text, const char *path, stp_error *err);
void stp_text_close(stp_text *text);
/* Gives the next line that counts, valid until the next call; *begin is NULL at the end. Errors:
 * IO, LIMIT, OUT_OF_MEMORY. */
stp_status stp_text_next(stp_text *text, const char **begin, const char **end, stp_error *err);
/* Continues with the first line of points. */
void stp_text_rewind(stp_text *text);
/* Counts the lines from here to the end, and marks every so manieth. Errors: IO, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_text_count(stp_text *text, uint64_t *count, stp_error *err);
/* Continues with a line that counts, by its number from the first one counted, which is a multiple
 * of STP_TEXT_MARK_LINES and less than all of them. */
void stp_text_seek(stp_text *text, uint64_t line);
/* Samples lines with sample->count fields, spread over the file from first_offset on, and goes back
 * there. Errors: IO, LIMIT, OUT_OF_MEMORY. */
stp_status stp_text_sample(stp_text *text, stp_separator separator, stp_columns_sample *sample,
                           stp_error *err);
/* Finds the columns by content, from the first line of points and a sample that it takes. Errors:
 * FORMAT (fewer than three numbers), IO, LIMIT, OUT_OF_MEMORY. */
stp_status stp_text_guess(stp_text *text, const char *begin, const char *end, bool intensity_first,
                          stp_columns_sample *sample, stp_error *err);
/* Takes the columns from a list of names, for lines like this one. Errors: INVALID_ARGUMENT. */
stp_status stp_text_use_list(stp_text *text, const char *list, const char *begin, const char *end,
                             stp_error *err);
/* Sets attributes of both kinds and scales. Call it when the columns are known. */
void stp_text_decide(stp_text *text, const stp_columns_sample *sample);
/* Makes two notes, after stp_text_decide. `columns`: the order of the columns and its origin, as in
 * "x,y,z,_ (header)". `left_out`: columns of a line with field_count fields that are not read, by
 * their names in the header; header may be NULL. */
void stp_text_note_columns(stp_text *text, const char *from, const char *header,
                           const char *header_end, stp_separator header_separator,
                           uint32_t field_count);
/* Fills in attributes and notes and, if one sample holds for all lines, the step (sample NULL: no
 * step). The text must not move while info is used. */
void stp_text_fill_info(stp_text *text, const stp_columns_sample *sample, stp_scan_info *info);
/* Parses the line that was read last as a point, and its attributes into `numbers`, which says
 * "missing" so far; NULL: none. Errors: CORRUPT. */
stp_status stp_text_point(const stp_text *text, const char *begin, const char *end, stp_point *out,
                          uint8_t *numbers, stp_error *err);

/* The point of these numbers, by stp_column. */
void stp_text_take(const stp_text *text, const double v[STP_COLUMN_PACKED + 1], stp_point *out);

#endif
