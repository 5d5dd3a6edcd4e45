/* Finds the chunks of a COPC file that a region needs: a COPC is a LAZ file whose chunks are the
 * nodes of an octree.
 *
 * COPC 1.0: the record "copc" 1 tells the root's cube, its spacing and the first page of the
 * hierarchy; pages lie in the extended record "copc" 1000. Threads: any. */
#ifndef STP_FORMATS_SCAN_LAS_COPC_H
#define STP_FORMATS_SCAN_LAS_COPC_H

#include "formats/scan/las/las_header.h"
#include "formats/scan/las/las_records.h"
#include "formats/scan/las/laz/laz_chunks.h"
#include "formats/scan/scan.h"

/* Whether the file is a COPC. */
static inline bool stp_copc_is(const stp_las_header *header, const stp_las_records *records)
{
    return header->compressed && records->kept[STP_LAS_COPC].bytes != NULL;
}

/* The spacing of the root's points; 0 if the record does not say. */
double stp_copc_spacing(const stp_las_records *records);
/* Lists the chunks with points of the region's nodes, in the order of the file, and counts their
 * points. Moves source. *out must be zero; free it. Errors: IO, CORRUPT (nodes that lie where none
 * may, or twice), LIMIT, OUT_OF_MEMORY. */
stp_status stp_copc_choose(stp_laz_chunks *out, uint64_t *point_count, const stp_las_header *header,
                           const stp_las_records *records, const stp_scan_region *region,
                           stp_source *source, stp_error *err);

#endif
