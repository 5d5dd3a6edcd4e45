/* Leaves out what a picture hides ("Occlusion" in shaders/README.md).
 * Threads: the render thread. */
#ifndef STP_RUNTIME_OCCLUDE_H
#define STP_RUNTIME_OCCLUDE_H

#include "runtime/draw/far_depths.h"
#include "runtime/frame.h"

/* What pictures hide (occlude.c). Zero: nothing is known. */
typedef struct stp_occluding {
    stp_far_depths depths;
    stp_occlusion maps[2]; /* what the last pictures hide */
    int newest;
    bool known;                /* maps[newest] is of a picture like this one */
    bool coarse;               /* the last picture lacked many blocks */
    bool on;                   /* for this picture */
    bool squares;              /* some squares of grids were drawn */
    const stp_occlusion *used; /* what this picture leaves out; NULL: nothing */
    int rounds;                /* pictures of this view that brought something to light */
    uint64_t shown;            /* patches of this picture that were not left out */
    int guesses;               /* pictures that this frame drew to guess what is hidden */
    int idle;                  /* so many pictures go without */
} stp_occluding;

/* Begins a frame: chooses what its picture leaves out as hidden. Errors: OUT_OF_MEMORY. */
stp_status stp_occlude_begin(stp_renderer *r, const stp_draw_params *params, stp_error *err);
/* Chooses what the next picture leaves out by what is known now. streams: of a picture that does
 * not wait. */
void stp_occlude_choose(stp_renderer *r, bool streams);
/* Whether a picture of what is resident is worth its time: many blocks are missing that it may
 * hide. */
bool stp_occlude_wants_guess(stp_renderer *r);
/* Takes what such a picture hides. Errors: OUT_OF_MEMORY, GL. */
stp_status stp_occlude_guessed(stp_renderer *r, stp_error *err);
/* Begins to look at what the picture hides, once it is finished. Errors: GL. */
stp_status stp_occlude_look(stp_renderer *r, int levels, stp_error *err);
/* Ends a picture: counts what was left out, and finds out whether it came to light. Errors:
 * OUT_OF_MEMORY, GL. */
stp_status stp_occlude_end(stp_renderer *r, stp_drawing *d, stp_error *err);
/* What the picture leaves out of what is resident; NULL: nothing. */
const stp_occlusion *stp_occlude_drawn(const stp_renderer *r);
/* Counts what a pass leaves out, of so many draws just looked at. */
void stp_occlude_count(stp_renderer *r, stp_drawing *d, size_t draw_count);
/* The next pictures leave nothing out, until a frame begins. */
void stp_occlude_pause(stp_renderer *r);
/* Forgets what pictures hide. */
void stp_occlude_forget(stp_renderer *r);
void stp_occlude_destroy(stp_renderer *r);

#endif
