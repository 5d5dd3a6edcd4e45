/* The nearest disc of several points at once: the centre and rim of a merged disc over the discs
 * under it; and the nearest of several discs to one point.
 *
 * Points, or discs, lie in lanes of floats, relative to an origin and a unit, so that the compiler
 * takes four or more a step: ten times faster than one by one. The choice is as exact as floats
 * are; whoever wants the distance computes it of the disc chosen. Threads: any. */
#ifndef STP_FORMATS_CHUNK_DISC_LANES_H
#define STP_FORMATS_CHUNK_DISC_LANES_H

#include "base/error.h"
#include "base/vec.h"

#include <stdint.h>

/* Room for 17 points, in whole steps of four. */
#define STP_DISC_LANES 20

typedef struct stp_disc_lanes {
    float x[STP_DISC_LANES], y[STP_DISC_LANES], z[STP_DISC_LANES];
    float squared[STP_DISC_LANES]; /* distance from the nearest disc so far */
    uint32_t nearest[STP_DISC_LANES];
    stp_dvec3 origin;
    double scale; /* lanes a unit of length */
} stp_disc_lanes;

/* count points (1 to STP_DISC_LANES) near origin, some units (> 0, else 1) about it; `first` is the
 * index of every point until a disc is tried. */
void stp_disc_lanes_begin(stp_disc_lanes *out, const stp_dvec3 *points, unsigned count,
                          stp_dvec3 origin, double unit, uint32_t first);

/* Takes the disc where it is nearer. A zero normal makes it a ball. */
void stp_disc_lanes_try(stp_disc_lanes *lanes, stp_dvec3 centre, stp_dvec3 normal, double radius,
                        uint32_t index);

/* Discs as columns: centre x y z, normal x y z, radius. A zero normal makes a ball. */
#define STP_DISC_COLUMNS 7
typedef struct stp_disc_columns {
    float *of[STP_DISC_COLUMNS];
} stp_disc_columns;

/* Room for count discs, and what a last step reads behind them. Errors: OUT_OF_MEMORY. */
stp_status stp_disc_columns_create(stp_disc_columns *out, uint32_t count, stp_error *err);
void stp_disc_columns_clear(stp_disc_columns *columns);

/* The nearest of the discs [begin, begin + count) to a point, if its squared distance is less than
 * *squared, which it then becomes; else UINT32_MAX. */
uint32_t stp_disc_columns_nearest(const stp_disc_columns *columns, uint32_t begin, uint32_t count,
                                  const float point[3], float *squared);

#endif
