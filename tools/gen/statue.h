/* The parts of the statue: a winged, hooded guardian with an orb, on an inscribed round plinth.
 *
 * Each part is a colour and an implicit function over a box, negative inside. On its box and
 * beyond, a part is at least statue_margin away. No fillet is that wide, so the part can be left
 * out there; this makes a figure of many parts cheap to evaluate. Units: the figure is about 2
 * high, +y up, facing +z. */
#ifndef STP_TOOLS_GEN_STATUE_H
#define STP_TOOLS_GEN_STATUE_H

#include "tools/gen/implicit.h"
#include "tools/gen/surface.h"

static const float statue_margin = 0.018f;

typedef struct statue_part {
    const char *name;
    gen_dual (*distance)(const gen_dual3 *p);
    vec3s (*colour)(vec3s p);
    vec3s min, max; /* where the part matters */
    float blend;    /* width of the fillet with the parts before it */
} statue_part;

/* In the order of the union. */
#define STATUE_PARTS(X)                                                                            \
    X(plinth)                                                                                      \
    X(robe)                                                                                        \
    X(sash)                                                                                        \
    X(cloak)                                                                                       \
    X(wings)                                                                                       \
    X(halo)                                                                                        \
    X(head)                                                                                        \
    X(hood)                                                                                        \
    X(sleeves)                                                                                     \
    X(orb)                                                                                         \
    X(hands)

#define X(name) extern const statue_part statue_##name;
STATUE_PARTS(X)
#undef X

/* Negative inside; *part (may be NULL) is set to the number of the nearest part. */
gen_dual gen_statue_distance(vec3s p, unsigned *part);

/* A smooth curve through (at, value) knots, constant beyond the ends: piecewise cubic with
 * finite-difference slopes. */
typedef struct statue_knot {
    float at, value;
} statue_knot;
gen_dual statue_profile(const statue_knot *knots, int count, gen_dual at);

/* The distance to the segment from a to b, less a radius that goes from ra to rb. */
gen_dual statue_limb(const gen_dual3 *p, vec3s a, vec3s b, float ra, float rb);
/* Approximates the distance to an ellipsoid. Source: Quilez, "ellipsoid SDF bound". */
gen_dual statue_ellipsoid(const gen_dual3 *p, vec3s centre, vec3s radii);
/* Rounded ridges with sharp creases between, 0..1, period pi: hanging cloth, feathers. sharpness:
 * width of the crease, e.g. 0.1. */
gen_dual statue_pleat(gen_dual phase, float sharpness);

vec3s statue_mix(vec3s a, vec3s b, float t);
vec3s statue_shade(vec3s colour, float factor);
/* Slow random variation in -1..1, for colours. */
float statue_mottle(vec3s p, float frequency);

/* Colours used by several parts. */
extern const vec3s statue_gold, statue_madder, statue_teal, statue_ivory;

#endif
