/* Halves sets of opening voxels until the balls around them are small. */
#include "preprocess/closed/openings.h"

#include "base/memory.h"

#include <stdlib.h>

/* With more opening voxels than this the surface is a sieve. */
#define VOXELS_LIMIT 16384u
/* Voxels. A larger opening is covered by several balls. */
#define RADIUS_MOST 6.0
/* Voxels. From a voxel's centre to its corners and to the next voxel, through whose face the path
 * goes. */
#define VOXEL_REACH 1.5

typedef struct run {
    int (*voxels)[3];
    size_t count;
} run;

static stp_opening ball_of(const run *r, int *longest)
{
    int low[3], high[3];
    double squared = 0.0, middle[3];
    for (int i = 0; i < 3; i++) {
        low[i] = high[i] = r->voxels[0][i];
        for (size_t v = 1; v < r->count; v++) {
            low[i] = r->voxels[v][i] < low[i] ? r->voxels[v][i] : low[i];
            high[i] = r->voxels[v][i] > high[i] ? r->voxels[v][i] : high[i];
        }
        middle[i] = 0.5 * (low[i] + high[i]) + 0.5;
    }
    *longest = 0;
    for (int i = 1; i < 3; i++)
        if (high[i] - low[i] > high[*longest] - low[*longest])
            *longest = i;
    for (size_t v = 0; v < r->count; v++) {
        double sum = 0.0;
        for (int i = 0; i < 3; i++) {
            double d = r->voxels[v][i] + 0.5 - middle[i];
            sum += d * d;
        }
        squared = stp_max(squared, sum);
    }
    return (stp_opening){{middle[0], middle[1], middle[2]}, sqrt(squared) + VOXEL_REACH};
}

/* Moves the voxels below the middle of an axis to the front. Returns their number. */
static size_t part(const run *r, int axis, double middle)
{
    size_t front = 0;
    for (size_t v = 0; v < r->count; v++) {
        if (r->voxels[v][axis] + 0.5 >= middle)
            continue;
        for (int i = 0; i < 3; i++) {
            int held = r->voxels[front][i];
            r->voxels[front][i] = r->voxels[v][i];
            r->voxels[v][i] = held;
        }
        front++;
    }
    return front;
}

stp_status stp_openings_find(const stp_voxel_grid *grid, stp_opening out[STP_OPENINGS_LIMIT],
                             size_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    int(*voxels)[3] = NULL;
    run runs[STP_OPENINGS_LIMIT];
    size_t run_count = 0;
    *count = STP_OPENINGS_LIMIT + 1;
    STP_TRY(stp_alloc(&voxels, VOXELS_LIMIT, sizeof *voxels, "openings", err));
    size_t found = stp_voxel_grid_openings(grid, &voxels[0][0], VOXELS_LIMIT);
    if (found > VOXELS_LIMIT)
        goto done;
    if (found > 0)
        runs[run_count++] = (run){voxels, found};
    for (size_t i = 0; i < run_count;) {
        int longest = 0;
        stp_opening ball = ball_of(&runs[i], &longest);
        out[i] = ball;
        if (ball.radius <= RADIUS_MOST || runs[i].count == 1) {
            i++;
            continue;
        }
        if (run_count == STP_OPENINGS_LIMIT)
            goto done;
        const double middle[3] = {ball.centre.x, ball.centre.y, ball.centre.z};
        size_t front = part(&runs[i], longest, middle[longest]);
        runs[run_count++] = (run){runs[i].voxels + front, runs[i].count - front};
        runs[i].count = front;
    }
    *count = run_count;
done:
    free(voxels);
    return status;
}
