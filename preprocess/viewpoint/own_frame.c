/* Looks for the rays of a sensor at the origin. */
#include "preprocess/viewpoint/own_frame.h"

#include "base/memory.h"
#include "base/sort.h"

#include <math.h>
#include <stdlib.h>

/* A gap between sorted numbers is wide from this part of the mean gap on. Numbers of a lattice have
 * few wide gaps, but at least so many; of other numbers, nine in ten gaps are wide. */
#define WIDE_GAP 0.1
#define WIDE_MOST 0.1
#define WIDE_LEAST 16u
#define WIDEST_TANGENT 3.0
/* Of a turning scanner. */
#define STEEPEST_SINE 0.866
#define STEEPER_MOST 0.001
#define SECTORS 36
#define SECTORS_LEAST 24
#define NEAR_PART 0.02
#define FARTHER 5.0

#define PI 3.14159265358979323846

/* Looks at the middle four fifths. */
static bool is_lattice(double *numbers, uint32_t count)
{
    uint32_t wide = 0;
    stp_sort_doubles(numbers, count);
    const uint32_t first = count / 10, last = count - 1 - count / 10;
    const double gap = WIDE_GAP * (numbers[last] - numbers[first]) / (last - first + 1.0);
    for (uint32_t i = first; i < last; i++)
        wide += numbers[i + 1] - numbers[i] > gap;
    return wide >= WIDE_LEAST && wide <= WIDE_MOST * (last - first);
}

/* A position's places across the view and along it, if that is along z or along x. */
static stp_dvec3 turned(stp_dvec3 p, bool along_x)
{
    return along_x ? (stp_dvec3){p.y, p.z, p.x} : p;
}

/* Whether all points lie before a camera. */
static bool is_before(const stp_dvec3 *positions, uint32_t count, bool along_x)
{
    for (uint32_t i = 0; i < count; i++) {
        const stp_dvec3 p = turned(positions[i], along_x);
        if (!(p.z * turned(positions[0], along_x).z > 0.0) ||
            fmax(fabs(p.x), fabs(p.y)) > WIDEST_TANGENT * fabs(p.z))
            return false;
    }
    return true;
}

/* Whether x/z and y/z are lattices, and x and y are not both. */
static bool is_camera(const stp_dvec3 *positions, uint32_t count, bool along_x, double *room)
{
    int lattices[2] = {0, 0}; /* of x and y; divided by z */
    if (!is_before(positions, count, along_x))
        return false;
    for (int axis = 0; axis < 2; axis++)
        for (int divided = 0; divided < 2; divided++) {
            for (uint32_t i = 0; i < count; i++) {
                const stp_dvec3 p = turned(positions[i], along_x);
                room[i] = (axis == 0 ? p.x : p.y) / (divided ? p.z : 1.0);
            }
            lattices[divided] += is_lattice(room, count);
        }
    return lattices[1] == 2 && lattices[0] < 2;
}

/* Whether rays go all around, at most this part of them steeply. */
static bool is_around(const stp_dvec3 *positions, uint32_t count, double steeper)
{
    bool any[SECTORS] = {false};
    uint32_t steep = 0;
    int sectors = 0;
    for (uint32_t i = 0; i < count; i++) {
        const stp_dvec3 p = positions[i];
        steep += fabs(p.z) > STEEPEST_SINE * stp_dvec3_length(p);
        any[(int)floor((atan2(p.y, p.x) / (2.0 * PI) + 1.0) * SECTORS) % SECTORS] = true;
    }
    for (int i = 0; i < SECTORS; i++)
        sectors += any[i];
    return steep <= steeper * count && sectors >= SECTORS_LEAST;
}

static bool is_turning(const stp_dvec3 *positions, uint32_t count, double *room)
{
    if (!is_around(positions, count, STEEPER_MOST))
        return false;
    for (uint32_t i = 0; i < count; i++)
        room[i] = stp_dvec3_length(positions[i]);
    stp_sort_doubles(room, count);
    const uint32_t near = (uint32_t)(NEAR_PART * count);
    return room[count - 1 - near] >= FARTHER * room[near];
}

bool stp_own_frame_may_be(const stp_dvec3 *few, uint32_t count)
{
    return is_before(few, count, false) || is_before(few, count, true) ||
           is_around(few, count, 10.0 * STEEPER_MOST);
}

stp_status stp_own_frame_find(stp_own_frame *out, const stp_dvec3 *positions, uint32_t count,
                              stp_error *err)
{
    double *room = NULL;
    *out = STP_OWN_FRAME_NONE;
    if (count == 0)
        return STP_OK;
    const stp_status status = stp_alloc(&room, count, sizeof *room, "numbers", err);
    if (status != STP_OK)
        return status;
    if (is_camera(positions, count, false, room) || is_camera(positions, count, true, room))
        *out = STP_OWN_FRAME_CAMERA;
    else if (is_turning(positions, count, room))
        *out = STP_OWN_FRAME_TURNING;
    free(room);
    return STP_OK;
}
