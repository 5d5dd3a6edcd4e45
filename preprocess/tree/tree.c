/* The chunk tree: leaf chunks from cells, lines and triangles, and parents from their children's
 * patch vertices. */
#include "preprocess/tree/tree.h"

#include "base/memory.h"
#include "formats/chunk/block/block_table.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/patch/world_lattice.h"
#include "preprocess/tree/cell_cut.h"
#include "preprocess/tree/leaf_order.h"
#include "preprocess/tree/point_leaf.h"
#include "preprocess/tree/tier_file.h"
#include "preprocess/tree/tier_numbers.h"

#include <limits.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Chunks that are encoded before they are written, or exchanged at once. Limits memory. */
#define CHUNKS_AHEAD 32u

/* If a tier has as many chunks as the tier below, it must have at most 1 / LEAST_MERGE of its
 * patches. */
#define LEAST_MERGE 2u

/* A written chunk, as its parent needs it. */
typedef struct node {
    stp_item *vertices;
    uint32_t vertex_count;
    uint32_t *run_ends;
    uint32_t run_count;
    uint32_t handle;
    uint64_t points_under;
} node;

/* Which nodes become one chunk of the next tier. */
typedef struct span {
    uint32_t begin, end;
} span;

typedef stp_tier_chunk built;

typedef struct tree {
    stp_chunk_writer *writer; /* of rank 0; else NULL */
    stp_tier_file file;       /* of several ranks */
    stp_cloud *cloud;
    const stp_tree_params *params;
    stp_point_item_params items;
    stp_pool *pool;
    const stp_progress *progress;
    stp_leaf_place *leaves; /* in order */
    uint32_t leaf_count;
    bool whole_grid; /* the leaves are those of one that lacks no sample */
    uint64_t progress_total;
    atomic_size_t progress_done; /* leaves built and leaves finished */

    node *below; /* nodes of the tier below; NULL while leaves are made */
    node *nodes; /* of the tier: written chunks */
    span *spans;
    uint32_t span_count;
    built *tier; /* all chunks of the tier, in order; each is measured with those around it */
    stp_chunk_boxes reaches; /* of the tier's chunks: boxes of their patches' bounds, world */
    uint32_t tier_count, wave_begin; /* wave: chunks that are built at once */
    stp_rank_part own; /* chunks of the tier that this rank builds, measures and encodes */

    uint32_t **children; /* by handle */
    uint32_t *child_counts;
    size_t children_capacity, child_counts_capacity;
    stp_chunk_numbers *numbers; /* by handle */
    size_t numbers_capacity;
    stp_dbox box; /* of all samples as stored */
    stp_tree_stats stats;
} tree;

static stp_status build_leaf(const tree *t, stp_leaf_place leaf, built *out, stp_error *err)
{
    stp_status status = STP_OK;
    const uint16_t intensity_max = t->params->intensity_max;
    const stp_leaf_sources *from = &t->params->sources;
    if (leaf.kind == STP_LEAF_LINES)
        STP_TRY(stp_line_leaf_build(from->lines, leaf.index, intensity_max, &out->chunk, err));
    else if (leaf.kind == STP_LEAF_TRIANGLES)
        STP_TRY(
            stp_triangle_leaf_build(from->triangles, leaf.index, intensity_max, &out->chunk, err));
    else if (leaf.kind == STP_LEAF_MAPS)
        STP_TRY(stp_map_leaf_build(from->maps, leaf.index, &t->items, &out->chunk, err));
    else if (leaf.kind == STP_LEAF_DEPTHS)
        STP_TRY(stp_depth_leaf_build(from->depths, leaf.index, &t->items, &out->chunk, err));
    else if (leaf.kind == STP_LEAF_TILE)
        STP_TRY(stp_height_grid_leaf(from->grid, leaf.index, &t->items, &out->chunk, err));
    else /* of images of depth cameras, a cell has those points alone that are in no image */
        STP_TRY(stp_point_leaf_build(&out->chunk, t->cloud, &t->cloud->cells[leaf.index],
                                     from->depths ? from->depths->loose : NULL, &t->items, err));
    const stp_chunk *chunk = out->chunk.chunk;
    out->entry.points_under = chunk->level_begin[0][chunk->patch_count];
    /* quantisation moves points a little: the file's box holds them as stored */
    stp_chunk_box(chunk, out->chunk.origin, &out->box);
done:
    return status;
}

