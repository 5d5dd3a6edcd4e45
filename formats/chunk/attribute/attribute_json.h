/* The list of a model's attributes as JSON (formats/SPEC.md, "Attributes"). Threads: any. */
#ifndef STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_JSON_H
#define STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_JSON_H

#include "base/error.h"
#include "formats/attribute/attribute.h"

/* *text: free with free(). Errors: OUT_OF_MEMORY. */
stp_status stp_attribute_list_write(const stp_attribute_list *list, char **text, stp_error *err);
/* Errors: CORRUPT (what is wrong). */
stp_status stp_attribute_list_read(stp_attribute_list *out, const char *text, size_t bytes,
                                   stp_error *err);

#endif
