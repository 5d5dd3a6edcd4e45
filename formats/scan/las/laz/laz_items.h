/* All items of a point: their models, and a stream for each layer. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_ITEMS_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_ITEMS_H

#include "base/error.h"
#include "formats/scan/las/laz/laz_layout.h"

typedef struct stp_laz_items {
    const stp_laz_layout *layout; /* borrowed */
    void *states[STP_LAZ_ITEMS_MOST];
    uint16_t *words;         /* of all models */
    unsigned stream_count;   /* one for each layer; not layered: one for all */
    stp_laz_stream *streams; /* owned; zero at first */
} stp_laz_items;

/* *out must be zero. Free it even after a failure. Errors: OUT_OF_MEMORY. */
stp_status stp_laz_items_create(stp_laz_items *out, const stp_laz_layout *layout, stp_error *err);
/* Begins a chunk, from its first record. */
void stp_laz_items_begin(stp_laz_items *items, const unsigned char *first);
/* Unpacks the next record of the chunk, or packs it: as the streams do. */
void stp_laz_items_next(stp_laz_items *items, unsigned char *record);
void stp_laz_items_free(stp_laz_items *items);

#endif