static stp_status build_inner(const tree *t, span children, built *out, stp_error *err)
{
    stp_item_group groups[STP_CHUNK_CHILDREN_LIMIT];
    const stp_holes *holes = stp_leaf_sources_holes(&t->params->sources);
    for (uint32_t i = children.begin; i < children.end; i++) {
        const node *child = &t->below[i];
        groups[i - children.begin] = (stp_item_group){.items = child->vertices,
                                                      .holes = holes,
                                                      .regular = t->whole_grid,
                                                      .count = child->vertex_count,
                                                      .run_ends = child->run_ends,
                                                      .run_count = child->run_count};
        out->entry.points_under += t->below[i].points_under;
    }
    return stp_chunk_build_inner(&out->chunk, groups, children.end - children.begin, err);
}

static stp_status advance(tree *t, stp_error *err)
{
    size_t done = t->below ? t->progress_total : atomic_fetch_add(&t->progress_done, 1) + 1;
    return stp_progress_update(t->progress, "patches", done, t->progress_total, err);
}

static stp_status build_any(const tree *t, uint32_t index, built *out, stp_error *err)
{
    *out = (built){.box = stp_dbox_empty()};
    return t->below ? build_inner(t, t->spans[index], out, err)
                    : build_leaf(t, t->leaves[index], out, err);
}

/* Nobody needs the points of a leaf that is built; stp_cloud_let_go forgets those of others. */
static void forget_cell(stp_cloud *cloud, const stp_cell *cell)
{
    const stp_rank_part own = stp_cloud_own(cloud);
    if (cell->begin >= own.begin && cell->begin < own.end)
        stp_cloud_forget(cloud, cell);
}

static stp_status build_one(void *context, size_t place, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    tree *t = context;
    const uint32_t index = t->wave_begin + (uint32_t)place;
    built *out = &t->tier[index];
    (void)worker;
    STP_TRY(build_any(t, index, out, err));
    if (!t->params->numbers.list)
        stp_tier_chunk_forget_sources(out);
    stp_placed_chunk placed = stp_built_chunk_place(&out->chunk);
    t->reaches.boxes[index] = stp_placed_chunk_box(&placed);
    STP_TRY(stp_built_chunk_stow(&out->chunk, t->cloud->spill, err));
    if (!t->below && t->leaves[index].kind == STP_LEAF_CELL && !t->params->sources.depths)
        forget_cell(t->cloud, &t->cloud->cells[t->leaves[index].index]);
    STP_TRY(advance(t, err));
done:
    return status;
}

static stp_status add_surrounding(void *context, uint32_t index, stp_surroundings *out,
                                  stp_error *err)
{
    const tree *t = context;
    const stp_placed_chunk other = stp_built_chunk_place(&t->tier[index].chunk);
    /* of other ranks only chunks with patches in reach are here */
    return other.chunk ? stp_surroundings_add(out, &other, err) : STP_OK;
}

static stp_codec codec_of(const tree *t, const stp_chunk *chunk)
{
    const stp_map_leaves *leaves = t->params->sources.maps;
    const bool is_map = leaves && chunk->raster_count > 0;
    return is_map && leaves->maps->paper ? STP_CODEC_PAPER : t->params->codec;
}

