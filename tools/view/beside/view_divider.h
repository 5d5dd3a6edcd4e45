/* The divider between two pictures that are shown beside each other. It knows no window: it turns
 * places into columns and sides. Threads: any (no shared state). */
#ifndef STP_TOOLS_VIEW_BESIDE_VIEW_DIVIDER_H
#define STP_TOOLS_VIEW_BESIDE_VIEW_DIVIDER_H

#include <stdbool.h>

#define VIEW_DIVIDER_WORDS "both|left alone|right alone"
typedef enum view_divider_shows {
    VIEW_DIVIDER_BOTH,
    VIEW_DIVIDER_LEFT,
    VIEW_DIVIDER_RIGHT
} view_divider_shows;

/* Sides are numbered: 0 is the first, 1 the second. Zero has the divider at the left end. */
typedef struct view_divider {
    double at; /* share of the width that is left of the divider */
    view_divider_shows shows;
    bool swapped; /* side 1 is at the left */
    bool dragged;
    double offset; /* of the dragging cursor from the divider, in pixels */
} view_divider;

/* The first column of a picture that belongs to the right side: 0 to width. */
int view_divider_column(const view_divider *divider, int width);
/* The side that is shown at a column. */
int view_divider_side(const view_divider *divider, int width, double x);
/* Takes the divider if it is shown within reach of x. False if not. */
bool view_divider_take(view_divider *divider, int width, double x, double reach);
/* Moves the divider that was taken: it keeps its distance from the cursor, within the picture. */
void view_divider_drag(view_divider *divider, int width, double x);
/* Moves it by a share of the width, within the picture; both sides are shown then. */
void view_divider_step(view_divider *divider, double by);

#endif
