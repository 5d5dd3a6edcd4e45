/* Walks the hierarchy of an octree that is told in pages, and lists the nodes that a region needs.
 *
 * A page tells a node and nodes below it: how many points each one has, or that another page tells
 * it. Pages that the region does not need are not read. A page that tells a foreign node, itself
 * anew, or what another page told, is an error, so the walk ends whatever the pages say. Memory:
 * STP_OCTREE_NODES_MOST nodes. Threads: one at a time per walk. */
#ifndef STP_FORMATS_SCAN_OCTREE_OCTREE_WALK_H
#define STP_FORMATS_SCAN_OCTREE_OCTREE_WALK_H

#include "formats/scan/octree/octree.h"

/* A node, or the page that tells it. */
typedef struct stp_octree_node {
    stp_octree_key key;     /* first, for stp_octree_key_compare */
    uint64_t offset, bytes; /* in the file; 0: a file of its own */
    uint32_t count;         /* points */
} stp_octree_node;

typedef struct stp_octree_list {
    stp_octree_node *nodes;
    size_t count, capacity;
} stp_octree_list;

/* Set octree, region and where; the rest zero. */
typedef struct stp_octree_walk {
    const stp_octree *octree;
    const stp_scan_region *region; /* NULL: all nodes */
    const char *where;             /* for messages; a reader of pages may set it to a page's name */
    stp_octree_list nodes;         /* with points, by key */
    stp_octree_list pages;
    stp_octree_key page; /* that is read now */
    uint64_t points;     /* of all nodes */
} stp_octree_walk;

/* Reads a page: calls stp_octree_walk_add for each of its entries. */
typedef stp_status stp_octree_read_page(void *context, stp_octree_walk *walk,
                                        const stp_octree_node *page, stp_error *err);

/* Walks from the root's page on. Free the walk even after a failure. Errors: CORRUPT, LIMIT,
 * OUT_OF_MEMORY, those of read. */
stp_status stp_octree_walk_run(stp_octree_walk *walk, const stp_octree_node *root,
                               stp_octree_read_page *read, void *context, stp_error *err);
/* Takes an entry of the page that is read now: a node, or another page. Errors: CORRUPT, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_octree_walk_add(stp_octree_walk *walk, const stp_octree_node *node, bool is_page,
                               stp_error *err);
void stp_octree_walk_free(stp_octree_walk *walk);

#endif
