/* Computes the i-th point of a scan of a surface as a function of i, so that memory does not grow
 * with the count.
 *
 * One curve threads the proxy's triangles: they are sorted along a Hilbert curve, and Sierpinski's
 * triangle curve fills each of them. Equal lengths of the curve are equal areas, and neighbours on
 * the curve are neighbours in space. The curve is cut into as many equal pieces as there are
 * points. Each piece gets one point, jittered about its middle. So the density is even, without
 * clumps and without a grid, like a scanner's. Scan order is the order of the curve. Random order
 * visits the pieces by a keyed permutation (a Feistel network, cycle-walked). Noise is Gaussian
 * along the true normal.
 *
 * With stations, only what some station sees is sampled, and each point names its station; see
 * visibility.h. Threads: filling is const, any number. */
#ifndef STP_TOOLS_GEN_SAMPLER_H
#define STP_TOOLS_GEN_SAMPLER_H

#include "formats/scan/scan.h"
#include "tools/gen/surface.h"

typedef struct gen_sampler gen_sampler;

typedef struct gen_sampler_params {
    const gen_surface *surface; /* borrowed for the sampler's life */
    uint64_t point_count;       /* at least 1 */
    uint64_t seed;
    uint64_t station_count; /* 0: everything is seen; at most GEN_STATION_LIMIT */
    double noise_spacings;  /* standard deviation over the spacing */
    bool random_order;
} gen_sampler_params;

/* Builds the proxy mesh with the pool. Errors: OUT_OF_MEMORY, INVALID_ARGUMENT, EMPTY (no station
 * sees anything). */
stp_status gen_sampler_create(gen_sampler **out, const gen_sampler_params *params, stp_pool *pool,
                              stp_error *err);
void gen_sampler_destroy(gen_sampler **sampler);
/* sqrt(area / count). The area is the whole surface's, or of what the stations see. */
double gen_sampler_spacing(const gen_sampler *sampler);
/* The station_count stations. */
const stp_dvec3 *gen_sampler_stations(const gen_sampler *sampler);

/* Fills points first .. first + count - 1 of point_count. truth (may be NULL) gets the points
 * without noise. */
void gen_sampler_fill(const gen_sampler *sampler, uint64_t first, size_t count, stp_point *points,
                      gen_hit *truth);

#endif
