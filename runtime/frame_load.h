/* What a frame draws and asks for: describes the view, chooses the cut by what is resident, and
 * loads blocks. Threads: the render thread. */
#ifndef STP_RUNTIME_FRAME_LOAD_H
#define STP_RUNTIME_FRAME_LOAD_H

#include "runtime/cut/cut.h"
#include "runtime/cut/scene.h"
#include "runtime/frame.h"
#include "runtime/stream/cache/block_cache.h"

/* Fills the frame record that shaders and the cut read: view, threshold, colours, and what the
 * picture leaves out. */
stp_gpu_frame stp_frame_describe(const stp_view *view, const stp_draw_params *params,
                                 const stp_scene *scene);
/* Chooses the cut of the frame; the sight has looked at none of its draws yet. While chunks stream
 * and the camera moves, the choice depends on the last cut. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_select(stp_renderer *r, const stp_drawing *d, stp_error *err);
/* Whether the last frame's cut and sight do: view, parameters and what is resident are the same,
 * and nothing is left out as hidden. A view at rest draws the same again while a host moves
 * something else, or what fades. */
bool stp_frame_may_keep(const stp_renderer *r);
/* Lists the blocks and levels that draws want in r->wants. headers: no finer than what tells the
 * levels of their patches. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_list_wants(stp_renderer *r, const stp_draw *draws, size_t count, bool headers,
                                stp_error *err);
/* Whether a picture that waits loads headers first: unless it shows every sample. */
bool stp_frame_asks_headers(const stp_renderer *r);
/* Sets the levels of draws whose headers are resident to what their patches need. */
stp_status stp_frame_refine(stp_renderer *r, stp_draw *draws, size_t count, stp_error *err);
/* Loads the cut's draws from draw `begin` on, as many as there is room for, and waits. known: their
 * levels are those that their patches need. Errors: IO, GL, OUT_OF_MEMORY. */
stp_status stp_frame_load_draws(stp_renderer *r, stp_drawing *d, size_t begin, bool known,
                                stp_cache_load *load, stp_error *err);
/* Chooses the cut and loads what its patches ask for, tier by tier, and waits. *complete: all of it
 * is there. Errors: as stp_frame_load_draws. */
stp_status stp_frame_load_asked(stp_renderer *r, stp_drawing *d, bool *complete, stp_error *err);
/* Marks what the cut draws, or falls back on, as used. */
void stp_frame_touch(stp_renderer *r);
/* Requests the blocks that are missing, and those that the camera's motion will reveal. ahead: may
 * be NULL. Errors: OUT_OF_MEMORY. */
stp_status stp_frame_want_missing(stp_renderer *r, const stp_drawing *d, const stp_view *ahead,
                                  stp_error *err);

#endif
