/* Reads lines that say how many lines follow: PTS and PTX. Threads: as stp_text. */
#ifndef STP_FORMATS_SCAN_TEXT_TEXT_COUNT_H
#define STP_FORMATS_SCAN_TEXT_TEXT_COUNT_H

#include "formats/scan/text/text.h"

/* No file has so many lines. */
#define STP_TEXT_NO_COUNT UINT64_MAX

/* True if the line is one whole number and nothing else. */
bool stp_text_is_count(const char *begin, const char *end);
/* Reads the next line, a whole number below STP_TEXT_NO_COUNT. `what` names the number in messages.
 * At the file's end *count is STP_TEXT_NO_COUNT. Errors: CORRUPT (another line), IO, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_text_next_count(stp_text *text, const char *what, uint64_t *count, stp_error *err);
/* Makes the error if line `count_line` promises `count` points and fewer follow. */
stp_status stp_text_few_lines(const stp_text *text, uint64_t count_line, uint64_t count,
                              uint64_t found, stp_error *err);

#endif