/* Measures and encodes a chunk. */
static stp_status finish_one(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    tree *t = context;
    const uint32_t self = (uint32_t)(t->own.begin + index);
    built *out = &t->tier[self];
    const stp_placed_chunk middle = stp_built_chunk_place(&out->chunk);
    const stp_surrounding_chunks others = {&t->reaches, add_surrounding, t};
    const bool alone = t->tier_count == 1; /* no task: see finish_tier */
    stp_surroundings around = {0};
    (void)worker;
    stp_spill_relieve(t->cloud->spill);
    STP_TRY(stp_surroundings_find(&around, &middle, self, &others, err));
    STP_TRY(stp_built_chunk_measure(&out->chunk, &around, alone ? t->pool : NULL, err));
    const stp_codec codec = codec_of(t, out->chunk.chunk);
    if (stp_codec_has_blocks(codec) && t->tier_count > 1) /* the root has no parent */
        STP_TRY(stp_built_chunk_cut(&out->chunk, codec, err));
    STP_TRY(stp_chunk_encode(out->chunk.chunk, codec, &out->payload, &out->entry, err));
    STP_TRY(stp_block_records_of(out->chunk.chunk, out->payload, &out->entry, &out->records, err));
    out->entry.origin = out->chunk.origin;
    STP_TRY(advance(t, err));
done:
    stp_surroundings_clear(&around);
    return status;
}

static void clear_tier(tree *t)
{
    for (uint32_t i = 0; t->tier && i < t->tier_count; i++)
        stp_tier_chunk_clear(&t->tier[i], t->cloud->spill);
    free(t->tier);
    t->tier = NULL;
    stp_chunk_boxes_clear(&t->reaches);
}

/* Appends a finished chunk, on rank 0, and keeps its vertices as a node. */
static stp_status write_one(tree *t, uint32_t index, stp_error *err)
{
    stp_status status = STP_OK;
    built *b = &t->tier[index];
    const span children = t->below ? t->spans[index] : (span){0, 0};
    uint32_t handle = t->stats.chunk_count;
    if (t->writer)
        STP_TRY(stp_chunk_writer_append_made(t->writer, b->payload, &b->records, &b->entry, &handle,
                                             err));
    STP_TRY(stp_grow(&t->children, &t->children_capacity, (size_t)handle + 1, sizeof *t->children,
                     "chunks", err));
    STP_TRY(stp_grow(&t->child_counts, &t->child_counts_capacity, (size_t)handle + 1,
                     sizeof *t->child_counts, "chunks", err));
    STP_TRY(stp_grow(&t->numbers, &t->numbers_capacity, (size_t)handle + 1, sizeof *t->numbers,
                     "chunks", err));
    t->numbers[handle] = b->numbers;
    b->numbers = (stp_chunk_numbers){0};
    t->children[handle] = NULL;
    t->child_counts[handle] = 0;
    t->stats.chunk_count = handle + 1;
    t->stats.patch_count += b->entry.patch_count;
    if (!t->below) {
        stp_dbox_join(&t->box, &b->box);
        stp_displacement_join(&t->stats.displacement, &b->chunk.displacement);
    }
    if (t->below) {
        uint32_t count = children.end - children.begin;
        STP_TRY(stp_alloc(&t->children[handle], count, sizeof(uint32_t), "chunks", err));
        t->child_counts[handle] = count;
        for (uint32_t i = 0; i < count; i++)
            t->children[handle][i] = t->below[children.begin + i].handle;
    }
    t->nodes[index] = (node){.vertices = b->chunk.vertices,
                             .vertex_count = b->chunk.vertex_count,
                             .run_ends = b->chunk.run_ends,
                             .run_count = b->chunk.run_count,
                             .handle = handle,
                             .points_under = b->entry.points_under};
    b->chunk.vertices = NULL;
    b->chunk.run_ends = NULL;
    stp_spill_free(t->cloud->spill, b->payload);
    b->payload = NULL;
    free(b->records.data);
    b->records = (stp_bytes){0};
done:
    return status;
}

/* Gives some own chunks, from `first` on, to ranks that measure theirs against them. */
static stp_status give_around(tree *t, uint32_t first, stp_bytes *out, stp_bytes *in, size_t *sent,
                              size_t *received, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = t->params->ranks;
    out->size = 0;
    for (unsigned rank = 0; rank < ranks->count; rank++) {
        const stp_rank_part part = stp_ranks_part(ranks, rank, t->tier_count);
        const size_t before = out->size;
        for (uint32_t i = first; i < t->own.end && i < first + CHUNKS_AHEAD; i++)
            if (rank != ranks->self)
                STP_TRY(stp_tier_chunk_pack_around(out, &t->tier[i], i, &t->reaches, part, err));
        sent[rank] = out->size - before;
    }
    stp_spill_relieve(t->cloud->spill);
    STP_TRY(stp_ranks_exchange_bytes(ranks, out->data, sent, in, received, err));
    for (stp_cursor from = {in->data, in->size}; from.left > 0;)
        STP_TRY(stp_tier_chunk_take_around(t->tier, &from, t->cloud->spill, err));
done:
    return status;
}

