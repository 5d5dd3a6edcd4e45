/* Finds which text format of points a file has, from its first bytes. Threads: any. */
#ifndef STP_FORMATS_SCAN_DETECT_TEXT_H
#define STP_FORMATS_SCAN_DETECT_TEXT_H

#include "formats/scan/detect.h"

#include <stdbool.h>
#include <stddef.h>

/* By content. PTX: two lines of one whole number, four lines of three numbers and one line of four.
 * PTS: a line of one whole number, then a line of at least three. XYZ: the first two lines have
 * equally many numbers, at least three, or the first has names of columns and the second at least
 * three numbers. False if the content is none of these. */
bool stp_detect_text(const char *bytes, size_t length, stp_scan_format *format);
/* By the file's name. A file named .pts that does not begin with its number of points is an XYZ
 * file. */
bool stp_detect_text_name(const char *path, const char *bytes, size_t length,
                          stp_scan_format *format);

#endif
