/* Finds the values of an E57 file that mean no and full intensity and colour. */
#ifndef STP_FORMATS_SCAN_E57_E57_RANGES_H
#define STP_FORMATS_SCAN_E57_E57_RANGES_H

#include "formats/scan/e57/e57_vector.h"
#include "formats/scan/value_range.h"

/* For all scans together; high <= low if no scan has the field. */
typedef struct stp_e57_ranges {
    stp_value_range intensity, colour;
} stp_e57_ranges;

/* vector reads points of scans that do not give their limits. Errors: as stp_e57_vector_open and
 * stp_e57_vector_read. */
stp_status stp_e57_ranges_find(stp_e57_ranges *ranges, const stp_e57_document *document,
                               stp_e57_vector *vector, stp_e57_pages *pages, stp_error *err);

#endif
