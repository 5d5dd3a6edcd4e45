/* Measures how far stored points are from the points that were read, in double, on the quantised
 * samples of level 0, when a leaf chunk is built. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_PATCH_DISPLACEMENT_H
#define STP_PREPROCESS_PATCH_DISPLACEMENT_H

#include "preprocess/patch/item.h"

#include <stdbool.h>

/* The resolution of the inputs. Displacements are compared with it. */
typedef struct stp_resolution {
    double step;      /* of the inputs' coordinates; 0: they have none */
    double precision; /* as asked for, or half the step; 0: 1/32 of the local spacing */
    bool exact;       /* every stored position must round to the number that was read */
    bool floats;      /* some inputs have no step: their numbers are floats or doubles */
} stp_resolution;

typedef struct stp_displacement {
    uint64_t points;
    double greatest, sum; /* scan's units */
    uint64_t beyond;      /* points displaced by more than the inputs resolve */
    uint64_t changed;     /* points that do not round to the numbers that were read */
} stp_displacement;

/* Adds an item's stored sample, in world coordinates. */
void stp_displacement_add(stp_displacement *d, const stp_item *item, stp_dvec3 stored,
                          const stp_resolution *resolution);
void stp_displacement_join(stp_displacement *d, const stp_displacement *other);
/* The mean displacement; 0 for no points. */
double stp_displacement_mean(const stp_displacement *d);

#endif
