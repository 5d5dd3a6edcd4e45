/* Sorts the parts of all blocks by their place in the file, and reads runs of them. */
#include "runtime/stream/gather.h"

#include "formats/chunk/layout.h"

#include <stdlib.h>
#include <string.h>

/* A part of a block. */
typedef struct span {
    uint64_t offset, end; /* in the file */
    uint8_t *out;
    uint32_t hash;
    size_t item;
} span;

/* Lists the parts of an item, at most STP_SEGMENT_COUNT. */
static size_t list_spans(const stp_gather_item *item, size_t index, span *out)
{
    size_t count = 0;
    uint32_t begin = 0;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        const stp_block_part *part = &item->block->parts[s];
        if (begin >= item->begin && begin + part->bytes <= item->end && part->bytes > 0)
            out[count++] = (span){.offset = part->offset,
                                  .end = part->offset + part->bytes,
                                  .out = item->out + (begin - item->begin),
                                  .hash = part->hash,
                                  .item = index};
        begin += part->bytes;
    }
    return count;
}

bool stp_gather_joins(stp_chunk_file *file, const stp_gather_item *a, const stp_gather_item *b)
{
    span of[2][STP_SEGMENT_COUNT];
    size_t count[2] = {list_spans(a, 0, of[0]), list_spans(b, 1, of[1])};
    const uint32_t gap = stp_byte_source_gap(stp_chunk_file_source(file));
    for (size_t i = 0; i < count[0]; i++)
        for (size_t k = 0; k < count[1]; k++) {
            const span *x = &of[0][i], *y = &of[1][k];
            const span *first = x->offset < y->offset ? x : y, *second = first == x ? y : x;
            if (second->offset - first->offset <= first->end - first->offset + gap &&
                second->end - first->offset <= STP_SOURCE_REQUEST_BYTES)
                return true;
        }
    return false;
}

static int compare_spans(const void *a, const void *b)
{
    const span *x = a, *y = b;
    return (x->offset > y->offset) - (x->offset < y->offset);
}

typedef struct group {
    const stp_gather_item *items;
    size_t count;
} group;

/* Whether any item is still wanted. */
static bool is_wanted(void *context)
{
    const group *g = context;
    for (size_t i = 0; i < g->count; i++) {
        const atomic_bool *unwanted = g->items[i].unwanted;
        if (unwanted == NULL || !atomic_load(unwanted))
            return true;
    }
    return false;
}

/* Ends an item before a part that did not come. */
static void end_item(stp_gather_item *item, const span *s, stp_status status,
                     const stp_error *error)
{
    const uint32_t at = item->begin + (uint32_t)(s->out - item->out);
    item->status = status;
    item->error = *error;
    item->got = at < item->got ? at : item->got;
}

/* Whether a server sent other bytes than the file has. */
static bool is_wrong(const span *s, const stp_gather_item *items)
{
    return items[s->item].status == STP_OK &&
           (uint32_t)stp_hash(s->out, (size_t)(s->end - s->offset)) != s->hash;
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

uint64_t stp_gather_read(stp_chunk_file *file, stp_gather_item *items, size_t count)
{
    span spans[STP_GATHER_BLOCKS * STP_SEGMENT_COUNT];
    stp_byte_range ranges[STP_GATHER_BLOCKS * STP_SEGMENT_COUNT];
    size_t span_count = 0;
    uint64_t read = 0;
    stp_error error = {0};
    stp_byte_source *source = stp_chunk_file_source(file);
    const bool remote = stp_byte_source_is_remote(source);
    if (count == 1 && !remote)
        return fetch(file, &items[0]);
    for (size_t i = 0; i < count; i++) {
        items[i].got = items[i].end;
        span_count += list_spans(&items[i], i, spans + span_count);
    }
    qsort(spans, span_count, sizeof *spans, compare_spans);
    for (size_t i = 0; i < span_count; i++)
        ranges[i] = (stp_byte_range){.offset = spans[i].offset,
                                     .data = spans[i].out,
                                     .size = (size_t)(spans[i].end - spans[i].offset)};
    const stp_read_wish wish = {is_wanted, &(group){items, count}};
    const stp_status status =
        stp_byte_source_read_ranges(source, ranges, span_count, &wish, &error);
    for (size_t i = 0; i < span_count; i++) {
        read += ranges[i].got;
        if (ranges[i].got < ranges[i].size)
            end_item(&items[spans[i].item], &spans[i], status, &error);
    }
    for (size_t i = 0; i < span_count && remote; i++)
        if (is_wrong(&spans[i], items))
            read += fetch(file, &items[spans[i].item]);
    return read;
}
