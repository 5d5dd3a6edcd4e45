/* Grids of heights: what takes the place of the stages of points. */
#ifndef STP_PREPROCESS_PREP_GRID_H
#define STP_PREPROCESS_PREP_GRID_H

#include "preprocess/prep_job.h"

/* Fails if holes are to grow and the inputs are neither a grid nor images. Success is no promise:
 * images may still become points. Errors: INVALID_ARGUMENT. */
stp_status stp_prep_grid_check(const stp_prep_job *job, stp_error *err);
/* Returns INVALID_ARGUMENT: holes cannot grow. */
stp_status stp_prep_no_grid(stp_error *err);
/* Makes the grid empty, and room for the records of it that this rank reads. Errors: OUT_OF_MEMORY,
 * IO. */
stp_status stp_prep_grid_begin(stp_prep_job *job, stp_error *err);
void stp_prep_grid_clear(stp_prep_job *job);
/* Whether several files make one grid, and this process reads them all. */
bool stp_prep_grid_has_parts(const stp_prep_job *job);
/* Puts a record into the grid, or where this rank's records are. *reject becomes TWICE if the grid
 * has a sample there. */
void stp_prep_grid_add(stp_prep_job *job, const stp_point *point, uint64_t record,
                       stp_reject *reject);
/* Puts samples that need no further look into the grid, up to the first other one. Returns how
 * many.
 */
size_t stp_prep_grid_take(stp_prep_job *job, const stp_point *points, size_t count);
/* Rejects samples at places that files before give, once ranks have read their parts. Errors: those
 * of stp_grid_records_sift and stp_prep_reject. */
stp_status stp_prep_grid_sift(stp_prep_job *job, stp_error *err);
/* Takes the place of all stages of points up to the first view: a grid's neighbours are known.
 * Errors: those of the grid's functions. */
stp_status stp_prep_treat_grid(stp_prep_job *job, stp_error *err);
/* Chooses the precision of heights that are floats: they have no step, and their spacing says
 * little about how fine they are. It is a quarter of their noise or 2^-17 of their range, whichever
 * is coarser, but no finer than `finest`, a part of a cell. */
void stp_prep_height_precision(stp_prep_job *job, double noise, double finest);
/* Sets the grid of normals that are computed, for the tree and the statistics. */
void stp_prep_set_normal_bits(stp_prep_job *job, unsigned bits);
/* Bits of the normals of leaves that are grids: `bits`, or fewer if they need no more. */
unsigned stp_prep_grid_bits(unsigned bits);

#endif
