/* The attributes of PCD points: fields that points have no member for, and intensities and classes
 * of more than 8 bits, which a sample holds in 8 alone.
 *
 * An attribute has the field's name, type and size. The values of a field of COUNT n are NAME_0 to
 * NAME_n-1. A field is no attribute if it only fills up records, or if not all its values fit into
 * the list (stp_attribute_list_add). Threads: any once found. */
#ifndef STP_FORMATS_SCAN_PCD_PCD_NUMBERS_H
#define STP_FORMATS_SCAN_PCD_PCD_NUMBERS_H

#include "formats/attribute/attribute.h"
#include "formats/scan/pcd/pcd_header.h"

/* A field that is kept: its values stand side by side in a packed point. */
typedef struct stp_pcd_extra {
    size_t field;            /* index in the header */
    size_t at, bytes;        /* of its values in a packed point */
    stp_attribute_type type; /* of each value */
} stp_pcd_extra;

typedef struct stp_pcd_numbers {
    stp_attribute_list list;
    stp_pcd_extra extras[STP_ATTRIBUTES_LIMIT];
    uint32_t count;  /* of extras */
    size_t stride;   /* bytes of a packed point */
    uint8_t *packed; /* of the points read last */
    size_t capacity;
} stp_pcd_numbers;

/* Finds the attributes of a header, whose fields learn their extra. *numbers must be zero. */
void stp_pcd_numbers_find(stp_pcd_numbers *numbers, stp_pcd_header *header);
/* Makes room for the numbers of so many points. Errors: OUT_OF_MEMORY. */
stp_status stp_pcd_numbers_reserve(stp_pcd_numbers *numbers, size_t points, stp_error *err);
/* Reads the whole of [begin, end) as a number of this type. False if it is none: no number, a
 * fraction for a whole type, or beyond the type's range. */
bool stp_pcd_number_parse(stp_attribute_type type, const char *begin, const char *end,
                          uint64_t *word);
void stp_pcd_numbers_clear(stp_pcd_numbers *numbers);

#endif
