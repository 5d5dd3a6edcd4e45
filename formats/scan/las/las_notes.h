/* Makes the notes of a LAS file: "wkt" (its coordinate system), "geokeys" (the same as GeoTIFF
 * keys, one per line), "left_out" (fields of its points that are not read, by the standard's
 * names), "lattice" (scale x y z, then offset x y z: coordinate = integer * scale + offset),
 * "gps_time_offset" (of LAS 1.5: GPS times begin after so many million seconds), "counts" (if its
 * numbers of points disagree), "scales" (if some are 0 or negative), "degrees" (if it names no
 * system, but its x and y are longitude and latitude: they have steps of a millionth or less, and z
 * has steps 100 times as wide or more). */
#ifndef STP_FORMATS_SCAN_LAS_LAS_NOTES_H
#define STP_FORMATS_SCAN_LAS_LAS_NOTES_H

#include "formats/scan/las/las_depth.h"
#include "formats/scan/las/las_header.h"
#include "formats/scan/las/las_records.h"
#include "formats/scan/las/las_text.h"
#include "formats/scan/scan.h"

#define STP_LAS_NOTES_MAX 8u

typedef struct stp_las_notes {
    stp_scan_note list[STP_LAS_NOTES_MAX];
    stp_las_text texts[STP_LAS_NOTES_MAX];
    uint32_t count;
} stp_las_notes;

/* *out must be zero. Free it even after a failure. keeps_numbers: attributes are read, but wave
 * packets. file_bytes is the file's size. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_las_notes_make(stp_las_notes *out, const stp_las_header *header,
                              const stp_las_records *records, const stp_las_depth *depth,
                              bool keeps_numbers, uint64_t file_bytes, stp_error *err);
void stp_las_notes_free(stp_las_notes *notes);

#endif
