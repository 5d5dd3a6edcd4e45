/* Decimal numbers out of text, without a locale: "1.5" is one and a half in every country. */
#ifndef STP_FORMATS_SCAN_NUMBER_H
#define STP_FORMATS_SCAN_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

/* Reads the whole of [begin, end) as one number, correctly rounded. nan, inf, infinity (any case)
 * and Windows' 1.#QNAN, -1.#IND, 1.#INF are numbers too. False if it is none. */
bool stp_number_parse(const char *begin, const char *end, double *value);

/* Reads a number in digits, as long as it goes on from begin; returns where it ends, NULL if there
 * is none (or one of the special ones above). Never reads at or behind end. Up to 19 digits that
 * count and 27 places either way are done in integers, the rare others by the C library. */
const char *stp_number_scan(const char *begin, const char *end, double *value);

/* Reads the whole of [begin, end) as an unsigned decimal integer; false if it is none or overflows.
 */
bool stp_number_parse_u64(const char *begin, const char *end, uint64_t *value);

#endif
