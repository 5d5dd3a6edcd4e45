/* Packets of chunks. */
#include "preprocess/tree/tier_chunk.h"

#include <stdlib.h>

void stp_tier_chunk_clear(stp_tier_chunk *c, stp_spill *spill)
{
    stp_built_chunk_clear(&c->chunk);
    stp_spill_free(spill, c->payload);
    free(c->records.data);
    stp_chunk_numbers_clear(&c->numbers, spill);
}

stp_status stp_tier_chunk_pack(stp_bytes *out, const stp_tier_chunk *c, stp_error *err)
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

stp_status stp_tier_chunk_take(stp_tier_chunk *out, stp_cursor from, stp_spill *spill,
                               stp_error *err)
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

stp_status stp_tier_chunk_pack_file(stp_bytes *out, const stp_tier_chunk *c,
                                    uint32_t attribute_count, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_numbers *n = &c->numbers;
    const uint64_t sizes[] = {c->entry.segment_end[STP_SEGMENT_COUNT - 1], c->records.size,
                              n->size};
    STP_TRY(stp_bytes_append(out, sizes, sizeof sizes, err));
    STP_TRY(stp_bytes_append(out, c->payload, sizes[0], err));
    STP_TRY(stp_bytes_append(out, c->records.data, sizes[1], err));
    if (attribute_count > 0) {
        STP_TRY(stp_bytes_append(out, n->bytes, n->size, err));
        STP_TRY(stp_bytes_append(out, n->rows, attribute_count * sizeof *n->rows, err));
    }
done:
    return status;
}

stp_status stp_tier_chunk_take_file(stp_tier_chunk *out, stp_cursor from, uint32_t attribute_count,
                                    stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_numbers *n = &out->numbers;
    uint64_t sizes[3];
    STP_TRY(stp_packet_take(&from, sizes, sizeof sizes, err));
    STP_TRY(stp_packet_take_array(&from, &out->payload, sizes[0], 1, err));
    STP_TRY(stp_packet_take_array(&from, &out->records.data, sizes[1], 1, err));
    out->records.size = sizes[1];
    if (attribute_count > 0) {
        n->size = sizes[2];
        STP_TRY(stp_packet_take_array(&from, &n->bytes, n->size, 1, err));
        STP_TRY(stp_packet_take_array(&from, &n->rows, attribute_count, sizeof *n->rows, err));
    }
done:
    return status;
}
