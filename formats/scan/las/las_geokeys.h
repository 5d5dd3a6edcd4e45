/* Prints the GeoTIFF keys of a LAS file as readable text. */
#ifndef STP_FORMATS_SCAN_LAS_LAS_GEOKEYS_H
#define STP_FORMATS_SCAN_LAS_LAS_GEOKEYS_H

#include "formats/scan/las/las_records.h"
#include "formats/scan/las/las_text.h"

/* Appends a line `name=value` for each key of the directory (GeoTIFF 1.0, section 2.4). A key
 * without a name there is `Key<number>`. Commas separate several numbers of one key. If the file
 * lacks a value, the text says that the value is missing. Errors: OUT_OF_MEMORY. */
stp_status stp_las_geokeys_text(stp_las_text *text, const stp_las_records *records, stp_error *err);

#endif
