/* Packs records of points as the points of a LAZ file. */
#include "formats/scan/las/laz/laz_pack.h"

#include "base/memory.h"
#include "formats/scan/las/las_bytes.h"
#include "formats/scan/las/laz/laz_chunks.h"
#include "formats/scan/las/laz/laz_items.h"

#include <stdlib.h>
#include <string.h>

struct stp_laz_packer {
    stp_output *output;
    stp_laz_layout layout;
    stp_laz_items items;
    size_t record_bytes;
    uint64_t begin;       /* of the points, in the output */
    uint32_t points;      /* of the chunk that is open; 0: none is */
    uint32_t chunk_count; /* that were written */
    uint32_t *chunk_bytes;
    size_t chunk_capacity;
    unsigned char *first; /* record of the chunk */
    unsigned char *head;  /* of a layered chunk: u32 points, u32 bytes of each layer */
};

/* Whether all items can be packed, in chunks of equal size. */
static bool can_pack(const stp_laz_layout *layout)
{
    bool can = layout->chunked && layout->chunk_points > 0 && layout->chunk_points < UINT32_MAX;
    for (unsigned i = 0; i < layout->item_count; i++)
        can = can && layout->items[i].coder->packs;
    return can;
}

stp_status stp_laz_packer_create(stp_laz_packer **out, const stp_laz_layout *layout,
                                 stp_output *output, stp_error *err)
{
    stp_status status = STP_OK;
    stp_laz_packer *p = NULL;
    static const unsigned char place[STP_LAZ_TABLE_PLACE_BYTES] = {0};
    if (!can_pack(layout))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "this kind of LAZ can be unpacked but not packed: write LAS");
    STP_TRY(stp_alloc(&p, 1, sizeof *p, "LAZ packer", err));
    p->output = output;
    p->layout = *layout;
    p->begin = stp_output_size(output);
    for (unsigned i = 0; i < layout->item_count; i++)
        p->record_bytes += layout->items[i].bytes;
    STP_TRY(stp_laz_items_create(&p->items, &p->layout, err));
    STP_TRY(stp_alloc(&p->first, 1, p->record_bytes, "a record", err));
    STP_TRY(stp_alloc(&p->head, 1 + (size_t)p->items.stream_count, 4, "LAZ layers", err));
    STP_TRY(stp_output_write(output, place, sizeof place, err));
    *out = p;
    p = NULL;
done:
    stp_laz_packer_destroy(&p);
    return status;
}

void stp_laz_packer_destroy(stp_laz_packer **packer)
{
    stp_laz_packer *p = *packer;
    if (!p)
        return;
    stp_laz_items_free(&p->items);
    free(p->chunk_bytes);
    free(p->first);
    free(p->head);
    free(p);
    *packer = NULL;
}

static void begin_chunk(stp_laz_packer *p, const unsigned char *record)
{
    memcpy(p->first, record, p->record_bytes);
    for (unsigned i = 0; i < p->items.stream_count; i++)
        stp_laz_stream_pack(&p->items.streams[i], p->chunk_count + 1);
    stp_laz_items_begin(&p->items, record);
}

/* A layered chunk leaves out layers that say nothing, but never the first two: positions. */
#define LAYERS_ALWAYS 2u

static bool is_written(const stp_laz_packer *p, unsigned stream)
{
    return !p->layout.layered || stream < LAYERS_ALWAYS || p->items.streams[stream].needed;
}

static stp_status end_chunk(stp_laz_packer *p, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned count = p->items.stream_count;
    const uint64_t begin = stp_output_size(p->output);
    stp_las_put_u32(p->head, p->points);
    for (unsigned i = 0; i < count; i++) {
        const size_t size = is_written(p, i) ? stp_laz_stream_finish(&p->items.streams[i]) : 0;
        stp_las_put_u32(p->head + 4 * (1 + (size_t)i), (uint32_t)size);
        if (p->items.streams[i].cut)
            return stp_error_set(err, STP_OUT_OF_MEMORY,
                                 "no memory for a chunk of LAZ: close other programs or write LAS");
    }
    STP_TRY(stp_grow(&p->chunk_bytes, &p->chunk_capacity, (size_t)p->chunk_count + 1,
                     sizeof *p->chunk_bytes, "chunks of points", err));
    STP_TRY(stp_output_write(p->output, p->first, p->record_bytes, err));
    if (p->layout.layered)
        STP_TRY(stp_output_write(p->output, p->head, 4 * (1 + (size_t)count), err));
    for (unsigned i = 0; i < count; i++)
        STP_TRY(stp_output_write(p->output, p->items.streams[i].packed,
                                 stp_las_u32(p->head + 4 * (1 + (size_t)i)), err));
    p->chunk_bytes[p->chunk_count++] = (uint32_t)(stp_output_size(p->output) - begin);
    p->points = 0;
done:
    return status;
}

stp_status stp_laz_packer_records(stp_laz_packer *packer, unsigned char *records, size_t count,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t i = 0; i < count; i++, records += packer->record_bytes) {
        if (packer->points == packer->layout.chunk_points)
            STP_TRY(end_chunk(packer, err));
        if (packer->points++ == 0)
            begin_chunk(packer, records);
        else
            stp_laz_items_next(&packer->items, records);
    }
done:
    return status;
}

stp_status stp_laz_packer_finish(stp_laz_packer *packer, stp_error *err)
{
    stp_status status = STP_OK;
    unsigned char place[STP_LAZ_TABLE_PLACE_BYTES];
    if (packer->points > 0)
        STP_TRY(end_chunk(packer, err));
    stp_las_put_u64(place, stp_output_size(packer->output));
    STP_TRY(stp_laz_chunks_write(packer->chunk_bytes, packer->chunk_count, packer->output, err));
    STP_TRY(stp_output_write_at(packer->output, packer->begin, place, sizeof place, err));
done:
    return status;
}
