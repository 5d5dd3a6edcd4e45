/* Draws a pass of a picture, what was chosen and is resident, and finishes the picture. Threads:
 * the render thread. */
#ifndef STP_RUNTIME_FRAME_PASS_H
#define STP_RUNTIME_FRAME_PASS_H

#include "runtime/cut/sight.h"
#include "runtime/draw/project.h"
#include "runtime/draw/reconstruct.h"
#include "runtime/frame.h"

/* Compiles the programs for `lod`, if the renderer does not have them: a picture may take another
 * road than its parameters say. Errors: GL. */
stp_status stp_frame_prepare(stp_renderer *r, stp_lod lod, stp_error *err);
/* The same for programs that the renderer does not own yet. */
stp_status stp_frame_prepare_road(stp_project *project, stp_reconstruct_programs *reconstruct,
                                  const char *folder, const stp_variant *variant, stp_lod lod,
                                  stp_error *err);
/* The parameters for looking at the sight (stp_sight_look). */
stp_sight_params stp_frame_sight(const stp_renderer *r);
/* Projects resident draws, then resolves the nearest sample of each pixel. Errors: GL, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_frame_pass(stp_renderer *r, stp_drawing *d, const stp_draw *draws, size_t count,
                          stp_error *err);
/* Which part of splats a pass draws: a pass of `count` blocks from the cut's draw `begin` on. */
stp_splat_part stp_frame_part(const stp_renderer *r, bool fronts_done, size_t begin, size_t count);
/* Makes the picture from what the passes left: pulls, pushes and shades. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_finish(stp_renderer *r, stp_drawing *d, double radius_px, stp_error *err);
/* Uploads r->frame for the shaders. */
void stp_frame_upload(const stp_renderer *r);

#endif
