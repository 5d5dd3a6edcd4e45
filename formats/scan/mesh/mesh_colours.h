/* Gives the vertices of a mesh the colours of the faces around them. */
#ifndef STP_FORMATS_SCAN_MESH_MESH_COLOURS_H
#define STP_FORMATS_SCAN_MESH_MESH_COLOURS_H

#include "formats/scan/mesh/point_mesh.h"

/* Loads the images of mesh->materials. A vertex gets the mean of its faces' colours there. Removes
 * the materials if they say nothing: the vertices have colours of their own other than one grey, or
 * all faces have one grey. Errors: OUT_OF_MEMORY. */
stp_status stp_mesh_take_colours(stp_point_mesh *mesh, const char *path, stp_error *err);

#endif
