/* The points of a map and those around it in its frame, in the squares of its grid, and the surface
 * through them. The points around are of other maps or of none: with them, maps agree where they
 * meet.
 *
 * The surface is a moving least squares surface by weighted averages (Alexa and Adamson 2004): near
 * a place, points are averaged with weights that fall with their distance, and so are their
 * normals. Over the plane of a map it is a height, in closed form. With p = (x, y, z) a point, g
 * the slope of its tangent plane, E the weighted mean over points, and q a place in the plane:
 *
 *     h(q) = E[z] + E[g] . (q - E[xy]) - cov(g, xy) / 2
 *
 * The first two terms are exact for planes. The third is what averages over a curved surface lie
 * off it, so h is exact for quadrics up to the square of |q - E[xy]|.
 *
 * Weights: (1 - d^2 / R^2)^4 n_z, d the distance in space. R follows the spacing and the noise at
 * the nearest point: 2.1 spacings, 2.9 where the plane of its normal is wide because of noise, 4.2
 * where it is widest (normals.h). Threads: any may read. */
#ifndef STP_PREPROCESS_MAPS_MAP_POINTS_H
#define STP_PREPROCESS_MAPS_MAP_POINTS_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/maps/map.h"

typedef struct stp_map_point {
    float x, y, z;    /* in the frame; the unit is the grid's spacing */
    float gx, gy, nz; /* slopes of the tangent plane; the normal along the map's axis */
    float reach;      /* R of the weights here */
    uint32_t place;   /* in the cloud */
    bool own;         /* of the map */
} stp_map_point;

struct stp_face_tree;

/* Points of a map and around it: places in the cloud. */
typedef struct stp_map_places {
    const uint32_t *own, *around;
    uint32_t own_count, around_count;
    stp_dbox box;                      /* of the points around */
    const struct stp_face_tree *faces; /* of meshes; NULL: there are none */
} stp_map_places;

/* Squares beyond the map's grid in which points are taken. */
#define STP_MAP_MARGIN 5u

/* Least component of a point's normal along the map's axis: slopes stay finite. */
#define STP_MAP_NORMAL_LEAST 0.1f

/* Squares around a grid place in which points are looked for. */
#define STP_MAP_RINGS 4

typedef struct stp_map_points {
    stp_map_point *points; /* square by square, row by row */
    uint32_t *begins;      /* by square: its first point; then the number of points */
    uint32_t *own;         /* by square: number of own points */
    uint32_t count;
    uint32_t columns, rows; /* squares, with the margin */
} stp_map_points;

/* The surface at a place. */
typedef struct stp_map_spot {
    float height; /* in spacings of the grid */
    float gx, gy;
    uint32_t nearest; /* number of the nearest own point */
    float rgb[3], intensity;
} stp_map_spot;

/* Takes points into the squares of the frame's grid. The grid has columns x rows squares, and every
 * own point lies in one. Points around count if they lie in the margin or nearer and face the
 * plane's side. Errors: OUT_OF_MEMORY. */
stp_status stp_map_points_create(stp_map_points *out, const stp_cloud *cloud,
                                 const stp_map_places *places, const stp_map_frame *frame,
                                 uint32_t columns, uint32_t rows, stp_error *err);
void stp_map_points_clear(stp_map_points *points);

/* Number of own points in a square; 0 outside of the grid. */
static inline uint32_t stp_map_points_in(const stp_map_points *p, int64_t column, int64_t row)
{
    const int64_t c = column + STP_MAP_MARGIN, r = row + STP_MAP_MARGIN;
    if (c < 0 || r < 0 || c >= p->columns || r >= p->rows)
        return 0;
    return p->own[(size_t)r * p->columns + (size_t)c];
}

/* Whether an own point lies at this very place of the frame. */
bool stp_map_points_has(const stp_map_points *p, stp_dvec3 local, const stp_map_frame *frame);

/* Finds the surface over a grid place. Returns false if no own point is within STP_MAP_RINGS
 * squares, or if no point is within the reach of weights, in space: where a surface is steep or
 * ends, its tangent planes soon lead away from it.
 */
bool stp_map_points_spot(const stp_map_points *p, const stp_cloud *cloud, uint32_t column,
                         uint32_t row, stp_map_spot *out);

#endif
