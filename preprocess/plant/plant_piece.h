/* One part of a plant's mesh with its own vertex numbers. Leaves and tubes are looked for in it.
 *
 * Vertices at one position are one vertex. Threads: one at a time. */
#ifndef STP_PREPROCESS_PLANT_PLANT_PIECE_H
#define STP_PREPROCESS_PLANT_PLANT_PIECE_H

#include "formats/scan/mesh/line_set.h"
#include "preprocess/plant/mesh_parts.h"

#include <stdbool.h>

typedef struct stp_plant_vertex {
    stp_dvec3 position;
    stp_dvec3 normal; /* mean of the corners' normals; zero if the mesh has none */
    double rgb[3];    /* mean of the corners' colours; likewise */
    uint32_t corner_count;
} stp_plant_vertex;

typedef struct stp_plant_piece {
    const stp_mesh *mesh;
    const stp_mesh_parts *parts;
    uint32_t triangle_count, vertex_count;
    const uint32_t *triangles; /* their places in the mesh */
    uint32_t (*corners)[3];
    stp_plant_vertex *vertices;
    uint32_t *star_begins; /* vertex_count + 1 places in stars */
    uint32_t *stars;       /* the triangles around each vertex */
    uint32_t *local;       /* by mesh vertex, while a piece is made */
} stp_plant_piece;

/* Makes room for the largest part. Errors: OUT_OF_MEMORY. */
stp_status stp_plant_piece_create(stp_plant_piece *out, const stp_mesh *mesh,
                                  const stp_mesh_parts *parts, stp_error *err);
/* Sets the piece to part number `part`, in time proportional to that part. */
void stp_plant_piece_set(stp_plant_piece *piece, uint32_t part);
void stp_plant_piece_clear(stp_plant_piece *piece);

static inline bool stp_plant_edge_is_open(const stp_plant_piece *piece, uint32_t triangle, int k)
{
    return (piece->parts->open_edges[piece->triangles[triangle]] & 1u << k) != 0;
}

/* A triangle's area vector: half the cross product of two sides. */
stp_dvec3 stp_plant_triangle_area(const stp_plant_piece *piece, uint32_t triangle);

/* A line's vertex with the mean colour of `count` of the piece's vertices. Grey (STP_POINT_GREY) if
 * the mesh has no colours. */
stp_line_vertex stp_plant_line_vertex(const stp_plant_piece *piece, const uint32_t *vertices,
                                      uint32_t count);

#endif
