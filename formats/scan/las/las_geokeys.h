/* The GeoTIFF keys of a LAS file as readable text. */
#ifndef STP_FORMATS_SCAN_LAS_LAS_GEOKEYS_H
#define STP_FORMATS_SCAN_LAS_LAS_GEOKEYS_H

#include "formats/scan/las/las_records.h"
#include "formats/scan/las/las_text.h"

/* Appends a line `name=value` for each key of the directory, by GeoTIFF 1.0, section 2.4; keys
 * without a name there are `Key<number>`. Several numbers of one key are parted by commas. A value
 * that the file does not have is said to be missing. Errors: OUT_OF_MEMORY. */
stp_status stp_las_geokeys_text(stp_las_text *text, const stp_las_records *records, stp_error *err);

#endif
