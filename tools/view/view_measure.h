/* Lines measured between two clicked points.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_MEASURE_H
#define STP_TOOLS_VIEW_VIEW_MEASURE_H

#include "runtime/stipple.h"

#define VIEW_LINES_LIMIT 32

/* Zero is empty. */
typedef struct view_measure {
    stp_dvec3 lines[VIEW_LINES_LIMIT][2]; /* the finished lines, oldest first */
    int line_count;
    bool begun;      /* a line whose second point is yet to come */
    stp_dvec3 first; /* its first point */
} view_measure;

/* Adds a point, which begins a line or ends it. False if there are VIEW_LINES_LIMIT lines. */
bool view_measure_add(view_measure *measure, stp_dvec3 point);
/* Removes one finished line. */
void view_measure_remove(view_measure *measure, int index);
/* The ends of the last finished line; NULL if there is none, or if another is begun. */
const stp_dvec3 *view_measure_last(const view_measure *measure);
double view_measure_length(const stp_dvec3 ends[2]);

#endif
