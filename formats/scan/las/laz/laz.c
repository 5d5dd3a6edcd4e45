/* Unpacks the points of a LAZ file, chunk by chunk. */
#include "formats/scan/las/laz/laz.h"

#include "base/memory.h"
#include "formats/scan/las/las_bytes.h"
#include "formats/scan/las/laz/laz_chunks.h"
#include "formats/scan/las/laz/laz_items.h"
#include "formats/scan/remote/mirror.h"

#include <stdlib.h>
#include <string.h>

/* Layers that stipple reads: of POINT14 up to intensity, and colour. */
#define POINT14_LAYERS_READ 5u
/* Points that a seek unpacks at once. */
#define SKIP_POINTS 64u

struct stp_laz {
    stp_laz_params params;
    stp_laz_layout layout;
    stp_laz_chunks chunks;
    stp_laz_items items;
    uint32_t *layer_bytes; /* of the chunk */
    uint32_t epoch;        /* number of chunks opened */
    size_t chunk;          /* the chunk that is read */
    uint64_t next, end;    /* points; end: behind the chunk's last. next = end: none is open */
    bool begun;            /* the chunk's first point was unpacked */
    bool chosen;           /* chunks are nodes that were chosen, each with a count of its own */
    unsigned char *first;  /* the chunk's first record */
};

static stp_status damaged(const stp_laz *laz, const char *what, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: point %llu of %llu: %s: the file was cut or damaged; copy or export "
                         "it again",
                         laz->params.source->path, (unsigned long long)laz->next,
                         (unsigned long long)laz->params.header->point_count, what);
}

/* Says what a decoder met, if it ran out of bytes. */
static stp_status check_decoders(const stp_laz *laz, stp_error *err)
{
    for (unsigned i = 0; i < laz->items.stream_count; i++) {
        const stp_laz_stream *d = &laz->items.streams[i];
        if (d->io_error)
            return stp_error_set(err, STP_IO, "%s: byte %llu: %s", laz->params.source->path,
                                 (unsigned long long)d->next, strerror(d->io_error));
        if (d->cut)
            return damaged(laz, "its chunk ends too early", err);
    }
    return STP_OK;
}

/* ---- opening ---- */

stp_status stp_laz_open(stp_laz **out, const stp_laz_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_laz *laz = NULL;
    const stp_source *source = params->source;
    STP_TRY(stp_alloc(&laz, 1, sizeof *laz, "LAZ reader", err));
    laz->params = *params;
    STP_TRY(stp_laz_layout_read(&laz->layout, params->record, params->header, source->path, err));
    STP_TRY(stp_laz_items_create(&laz->items, &laz->layout, err));
    STP_TRY(stp_alloc(&laz->layer_bytes, laz->items.stream_count, sizeof *laz->layer_bytes,
                      "LAZ layers", err));
    STP_TRY(stp_alloc(&laz->first, 1, params->header->record_bytes, "a record", err));
    laz->chosen = params->chosen != NULL;
    if (laz->chosen) {
        laz->chunks = *params->chosen;
        *params->chosen = (stp_laz_chunks){0};
    } else {
        STP_TRY(stp_laz_chunks_read(&laz->chunks, &laz->layout, params->header, source->descriptor,
                                    source->size, source->path, err));
    }
    *out = laz;
    laz = NULL;
done:
    stp_laz_close(&laz);
    return status;
}

void stp_laz_close(stp_laz **laz)
{
    stp_laz *l = *laz;
    if (!l)
        return;
    stp_laz_items_free(&l->items);
    stp_laz_chunks_free(&l->chunks);
    free(l->layer_bytes);
    free(l->first);
    free(l);
    *laz = NULL;
}

/* ---- a chunk ---- */

/* Whether a layer is unpacked. layer: within its item. */
static bool is_wanted(const stp_laz *laz, unsigned item, unsigned layer)
{
    const stp_laz_coder *coder = laz->layout.items[item].coder;
    const bool read = coder->type == STP_LAZ_POINT14 ? layer < POINT14_LAYERS_READ
                                                     : layer == 0 && coder->type != STP_LAZ_BYTES14;
    return !coder->skipped && (read || laz->params.all_fields);
}

/* Opens the decoders of a layered chunk, whose layers begin at a place of the file. *behind: where
 * they end. */
