/* Reads colours of binary STL's facets, which two programs put into the two bytes after each facet:
 *
 * - VisCAM and SolidView: bit 15 is set, and blue, green and red have 5 bits each, blue the lowest.
 * - Materialise, if `COLOR=` stands in the header, with 4 bytes: bit 15 is clear, and red, green
 * and blue have 5 bits each, red the lowest. A facet with bit 15 set has the header's colour.
 *
 * Threads: any. */
#ifndef STP_FORMATS_SCAN_MESH_STL_COLOURS_H
#define STP_FORMATS_SCAN_MESH_STL_COLOURS_H

#include "formats/scan/mesh/mesh_text.h"

/* Adds the colours of all facets but those whose corners coincide: OpenMesh leaves these out. Adds
 * nothing if no facet has a colour. The text was checked (stp_mesh_text_check_stl_binary). Errors:
 * OUT_OF_MEMORY. */
stp_status stp_stl_colours_add(const stp_mesh_text *text, stp_materials *materials, stp_error *err);

#endif
