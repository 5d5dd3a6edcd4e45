/* Whole JSON files in and out, and numbers with all their digits.
 *
 * The caller knows what a key means. Ownership: values are cJSON's; free them with cJSON_Delete.
 * Threads: any. */
#ifndef STP_BASE_JSON_H
#define STP_BASE_JSON_H

#include "base/error.h"
#include "base/vec_types.h"

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>

/* Files with more bytes are no JSON of ours. A camera path of 100,000 keyframes has half of them.
 */
#define STP_JSON_BYTES_LIMIT (64u << 20)

/* Reads a file that holds one JSON object. Free *out with cJSON_Delete. expected: what the file
 * should be, for the message. Errors: NOT_FOUND, IO, FORMAT, OUT_OF_MEMORY. */
stp_status stp_json_load(cJSON **out, const char *path, const char *expected, stp_error *err);
/* The same from bytes in memory; name: of the file, for the message. Errors: FORMAT, OUT_OF_MEMORY.
 */
stp_status stp_json_parse(cJSON **out, const char *text, size_t size, const char *name,
                          const char *expected, stp_error *err);
/* Writes a JSON value to a file that appears whole or not at all. json is freed even on failure;
 * NULL means that memory is exhausted. If force is set, an existing file is replaced. Errors:
 * EXISTS, IO, OUT_OF_MEMORY. */
stp_status stp_json_save(cJSON *json, const char *path, bool force, stp_error *err);

/* Whether an object has the key. Upper and lower case differ. */
bool stp_json_has(const cJSON *object, const char *key);
/* Sets out[0..count), count <= 6, to a key's finite numbers: one number if count is 1, else an
 * array of count numbers. If the key is missing, out stays as it is. where: a name for the message,
 * such as "C.json". Errors: FORMAT. */
stp_status stp_json_numbers(const cJSON *object, const char *key, double *out, int count,
                            const char *where, stp_error *err);
/* Adds a finite number, or an array of three, with 17 digits, so that reading gives the same value.
 * cJSON by itself writes 15 digits if they are nearly the number. */
void stp_json_add_number(cJSON *object, const char *key, double value);
void stp_json_add_vector(cJSON *object, const char *key, stp_dvec3 vector);

#endif
