/* Allocation that reports: arrays by count and element size, with overflow checked. */
#ifndef STP_BASE_MEMORY_H
#define STP_BASE_MEMORY_H

#include "base/error.h"

#include <stddef.h>

/* Sets *out to zeroed memory for count elements of size bytes (NULL for none, which is no error).
 * `what` names the thing in the message. Errors: OUT_OF_MEMORY. Free with free(). */
stp_status stp_alloc(void *out, size_t count, size_t size, const char *what, stp_error *err);

/* Sets *out to a copy of a text. `what` as above. Errors: OUT_OF_MEMORY. Free with free(). */
stp_status stp_text_copy(char **out, const char *text, const char *what, stp_error *err);

/* Grows *array (of *capacity elements of size bytes) to hold at least needed elements, by doubling.
 * Errors: OUT_OF_MEMORY, then *array and *capacity are as before. */
stp_status stp_grow(void *array, size_t *capacity, size_t needed, size_t size, const char *what,
                    stp_error *err);

#endif
