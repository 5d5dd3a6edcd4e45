/* Which of the formats of points in text the begin of a file is in. Threads: any. */
#ifndef STP_FORMATS_SCAN_DETECT_TEXT_H
#define STP_FORMATS_SCAN_DETECT_TEXT_H

#include "formats/scan/detect.h"

#include <stdbool.h>
#include <stddef.h>

/* Whether the bytes hold none that text does not have. */
bool stp_is_text(const char *bytes, size_t length);
/* By content: two lines of one whole number, four of three numbers and one of four: PTX; a line of
 * one whole number and then one of at least three: PTS; else XYZ, if the first two lines are at
 * least three numbers each and equally many, or names of columns and then at least three numbers.
 * False if none. */
bool stp_detect_text(const char *bytes, size_t length, stp_scan_format *format);
/* By the file's name; what is named .pts without its number of points is an XYZ file. */
bool stp_detect_text_name(const char *path, const char *bytes, size_t length,
                          stp_scan_format *format);

#endif
