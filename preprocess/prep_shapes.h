/* Cuts lines and triangles into leaves; how far points and shapes reach. */
#ifndef STP_PREPROCESS_PREP_SHAPES_H
#define STP_PREPROCESS_PREP_SHAPES_H

#include "preprocess/prep_job.h"

/* Cuts the source's lines and triangles into leaves. Errors: LIMIT (they are too large for the
 * memory), EMPTY (there are no points either), OUT_OF_MEMORY. */
stp_status stp_prep_cut_shapes(stp_prep_job *job, stp_error *err);
/* Adds the triangles between maps to those of the source, and cuts all into leaves, if there are
 * any between maps. Errors: those of stp_triangle_leaves_create. */
stp_status stp_prep_fill_maps(stp_prep_job *job, stp_error *err);
void stp_prep_clear_shapes(stp_prep_shapes *shapes);
/* The longest side of the box of points, lines and triangles. Errors: LIMIT (coordinates too large,
 * or the box too small, for a picture). */
stp_status stp_prep_side(double *out, const stp_prep_source *source, const stp_prep_stats *stats,
                         stp_error *err);

#endif
