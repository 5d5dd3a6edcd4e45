/* Allocation that reports: arrays by count and element size, with overflow checked. */
#ifndef STP_BASE_MEMORY_H
#define STP_BASE_MEMORY_H

#include "base/error.h"

#include <stddef.h>

/* Sets *out to zeroed memory for count elements of size bytes. If count is 0, *out is NULL, and
 * that is no error. `what` names the elements in the message. Errors: OUT_OF_MEMORY. Free with
 * free(). */
stp_status stp_alloc(void *out, size_t count, size_t size, const char *what, stp_error *err);

/* The same without zeroing: for large arrays that are written before they are read. */
stp_status stp_alloc_unset(void *out, size_t count, size_t size, const char *what, stp_error *err);

/* Sets *out to a copy of a text. `what` names it in the message. Errors: OUT_OF_MEMORY. Free with
 * free(). */
stp_status stp_text_copy(char **out, const char *text, const char *what, stp_error *err);

/* Grows *array (of *capacity elements of size bytes) by doubling until it holds at least `needed`
 * elements. Errors: OUT_OF_MEMORY; *array and *capacity then stay as they were. */
stp_status stp_grow(void *array, size_t *capacity, size_t needed, size_t size, const char *what,
                    stp_error *err);

#endif
