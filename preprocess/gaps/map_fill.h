/* Fills what is left between trimmed maps with triangles, so that the maps' cells and these
 * triangles are one mesh (Ochotta and Hiller 2006 join border vertices to the nearest border edges
 * of other maps likewise).
 *
 *      o--o--o---o           o: samples of two maps.
 *      |  |  |\ / \          The triangles between are filled in. Each begins at an edge that has
 *      o--o--o---o \         one triangle; its third corner is the border sample that sees this
 *      |  |  |\ /   o        edge at the greatest angle, so in a plane the triangles are those of
 *      o--o--o-o-- /         a constrained Delaunay triangulation. No triangle lies over another
 *               \_/          one, of the maps or of the filling.
 *
 * Triangles as wide as the borders' samples come first, wider ones later. Small loops of edges that
 * remain are closed by the triangulation of least area. Holes wider than that stay open.
 *
 * Threads: one. */
#ifndef STP_PREPROCESS_GAPS_MAP_FILL_H
#define STP_PREPROCESS_GAPS_MAP_FILL_H

#include "preprocess/gaps/map_border.h"

typedef struct stp_map_fill {
    stp_map_border border;    /* its vertices are the corners of the triangles */
    uint32_t (*triangles)[3]; /* counterclockwise, seen from where the maps look */
    uint32_t count;
    uint64_t open_edges; /* edges of cells and triangles that have one triangle */
} stp_map_fill;

/* Fills the gaps between maps that stp_maps_trim made disjoint. Errors: OUT_OF_MEMORY, LIMIT. Free
 * with stp_map_fill_clear. */
stp_status stp_map_fill_create(stp_map_fill *out, const stp_map *maps, uint32_t count,
                               stp_error *err);
void stp_map_fill_clear(stp_map_fill *fill);

#endif
