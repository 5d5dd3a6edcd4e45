/* Writes a repaired file that differs from its input. */
#include "formats/chunk/repair/repair_write.h"

#include "base/memory.h"
#include "base/sort.h"
#include "formats/chunk/repair/repair_note.h"

#include <inttypes.h>
#include <stdlib.h>

typedef struct writing {
    stp_repair_plan *plan;
    stp_chunk_writer *writer;
    stp_codec codec; /* of rebuilt chunks without an entry that tells */
    stp_dbox box;
    uint32_t *handles;   /* by id */
    uint32_t *counts;    /* by handle */
    uint32_t **children; /* by handle, into `listed` */
    uint32_t *listed;
    uint32_t handle_count;
    uint32_t joined_count; /* chunks whose blocks became one */
} writing;

/* ---- counting ---- */

/* Level-0 samples of a leaf in the output. */
static uint64_t leaf_samples(const stp_repair_plan *plan, uint32_t id)
{
    const stp_chunk *chunk = plan->nodes[id].chunk;
    return chunk ? chunk->level_begin[0][chunk->patch_count]
                 : plan->damaged->entries[id].sample_count[0];
}

/* Gives chunks their ids in the output, and counts the points under each. */
static void count_points(stp_repair_plan *plan, const bool *stood_in)
{
    uint32_t next = 0;
    for (uint32_t id = 0; id < plan->count; id++)
        plan->nodes[id].id = plan->nodes[id].fate == STP_FATE_GONE ? STP_CHUNK_NONE : next++;
    for (uint32_t id = plan->count; id-- > 0;) {
        stp_repair_node *node = &plan->nodes[id];
        if (node->fate == STP_FATE_GONE)
            continue;
        if (node->child_count == 0) {
            bool real = node->fate == STP_FATE_KEPT && !stood_in[id];
            *(real ? &node->points : &node->stand_ins) = leaf_samples(plan, id);
        }
        if (id > 0) {
            plan->nodes[node->parent].points += node->points;
            plan->nodes[node->parent].stand_ins += node->stand_ins;
        }
    }
}

/* Points that the damaged file stored, without samples that stood in for others already. */
static uint64_t points_before(const stp_repair_plan *plan, const bool *stood_in)
{
    const stp_damaged *d = plan->damaged;
    uint64_t points = d->header.point_count;
    for (uint32_t id = 0; id < plan->count; id++)
        if (stood_in[id] && d->known[id] && d->entries[id].sample_count[0] <= points)
            points -= d->entries[id].sample_count[0];
    return points;
}

static stp_status count_losses(stp_repair_plan *plan, stp_repair_result *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_damaged *d = plan->damaged;
    bool *stood_in = NULL;
    STP_TRY(stp_alloc(&stood_in, plan->count, sizeof *stood_in, "chunks", err));
    if (!d->metadata_lost)
        stp_repair_note_stand_ins(d->metadata, stood_in, plan->count);
    count_points(plan, stood_in);
    uint64_t before = points_before(plan, stood_in);
    out->points_lost = before > plan->nodes[0].points ? before - plan->nodes[0].points : 0;
    out->stand_ins = plan->nodes[0].stand_ins;
    const bool attributes = stp_header_section(&d->header, STP_SECTION_ATTRIBUTES) != NULL;
    if (attributes)
        stp_damaged_say(d, "its attributes are lost: a file that is written anew has none");
    out->attributes_lost = attributes;
    out->whole = out->points_lost == 0 && !d->metadata_lost && !attributes;
done:
    free(stood_in);
    return status;
}

/* ---- chunks ---- */

static stp_status append_kept(writing *w, uint32_t id, uint32_t *handle, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_damaged *d = w->plan->damaged;
    stp_chunk_entry entry = d->entries[id];
    uint8_t *bytes = NULL;
    size_t size = entry.segment_end[STP_SEGMENT_COUNT - 1];
    STP_TRY(stp_alloc(&bytes, size + 1, 1, "payload", err));
    STP_TRY(stp_damaged_read(d, entry.offset, bytes, size, err));
    entry.points_under = w->plan->nodes[id].points + w->plan->nodes[id].stand_ins;
    STP_TRY(stp_chunk_writer_append(w->writer, bytes, &entry, handle, err));
done:
    free(bytes);
    return status;
}

static stp_status append_chunk(writing *w, uint32_t id, const stp_chunk *chunk, stp_dvec3 origin,
                               uint32_t *handle, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_damaged *d = w->plan->damaged;
    const stp_repair_node *node = &w->plan->nodes[id];
    void *payload = NULL;
    stp_chunk_entry entry = {.origin = origin, .points_under = node->points + node->stand_ins};
    stp_codec codec = d->known[id] ? (stp_codec)d->entries[id].codec : w->codec;
    STP_TRY(stp_chunk_encode(chunk, codec, &payload, &entry, err));
    STP_TRY(stp_chunk_writer_append(w->writer, payload, &entry, handle, err));
    if (node->child_count == 0)
        stp_chunk_box(chunk, origin, &w->box);
done:
    free(payload);
    return status;
}

/* A rebuilt chunk is not linked, so that a chunk under it must be one block. */
static bool must_join(const stp_repair_plan *plan, uint32_t id)
{
    const uint32_t parent = plan->nodes[id].parent;
    return parent != STP_CHUNK_NONE && plan->nodes[parent].fate == STP_FATE_REBUILT &&
           plan->damaged->known[id] && plan->damaged->entries[id].block_count > 1;
}