/* Gives chunks to all ranks whose chunks they reach into. */
static stp_status share_around(tree *t, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes out = {0}, in = {0};
    size_t *sizes = NULL;
    const unsigned count = stp_ranks_count(t->params->ranks);
    const uint32_t most = t->tier_count / count + 1; /* chunks of a rank */
    STP_TRY(stp_alloc(&sizes, 2 * (size_t)count, sizeof *sizes, "ranks", err));
    for (uint32_t at = 0; count > 1 && at < most; at += CHUNKS_AHEAD)
        STP_TRY(give_around(t, (uint32_t)t->own.begin + at, &out, &in, sizes, sizes + count, err));
done:
    free(sizes);
    free(out.data);
    free(in.data);
    return status;
}

/* Builds this rank's chunks of the tier; in waves if they have attributes, which takes all ranks.
 */
static stp_status build_own(tree *t, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = (uint32_t)(t->own.end - t->own.begin);
    const bool numbered = t->params->numbers.list;
    const uint32_t wave = numbered ? CHUNKS_AHEAD : count;
    const uint32_t most = numbered ? t->tier_count / stp_ranks_count(t->params->ranks) + 1 : count;
    for (uint32_t at = 0; at < most; at += wave) {
        const uint32_t begin = at < count ? at : count;
        const uint32_t here = count - begin < wave ? count - begin : wave;
        t->wave_begin = (uint32_t)t->own.begin + begin;
        STP_TRY(stp_cloud_run(t->cloud, t->pool, here, build_one, t, err));
        if (numbered)
            STP_TRY(stp_tier_numbers_make(t->tier + t->wave_begin, here, t->params, t->cloud,
                                          t->pool, err));
    }
done:
    return status;
}

/* Builds this rank's chunks of the tier, and gets those around them. */
static stp_status build_tier(tree *t, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = t->params->ranks;
    t->own = stp_ranks_own(ranks, t->tier_count);
    for (uint64_t i = t->own.begin; !t->below && i < t->own.end; i++)
        stp_leaf_ask(t->cloud, &t->params->sources, &t->leaves[i]);
    STP_TRY(stp_cloud_fetch(t->cloud, err));
    if (!t->below && t->params->sources.maps)
        STP_TRY(stp_map_leaves_fetch(t->params->sources.maps, err));
    STP_TRY(build_own(t, err));
    stp_cloud_let_go(t->cloud);
    STP_TRY(stp_ranks_share(ranks, t->reaches.boxes, t->tier_count, sizeof *t->reaches.boxes, err));
    stp_chunk_boxes_join(&t->reaches);
    STP_TRY(share_around(t, err));
done:
    return status;
}

/* Puts a payload aside until it is known where it goes. */
static stp_status stow_payload(const tree *t, built *b, stp_error *err)
{
    return stp_spill_move(t->cloud->spill, &b->payload, b->entry.segment_end[STP_SEGMENT_COUNT - 1],
                          1, "chunks", err);
}

/* Writes the payloads of this rank, and gives what else is known of finished chunks to all. */
static stp_status write_shared(tree *t, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes packet = {0};
    const stp_attribute_list *list = t->params->numbers.list;
    STP_TRY(stp_tier_file_write(&t->file, t->tier, t->tier_count, t->cloud->spill, err));
    for (unsigned owner = 0; owner < t->params->ranks->count; owner++) {
        const stp_rank_part part = stp_ranks_part(t->params->ranks, owner, t->tier_count);
        for (uint32_t i = (uint32_t)part.begin; i < part.end; i++) {
            stp_spill_relieve(t->cloud->spill);
            STP_TRY(stp_tier_chunk_share(&t->tier[i], owner, t->params->ranks, list, &packet,
                                         t->cloud->spill, err));
            STP_TRY(write_one(t, i, err));
        }
    }
done:
    free(packet.data);
    return status;
}

