/* Decimal numbers out of text, without a locale: "1.5" is one and a half in every country. */
#ifndef STP_FORMATS_SCAN_NUMBER_H
#define STP_FORMATS_SCAN_NUMBER_H

#include <stdbool.h>
#include <stdint.h>

/* Reads the whole of [begin, end) as one number, correctly rounded. nan, inf, infinity (any case)
 * and Windows' 1.#QNAN, -1.#IND, 1.#INF are numbers too. False if it is none. */
bool stp_number_parse(const char *begin, const char *end, double *value);

/* Reads the whole of [begin, end) as an unsigned decimal integer; false if it is none or overflows.
 */
bool stp_number_parse_u64(const char *begin, const char *end, uint64_t *value);

#endif
