/* Finds the samples of a model along a line on the map: its profile.
 *
 * A sample belongs to the profile if its place (x, y) is at most half the width away from the
 * segment between two points. Reads the leaves that the segment's surroundings meet, and no others.
 * Memory: 48 bytes a sample found. Threads: one at a time. */
#ifndef STP_TOOLS_PROFILE_PROFILE_CUT_H
#define STP_TOOLS_PROFILE_PROFILE_CUT_H

#include "base/progress.h"
#include "formats/chunk/chunk_file.h"

typedef struct profile_line {
    double from[2], to[2]; /* x, y in the world */
    double width;          /* 0: twice the spacing of the model's samples */
    const char *where;     /* takes the samples that fulfil this condition; NULL: all. Borrowed */
} profile_line;

typedef struct profile_point {
    double distance; /* along the line, from its beginning */
    stp_dvec3 position;
    uint8_t rgb[3];
} profile_point;

typedef struct profile {
    profile_point *points; /* by distance; equal ones by height */
    size_t count, capacity;
    double width;  /* the one that was used */
    double length; /* of the line */
    bool coloured; /* the model has colours */
} profile;

/* Finds the points. Strips, triangles and samples that stand in for lost points are left out.
 * Errors: EMPTY (no sample is there), INVALID_ARGUMENT (the condition), those of
 * stp_chunk_file_read, CANCELLED, OUT_OF_MEMORY. Free with profile_clear. */
stp_status profile_find(profile *out, stp_chunk_file *file, const profile_line *line,
                        const stp_progress *progress, stp_error *err);
void profile_clear(profile *p);

#endif
