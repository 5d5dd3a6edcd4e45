/* Parses decimal numbers in text without a locale: "1.5" is one and a half in every country. */
#ifndef STP_FORMATS_SCAN_NUMBER_H
#define STP_FORMATS_SCAN_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

/* Reads the whole of [begin, end) as one number, correctly rounded. nan, inf, infinity (any case)
 * and Windows' 1.#QNAN, -1.#IND, 1.#INF are numbers, too. False if the text is no number. */
bool stp_number_parse(const char *begin, const char *end, double *value);

/* Reads a number in digits from begin to the last character that belongs to it. Returns its end;
 * NULL if no number is there or a special one (see above). Never reads at or after end. Numbers
 * with up to 19 significant digits and up to 27 places either way are parsed in integers, the rare
 * others by the C library. */
const char *stp_number_scan(const char *begin, const char *end, double *value);

/* Reads the whole of [begin, end) as an unsigned decimal integer. False if the text is none or
 * overflows. */
bool stp_number_parse_u64(const char *begin, const char *end, uint64_t *value);

#endif
