/* Walks the pages of an octree's hierarchy, depth by depth. */
#include "formats/scan/octree/octree_walk.h"

#include "base/memory.h"

#include <stdlib.h>

static stp_status add(stp_octree_list *list, const stp_octree_node *node, const char *where,
                      stp_error *err)
{
    stp_status status = STP_OK;
    if (list->count >= STP_OCTREE_NODES_MOST)
        return stp_error_set(err, STP_LIMIT,
                             "%s: its octree has more than %zu nodes: read a part of it (--bounds, "
                             "--resolution)",
                             where, STP_OCTREE_NODES_MOST);
    STP_TRY(stp_grow(&list->nodes, &list->capacity, list->count + 1, sizeof *list->nodes,
                     "nodes of an octree", err));
    list->nodes[list->count++] = *node;
done:
    return status;
}

stp_status stp_octree_walk_add(stp_octree_walk *walk, const stp_octree_node *node, bool is_page,
                               stp_error *err)
{
    const stp_octree_key k = node->key, p = walk->page;
    const bool itself = is_page && stp_octree_key_compare(&k, &p) == 0;
    if (!stp_octree_key_valid(k) || !stp_octree_key_below(k, p) || itself)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: the part of its hierarchy for node %u-%u-%u-%u %s node "
                             "%u-%u-%u-%u%s: it is damaged; copy or export it again",
                             walk->where, p.depth, p.x, p.y, p.z,
                             itself ? "says that it itself lists" : "lists", k.depth, k.x, k.y, k.z,
                             itself ? "" : ", which does not lie in it");
    if ((!is_page && node->count == 0) || !stp_octree_wants(walk->octree, walk->region, k))
        return STP_OK;
    walk->points += is_page ? 0 : node->count;
    return add(is_page ? &walk->pages : &walk->nodes, node, walk->where, err);
}

/* Sorts nodes from `first` on. No key may be there twice. */
static stp_status sort(const stp_octree_list *list, size_t first, const char *where, stp_error *err)
{
    const size_t count = list->count - first;
    if (count < 2)
        return STP_OK;
    stp_octree_node *nodes = list->nodes + first;
    qsort(nodes, count, sizeof *nodes, stp_octree_key_compare);
    for (size_t i = 1; i < count; i++) {
        const stp_octree_key k = nodes[i].key;
        if (stp_octree_key_compare(&nodes[i - 1], &nodes[i]) == 0)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: its hierarchy lists node %u-%u-%u-%u twice: it is damaged; "
                                 "copy or export it again",
                                 where, k.depth, k.x, k.y, k.z);
    }
    return STP_OK;
}

stp_status stp_octree_walk_run(stp_octree_walk *walk, const stp_octree_node *root,
                               stp_octree_read_page *read, void *context, stp_error *err)
{
    stp_status status = STP_OK;
    const char *where = walk->where;
    unsigned sorted_depth = 0;
    STP_TRY(add(&walk->pages, root, where, err));
    for (size_t i = 0; i < walk->pages.count; i++) {
        /* Pages that a page names are deeper: those of one depth are complete when their turn
         * comes. */
        if (i == 0 || walk->pages.nodes[i].key.depth != sorted_depth)
            STP_TRY(sort(&walk->pages, i, where, err));
        const stp_octree_node page = walk->pages.nodes[i];
        sorted_depth = page.key.depth;
        walk->page = page.key;
        STP_TRY(read(context, walk, &page, err));
        walk->where = where;
    }
    STP_TRY(sort(&walk->nodes, 0, where, err));
done:
    walk->where = where;
    return status;
}

void stp_octree_walk_free(stp_octree_walk *walk)
{
    free(walk->nodes.nodes);
    free(walk->pages.nodes);
    walk->nodes = walk->pages = (stp_octree_list){0};
}
