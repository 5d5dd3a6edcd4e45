/* Packets of chunks. */
#include "preprocess/tree/tier_chunk.h"

#include "base/memory.h"

#include <stdlib.h>

/* What a packet of patches begins with. */
typedef struct around_head {
    stp_dvec3 origin;
    uint32_t index, patches, samples, carries;
} around_head;

void stp_tier_chunk_clear(stp_tier_chunk *c, stp_spill *spill)
{
    stp_built_chunk_clear(&c->chunk);
    stp_spill_free(spill, c->payload);
    free(c->records.data);
    stp_chunk_numbers_clear(&c->numbers, spill);
}

void stp_tier_chunk_forget_sources(stp_tier_chunk *c)
{
    free(c->chunk.sources);
    c->chunk.sources = NULL;
}

/* Appends what every rank needs of a chunk: its entry, its vertices and what is summed up. */
static stp_status pack(stp_bytes *out, const stp_tier_chunk *c, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_built_chunk *b = &c->chunk;
    const uint32_t counts[] = {b->vertex_count, b->run_count};
    STP_TRY(stp_bytes_append(out, &c->entry, sizeof c->entry, err));
    STP_TRY(stp_bytes_append(out, &c->box, sizeof c->box, err));
    STP_TRY(stp_bytes_append(out, &b->displacement, sizeof b->displacement, err));
    STP_TRY(stp_bytes_append(out, counts, sizeof counts, err));
    STP_TRY(stp_bytes_append(out, b->vertices, b->vertex_count * sizeof *b->vertices, err));
    STP_TRY(stp_bytes_append(out, b->run_ends, b->run_count * sizeof *b->run_ends, err));
done:
    return status;
}

/* Sets these in place of what was there. */
static stp_status take(stp_tier_chunk *out, stp_cursor from, stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t counts[2];
    stp_built_chunk b = {.spill = spill};
    stp_tier_chunk_clear(out, spill);
    *out = (stp_tier_chunk){0};
    STP_TRY(stp_packet_take(&from, &out->entry, sizeof out->entry, err));
    STP_TRY(stp_packet_take(&from, &out->box, sizeof out->box, err));
    STP_TRY(stp_packet_take(&from, &b.displacement, sizeof b.displacement, err));
    STP_TRY(stp_packet_take(&from, counts, sizeof counts, err));
    b.vertex_count = counts[0];
    b.run_count = counts[1];
    STP_TRY(stp_packet_take_array(&from, &b.vertices, b.vertex_count, sizeof *b.vertices, err));
    STP_TRY(stp_packet_take_array(&from, &b.run_ends, b.run_count, sizeof *b.run_ends, err));
    STP_TRY(stp_spill_move(spill, &b.vertices, b.vertex_count, sizeof *b.vertices, "patches", err));
done:
    out->chunk = b; /* owned by out also after a failure */
    return status;
}

/* Lists the patches of a chunk that reach into chunks of a part. list: room for all. */
static around_head find_around(uint32_t *list, const stp_tier_chunk *c,
                               const stp_chunk_boxes *boxes, stp_rank_part part)
{
    const stp_placed_chunk placed = stp_built_chunk_place(&c->chunk);
    around_head head = {.origin = placed.origin};
    for (uint32_t p = 0; p < placed.chunk->patch_count; p++) {
        const stp_patch *patch = &placed.chunk->patches[p];
        const stp_dbox box = stp_placed_patch_box(&placed, p);
        if (patch->flags & STP_PATCH_SHAPES || /* nothing is measured against them */
            stp_chunk_boxes_next(boxes, &box, (uint32_t)part.begin) >= part.end)
            continue;
        list[head.patches++] = p;
        head.samples += patch->counts[0];
    }
    head.carries = placed.carry ? head.samples : 0;
    return head;
}

stp_status stp_tier_chunk_pack_around(stp_bytes *out, const stp_tier_chunk *c, uint32_t index,
                                      const stp_chunk_boxes *boxes, stp_rank_part part,
                                      stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk *chunk = c->chunk.chunk;
    uint32_t *list = NULL;
    if (stp_chunk_boxes_next(boxes, &boxes->boxes[index], (uint32_t)part.begin) >= part.end)
        return STP_OK;
    STP_TRY(stp_alloc(&list, chunk->patch_count, sizeof *list, "patches", err));
    around_head head = find_around(list, c, boxes, part);
    head.index = index;
    if (head.patches == 0)
        goto done;
    STP_TRY(stp_bytes_append(out, &head, sizeof head, err));
    for (uint32_t i = 0; i < head.patches; i++) {
        const stp_patch *patch = &chunk->patches[list[i]];
        const uint32_t first = chunk->level_begin[0][list[i]], count = patch->counts[0];
        STP_TRY(stp_bytes_append(out, patch, sizeof *patch, err));
        STP_TRY(stp_bytes_append(out, &chunk->samples[0][first], count * sizeof(stp_sample), err));
        if (head.carries > 0)
            STP_TRY(stp_bytes_append(out, &c->chunk.carry[first], count * sizeof(stp_carry), err));
    }
done:
    free(list);
    return status;
}

