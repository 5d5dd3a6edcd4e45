/* What cameras and paths read out of JSON files. Threads: any. */
#ifndef STP_RUNTIME_JSON_H
#define STP_RUNTIME_JSON_H

#include "base/error.h"

#include <cjson/cJSON.h>

/* Reads a file whose text is a JSON object; *out is to be freed with cJSON_Delete. expected: what
 * the file should be, for the message. Errors: NOT_FOUND, IO, FORMAT, OUT_OF_MEMORY. */
stp_status stp_json_load(cJSON **out, const char *path, const char *expected, stp_error *err);

/* Replaces out[0..count), count <= 3, by the finite numbers of a key, a number or an array of them;
 * a key that is not there leaves them. where: of the message, like "C.json". Errors: FORMAT. */
stp_status stp_json_numbers(const cJSON *object, const char *key, double *out, int count,
                            const char *where, stp_error *err);

#endif
