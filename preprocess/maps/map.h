/* An elevation map: heights over a plane, on a grid, where the plane carries a part of a surface.
 *
 *          o   o--o
 *        o--o--o  |        o: samples; a sample without support is no part of the map
 *       -+--+--+--+-       plane: origin, axes[0] along a row, axes[1] from row to row
 *
 *     world = origin + spacing (column axes[0] + row axes[1]) + height height_step axes[2]
 *
 * Between samples the surface is that of triangles: each square of the grid is cut from its corner
 * (column, row) to (column + 1, row + 1); a square with three supported corners is one triangle. */
#ifndef STP_PREPROCESS_MAPS_MAP_H
#define STP_PREPROCESS_MAPS_MAP_H

#include "base/vec.h"

#include <stddef.h>
#include <stdint.h>

#define STP_MAP_SUPPORTED 1u
#define STP_MAP_ORIENTED 2u /* the side that the normal points to is known */
#define STP_MAP_CLOSED 4u   /* the back of the nearest point is hidden (closed/enclosure.h) */

/* The places of a grid beside each place, by column and row: each pair of neighbours once. The last
 * two lie across a diagonal. */
#define STP_MAP_BESIDE 4
static const int8_t stp_map_beside[STP_MAP_BESIDE][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};

typedef struct stp_map_sample {
    int32_t height; /* in steps, 0 or more */
    uint16_t intensity;
    uint8_t normal[3]; /* of the surface, as a chunk's sample stores it */
    uint8_t rgb[3];
    uint8_t class_id;
    uint8_t flags; /* STP_MAP_* */
} stp_map_sample;

typedef struct stp_map_frame {
    stp_dvec3 origin;  /* world */
    stp_dvec3 axes[3]; /* of columns, rows and heights; unit vectors, right-handed */
    double spacing;    /* between columns and between rows, world units */
    double height_step;
} stp_map_frame;

typedef struct stp_map {
    stp_map_frame frame;
    uint32_t columns, rows;
    stp_map_sample *samples; /* row by row; owned, in a spill or plain memory */
    uint32_t count;          /* of supported samples */
    uint32_t sheet;          /* of its first point (preprocess/orient/sheets.h) */
    bool rough;              /* heights are too rough for normals (map_make.h) */
} stp_map;

static inline const stp_map_sample *stp_map_at(const stp_map *map, uint32_t column, uint32_t row)
{
    return &map->samples[(size_t)row * map->columns + column];
}

/* A place in the map's frame, in world units of length. */
static inline stp_dvec3 stp_map_frame_local(const stp_map_frame *frame, stp_dvec3 world)
{
    const stp_dvec3 d = stp_dvec3_sub(world, frame->origin);
    return (stp_dvec3){stp_dvec3_dot(d, frame->axes[0]), stp_dvec3_dot(d, frame->axes[1]),
                       stp_dvec3_dot(d, frame->axes[2])};
}

static inline stp_dvec3 stp_map_frame_world(const stp_map_frame *frame, stp_dvec3 local)
{
    stp_dvec3 out = stp_dvec3_add(frame->origin, stp_dvec3_scale(frame->axes[0], local.x));
    out = stp_dvec3_add(out, stp_dvec3_scale(frame->axes[1], local.y));
    return stp_dvec3_add(out, stp_dvec3_scale(frame->axes[2], local.z));
}

/* A sample's place in the frame. */
static inline stp_dvec3 stp_map_local(const stp_map *map, uint32_t column, uint32_t row)
{
    return (stp_dvec3){column * map->frame.spacing, row * map->frame.spacing,
                       stp_map_at(map, column, row)->height * map->frame.height_step};
}

/* A sample's place in the world. */
static inline stp_dvec3 stp_map_world(const stp_map *map, uint32_t column, uint32_t row)
{
    return stp_map_frame_world(&map->frame, stp_map_local(map, column, row));
}

#endif
