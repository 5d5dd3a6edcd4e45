/* Reads how the points of a LAZ file are packed. */
#include "formats/scan/las/laz_layout.h"

#include "base/memory.h"
#include "formats/scan/las/las_bytes.h"
#include "formats/scan/las/laz_decoder.h"

#include <stdlib.h>

/* The record: u16 way of packing, u16 coder, u8 u8 u16 version, u32 options, u32 points of a chunk,
 * i64 i64 special records, u16 items; then u16 type, u16 bytes, u16 version of each item. */
#define RECORD_BYTES 34u
#define ITEM_BYTES 6u
enum { AT_CHUNK_POINTS = 12, AT_ITEM_COUNT = 32 };
enum { WAY_POINTS = 1, WAY_CHUNKS = 2, WAY_LAYERS = 3 };

/* The table: u32 version, u32 chunks, then the chunks' points (if they vary) and bytes, coded. */
#define TABLE_PLACE_BYTES 8u
#define TABLE_HEAD_BYTES 8u
enum { CONTEXT_POINTS = 0, CONTEXT_BYTES = 1 };

/* ---- the record ---- */

static stp_status take_item(stp_laz_layout *out, const unsigned char *at, const char *path,
                            stp_error *err)
{
    const unsigned type = stp_las_u16(at), bytes = stp_las_u16(at + 2),
                   version = stp_las_u16(at + 4);
    const stp_laz_coder *coder = stp_laz_coder_find(type, version);
    if (!coder)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: its LAZ has an item of type %u in version %u, which this program "
                             "does not know: unpack the file (laszip -i in.laz -o out.las)",
                             path, type, version);
    const bool fits = coder->bytes ? coder->bytes == bytes : bytes > 0;
    if (!fits || (coder->layers > 0) != out->layered)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: its LAZ record has an item of type %u with %u bytes, which does "
                             "not belong there: the file is damaged; copy it again",
                             path, type, bytes);
    if (!coder->bytes && bytes > coder->bytes_most)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: its points have %u extra bytes in LAZ of version %u, and at most "
                             "%u are read: unpack the file (laszip -i in.laz -o out.las)",
                             path, bytes, version, coder->bytes_most);
    out->items[out->item_count].coder = coder;
    out->items[out->item_count++].bytes = bytes;
    return STP_OK;
}

/* Checks that the items make up a record of the header's point format. */
static stp_status check_items(const stp_laz_layout *layout, const stp_las_header *header,
                              const char *path, stp_error *err)
{
    const unsigned type = layout->items[0].coder->type;
    unsigned bytes = 0;
    for (unsigned i = 0; i < layout->item_count; i++)
        bytes += layout->items[i].bytes;
    if (bytes == header->record_bytes &&
        type == (header->format->extended ? STP_LAZ_POINT14 : STP_LAZ_POINT10))
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: its LAZ record describes points of %u bytes, its header points of "
                         "format %u with %u bytes: the file is damaged; copy it again",
                         path, bytes, header->point_format, header->record_bytes);
}

stp_status stp_laz_layout_read(stp_laz_layout *out, const stp_las_record *record,
                               const stp_las_header *header, const char *path, stp_error *err)
{
    stp_laz_layout layout = {0};
    const unsigned char *bytes = record->bytes;
    if (record->length < RECORD_BYTES)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: is compressed LAS (LAZ) without the record that says how: the "
                             "file is damaged; copy or export it again",
                             path);
    const unsigned way = stp_las_u16(bytes), coder = stp_las_u16(bytes + 2);
    const unsigned count = stp_las_u16(bytes + AT_ITEM_COUNT);
    if (way < WAY_POINTS || way > WAY_LAYERS || coder != 0)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: its LAZ is packed in way %u with coder %u, which this program "
                             "does not know: unpack the file (laszip -i in.laz -o out.las)",
                             path, way, coder);
    layout.layered = way == WAY_LAYERS;
    layout.chunked = way != WAY_POINTS;
    layout.chunk_points = stp_las_u32(bytes + AT_CHUNK_POINTS);
    if (count == 0 || count > STP_LAZ_ITEMS_MOST ||
        record->length < RECORD_BYTES + count * (size_t)ITEM_BYTES ||
        (layout.chunked && layout.chunk_points == 0))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: its LAZ record names %u items and chunks of %u points: the file "
                             "is damaged; copy or export it again",
                             path, count, layout.chunk_points);
    for (unsigned i = 0; i < count; i++) {
        stp_status status =
            take_item(&layout, bytes + RECORD_BYTES + i * (size_t)ITEM_BYTES, path, err);
        if (status != STP_OK)
            return status;
    }
    stp_status status = check_items(&layout, header, path, err);
    if (status == STP_OK)
        *out = layout;
    return status;
}

unsigned stp_laz_item_layers(const stp_laz_layout *layout, unsigned item)
{
    const stp_laz_coder *coder = layout->items[item].coder;
    return coder->type == STP_LAZ_BYTES14 ? layout->items[item].bytes : coder->layers;
}

/* ---- the table of chunks ---- */

