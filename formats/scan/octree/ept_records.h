/* Decodes records of an Entwine Point Tile set's schema to points. Threads: any. */
#ifndef STP_FORMATS_SCAN_OCTREE_EPT_RECORDS_H
#define STP_FORMATS_SCAN_OCTREE_EPT_RECORDS_H

#include "formats/scan/las/las_depth.h"
#include "formats/scan/octree/ept_header.h"

/* Adds count records. */
void stp_ept_records_look(stp_las_seen *seen, const stp_ept_header *header,
                          const unsigned char *records, size_t count);
/* Decodes count records. Positions may be NaN or infinite. */
void stp_ept_records_decode(const stp_ept_header *header, const stp_las_depth *depth,
                            const unsigned char *records, stp_point *points, size_t count);

#endif