static stp_status append_joined(writing *w, uint32_t id, uint32_t *handle, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_repair_node *node = &w->plan->nodes[id];
    stp_chunk *own = NULL, *chunk = node->chunk;
    if (!chunk)
        STP_TRY(stp_damaged_chunk(w->plan->damaged, id, 0, &own, err));
    chunk = chunk ? chunk : own;
    chunk->block_count = 0;
    STP_TRY(append_chunk(w, id, chunk, own ? w->plan->damaged->entries[id].origin : node->origin,
                         handle, err));
    w->joined_count++;
done:
    stp_chunk_destroy(&own);
    return status;
}

static stp_status append(writing *w, uint32_t id, uint32_t *handle, stp_error *err)
{
    const stp_repair_node *node = &w->plan->nodes[id];
    if (must_join(w->plan, id))
        return append_joined(w, id, handle, err);
    return node->chunk ? append_chunk(w, id, node->chunk, node->origin, handle, err)
                       : append_kept(w, id, handle, err);
}

/* Appends chunks in the order of the damaged file. */
static stp_status append_all(writing *w, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_repair_plan *plan = w->plan;
    const stp_damaged *d = plan->damaged;
    stp_placed *order = NULL;
    STP_TRY(stp_alloc(&order, plan->count, sizeof *order, "chunks", err));
    for (uint32_t id = 0; id < plan->count; id++)
        order[id] = (stp_placed){d->known[id] ? d->entries[id].offset : UINT64_MAX, id};
    stp_sort_placed(order, plan->count);
    for (uint32_t i = 0; i < plan->count; i++) {
        uint32_t id = order[i].id;
        if (plan->nodes[id].fate == STP_FATE_GONE)
            continue;
        STP_TRY(append(w, id, &w->handles[id], err));
        w->handle_count++;
        STP_TRY(stp_progress_update(d->params->progress, "write", i + 1, plan->count, err));
    }
    if (w->joined_count > 0)
        stp_damaged_say(d, "%" PRIu32 " chunk%s: one block now, because the chunk above is rebuilt",
                        w->joined_count, w->joined_count == 1 ? "" : "s");
done:
    free(order);
    return status;
}

/* ---- tree ---- */

static stp_status list_children(writing *w, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_repair_plan *plan = w->plan;
    uint32_t at = 0;
    STP_TRY(stp_alloc(&w->counts, w->handle_count, sizeof *w->counts, "chunks", err));
    STP_TRY(stp_alloc(&w->children, w->handle_count, sizeof *w->children, "chunks", err));
    STP_TRY(stp_alloc(&w->listed, w->handle_count, sizeof *w->listed, "chunks", err));
    for (uint32_t id = 0; id < plan->count; id++) {
        if (plan->nodes[id].fate == STP_FATE_GONE)
            continue;
        w->children[w->handles[id]] = &w->listed[at];
        at += plan->nodes[id].child_count;
    }
    for (uint32_t id = 1; id < plan->count; id++) {
        if (plan->nodes[id].fate == STP_FATE_GONE)
            continue;
        uint32_t parent = w->handles[plan->nodes[id].parent];
        w->children[parent][w->counts[parent]++] = w->handles[id];
    }
done:
    return status;
}

static stp_status finish(writing *w, const stp_repair_result *result, stp_error *err)
{
    stp_status status = STP_OK;
    char *metadata = stp_repair_note_write(w->plan, result);
    if (!metadata)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the metadata");
    STP_TRY(list_children(w, err));
    STP_TRY(stp_chunk_writer_finish(&w->writer, w->handles[0], (const uint32_t *const *)w->children,
                                    w->counts, &w->box, metadata, NULL, err));
done:
    free(metadata);
    return status;
}

static stp_codec told_codec(const stp_damaged *d)
{
    stp_codec codec = STP_CODEC_DRACO;
    for (uint32_t id = d->header.chunk_count; id-- > 0;)
        if (d->known[id])
            codec = (stp_codec)d->entries[id].codec;
    return d->header.version_major == 1 ? codec : stp_codec_in_blocks(codec);
}

stp_status stp_repair_write(stp_repair_plan *plan,
                            stp_status (*check)(void *context, const char *path, stp_error *err),
                            void *context, stp_repair_result *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_damaged *d = plan->damaged;
    const stp_header *h = &d->header;
    writing w = {.plan = plan, .codec = told_codec(d), .box = h->box};
    stp_chunk_writer_params params = {.force = d->params->force,
                                      .codec = w.codec,
                                      .attributes = h->attributes,
                                      .orientation = (stp_orientation)h->orientation,
                                      .lambda = h->lambda,
                                      .check = check,
                                      .check_context = context};
    stp_repair_result result = *out;
    if (stp_chunk_file_is_newer(h->version_major, h->version_minor))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: cannot be repaired: version %u.%u is newer than this program: "
                             "use a newer stipple",
                             d->path, h->version_major, h->version_minor);
    STP_TRY(stp_alloc(&w.handles, plan->count, sizeof *w.handles, "chunks", err));
    STP_TRY(stp_chunk_writer_create(&w.writer, d->params->output, &params, err));
    STP_TRY(count_losses(plan, &result, err));
    STP_TRY(append_all(&w, err));
    STP_TRY(finish(&w, &result, err));
    *out = result;
done:
    stp_chunk_writer_destroy(&w.writer);
    free(w.handles);
    free(w.counts);
    free(w.children);
    free(w.listed);
    return status;
}
