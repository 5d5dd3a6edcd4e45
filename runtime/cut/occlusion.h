/* What a picture hides: the farthest depth of each of its cells, and the camera that it was drawn
 * with. A block or a patch whose bound projects into the picture and lies wholly behind is not
 * drawn, not asked for and not refined ("Occlusion" in shaders/README.md). Threads: any may ask. */
#ifndef STP_RUNTIME_CUT_OCCLUSION_H
#define STP_RUNTIME_CUT_OCCLUSION_H

#include "base/error.h"
#include "base/vec.h"
#include "runtime/gl/gpu_layout.h"

#include <stdbool.h>
#include <stddef.h>

/* A cell is a square of so many pixels; a tile of runtime/cut/tiles.h. */
#define STP_OCCLUSION_CELL_PX 8
#define STP_OCCLUSION_LEVELS_LIMIT 14
/* The depth of a cell that hides nothing. */
#define STP_OCCLUSION_NONE 1e38f

/* A level of the pyramid of farthest depths: a cell of the next is as far as the farthest of four.
 */
typedef struct stp_occlusion_level {
    const float *far;
    int columns, rows;
} stp_occlusion_level;

/* The box of blocks that may be hidden, relative to the eye of the picture that asks. */
typedef struct stp_occluded {
    float low[3], high[3];
} stp_occluded;

/* Zero hides nothing. */
typedef struct stp_occlusion {
    float *far; /* owned: the cells of all levels */
    size_t capacity;
    stp_occlusion_level levels[STP_OCCLUSION_LEVELS_LIMIT];
    int level_count;
    float axes[3][3]; /* right, up, back */
    float viewport[4], centre[2];
    bool orthographic;
    stp_dvec3 eye;
    /* Of the picture that asks: its eye less this one, and how far around a bound all must be
     * hidden. */
    float shift[3], margin_px;
    bool same; /* the cameras are: what lies outside this picture is outside that one, too */
    /* It may hide too much: draw what is resident, but ask for nothing that it hides. */
    bool asks_only;
} stp_occlusion;

/* Makes room for a picture's cells. The caller fills levels[0].far, row by row, then calls
 * stp_occlusion_close. Errors: OUT_OF_MEMORY. */
stp_status stp_occlusion_open(stp_occlusion *occlusion, const stp_gpu_frame *frame, stp_dvec3 eye,
                              stp_error *err);
void stp_occlusion_close(stp_occlusion *occlusion);
void stp_occlusion_destroy(stp_occlusion *occlusion);

/* Whether it is of a picture with this camera. */
bool stp_occlusion_is_of(const stp_occlusion *occlusion, const stp_gpu_frame *frame, stp_dvec3 eye);
/* Sets the eye of the picture that asks, how far the two may see apart, and whether they have the
 * same camera. */
void stp_occlusion_aim(stp_occlusion *occlusion, stp_dvec3 eye, float margin_px, bool same);
/* How many pixels what is seen may move against what is behind it, if the eye moves to `eye`. */
float stp_occlusion_parallax(const stp_occlusion *occlusion, stp_dvec3 eye);
/* Whether a ball relative to the eye of the picture that asks is hidden. NULL hides nothing. */
bool stp_occlusion_hides(const stp_occlusion *occlusion, const float centre[3], float radius);
/* The same for a box along the world's axes. */
bool stp_occlusion_hides_box(const stp_occlusion *occlusion, const stp_occluded *box);

#endif
