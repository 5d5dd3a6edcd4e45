/* Reads the faces of meshes for maps. */
#ifndef STP_TOOLS_PREP_PREP_MESHES_H
#define STP_TOOLS_PREP_PREP_MESHES_H

#include "tools/prep/prep_inputs.h"

/* Loads the meshes of all inputs as one, but for those that are projected or addresses. *out stays
 * NULL if there are none. The survey is done. Errors: those of stp_mesh_load, LIMIT (2^32
 * vertices). Free with stp_mesh_destroy. */
stp_status prep_meshes_read(const prep_inputs *in, stp_mesh **out, stp_error *err);

#endif
