/* All items of a point. */
#include "formats/scan/las/laz/laz_items.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* Gives the models their memory, or counts it. */
static void place_models(stp_laz_items *items, stp_laz_arena *arena)
{
    const stp_laz_layout *layout = items->layout;
    for (unsigned i = 0; i < layout->item_count; i++)
        if (!layout->items[i].coder->skipped)
            layout->items[i].coder->place(items->states[i], layout->items[i].bytes, arena);
}

stp_status stp_laz_items_create(stp_laz_items *out, const stp_laz_layout *layout, stp_error *err)
{
    stp_status status = STP_OK;
    stp_laz_arena arena = {0};
    out->layout = layout;
    for (unsigned i = 0; i < layout->item_count; i++) {
        STP_TRY(
            stp_alloc(&out->states[i], 1, layout->items[i].coder->state_bytes, "LAZ models", err));
        out->stream_count += stp_laz_item_layers(layout, i);
    }
    if (!layout->layered)
        out->stream_count = 1;
    place_models(out, &arena);
    STP_TRY(stp_alloc(&out->words, arena.used, sizeof *out->words, "LAZ models", err));
    arena = (stp_laz_arena){.words = out->words};
    place_models(out, &arena);
    STP_TRY(stp_alloc(&out->streams, out->stream_count, sizeof *out->streams, "LAZ layers", err));
done:
    return status;
}

void stp_laz_items_begin(stp_laz_items *items, const unsigned char *first)
{
    const stp_laz_layout *layout = items->layout;
    unsigned channel = 0;
    for (unsigned i = 0; i < layout->item_count; i++) {
        if (!layout->items[i].coder->skipped)
            channel = layout->items[i].coder->begin(items->states[i], first, channel);
        first += layout->items[i].bytes;
    }
}

void stp_laz_items_next(stp_laz_items *items, unsigned char *record)
{
    const stp_laz_layout *layout = items->layout;
    unsigned layer = 0, channel = 0;
    for (unsigned i = 0; i < layout->item_count; i++) {
        const stp_laz_coder *coder = layout->items[i].coder;
        if (coder->skipped)
            memset(record, 0, layout->items[i].bytes);
        else
            channel = coder->next(items->states[i], &items->streams[layer], channel, record);
        record += layout->items[i].bytes;
        layer += stp_laz_item_layers(layout, i);
    }
}

void stp_laz_items_free(stp_laz_items *items)
{
    for (unsigned i = 0; i < STP_LAZ_ITEMS_MOST; i++)
        free(items->states[i]);
    for (unsigned i = 0; items->streams && i < items->stream_count; i++)
        stp_laz_stream_free(&items->streams[i]);
    free(items->streams);
    free(items->words);
    *items = (stp_laz_items){0};
}
