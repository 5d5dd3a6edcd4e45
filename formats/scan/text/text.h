/* Points out of lines of text: what the readers of XYZ, PTS and PTX share.
 *
 * Lines that are blank or begin with # or // are passed over; a byte order mark is, too. Colours
 * and intensities are brought to 0..65535 by what a look at up to 4 MiB, 64 blocks spread over the
 * file, finds (m the greatest value seen; values beyond are clamped):
 *   - colours: fractions up to 1 times 65535, up to 255 times 257, others as they are;
 *   - intensities without negative ones the same, and beyond 65535 times 65535 / m;
 *   - whole intensities with negative ones within -2048..2047, as Leica's programs write them:
 *     -2048 becomes 0 and 2047 becomes 65535;
 *   - other intensities with negative ones (decibels): least to greatest seen become 0 to 65535.
 * A line with too few, too many or unreadable numbers is an error that names it: what is lost in
 * silence is found too late. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_TEXT_TEXT_H
#define STP_FORMATS_SCAN_TEXT_TEXT_H

#include "formats/scan/name_list.h"
#include "formats/scan/scan.h"
#include "formats/scan/source.h"
#include "formats/scan/text/columns.h"

/* A header and the first line of numbers are shorter than this. */
#define STP_TEXT_LINE_MAX 8192u

typedef struct stp_text {
    stp_source source;
    uint64_t first_offset, first_line; /* where points begin, and the number of the line before */
    stp_columns columns;
    uint32_t attributes;                                 /* STP_POINT_HAS_* of the columns */
    double colour_scale, intensity_scale, intensity_low; /* (value - low) * scale */
    stp_name_list left_out;
    char order[1024]; /* room for STP_COLUMNS_MAX of the longest names */
    stp_scan_note notes[2];
} stp_text;

/* path must outlive it. Errors: as stp_source_open, UNSUPPORTED (lines without \n). */
stp_status stp_text_open(stp_text *text, const char *path, stp_error *err);
void stp_text_close(stp_text *text);
/* The next line that counts, valid until the next call; *begin NULL at the end. Errors: IO, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_text_next(stp_text *text, const char **begin, const char **end, stp_error *err);
/* Continues with the first line of points. */
void stp_text_rewind(stp_text *text);
/* Counts the lines from here to the end. Errors: IO, LIMIT, OUT_OF_MEMORY. */
stp_status stp_text_count(stp_text *text, uint64_t *count, stp_error *err);
/* Looks at lines of sample->count fields spread over what follows first_offset, and goes back
 * there. Errors: IO, LIMIT, OUT_OF_MEMORY. */
stp_status stp_text_sample(stp_text *text, stp_separator separator, stp_columns_sample *sample,
                           stp_error *err);
/* Columns by content, from the first line of points and the sample that is made. Errors: FORMAT
 * (fewer than three numbers), IO, LIMIT, OUT_OF_MEMORY. */
stp_status stp_text_guess(stp_text *text, const char *begin, const char *end, bool intensity_first,
                          stp_columns_sample *sample, stp_error *err);
/* Columns by a list of names, for lines like this one. Errors: INVALID_ARGUMENT. */
stp_status stp_text_use_list(stp_text *text, const char *list, const char *begin, const char *end,
                             stp_error *err);
/* Once the columns are known: attributes and scales. */
void stp_text_settle(stp_text *text, const stp_columns_sample *sample);
/* The notes `columns` (their order and where it is from, as in "x,y,z,_ (header)") and `left_out`
 * (columns of a line with field_count fields that are not read, by their names in the header where
 * there is one: header may be NULL). */
void stp_text_note_columns(stp_text *text, const char *from, const char *header,
                           const char *header_end, stp_separator header_separator,
                           uint32_t field_count);
/* Attributes, notes and, where all lines have the columns of one sample, the step (NULL: none);
 * the text stays where it is while they are used. */
void stp_text_fill_info(stp_text *text, const stp_columns_sample *sample, stp_scan_info *info);
/* The line that was read last as a point. Errors: CORRUPT. */
stp_status stp_text_point(const stp_text *text, const char *begin, const char *end, stp_point *out,
                          stp_error *err);

#endif