/* Writes a finished chunk, or puts it aside if several ranks build the tier. */
static stp_status take_one(void *context, size_t index, unsigned worker, stp_error *err)
{
    tree *t = context;
    const uint32_t self = (uint32_t)(t->own.begin + index);
    (void)worker;
    return stp_ranks_count(t->params->ranks) == 1 ? write_one(t, self, err)
                                                  : stow_payload(t, &t->tier[self], err);
}

/* Measures, encodes and writes chunks; if there is but one, all threads share it. */
static stp_status finish_tier(tree *t, stp_error *err)
{
    const size_t count = t->own.end - t->own.begin;
    if (t->tier_count > 1)
        return stp_pool_run_in_order(t->pool, count, CHUNKS_AHEAD, finish_one, take_one, t, err);
    const stp_status status = count > 0 ? finish_one(t, 0, 0, err) : STP_OK;
    return status == STP_OK && count > 0 ? take_one(t, 0, 0, err) : status;
}

/* Builds and writes `count` chunks. Makes one node each. */
static stp_status write_tier(tree *t, uint32_t count, node *nodes, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&t->tier, count, sizeof *t->tier, "chunks", err));
    t->tier_count = count;
    t->nodes = nodes;
    STP_TRY(stp_chunk_boxes_create(&t->reaches, count, err));
    STP_TRY(build_tier(t, err));
    STP_TRY(finish_tier(t, err));
    if (stp_ranks_count(t->params->ranks) > 1)
        STP_TRY(write_shared(t, err));
done:
    clear_tier(t);
    return status;
}

/* Groups nodes into runs that fit one parent: at most 64 children and 64 k patch vertices. Runs
 * follow the Morton order, so their nodes are near each other. */
static stp_status group_nodes(tree *t, const node *nodes, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&t->spans, count, sizeof *t->spans, "chunks", err));
    t->span_count = 0;
    uint32_t begin = 0;
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (i - begin == STP_CHUNK_CHILDREN_LIMIT ||
            (i > begin && sum + nodes[i].vertex_count > STP_CHUNK_SAMPLES_LIMIT)) {
            t->spans[t->span_count++] = (span){begin, i};
            begin = i;
            sum = 0;
        }
        sum += nodes[i].vertex_count;
    }
    t->spans[t->span_count++] = (span){begin, count};
done:
    return status;
}

static uint64_t sum_vertices(const node *nodes, uint32_t count)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++)
        sum += nodes[i].vertex_count;
    return sum;
}

/* If a tier has no fewer chunks than the one below, it must have far fewer patches. Then a chunk of
 * the next tier has room for several of its chunks. */
static stp_status check_growth(const tree *t, const node *above, const node *below, uint32_t count,
                               stp_error *err)
{
    if (t->span_count < count ||
        sum_vertices(above, count) <= sum_vertices(below, count) / LEAST_MERGE)
        return STP_OK;
    return stp_error_set(err, STP_LIMIT,
                         "the model's patches do not group: its points lie too far apart to be "
                         "merged");
}

static void free_nodes(const tree *t, node *nodes, uint32_t count)
{
    for (uint32_t i = 0; nodes && i < count; i++) {
        stp_spill_free(t->cloud->spill, nodes[i].vertices);
        free(nodes[i].run_ends);
    }
    free(nodes);
}

