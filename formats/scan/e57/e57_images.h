/* Images of an E57 file: scans whose records tell their rows and columns (rowIndex, columnIndex).
 *
 * Records may come in any order, and pixels without a return may be missing. So a scan's records
 * are read once to find which rows and columns there are. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_E57_E57_IMAGES_H
#define STP_FORMATS_SCAN_E57_E57_IMAGES_H

#include "formats/scan/e57/e57_vector.h"
#include "formats/scan/scan.h"

typedef struct stp_e57_images {
    stp_scan_image *list;
    double (*first)[2]; /* by image: its first column and row */
    size_t capacity, first_capacity;
    uint32_t count;
} stp_e57_images;

/* Adds a scan that has a station, if it is an image. first: the number of records before it. Moves
 * the vector. Errors: those of the vector, OUT_OF_MEMORY. */
stp_status stp_e57_images_add(stp_e57_images *images, const stp_e57_scan *scan, uint64_t first,
                              uint16_t station, stp_e57_vector *vector, stp_e57_pages *pages,
                              stp_error *err);
/* Sets the pixels of points whose records were read last, of a station's scan; 0: it has none. */
void stp_e57_images_tell(const stp_e57_images *images, const stp_e57_vector *vector,
                         uint16_t station, stp_point *points, size_t count);
void stp_e57_images_clear(stp_e57_images *images);

#endif
