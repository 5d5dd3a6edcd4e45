/* Lines measured between two clicked points.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_MEASURE_H
#define STP_TOOLS_VIEW_VIEW_MEASURE_H

#include "runtime/stipple.h"

#define VIEW_LINES_LIMIT 32

/* Zero is empty. */
typedef struct view_measure {
    stp_dvec3 points[2];                  /* of the last line */
    int count;                            /* 1: its second point is yet to come */
    stp_dvec3 lines[VIEW_LINES_LIMIT][2]; /* the finished lines, oldest first */
    int line_count;
} view_measure;

/* Adds a point, which begins a line or ends it. False if there are VIEW_LINES_LIMIT lines. */
bool view_measure_add(view_measure *measure, stp_dvec3 point);
/* Removes one finished line. */
void view_measure_remove(view_measure *measure, int index);
double view_measure_length(const stp_dvec3 ends[2]);

#endif
