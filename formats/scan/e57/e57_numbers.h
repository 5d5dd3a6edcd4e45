/* The attributes of E57 points: fields that points have no member for, and intensities and classes
 * that a sample's 8 bits do not hold.
 *
 * An attribute has the field's name without the prefix of its extension. A whole number has the
 * least type that holds what the field's bits can say, and the field's scale and offset; a float
 * has 32 or 64 bits. If a scan says that an intensity or a time stamp is not valid, the number is
 * missing, as it is in scans without the field. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_E57_E57_NUMBERS_H
#define STP_FORMATS_SCAN_E57_E57_NUMBERS_H

#include "formats/attribute/attribute_list.h"
#include "formats/scan/e57/e57_ranges.h"
#include "formats/scan/e57/e57_vector.h"

typedef struct stp_e57_numbers {
    stp_attribute_union all; /* of all scans with points */
    stp_attribute_list own;  /* of the scan that is being read */
    uint8_t *packed;         /* of the points read last */
    size_t capacity;
} stp_e57_numbers;

/* Finds the attributes of all scans; ranges: of their values. Fields that are none, are used no
 * more. *numbers must be zero. */
void stp_e57_numbers_find(stp_e57_numbers *numbers, stp_e57_document *document,
                          const stp_e57_ranges *ranges);
/* Makes room for so many points. Errors: OUT_OF_MEMORY. */
stp_status stp_e57_numbers_reserve(stp_e57_numbers *numbers, size_t points, stp_error *err);
/* Goes to the points of a scan. */
void stp_e57_numbers_begin(stp_e57_numbers *numbers, const stp_e57_document *document,
                           const stp_e57_scan *scan);
/* Packs the `count` points that the vector read last, from point `first` on. */
void stp_e57_numbers_pack(stp_e57_numbers *numbers, const stp_e57_vector *vector, size_t first,
                          size_t count);
void stp_e57_numbers_clear(stp_e57_numbers *numbers);

#endif
