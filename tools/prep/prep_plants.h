/* Reads meshes of plants for prep (--lines auto): their lines and the remaining triangles. */
#ifndef STP_TOOLS_PREP_PREP_PLANTS_H
#define STP_TOOLS_PREP_PREP_PLANTS_H

#include "formats/scan/mesh/triangle_set.h"
#include "formats/scan/scan.h"
#include "preprocess/plant/plant.h"

/* Converts a mesh file. *lines and *triangles must be empty. Adds to *report. Errors: those of
 * stp_mesh_load and stp_plant_convert. */
stp_status prep_plants_read(const char *path, stp_line_set *lines, stp_triangle_set *triangles,
                            stp_plant_report *report, stp_error *err);
/* Whether --lines auto is worth a hint: the mesh has many leaves, and most of its triangles would
 * become lines. Loads the mesh only if it is small and has as many vertices as loose leaves bring.
 * False if in doubt, also if the mesh cannot be loaded. */
bool prep_plants_suspect(const char *path, const stp_scan_info *info);

#endif
