/* What a TIFF says of its place and of its numbers. Part of the module of TIFF. Threads: one at a
 * time per TIFF. */
#ifndef STP_FORMATS_SCAN_GRID_TIFF_GEO_H
#define STP_FORMATS_SCAN_GRID_TIFF_GEO_H

#include "formats/scan/grid/raster.h"

#include <tiffio.h>

/* Names the tags to libtiff, for all files that are opened from here on. Call it once. */
void stp_tiff_name_tags(void);
/* Finds no-data, scale and offset. singles: numbers are floats of 32 bits. */
void stp_tiff_find_meaning(TIFF *tiff, bool singles, stp_raster_info *info);
/* Finds where the image lies. */
void stp_tiff_find_place(TIFF *tiff, stp_raster_info *info);

#endif
