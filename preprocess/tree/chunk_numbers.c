/* Encodes the attributes of a built chunk. */
#include "preprocess/tree/chunk_numbers.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* The numbers of the places in their order, and the samples that hold them. */
typedef struct gathered {
    uint8_t *packed;
    stp_sample *holders;
} gathered;

/* What stands for a sample without numbers: of a line or a triangle. */
static void put_missing(const stp_attribute_list *list, uint8_t *packed)
{
    for (uint32_t a = 0; a < list->count; a++) {
        const stp_attribute *attribute = &list->items[a];
        stp_attribute_put(attribute->type, stp_attribute_missing(attribute), packed);
        packed += stp_attribute_bytes(attribute->type);
    }
}

static stp_status gather(gathered *out, const stp_built_chunk *built,
                         const stp_attribute_order *order, const stp_point_numbers *numbers,
                         const uint8_t *rows, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t stride = stp_attribute_list_bytes(numbers->list);
    const uint32_t count = order->ends[STP_LEVEL_COUNT - 1];
    uint32_t i = 0;
    STP_TRY(stp_alloc(&out->packed, count, stride, "attributes", err));
    STP_TRY(stp_alloc(&out->holders, count, sizeof *out->holders, "attributes", err));
    for (int part = 0; part < STP_LEVEL_COUNT; part++)
        for (; i < order->ends[part]; i++) {
            const uint32_t place = order->places[i];
            const uint64_t source = built->sources ? built->sources[place] : STP_SOURCE_NONE;
            uint8_t *to = out->packed + i * stride;
            if (source == STP_SOURCE_NONE)
                put_missing(numbers->list, to);
            else
                memcpy(to,
                       rows ? rows + place * stride
                            : numbers->packed + (source - numbers->first) * stride,
                       stride);
            out->holders[i] = built->chunk->samples[STP_LEVEL_COUNT - 1 - part][order->holders[i]];
        }
done:
    return status;
}

/* A vertex goes on to the chunk above as one of its samples. */
static void lend_to_vertices(stp_built_chunk *built, const stp_attribute_order *order)
{
    for (uint32_t p = 0; p < built->vertex_count; p++)
        built->vertices[p].source =
            built->sources ? built->sources[order->of_vertex[p]] : STP_SOURCE_NONE;
}

stp_status stp_chunk_numbers_make(stp_chunk_numbers *out, stp_built_chunk *built,
                                  const stp_point_numbers *numbers, const uint8_t *rows,
                                  stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    stp_attribute_order order = {0};
    gathered g = {0};
    stp_bytes bytes = {0};
    STP_TRY(stp_attribute_order_make(&order, built->chunk, err));
    STP_TRY(gather(&g, built, &order, numbers, rows, err));
    lend_to_vertices(built, &order);
    STP_TRY(stp_alloc(&out->rows, numbers->list->count, sizeof *out->rows, "attributes", err));
    const stp_attribute_numbers of_chunk = {g.packed, order.ends, g.holders};
    STP_TRY(stp_attribute_numbers_encode(numbers->list, &of_chunk, &bytes, out->rows, err));
    out->bytes = bytes.data;
    out->size = bytes.size;
    bytes = (stp_bytes){0};
    STP_TRY(stp_spill_move(spill, &out->bytes, out->size, 1, "attributes", err));
done:
    stp_attribute_order_clear(&order);
    free(g.packed);
    free(g.holders);
    free(bytes.data);
    return status;
}

void stp_chunk_numbers_clear(stp_chunk_numbers *numbers, stp_spill *spill)
{
    stp_spill_free(spill, numbers->bytes);
    free(numbers->rows);
    *numbers = (stp_chunk_numbers){0};
}
