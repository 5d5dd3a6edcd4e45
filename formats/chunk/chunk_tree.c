/* Numbers chunks breadth first, and gives them their links. */
#include "formats/chunk/chunk_tree.h"

#include "base/memory.h"
#include "formats/chunk/layout.h"

#include <inttypes.h>
#include <stdlib.h>

/* What numbering works on. */
typedef struct numbering {
    const stp_chunk_entry *entries; /* by handle */
    size_t count;
    bool *seen; /* by handle: it has an id */
    stp_chunk_tree *tree;
} numbering;

/* Gives a chunk the next id. */
static stp_status number(numbering *n, uint32_t handle, uint32_t parent, uint8_t depth,
                         stp_error *err)
{
    if (handle >= n->count || n->seen[handle])
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "chunk handle %" PRIu32 " does not exist or has two parents", handle);
    n->seen[handle] = true;
    stp_chunk_entry *entry = &n->tree->entries[n->tree->count];
    *entry = n->entries[handle];
    entry->parent = parent;
    entry->depth = depth;
    n->tree->handle[n->tree->count++] = handle;
    return STP_OK;
}

static stp_status number_children(numbering *n, uint32_t id, const uint32_t *children,
                                  uint32_t child_count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry *parent = &n->tree->entries[id];
    if (child_count > STP_CHUNK_CHILDREN_LIMIT)
        return stp_error_set(err, STP_LIMIT, "a chunk of %" PRIu32 " children: use at most %u",
                             child_count, STP_CHUNK_CHILDREN_LIMIT);
    if (child_count > 0 && parent->depth + 1u >= STP_DEPTH_LIMIT)
        return stp_error_set(err, STP_LIMIT, "a tree of more than %u levels", STP_DEPTH_LIMIT);
    parent->child_count = child_count;
    parent->first_child = child_count > 0 ? n->tree->count : STP_CHUNK_NONE;
    for (uint32_t c = 0; c < child_count; c++)
        STP_TRY(number(n, children[c], id, (uint8_t)(parent->depth + 1u), err));
done:
    return status;
}

stp_status stp_chunk_tree_number(const stp_chunk_entry *entries, size_t count, uint32_t root,
                                 const uint32_t *const *children, const uint32_t *child_counts,
                                 stp_chunk_tree *out, stp_error *err)
{
    stp_status status = STP_OK;
    numbering n = {entries, count, NULL, out};
    STP_TRY(stp_alloc(&n.seen, count, sizeof *n.seen, "directory", err));
    STP_TRY(stp_alloc(&out->handle, count, sizeof *out->handle, "directory", err));
    STP_TRY(stp_alloc(&out->entries, count, sizeof *out->entries, "directory", err));
    STP_TRY(number(&n, root, STP_CHUNK_NONE, 0, err));
    for (uint32_t id = 0; id < out->count; id++) {
        const uint32_t handle = out->handle[id];
        STP_TRY(number_children(&n, id, children[handle], child_counts[handle], err));
    }
    out->depth = out->entries[out->count - 1].depth + 1u;
    if (out->count != count)
        status =
            stp_error_set(err, STP_INVALID_ARGUMENT, "%zu of %zu chunks are not under the root",
                          count - out->count, count);
done:
    free(n.seen);
    return status;
}

void stp_chunk_tree_clear(stp_chunk_tree *tree)
{
    free(tree->handle);
    free(tree->entries);
    *tree = (stp_chunk_tree){0};
}