stp_status stp_tier_chunk_take_around(stp_tier_chunk *tier, stp_cursor *from, stp_spill *spill,
                                      stp_error *err)
{
    stp_status status = STP_OK;
    stp_built_chunk b = {0};
    around_head head;
    uint32_t at = 0;
    STP_TRY(stp_packet_take(from, &head, sizeof head, err));
    const uint32_t samples[STP_LEVEL_COUNT] = {head.samples};
    b.origin = head.origin;
    STP_TRY(stp_chunk_create(&b.chunk, head.patches, samples, 0, err));
    STP_TRY(stp_alloc(&b.carry, head.carries, sizeof *b.carry, "errors", err));
    for (uint32_t p = 0; p < head.patches; p++) {
        stp_patch *patch = &b.chunk->patches[p];
        STP_TRY(stp_packet_take(from, patch, sizeof *patch, err));
        const uint32_t count = patch->counts[0];
        b.chunk->level_begin[0][p] = at;
        STP_TRY(stp_packet_take(from, &b.chunk->samples[0][at], count * sizeof(stp_sample), err));
        if (head.carries > 0)
            STP_TRY(stp_packet_take(from, &b.carry[at], count * sizeof *b.carry, err));
        at += count;
    }
    b.chunk->level_begin[0][head.patches] = at;
    STP_TRY(stp_built_chunk_stow(&b, spill, err));
    tier[head.index].chunk = b;
    b = (stp_built_chunk){0};
done:
    stp_built_chunk_clear(&b);
    return status;
}

/* Appends what only the file needs beside the payload: records and attributes. */
static stp_status pack_file(stp_bytes *out, const stp_tier_chunk *c, uint32_t attribute_count,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_numbers *n = &c->numbers;
    const uint64_t sizes[] = {c->records.size, n->size};
    STP_TRY(stp_bytes_append(out, sizes, sizeof sizes, err));
    STP_TRY(stp_bytes_append(out, c->records.data, sizes[0], err));
    if (attribute_count > 0) {
        STP_TRY(stp_bytes_append(out, n->bytes, n->size, err));
        STP_TRY(stp_bytes_append(out, n->rows, attribute_count * sizeof *n->rows, err));
    }
done:
    return status;
}

static stp_status take_file(stp_tier_chunk *out, stp_cursor from, uint32_t attribute_count,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_numbers *n = &out->numbers;
    uint64_t sizes[2];
    STP_TRY(stp_packet_take(&from, sizes, sizeof sizes, err));
    STP_TRY(stp_packet_take_array(&from, &out->records.data, sizes[0], 1, err));
    out->records.size = sizes[0];
    if (attribute_count > 0) {
        n->size = sizes[1];
        STP_TRY(stp_packet_take_array(&from, &n->bytes, n->size, 1, err));
        STP_TRY(stp_packet_take_array(&from, &n->rows, attribute_count, sizeof *n->rows, err));
    }
done:
    return status;
}

stp_status stp_tier_chunk_share(stp_tier_chunk *c, unsigned owner, stp_ranks *ranks,
                                const stp_attribute_list *list, stp_bytes *packet, stp_spill *spill,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t attributes = list ? list->count : 0;
    packet->size = 0;
    if (ranks->self == owner)
        STP_TRY(pack(packet, c, err));
    STP_TRY(stp_ranks_broadcast_bytes(ranks, owner, packet, err));
    if (ranks->self != owner)
        STP_TRY(take(c, (stp_cursor){packet->data, packet->size}, spill, err));
    if (owner == 0)
        goto done;
    packet->size = 0;
    if (ranks->self == owner)
        STP_TRY(pack_file(packet, c, attributes, err));
    STP_TRY(stp_ranks_send_bytes(ranks, owner, packet, err));
    if (ranks->self == 0)
        STP_TRY(take_file(c, (stp_cursor){packet->data, packet->size}, attributes, err));
done:
    return status;
}
