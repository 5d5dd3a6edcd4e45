/* Sorts the parts of all blocks by their place in the file, and reads runs of them. */
#include "runtime/stream/gather.h"

#include "formats/chunk/layout.h"

#include <stdlib.h>
#include <string.h>

/* Reads over a gap of so many bytes rather than asking twice. */
#define GAP_ON_DISK (1u << 8)
#define GAP_ON_SERVER (8u << 10)

/* A part of a block, and where its bytes go. */
typedef struct span {
    uint64_t begin, end; /* in the file */
    uint32_t hash;
    uint8_t *out;
    size_t item;
} span;

static uint64_t gap_of(stp_chunk_file *file)
{
    return stp_byte_source_is_remote(stp_chunk_file_source(file)) ? GAP_ON_SERVER : GAP_ON_DISK;
}

/* Lists the parts of an item, at most STP_SEGMENT_COUNT. */
static size_t list_spans(const stp_gather_item *item, size_t index, span *out)
{
    size_t count = 0;
    uint32_t begin = 0;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        const stp_block_part *part = &item->block->parts[s];
        if (begin >= item->begin && begin + part->bytes <= item->end && part->bytes > 0)
            out[count++] = (span){.begin = part->offset,
                                  .end = part->offset + part->bytes,
                                  .hash = part->hash,
                                  .out = item->out + (begin - item->begin),
                                  .item = index};
        begin += part->bytes;
    }
    return count;
}

bool stp_gather_joins(stp_chunk_file *file, const stp_gather_item *a, const stp_gather_item *b)
{
    span of[2][STP_SEGMENT_COUNT];
    size_t count[2] = {list_spans(a, 0, of[0]), list_spans(b, 1, of[1])};
    uint64_t gap = gap_of(file);
    for (size_t i = 0; i < count[0]; i++)
        for (size_t k = 0; k < count[1]; k++) {
            const span *x = &of[0][i], *y = &of[1][k];
            const span *first = x->begin < y->begin ? x : y, *second = first == x ? y : x;
            if (second->begin - first->begin <= first->end - first->begin + gap &&
                second->end - first->begin <= STP_GATHER_BYTES)
                return true;
        }
    return false;
}

static int compare_spans(const void *a, const void *b)
{
    const span *x = a, *y = b;
    return (x->begin > y->begin) - (x->begin < y->begin);
}

/* The number of spans, from the first on, that one request brings. *end: its last byte, plus 1. */
static size_t run_of(const span *spans, size_t count, uint64_t gap, uint64_t *end)
{
    size_t run = 1;
    *end = spans[0].end;
    while (run < count && *end - spans[0].begin <= STP_GATHER_BYTES &&
           spans[run].begin - spans[0].begin <= *end - spans[0].begin + gap &&
           spans[run].end - spans[0].begin <= STP_GATHER_BYTES) {
        *end = spans[run].end > *end ? spans[run].end : *end;
        run++;
    }
    return run;
}

/* Spans that one request brings, and their items. */
typedef struct request {
    const stp_gather_item *items;
    const span *spans;
    size_t count;
} request;

/* Whether any item of a request is still wanted. */
static bool is_wanted(void *context)
{
    const request *r = context;
    for (size_t i = 0; i < r->count; i++) {
        const atomic_bool *unwanted = r->items[r->spans[i].item].unwanted;
        if (unwanted == NULL || !atomic_load(unwanted))
            return true;
    }
    return false;
}

/* Reads a run of spans by one request. A single span is read to where it goes. */
static void read_run(stp_chunk_file *file, stp_gather_item *items, const span *spans, size_t count,
                     uint64_t end, uint8_t *buffer)
{
    stp_error error = {0};
    uint64_t begin = spans[0].begin;
    stp_byte_source *source = stp_chunk_file_source(file);
    request all = {items, spans, count};
    stp_status status = stp_byte_source_read_wanted(
        source, begin, count > 1 ? buffer : spans[0].out, (size_t)(end - begin),
        &(stp_read_wish){is_wanted, &all}, &error);
    for (size_t i = 0; i < count; i++) {
        stp_gather_item *item = &items[spans[i].item];
        if (status == STP_OK && count > 1)
            memcpy(spans[i].out, buffer + (spans[i].begin - begin),
                   (size_t)(spans[i].end - spans[i].begin));
        if (status != STP_OK && item->status == STP_OK) {
            item->status = status;
            item->error = error;
        }
        const uint32_t at = item->begin + (uint32_t)(spans[i].out - item->out);
        if (status != STP_OK && at < item->got)
            item->got = at;
    }
}

/* Whether an item still gains by a run: a part is of no use where one before it did not come. */
static bool is_useful(const stp_gather_item *items, const span *spans, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (items[spans[i].item].status == STP_OK)
            return true;
    return false;
}

/* Whether a server sent other bytes than the file has. */
static bool is_wrong(const span *s, const stp_gather_item *items)
{
    return items[s->item].status == STP_OK &&
           (uint32_t)stp_hash(s->out, (size_t)(s->end - s->begin)) != s->hash;
}

/* Reads one item. A request brings the parts that lie together; those that came are kept if the
 * next request fails. */
static uint64_t fetch(stp_chunk_file *file, stp_gather_item *item)
{
    const stp_block_part *parts = item->block->parts;
    uint32_t end = 0;
    item->got = item->begin;
    item->status = STP_OK;
    for (int s = 0; s < STP_SEGMENT_COUNT && item->got < item->end; s++) {
        end += parts[s].bytes;
        bool joins =
            s + 1 < STP_SEGMENT_COUNT && parts[s + 1].offset == parts[s].offset + parts[s].bytes;
        if (end <= item->got || (joins && end < item->end))
            continue;
        end = end < item->end ? end : item->end;
        item->status = stp_block_fetch(file, item->block, item->got, end,
                                       item->out + (item->got - item->begin), &item->error);
        if (item->status != STP_OK)
            break;
        item->got = end;
    }
    return item->end - item->begin;
}

uint64_t stp_gather_read(stp_chunk_file *file, stp_gather_item *items, size_t count,
                         uint8_t *buffer)
{
    span spans[STP_GATHER_BLOCKS * STP_SEGMENT_COUNT];
    size_t span_count = 0;
    uint64_t read = 0, end = 0;
    const bool remote = stp_byte_source_is_remote(stp_chunk_file_source(file));
    if (count == 1 && !remote)
        return fetch(file, &items[0]);
    for (size_t i = 0; i < count; i++) {
        items[i].got = items[i].end;
        span_count += list_spans(&items[i], i, spans + span_count);
    }
    qsort(spans, span_count, sizeof *spans, compare_spans);
    for (size_t i = 0, run; i < span_count; i += run) {
        run = run_of(spans + i, span_count - i, gap_of(file), &end);
        if (!is_useful(items, spans + i, run))
            continue;
        read_run(file, items, spans + i, run, end, buffer);
        read += end - spans[i].begin;
    }
    for (size_t i = 0; i < span_count && remote; i++)
        if (is_wrong(&spans[i], items))
            read += fetch(file, &items[spans[i].item]);
    return read;
}