stp_status stp_laz_chunks_add(stp_laz_chunks *chunks, uint64_t begin, uint64_t first,
                              stp_error *err)
{
    stp_status status = stp_grow(&chunks->list, &chunks->capacity, chunks->count + 1,
                                 sizeof *chunks->list, "chunks of points", err);
    if (status == STP_OK)
        chunks->list[chunks->count++] = (stp_laz_chunk){begin, first, 0};
    return status;
}

void stp_laz_chunks_free(stp_laz_chunks *chunks)
{
    free(chunks->list);
    *chunks = (stp_laz_chunks){0};
}

/* What reading a table needs. */
typedef struct table {
    stp_laz_decoder decoder;
    stp_laz_integer number;
    uint16_t *words;
    uint64_t begin, end; /* in the file */
} table;

/* Finds where the table begins: the points' begin says so, or the end of a file that was written
 * without going back. */
static bool find_table(table *t, const stp_las_header *header, int descriptor, uint64_t file_bytes)
{
    unsigned char bytes[TABLE_PLACE_BYTES];
    t->end = file_bytes;
    stp_laz_decoder_open(&t->decoder, descriptor, header->point_offset, file_bytes);
    stp_laz_decoder_raw(&t->decoder, bytes, sizeof bytes);
    t->begin = stp_las_u64(bytes);
    if (t->begin == UINT64_MAX && file_bytes > TABLE_PLACE_BYTES) {
        stp_laz_decoder_open(&t->decoder, descriptor, file_bytes - TABLE_PLACE_BYTES, file_bytes);
        stp_laz_decoder_raw(&t->decoder, bytes, sizeof bytes);
        t->begin = stp_las_u64(bytes);
    }
    return !t->decoder.cut && t->begin >= header->point_offset + TABLE_PLACE_BYTES &&
           t->begin < file_bytes && file_bytes - t->begin >= TABLE_HEAD_BYTES;
}

/* Reads the entries; false if they do not fit the file. */
static bool read_entries(stp_laz_chunks *out, table *t, const stp_laz_layout *layout,
                         const stp_las_header *header, stp_status *status, stp_error *err)
{
    const bool varies = layout->chunk_points == UINT32_MAX;
    unsigned char head[TABLE_HEAD_BYTES];
    uint64_t begin = out->list[0].begin, first = 0;
    int32_t points = 0, bytes = 0;
    stp_laz_decoder_open(&t->decoder, t->decoder.descriptor, t->begin, t->end);
    stp_laz_decoder_raw(&t->decoder, head, sizeof head);
    const uint32_t count = stp_las_u32(head + 4);
    if (stp_las_u32(head) != 0 || count == 0)
        return false;
    stp_laz_decoder_begin(&t->decoder, 1);
    for (uint32_t i = 0; i < count; i++) {
        if (varies)
            points = stp_laz_decode_integer(&t->decoder, &t->number, points, CONTEXT_POINTS);
        bytes = stp_laz_decode_integer(&t->decoder, &t->number, bytes, CONTEXT_BYTES);
        if (t->decoder.cut || (uint32_t)bytes > t->begin - begin ||
            (uint32_t)bytes < header->record_bytes)
            return false;
        begin += (uint32_t)bytes;
        first += varies ? (uint32_t)points : layout->chunk_points;
        *status = stp_laz_chunks_add(out, begin, first, err);
        if (*status != STP_OK)
            return false;
    }
    return first >= header->point_count;
}

stp_status stp_laz_chunks_read(stp_laz_chunks *out, const stp_laz_layout *layout,
                               const stp_las_header *header, int descriptor, uint64_t file_bytes,
                               const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_laz_chunks chunks = {.end = file_bytes};
    stp_laz_arena arena = {0};
    table *t = NULL;
    STP_TRY(stp_alloc(&t, 1, sizeof *t, "a table of chunks", err));
    STP_TRY(stp_laz_chunks_add(
        &chunks, header->point_offset + (layout->chunked ? TABLE_PLACE_BYTES : 0), 0, err));
    stp_laz_integer_place(&t->number, 32, 2, &arena);
    STP_TRY(stp_alloc(&t->words, arena.used, sizeof *t->words, "a table of chunks", err));
    arena = (stp_laz_arena){.words = t->words};
    stp_laz_integer_place(&t->number, 32, 2, &arena);
    if (layout->chunked && header->point_count > 0) {
        if (find_table(t, header, descriptor, file_bytes)) {
            chunks.complete = read_entries(&chunks, t, layout, header, &status, err);
            chunks.end = chunks.complete ? t->begin : file_bytes;
        }
        if (status != STP_OK)
            goto done;
        if (!chunks.complete && !layout->layered && layout->chunk_points == UINT32_MAX) {
            status = stp_error_set(err, STP_CORRUPT,
                                   "%s: its table of chunks is missing or damaged, and without it "
                                   "its points cannot be found: the file was cut; copy it again",
                                   path);
            goto done;
        }
        if (!chunks.complete)
            chunks.count = 1;
    }
    *out = chunks;
    chunks = (stp_laz_chunks){0};
done:
    if (t)
        free(t->words);
    free(t);
    stp_laz_chunks_free(&chunks);
    return status;
}