/* Builds tiers until one chunk is left. *root is its handle. */
static stp_status build_tiers(tree *t, uint32_t *root, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t count = t->leaf_count;
    node *nodes = NULL;
    STP_TRY(stp_alloc(&nodes, count, sizeof *nodes, "chunks", err));
    STP_TRY(write_tier(t, count, nodes, err));
    while (count > 1) {
        node *above = NULL;
        STP_TRY(group_nodes(t, nodes, count, err));
        STP_TRY(stp_alloc(&above, t->span_count, sizeof *above, "chunks", err));
        t->below = nodes;
        status = write_tier(t, t->span_count, above, err);
        if (status == STP_OK)
            status = check_growth(t, above, nodes, count, err);
        free_nodes(t, nodes, count);
        nodes = above;
        count = t->span_count;
        free(t->spans);
        t->spans = NULL;
        if (status != STP_OK)
            goto done;
    }
    *root = nodes[0].handle;
done:
    free_nodes(t, nodes, count);
    free(t->spans);
    t->spans = NULL;
    return status;
}

/* Writes the attributes of all chunks behind the payloads. */
static stp_status write_numbers(tree *t, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_attribute_list *list = t->params->numbers.list;
    for (uint32_t handle = 0; list && t->writer && handle < t->stats.chunk_count; handle++) {
        stp_chunk_numbers *n = &t->numbers[handle];
        STP_TRY(stp_chunk_writer_append_numbers(t->writer, handle, list, n->bytes, n->size, n->rows,
                                                err));
        stp_chunk_numbers_clear(n, t->cloud->spill);
    }
done:
    return status;
}

stp_point_item_params stp_tree_item_params(const stp_tree_params *params, const stp_dbox *box)
{
    const double side = stp_dbox_side(box);
    return (stp_point_item_params){.lambda = params->lambda,
                                   .resolution = params->resolution,
                                   .intensity_max = params->intensity_max,
                                   .normal_bits = params->normal_bits,
                                   .normal_step = params->normal_step,
                                   .given_bits = params->given_bits,
                                   .vertex_least = side > 0.0 && isfinite(side)
                                                       ? stp_floor_log2(side) - STP_MODEL_OCTAVES
                                                       : INT_MIN / 2};
}

stp_status stp_tree_write(stp_chunk_writer **writer, stp_cloud *cloud,
                          const stp_tree_params *params, stp_metadata_maker *metadata,
                          void *context, stp_pool *pool, const stp_progress *progress,
                          stp_tree_stats *stats, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t root = 0;
    tree *t = NULL;
    char *json = NULL;
    const stp_dbox box = stp_leaf_sources_box(cloud, &params->sources);
    STP_TRY(stp_alloc(&t, 1, sizeof *t, "tree", err));
    t->writer = *writer;
    t->cloud = cloud;
    t->params = params;
    t->pool = pool;
    t->progress = progress;
    t->box = stp_dbox_empty();
    t->items = stp_tree_item_params(params, &box);
    STP_TRY(stp_cells_cut(cloud, &t->items, pool, err));
    STP_TRY(stp_leaf_order(cloud, &params->sources, &t->leaves, &t->leaf_count, err));
    t->whole_grid = stp_leaves_are_whole_grid(&params->sources, t->leaves, t->leaf_count);
    t->own = stp_ranks_own(params->ranks, t->leaf_count);
    t->progress_total = 2 * (uint64_t)(t->own.end - t->own.begin);
    if (stp_ranks_count(params->ranks) > 1)
        STP_TRY(stp_tier_file_open(&t->file, t->writer, params->ranks, err));
    STP_TRY(build_tiers(t, &root, err));
    STP_TRY(write_numbers(t, err));
    if (t->file.path)
        STP_TRY(stp_tier_file_sync(&t->file, err));
    json = metadata(context, &t->stats);
    if (!json) {
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the metadata");
        goto done;
    }
    if (t->writer)
        STP_TRY(stp_chunk_writer_finish(writer, root, (const uint32_t *const *)t->children,
                                        t->child_counts, &t->box, json, &t->stats.file_bytes, err));
    *stats = t->stats;
done:
    free(json);
    stp_chunk_writer_destroy(writer);
    for (uint32_t i = 0; t && i < t->stats.chunk_count; i++) {
        free(t->children[i]);
        stp_chunk_numbers_clear(&t->numbers[i], cloud->spill);
    }
    if (t) {
        stp_tier_file_close(&t->file);
        free(t->numbers);
        free(t->children);
        free(t->child_counts);
        free(t->leaves);
    }
    free(t);
    return status;
}
