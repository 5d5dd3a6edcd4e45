/* Reads and writes the table of chunks of a LAZ file. */
#include "formats/scan/las/laz/laz_chunks.h"

#include "base/memory.h"
#include "formats/scan/las/las_bytes.h"
#include "formats/scan/las/laz/laz_stream.h"

#include <stdlib.h>

/* The table: u32 version, u32 chunks, then the chunks' points (if they vary) and bytes, coded. */
#define TABLE_HEAD_BYTES 8u
enum { CONTEXT_POINTS = 0, CONTEXT_BYTES = 1 };

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

/* What reading or writing a table needs. */
typedef struct table {
    stp_laz_stream stream;
    stp_laz_integer number;
    uint16_t *words;
    uint64_t begin, end; /* in the file */
} table;

static void table_free(table *t)
{
    if (!t)
        return;
    stp_laz_stream_free(&t->stream);
    free(t->words);
    free(t);
}

static stp_status table_create(table **out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_laz_arena arena = {0};
    table *t = NULL;
    STP_TRY(stp_alloc(&t, 1, sizeof *t, "a table of chunks", err));
    stp_laz_integer_place(&t->number, 32, 2, &arena);
    STP_TRY(stp_alloc(&t->words, arena.used, sizeof *t->words, "a table of chunks", err));
    arena = (stp_laz_arena){.words = t->words};
    stp_laz_integer_place(&t->number, 32, 2, &arena);
    *out = t;
    t = NULL;
done:
    table_free(t);
    return status;
}

/* Finds where the table begins: the points' begin says so, or the end of a file that was written
 * without going back. */
static bool find_table(table *t, const stp_las_header *header, int descriptor, uint64_t file_bytes)
{
    unsigned char bytes[STP_LAZ_TABLE_PLACE_BYTES];
    t->end = file_bytes;
    stp_laz_stream_open(&t->stream, descriptor, header->point_offset, file_bytes);
    stp_laz_stream_raw(&t->stream, bytes, sizeof bytes);
    t->begin = stp_las_u64(bytes);
    if (t->begin == UINT64_MAX && file_bytes > STP_LAZ_TABLE_PLACE_BYTES) {
        stp_laz_stream_open(&t->stream, descriptor, file_bytes - STP_LAZ_TABLE_PLACE_BYTES,
                            file_bytes);
        stp_laz_stream_raw(&t->stream, bytes, sizeof bytes);
        t->begin = stp_las_u64(bytes);
    }
    return !t->stream.cut && t->begin >= header->point_offset + STP_LAZ_TABLE_PLACE_BYTES &&
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
    stp_laz_stream_open(&t->stream, t->stream.descriptor, t->begin, t->end);
    stp_laz_stream_raw(&t->stream, head, sizeof head);
    const uint32_t count = stp_las_u32(head + 4);
    if (stp_las_u32(head) != 0 || count == 0)
        return false;
    stp_laz_stream_begin(&t->stream, 1);
    for (uint32_t i = 0; i < count; i++) {
        if (varies)
            points = stp_laz_decode_integer(&t->stream, &t->number, points, CONTEXT_POINTS);
        bytes = stp_laz_decode_integer(&t->stream, &t->number, bytes, CONTEXT_BYTES);
        if (t->stream.cut || (uint32_t)bytes > t->begin - begin ||
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
    table *t = NULL;
    STP_TRY(table_create(&t, err));
    STP_TRY(stp_laz_chunks_add(
        &chunks, header->point_offset + (layout->chunked ? STP_LAZ_TABLE_PLACE_BYTES : 0), 0, err));
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
    table_free(t);
    stp_laz_chunks_free(&chunks);
    return status;
}

stp_status stp_laz_chunks_write(const uint32_t *bytes, uint32_t count, stp_output *output,
                                stp_error *err)
{
    stp_status status = STP_OK;
    unsigned char head[TABLE_HEAD_BYTES] = {0};
    int32_t last = 0;
    table *t = NULL;
    STP_TRY(table_create(&t, err));
    stp_las_put_u32(head + 4, count);
    STP_TRY(stp_output_write(output, head, sizeof head, err));
    stp_laz_stream_pack(&t->stream, 1);
    for (uint32_t i = 0; i < count; i++)
        last = stp_laz_code_integer(&t->stream, &t->number, last, CONTEXT_BYTES, (int32_t)bytes[i]);
    const size_t size = count > 0 ? stp_laz_stream_finish(&t->stream) : 0;
    if (t->stream.cut)
        status =
            stp_error_set(err, STP_OUT_OF_MEMORY,
                          "no memory for a table of chunks: close other programs or write LAS");
    else
        status = stp_output_write(output, t->stream.packed, size, err);
done:
    table_free(t);
    return status;
}
