/* The items of a LAZ point: groups of fields that are coded together, to pack and to unpack.
 *
 * A record is its items one behind the other: POINT10 (20 bytes, point formats 0 to 5) or POINT14
 * (30, formats 6 to 10), then time, colour, waveform, extra bytes. In files of formats 0 to 5 all
 * items of a point share one stream. In files of formats 6 to 10 ("layered") an item has a stream
 * for each of its layers. Both keep models in their state and predict a point from those before it
 * in the chunk. Source: LASzip's item versions 1 to 4. Threads: one at a time per state. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_ITEM_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_ITEM_H

#include "formats/scan/las/laz/laz_stream.h"

enum {
    STP_LAZ_BYTES = 0,
    STP_LAZ_POINT10 = 6,
    STP_LAZ_TIME11 = 7,
    STP_LAZ_RGB12 = 8,
    STP_LAZ_WAVE13 = 9,
    STP_LAZ_POINT14 = 10,
    STP_LAZ_RGB14 = 11,
    STP_LAZ_RGBNIR14 = 12,
    STP_LAZ_WAVE14 = 13,
    STP_LAZ_BYTES14 = 14
};

#define STP_LAZ_POINT10_BYTES 20u
#define STP_LAZ_POINT14_BYTES 30u
/* Layers of POINT14: returns with x and y; z; class; flags; intensity; angle; user data; source;
 * time. */
#define STP_LAZ_POINT14_LAYERS 9u
/* A point belongs to one of four scanner channels, each with models of its own. */
#define STP_LAZ_CHANNELS 4u

typedef struct stp_laz_coder {
    uint16_t type, version; /* of the item */
    uint16_t bytes;         /* of the item; 0: any number up to bytes_most */
    uint16_t bytes_most;
    uint16_t layers; /* 0: not layered */
    bool skipped;    /* its layers are not decoded: the item is zero */
    bool packs;      /* next goes both ways; else it only unpacks */
    size_t state_bytes;
    /* Gives the state's models their memory. */
    void (*place)(void *state, unsigned bytes, stp_laz_arena *arena);
    /* Begins a chunk, from its first point's item as it stands. channel, and the result: as next.
     */
    unsigned (*begin)(void *state, const unsigned char *first, unsigned channel);
    /* Codes the item of the next point, which a stream that unpacks puts to `item`, and one that
     * packs takes from there. layers: the stream, or one for each layer; a layer that is absent has
     * length 0. Returns the channel for the point's next item: POINT14 sets it, others pass it on.
     */
    unsigned (*next)(void *state, stp_laz_stream *layers, unsigned channel, unsigned char *item);
} stp_laz_coder;

/* NULL: not known. */
const stp_laz_coder *stp_laz_coder_find(unsigned type, unsigned version);

extern const stp_laz_coder stp_laz_point10_v1, stp_laz_point10_v2, stp_laz_time11_v1,
    stp_laz_time11_v2, stp_laz_rgb12_v1, stp_laz_rgb12_v2, stp_laz_wave13, stp_laz_bytes_v1,
    stp_laz_bytes_v2, stp_laz_point14_v3, stp_laz_point14_v4, stp_laz_rgb14_v3, stp_laz_rgb14_v4,
    stp_laz_rgbnir14_v3, stp_laz_rgbnir14_v4, stp_laz_bytes14_v3, stp_laz_bytes14_v4;

#endif
