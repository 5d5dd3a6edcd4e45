/* Overhang: how far merged discs stick out past the surface they stand for. Gives each patch its
 * tangential error t.
 *
 * What the viewer is promised. A merged disc replaces the level-0 discs under it. Let p be its
 * centre or one of its 16 rim points. Then some level-0 disc is drawn at most this far from p on
 * the screen:
 *
 *    error_px = scale * min(e sin(alpha) + t, sqrt(e^2 + t^2))
 *
 * scale is pixels a world unit, e the perpendicular and t the tangential error of p's quarter (at
 * level 3: of the patch). alpha is the greatest angle between an eye ray and a normal of the patch.
 * e and t are the two legs of a right angle that leads from p to a level-0 disc.
 *
 * The cost of p over a level-0 disc d, cost(p, d), is the t that p needs if it goes by d:
 *
 *                 p
 *                 : h   height of p over the plane of d, along the normal of d
 *    =====d=====..:
 *               o       from the rim of d to the foot of p, in the plane of d; 0 inside
 *
 *    cost(p, d) = o + t_d + min(a + b, h)
 *    a = h sin(beta)   if d is not under p's merged disc, else 0;
 *                      beta is the angle between the normals of d and of p's merged disc
 *    b = sqrt(max(0, (h + e_d)^2 - e^2))   the leg that e leaves uncovered
 *
 * e_d and t_d are the errors that d carries from the chunk below (stp_carry); 0 in a leaf. A zero
 * normal makes d a ball: then h is 0.
 *
 * A rim that leaves the discs under it is no error if a neighbour's discs go on there. So d runs
 * over all level-0 discs of the chunk and of its surroundings, and only an open border costs
 * anything (docs/algorithms.md, "Tangential error").
 *
 * Example, in metres, e = 0.03, nothing carried. p is h = 0.05 over a disc under its own merged
 * disc and o = 0.02 outside: cost 0.02 + min(0 + 0.04, 0.05) = 0.06. A neighbour's disc has o = 0,
 * h = 0.02, sin(beta) = 0.5: cost min(0.01 + 0, 0.02) = 0.01. So p needs t = 0.01. At 50 pixels a
 * metre and sin(alpha) = 0.2 the error is 50 * min(0.016, 0.032) = 0.8 pixels; at an outline, where
 * sin(alpha) = 1, it is 50 * min(0.04, 0.032) = 1.6 pixels.
 *
 * How a stored t is checked (SPEC.md, stp_overhang_check): t >= min over d of cost(p, d), for each
 * p, without what discs carry.
 *
 * A grid of heights (disc_rows.h) may have a hole between centre and rim. There p is also the
 * disc's point in the middle of the hole. d runs over the discs in the columns and rows about p.
 *
 * What is stored (stp_overhang_measure) may be more, so that p is also drawn near what is nearest
 * to it in space. Let gamma be the patch's cone angle, at most a right angle. Then d must be the
 * disc nearest to p, or lie within t + e sin(gamma) of p. Whatever is nearer than d is then near
 * enough in any direction: the rule never takes sin(alpha) for less than sin(gamma). In a grid of
 * heights no disc lies over another one: there any d will do.
 *
 * Strips and triangles have errors of their own (strip.h, triangles.h): stp_overhang_measure
 * returns what they store, stp_overhang_check skips them. Threads: any, one chunk each. */
#ifndef STP_FORMATS_CHUNK_MEASURE_OVERHANG_H
#define STP_FORMATS_CHUNK_MEASURE_OVERHANG_H

#include "base/pool.h"
#include "formats/chunk/measure/surroundings.h"

/* The least tangential error of a merged level that is told apart: the patch's greatest level-0
 * radius divided by this. It spares most of the search. */
#define STP_OVERHANG_PARTS 20.0

/* Tangential errors of a patch, world units. level: by level. quarter: of levels 1 and 2 by
 * quarter, index level - 1. No error is less than that of the finer level under it. At level 0 it
 * is the greatest t_d that the samples carry. */
typedef struct stp_overhang {
    double level[STP_LEVEL_COUNT];
    double quarter[2][STP_PATCH_QUARTERS];
} stp_overhang;

/* Measures all patches into out[patch_count], rounded up to what can be stored. If a point's
 * nearest disc cannot be found in bounded time, the nearest of the discs under its merged disc
 * takes its place. carry: by level-0 sample, or NULL for none. around: what reaches in from other
 * chunks, with carries if the chunk has them; NULL for nothing. The chunk must have all levels, and
 * its patches their cones and perpendicular errors. pool: its threads share the patches; NULL: this
 * thread measures alone. Errors: OUT_OF_MEMORY. */
stp_status stp_overhang_measure(stp_overhang *out, const stp_chunk *chunk, const stp_carry *carry,
                                const stp_surroundings *around, stp_pool *pool, stp_error *err);

/* Sets *patch to the first patch that stores too small a tangential error for a merged level: some
 * point's least cost surely exceeds it, even without carries. STP_CHUNK_NONE if there is none.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_overhang_check(uint32_t *patch, const stp_chunk *chunk,
                              const stp_surroundings *around, stp_error *err);

#endif
