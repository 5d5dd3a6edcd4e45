/* The views in which the promise is measured: 26 directions and ten close ones.
 *
 * They are made without the runtime, so that they judge the runtime too. Threads: any. */
#ifndef STP_TESTS_SUPPORT_VIEWS_H
#define STP_TESTS_SUPPORT_VIEWS_H

#include "runtime/camera/camera.h"
#include "tests/support/promise.h"

#define VIEWS_DIRECTIONS 26
#define VIEWS_CLOSE 10
#define VIEWS_COUNT (VIEWS_DIRECTIONS + VIEWS_CLOSE)

/* A perspective view; `up` is replaced if it is parallel to the view. */
stp_view views_look(stp_dvec3 eye, stp_dvec3 look, double fovy_deg, const stp_ball *ball, int width,
                    int height);

/* Views i < VIEWS_DIRECTIONS look from a face, edge or corner of a cube; the ball fills the view.
 * The others stand over a disc of the model, 0.02 to 0.5 of the ball's radius away, head-on to
 * grazing, with fields of view up to 100 degrees. */
stp_view views_get(int i, const stp_ball *ball, const promise_disc *discs, size_t count, int width,
                   int height);

#endif
