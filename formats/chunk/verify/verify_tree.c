/* Checks tree, sums and extents of payloads from the directory alone. */
#include "formats/chunk/verify/verify_tree.h"

#include "base/memory.h"
#include "formats/chunk/free_ranges.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static stp_status fault(const stp_chunk_file *file, uint32_t id, const char *what, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT, "%s: chunk %" PRIu32 ": %s", stp_chunk_file_path(file),
                         id, what);
}

/* Children follow each other breadth first, name their parent, and add up to its points. */
stp_status stp_verify_tree_entries(const stp_chunk_file *file, const stp_chunk_entry *entries,
                                   stp_error *err)
{
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    uint64_t next = 1;
    uint32_t depth = 0;
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        const stp_chunk_entry *e = &entries[id];
        uint64_t points = 0;
        depth = e->depth + 1u > depth ? e->depth + 1u : depth;
        if (e->child_count == 0)
            continue;
        if (e->first_child != next)
            return fault(file, id, "its first child is not the next in breadth-first order", err);
        next += e->child_count;
        for (uint32_t c = e->first_child; c < next; c++) {
            if (entries[c].parent != id)
                return fault(file, c, "its parent is not the chunk that lists it", err);
            if (entries[c].depth != e->depth + 1u)
                return fault(file, c, "its depth is not its parent's and one", err);
            points += entries[c].points_under;
        }
        if (points != e->points_under)
            return fault(file, id, "its points_under is not the sum of its children's", err);
    }
    if (next != info->chunk_count)
        return fault(file, (uint32_t)next, "it is no chunk's child", err);
    if (depth != info->depth)
        return fault(file, info->chunk_count - 1, "the tree's depth is not the header's", err);
    return STP_OK;
}

typedef struct extent {
    uint64_t begin, end;
    uint32_t id; /* STP_CHUNK_NONE: unused bytes */
} extent;

static int compare_extents(const void *a, const void *b)
{
    const extent *x = a;
    const extent *y = b;
    if (x->begin != y->begin)
        return x->begin < y->begin ? -1 : 1;
    return x->end < y->end ? -1 : x->end > y->end;
}

/* Lists the payloads and the unused bytes, in order. */
static stp_status list_extents(const stp_chunk_file *file, const stp_chunk_entry *entries,
                               extent **out, size_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t chunks = stp_chunk_file_get_info(file)->chunk_count;
    stp_free_range *unused = NULL;
    size_t unused_count = 0;
    STP_TRY(stp_free_ranges_read(file, &unused, &unused_count, err));
    STP_TRY(stp_alloc(out, chunks + unused_count, sizeof **out, "payload extents", err));
    for (uint32_t id = 0; id < chunks; id++) {
        const uint64_t begin = entries[id].offset;
        (*out)[id] = (extent){begin, begin + entries[id].segment_end[STP_SEGMENT_COUNT - 1], id};
    }
    for (size_t i = 0; i < unused_count; i++)
        (*out)[chunks + i] =
            (extent){unused[i].offset, unused[i].offset + unused[i].bytes, STP_CHUNK_NONE};
    *count = chunks + unused_count;
    qsort(*out, *count, sizeof **out, compare_extents);
done:
    free(unused);
    return status;
}

/* Every byte between header and sections belongs to exactly one payload or is listed as unused. */
static stp_status check_extents(const stp_chunk_file *file, const stp_chunk_entry *entries,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    extent *extents = NULL;
    size_t count = 0;
    uint64_t at = info->payloads_begin;
    STP_TRY(list_extents(file, entries, &extents, &count, err));
    for (size_t i = 0; i < count; i++) {
        if (extents[i].begin != at && extents[i].id == STP_CHUNK_NONE) {
            status = stp_error_set(err, STP_CORRUPT,
                                   "%s: unused bytes begin at byte %" PRIu64
                                   ", the payload before them ends at byte %" PRIu64,
                                   stp_chunk_file_path(file), extents[i].begin, at);
            goto done;
        }
        if (extents[i].begin != at) {
            status = stp_error_set(err, STP_CORRUPT,
                                   "%s: chunk %" PRIu32 ": its payload begins at byte %" PRIu64
                                   ", the one before it ends at byte %" PRIu64,
                                   stp_chunk_file_path(file), extents[i].id, extents[i].begin, at);
            goto done;
        }
        at = extents[i].end;
    }
    if (at != info->payloads_end)
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: the payloads end at byte %" PRIu64
                               ", the metadata begins at byte %" PRIu64,
                               stp_chunk_file_path(file), at, info->payloads_end);
done:
    free(extents);
    return status;
}

stp_status stp_verify_tree(stp_chunk_file *file, stp_chunk_entry **entries, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry *all = NULL;
    uint32_t count = stp_chunk_file_get_info(file)->chunk_count;
    STP_TRY(stp_alloc(&all, count, sizeof *all, "directory", err));
    for (uint32_t id = 0; id < count; id++)
        STP_TRY(stp_chunk_file_entry(file, id, &all[id], err));
    STP_TRY(stp_verify_tree_entries(file, all, err));
    STP_TRY(check_extents(file, all, err));
    *entries = all;
    all = NULL;
done:
    free(all);
    return status;
}