static stp_status open_layers(stp_laz *laz, uint64_t begin, uint64_t end, uint64_t *behind,
                              stp_error *err)
{
    const int descriptor = laz->params.source->descriptor;
    unsigned layer = 0;
    for (unsigned item = 0; item < laz->layout.item_count; item++) {
        const unsigned count = stp_laz_item_layers(&laz->layout, item);
        for (unsigned l = 0; l < count; l++, layer++) {
            const uint32_t bytes = laz->layer_bytes[layer];
            stp_laz_stream *d = &laz->items.streams[layer];
            if (bytes > end - begin)
                return damaged(laz, "a layer of its chunk is longer than the chunk", err);
            stp_laz_stream_open(d, descriptor, begin, begin + bytes);
            if (bytes > 0 && is_wanted(laz, item, l))
                stp_laz_stream_begin(d, laz->epoch);
            else
                d->length = 0;
            begin += bytes;
        }
    }
    *behind = begin;
    return STP_OK;
}

/* Adds the chunk behind the one that is open, if no table told it. */
static stp_status learn_next(stp_laz *laz, uint64_t begin, stp_error *err)
{
    if (laz->chunks.complete || laz->chunk + 1 < laz->chunks.count)
        return STP_OK;
    return stp_laz_chunks_add(&laz->chunks, begin, laz->end, err);
}

/* Where a chunk ends at the latest, in the file. */
static uint64_t chunk_limit(const stp_laz *laz, size_t index)
{
    const stp_laz_chunk *chunk = &laz->chunks.list[index];
    if (chunk->end > 0)
        return chunk->end;
    return index + 1 < laz->chunks.count ? chunk[1].begin : laz->chunks.end;
}

/* Points of a chunk by table or header. */
static uint64_t chunk_points(const stp_laz *laz, size_t index)
{
    const uint64_t first = laz->chunks.list[index].first;
    const uint64_t left = laz->params.header->point_count - first;
    uint64_t points = laz->layout.chunked ? laz->layout.chunk_points : left;
    if (index + 1 < laz->chunks.count)
        points = laz->chunks.list[index + 1].first - first;
    return points < left ? points : left;
}

/* Reads the count of points and the sizes of layers that follow the first record. */
static stp_status begin_layered(stp_laz *laz, size_t index, stp_error *err)
{
    stp_status status = STP_OK;
    stp_laz_stream *d = &laz->items.streams[0];
    unsigned char bytes[4];
    uint64_t behind = 0;
    stp_laz_stream_raw(d, bytes, sizeof bytes);
    const uint32_t points = stp_las_u32(bytes);
    for (unsigned i = 0; i < laz->items.stream_count; i++) {
        stp_laz_stream_raw(d, bytes, sizeof bytes);
        laz->layer_bytes[i] = stp_las_u32(bytes);
    }
    STP_TRY(check_decoders(laz, err));
    if (laz->layout.chunk_points == UINT32_MAX && !laz->chunks.complete)
        laz->end = laz->chunks.list[index].first + points;
    if (points < laz->end - laz->next || (laz->chosen && points != laz->end - laz->next)) {
        status = damaged(laz,
                         laz->chosen ? "its chunk has not as many points as the hierarchy says"
                                     : "its chunk has fewer points than the table of chunks says",
                         err);
        goto done;
    }
    STP_TRY(open_layers(laz, stp_laz_stream_place(d), chunk_limit(laz, index), &behind, err));
    if (laz->end - laz->next > 1 && laz->items.streams[0].length == 0) {
        status = damaged(laz, "its chunk has no positions", err);
        goto done;
    }
    STP_TRY(learn_next(laz, behind, err));
done:
    return status;
}

static stp_status open_chunk(stp_laz *laz, size_t index, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t begin = laz->chunks.list[index].begin, end = chunk_limit(laz, index);
    stp_laz_stream *d = &laz->items.streams[0];
    laz->chunk = index;
    laz->next = laz->chunks.list[index].first;
    laz->end = laz->next; /* none is open until all is well */
    for (unsigned i = 0; i < laz->items.stream_count; i++)
        laz->items.streams[i].cut = false;
    if (begin > end)
        return damaged(laz, "its chunk lies outside of the file", err);
    if (laz->params.source->mirror)
        STP_TRY(stp_mirror_need(laz->params.source->mirror, begin, end, err));
    stp_laz_stream_open(d, laz->params.source->descriptor, begin, end);
    stp_laz_stream_raw(d, laz->first, laz->params.header->record_bytes);
    STP_TRY(check_decoders(laz, err));
    laz->epoch++;
    laz->begun = false;
    stp_laz_items_begin(&laz->items, laz->first);
    laz->end = laz->next + chunk_points(laz, index);
    if (laz->layout.layered)
        status = begin_layered(laz, index, err);
    if (status != STP_OK)
        laz->end = laz->next;
done:
    return status;
}

