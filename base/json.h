/* JSON files as a whole, and numbers in them with all their digits.
 *
 * What a key means is for the caller to know. Ownership: values are cJSON's, freed with
 * cJSON_Delete. Threads: any. */
#ifndef STP_BASE_JSON_H
#define STP_BASE_JSON_H

#include "base/error.h"
#include "base/vec_types.h"

#include <cjson/cJSON.h>
#include <stdbool.h>

/* Reads a file whose text is a JSON object; *out is to be freed with cJSON_Delete. expected: what
 * the file should be, for the message. Errors: NOT_FOUND, IO, FORMAT, OUT_OF_MEMORY. */
stp_status stp_json_load(cJSON **out, const char *path, const char *expected, stp_error *err);
/* Writes a JSON value, freed in any case (NULL: memory is exhausted), to a file that appears whole
 * or not at all; an existing one is replaced with force. Errors: EXISTS, IO, OUT_OF_MEMORY. */
stp_status stp_json_save(cJSON *json, const char *path, bool force, stp_error *err);

/* Whether an object has the key, spelled so. */
bool stp_json_has(const cJSON *object, const char *key);
/* Replaces out[0..count), count <= 3, by the finite numbers of a key, a number or an array of them;
 * a key that is not there leaves them. where: of the message, like "C.json". Errors: FORMAT. */
stp_status stp_json_numbers(const cJSON *object, const char *key, double *out, int count,
                            const char *where, stp_error *err);
/* Adds a finite number, or three of them as an array, so that they are read as they were: cJSON
 * itself writes 15 digits where that is nearly the number. */
void stp_json_add_number(cJSON *object, const char *key, double value);
void stp_json_add_vector(cJSON *object, const char *key, stp_dvec3 vector);

#endif
