/* The edges between filled and unfilled surface, while gaps between maps are filled. An edge from a
 * to b is directed: its triangle lies on its left. An edge is wanted if only the triangle on its
 * right is there. Threads: one. */
#ifndef STP_PREPROCESS_GAPS_FILL_FRONT_H
#define STP_PREPROCESS_GAPS_FILL_FRONT_H

#include "preprocess/gaps/map_fill.h"

#define STP_FILL_NONE UINT32_MAX

typedef struct stp_fill_edge {
    uint32_t from, to;
} stp_fill_edge;

typedef struct stp_fill_front {
    stp_map_fill *fill; /* borrowed */
    size_t capacity;    /* of its triangles */
    uint64_t *edges;    /* a hash table of edges that have triangles; 0: a free place */
    size_t edge_mask, edge_count;
    uint32_t *first; /* by vertex: its first corner of a filled triangle, 3 triangle + k; or NONE */
    uint32_t *next;  /* by corner: the vertex's next one */
    size_t next_capacity;
    uint32_t *wanted;     /* by vertex: how many wanted edges leave it */
    stp_fill_edge *queue; /* edges that became wanted, in order; some are no longer */
    size_t queued, queue_capacity;
} stp_fill_front;

/* Takes the edges of the border's triangles. Errors: OUT_OF_MEMORY. Free with
 * stp_fill_front_clear. */
stp_status stp_fill_front_create(stp_fill_front *out, stp_map_fill *fill, stp_error *err);
void stp_fill_front_clear(stp_fill_front *front);

bool stp_fill_has_edge(const stp_fill_front *front, uint32_t from, uint32_t to);
bool stp_fill_wants(const stp_fill_front *front, uint32_t from, uint32_t to);
/* Whether a triangle would give no edge a second triangle on one side. */
bool stp_fill_may_add(const stp_fill_front *front, uint32_t a, uint32_t b, uint32_t c);
/* Adds a triangle that may be added. Errors: OUT_OF_MEMORY, LIMIT (2^30 triangles). */
stp_status stp_fill_add(stp_fill_front *front, uint32_t a, uint32_t b, uint32_t c, stp_error *err);

#endif
