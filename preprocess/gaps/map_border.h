/* The borders of trimmed maps: their samples, and the triangles of all cells that touch a border.
 * Threads: one. */
#ifndef STP_PREPROCESS_GAPS_MAP_BORDER_H
#define STP_PREPROCESS_GAPS_MAP_BORDER_H

#include "formats/scan/mesh/mesh.h"
#include "preprocess/maps/map.h"

typedef struct stp_map_vertex {
    uint32_t map, column, row;
    bool on_border; /* else the vertex is only a corner of a triangle that touches the border */
    double size;    /* mean length of the edges of its triangles */
} stp_map_vertex;

typedef struct stp_map_border {
    stp_mesh mesh;            /* positions and normals of the vertices; triangles */
    stp_map_vertex *vertices; /* mesh.vertex_count */
} stp_map_border;

/* Each cell is cut from the next column to the next row, as it is drawn. Errors: OUT_OF_MEMORY,
 * LIMIT (2^32 vertices). Free with stp_map_border_clear. */
stp_status stp_map_border_create(stp_map_border *out, const stp_map *maps, uint32_t count,
                                 stp_error *err);
void stp_map_border_clear(stp_map_border *border);

#endif
