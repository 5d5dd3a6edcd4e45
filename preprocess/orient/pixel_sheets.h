/* Joins the sheets of a depth camera's image where neighbouring pixels lie on one surface.
 *
 * A depth camera's error is far larger than the distance between its pixels, so its surfaces fall
 * into layers, often one for each step of the camera's disparity. To a search in space each layer
 * is a sheet of its own, and patches of one sheet would have a dozen points. In the image, layers
 * of one surface touch.
 *
 * A pixel and the next one to the right or below lie on one surface if each is as near to the
 * other's plane as the camera's noise allows: 6 times the median of pixels 16 apart, which grows as
 * the square of the distance. Only points whose normals the image told (image_normals.h) are
 * joined: the others have little noise. Threads: one. */
#ifndef STP_PREPROCESS_ORIENT_PIXEL_SHEETS_H
#define STP_PREPROCESS_ORIENT_PIXEL_SHEETS_H

#include "preprocess/prep.h"

/* Call it last of all that changes sheets. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_pixel_sheets_join(stp_cloud *cloud, const stp_prep_source *source, stp_error *err);

#endif
