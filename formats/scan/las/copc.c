/* Finds the chunks of a COPC file that a region needs. */
#include "formats/scan/las/copc.h"

#include "formats/scan/las/las_bytes.h"
#include "formats/scan/octree/octree_walk.h"

#include <math.h>
#include <stdlib.h>

/* The record "copc" 1: f64 centre x, y, z, half of the root's side, root's spacing; u64 place and
 * bytes of the first page; the rest is not needed. */
#define INFO_BYTES 160u
enum { AT_CENTRE = 0, AT_HALF = 24, AT_SPACING = 32, AT_ROOT = 40, AT_ROOT_BYTES = 48 };
/* An entry of a page: i32 depth, x, y, z; u64 place; i32 bytes; i32 points, -1: of a page. */
#define ENTRY_BYTES 32u
enum { AT_PLACE = 16, AT_BYTES = 24, AT_POINTS = 28 };

typedef struct pages {
    stp_source *source;
    const stp_las_header *header;
} pages;

static stp_status read_info(stp_octree *octree, stp_octree_node *root, const stp_las_header *header,
                            const stp_las_record *record, const char *path, stp_error *err)
{
    const unsigned char *b = record->bytes;
    if (record->length < INFO_BYTES)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: its COPC record has %zu bytes, expected %u: the file is damaged; "
                             "copy or export it again",
                             path, record->length, INFO_BYTES);
    const double half = stp_las_double(b + AT_HALF), spacing = stp_las_double(b + AT_SPACING);
    bool good = half > 0.0 && isfinite(half) && spacing > 0.0 && isfinite(spacing);
    octree->spacing = spacing;
    octree->slack = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        const double centre = stp_las_double(b + AT_CENTRE + 8 * axis);
        good = good && isfinite(centre - half) && isfinite(centre + half);
        octree->min[axis] = centre - half;
        octree->size[axis] = 2.0 * half;
        octree->slack = fmax(octree->slack, fabs(header->scale[axis]));
    }
    if (!good)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: its COPC record says that the octree has half a side of %g and a "
                             "spacing of %g around (%g, %g, %g): the file is damaged; copy or "
                             "export it again",
                             path, half, spacing, stp_las_double(b), stp_las_double(b + 8),
                             stp_las_double(b + 16));
    *root = (stp_octree_node){.offset = stp_las_u64(b + AT_ROOT),
                              .bytes = stp_las_u64(b + AT_ROOT_BYTES)};
    return STP_OK;
}

double stp_copc_spacing(const stp_las_records *records)
{
    const stp_las_record *record = &records->kept[STP_LAS_COPC];
    const double spacing =
        record->length >= INFO_BYTES ? stp_las_double(record->bytes + AT_SPACING) : 0.0;
    return spacing > 0.0 && isfinite(spacing) ? spacing : 0.0;
}

static stp_status outside(const pages *p, const char *what, const stp_octree_node *node,
                          stp_error *err)
{
    const stp_octree_key k = node->key;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: %s for node %u-%u-%u-%u should have %llu bytes at byte %llu, where "
                         "the file (%llu bytes) has none: it was cut or damaged; copy or export "
                         "it again",
                         p->source->path, what, k.depth, k.x, k.y, k.z,
                         (unsigned long long)node->bytes, (unsigned long long)node->offset,
                         (unsigned long long)p->source->size);
}

static bool lies_inside(const pages *p, const stp_octree_node *node, uint64_t least)
{
    const uint64_t size = p->source->size;
    return node->bytes >= least && node->offset >= p->header->header_bytes &&
           node->offset <= size && node->bytes <= size - node->offset;
}

static stp_status take_entry(const pages *p, stp_octree_walk *walk, const unsigned char *b,
                             stp_error *err)
{
    const int32_t bytes = (int32_t)stp_las_u32(b + AT_BYTES);
    const int32_t points = (int32_t)stp_las_u32(b + AT_POINTS);
    const stp_octree_node node = {
        .key = {stp_las_u32(b), stp_las_u32(b + 4), stp_las_u32(b + 8), stp_las_u32(b + 12)},
        .offset = stp_las_u64(b + AT_PLACE),
        .bytes = bytes > 0 ? (uint64_t)bytes : 0,
        .count = points > 0 ? (uint32_t)points : 0};
    if (points < -1 || bytes < 0)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: its hierarchy says that node %u-%u-%u-%u has %d points in %d "
                             "bytes: it is damaged; copy or export it again",
                             p->source->path, node.key.depth, node.key.x, node.key.y, node.key.z,
                             points, bytes);
    if (points > 0 &&
        (!lies_inside(p, &node, p->header->record_bytes) || node.offset < p->header->point_offset))
        return outside(p, "the points", &node, err);
    return stp_octree_walk_add(walk, &node, points == -1, err);
}

static stp_status read_page(void *context, stp_octree_walk *walk, const stp_octree_node *page,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const pages *p = context;
    if (!lies_inside(p, page, ENTRY_BYTES) || page->bytes % ENTRY_BYTES != 0)
        return outside(p, "a page of the hierarchy", page, err);
    stp_source_seek(p->source, page->offset, 0);
    for (uint64_t i = 0; i < page->bytes / ENTRY_BYTES; i++) {
        const unsigned char *bytes;
        size_t available;
        STP_TRY(stp_source_peek(p->source, ENTRY_BYTES, &bytes, &available, err));
        if (available < ENTRY_BYTES)
            return outside(p, "a page of the hierarchy", page, err);
        STP_TRY(take_entry(p, walk, bytes, err));
        stp_source_consume(p->source, ENTRY_BYTES);
    }
done:
    return status;
}

static int compare_places(const void *a, const void *b)
{
    const stp_octree_node *x = a, *y = b;
    return (x->offset > y->offset) - (x->offset < y->offset);
}

/* Turns nodes, sorted by their place in the file, into chunks. */
static stp_status list_chunks(stp_laz_chunks *out, const stp_octree_list *nodes, const char *path,
                              stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t first = 0, end = 0;
    for (size_t i = 0; i < nodes->count; i++) {
        const stp_octree_node *n = &nodes->nodes[i];
        if (n->offset < end)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: byte %llu: two nodes of its hierarchy have the same points: "
                                 "the file is damaged; copy or export it again",
                                 path, (unsigned long long)n->offset);
        end = n->offset + n->bytes;
        STP_TRY(stp_laz_chunks_add(out, n->offset, first, err));
        out->list[i].end = end;
        first += n->count;
    }
    STP_TRY(stp_laz_chunks_add(out, end, first, err));
    out->complete = true;
    out->end = end;
done:
    return status;
}

stp_status stp_copc_choose(stp_laz_chunks *out, uint64_t *point_count, const stp_las_header *header,
                           const stp_las_records *records, const stp_scan_region *region,
                           stp_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    stp_octree octree;
    stp_octree_node root;
    pages p = {source, header};
    stp_octree_walk walk = {.octree = &octree, .region = region, .where = source->path};
    STP_TRY(read_info(&octree, &root, header, &records->kept[STP_LAS_COPC], source->path, err));
    STP_TRY(stp_octree_walk_run(&walk, &root, read_page, &p, err));
    if (walk.nodes.count > 0)
        qsort(walk.nodes.nodes, walk.nodes.count, sizeof *walk.nodes.nodes, compare_places);
    STP_TRY(list_chunks(out, &walk.nodes, source->path, err));
    *point_count = walk.points;
done:
    stp_octree_walk_free(&walk);
    return status;
}