/* ---- points ---- */

/* Unpacks count points of the open chunk. */
static void unpack_run(stp_laz *laz, unsigned char *records, size_t count)
{
    const size_t bytes = laz->params.header->record_bytes;
    size_t i = 0;
    if (!laz->begun && count > 0) {
        memcpy(records, laz->first, bytes);
        /* Behind a chunk's only point nothing is told, and some writers leave the code out. */
        if (!laz->layout.layered && (laz->end - laz->next > 1 || !laz->chunks.complete))
            stp_laz_stream_begin(&laz->items.streams[0], laz->epoch);
        laz->begun = true;
        i = 1;
    }
    for (; i < count; i++)
        stp_laz_items_next(&laz->items, records + i * bytes);
    laz->next += count;
}

/* Opens the chunk behind the one that has ended. */
static stp_status next_chunk(stp_laz *laz, stp_error *err)
{
    const bool first = laz->epoch == 0;
    const size_t index = first ? 0 : laz->chunk + 1;
    if (index + laz->chunks.complete >= laz->chunks.count)
        return damaged(laz, "there is no chunk for it", err);
    return open_chunk(laz, index, err);
}

stp_status stp_laz_read(stp_laz *laz, unsigned char *records, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    while (count > 0) {
        if (laz->next == laz->end)
            STP_TRY(next_chunk(laz, err));
        const uint64_t left = laz->end - laz->next;
        const size_t part = left < count ? (size_t)left : count;
        unpack_run(laz, records, part);
        STP_TRY(check_decoders(laz, err));
        if (laz->next == laz->end && !laz->layout.layered)
            STP_TRY(learn_next(laz, stp_laz_stream_place(&laz->items.streams[0]), err));
        records += part * laz->params.header->record_bytes;
        count -= part;
    }
done:
    return status;
}

/* The last known chunk that begins at or before a point. */
static size_t find_chunk(const stp_laz *laz, uint64_t point)
{
    size_t low = 0, high = laz->chunks.count - laz->chunks.complete;
    while (high > low + 1) {
        const size_t middle = low + (high - low) / 2;
        if (laz->chunks.list[middle].first <= point)
            low = middle;
        else
            high = middle;
    }
    return low;
}

uint64_t stp_laz_chunk_points(const stp_laz *laz)
{
    const bool even = laz->layout.chunked && laz->layout.chunk_points != UINT32_MAX;
    return even ? laz->layout.chunk_points : 0;
}

uint64_t stp_laz_chunk_begin(const stp_laz *laz, uint64_t point)
{
    return laz->chunks.list[find_chunk(laz, point)].first;
}

uint64_t stp_laz_chunk_at(const stp_laz *laz, uint64_t point)
{
    const size_t index = find_chunk(laz, point);
    const bool begins = laz->chunks.complete && point < laz->params.header->point_count &&
                        laz->chunks.list[index].first == point;
    return begins ? chunk_points(laz, index) : 0;
}

uint64_t stp_laz_chunk_left(const stp_laz *laz)
{
    return laz->end - laz->next;
}

stp_status stp_laz_seek(stp_laz *laz, uint64_t point, stp_error *err)
{
    stp_status status = STP_OK;
    unsigned char *skipped = NULL;
    if (laz->epoch > 0 && point == laz->next)
        return STP_OK;
    const size_t index = find_chunk(laz, point);
    const bool ahead = laz->epoch > 0 && index == laz->chunk && point > laz->next;
    if (!ahead)
        STP_TRY(open_chunk(laz, index, err));
    STP_TRY(stp_alloc(&skipped, SKIP_POINTS, laz->params.header->record_bytes, "records", err));
    while (laz->next < point) {
        const uint64_t left = point - laz->next;
        STP_TRY(stp_laz_read(laz, skipped, left < SKIP_POINTS ? (size_t)left : SKIP_POINTS, err));
    }
done:
    free(skipped);
    return status;
}
