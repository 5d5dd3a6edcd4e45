/* Makes points of a scan into items of a leaf chunk. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_PATCH_POINT_ITEM_H
#define STP_PREPROCESS_PATCH_POINT_ITEM_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/patch/displacement.h"

typedef struct stp_point_item_params {
    double lambda; /* radius of a sample over its spacing */
    stp_resolution resolution;
    uint16_t intensity_max; /* 255 in the file stands for it, and for what is more */
    int vertex_least;       /* exponent of the finest lattice of patch vertices */
    unsigned normal_bits;   /* of the grid of level-0 normals (normal_grid.h), rounded up */
    unsigned normal_step;   /* of that grid */
    unsigned given_bits;    /* the same of normals that the input gave */
} stp_point_item_params;

/* The exponent of a point's lattice. spacing: the distance to its neighbours. If exact: by the
 * inputs' step, whatever the disc; for floats as fine as patches of some 64 points allow. */
int stp_point_exponent(stp_dvec3 position, double spacing, const stp_point_item_params *params);
/* Whether the lattice is so fine beside the coordinates that only rounding separates the point from
 * its neighbours. */
bool stp_point_is_rounded(stp_dvec3 position, int exponent);

/* The finest lattice on which all points of a chunk with this side fit. */
int stp_point_finest(double side);
/* The point's exponent among the points of its chunk, of which `finest` is told: those that only
 * rounding separates ask for lattices too fine for any chunk's width. */
int stp_point_exponent_lifted(stp_dvec3 position, int exponent, int finest);
/* The spacing that the disc of a point on such a lattice has. */
double stp_point_spacing_on(double spacing, int exponent, const stp_point_item_params *params);

/* Scales an intensity so that a byte covers the range that the scan uses. Scaled by all 16 bits, a
 * scan with 12 bits would keep only 4. greatest: of all points. */
uint8_t stp_point_intensity(uint16_t intensity, uint32_t greatest);

/* What is known of a point. */
typedef struct stp_point_facts {
    stp_dvec3 position;   /* world */
    double spacing;       /* distance to its neighbours, world units */
    bool measured;        /* the spacing is that of the nearest points: noisy. The radius is rounded
                             by STP_RADII_BY_OCTAVE, the position to a patch's sublattice */
    vec3s normal;         /* unit, or zero */
    unsigned normal_step; /* of its grid; 0: its code is known */
    uint8_t normal_code[3];
    uint32_t sheet;
    uint64_t source; /* place in the input */
    uint16_t rgb[3];
    uint8_t intensity, class_id, flags; /* as a sample stores them */
} stp_point_facts;

/* Makes one point an item on a lattice, that of stp_point_exponent. If exact and the disc is too
 * large to have a code on the point's lattice, it gets the largest radius that has one. */
void stp_point_item_set(stp_item *out, const stp_point_facts *facts, int exponent,
                        const stp_point_item_params *params);
/* Makes a point of a cloud an item whose disc has a spacing of its own. */
stp_item stp_point_item_of(const stp_cloud *cloud, uint64_t i, double spacing,
                           const stp_point_item_params *params);
/* Makes a point of a sorted cloud an item on a lattice. */
void stp_point_item_make(stp_item *out, const stp_cloud *cloud, uint64_t i, int exponent,
                         const stp_point_item_params *params);
/* Makes points [begin, end) of a sorted cloud into items of one chunk. */
void stp_point_items_make(stp_item *items, const stp_cloud *cloud, uint64_t begin, uint64_t end,
                          const stp_point_item_params *params);

#endif
