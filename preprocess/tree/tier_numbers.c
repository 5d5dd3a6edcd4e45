/* Fetches and encodes the attributes of chunks. */
#include "preprocess/tree/tier_numbers.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* Bytes of numbers that all ranks ask for in one round, about. */
#define ROUND_BYTES (16u << 20)

typedef struct maker {
    stp_tier_chunk *chunks;
    const stp_tree_params *params;
    stp_spill *spill;
    uint8_t *rows;    /* numbers of the chunks' level-0 samples; NULL: all records are here */
    uint32_t *firsts; /* by chunk: its first sample among these; then how many there are */
} maker;

/* One round of fetching. */
typedef struct number_round {
    uint64_t *asked;       /* records, rank after rank */
    size_t *counts, *next; /* by rank: how many; where its next record, or number, is */
    stp_bytes in;          /* numbers that come */
} number_round;

static uint32_t sample_count(const stp_tier_chunk *c)
{
    const stp_chunk *chunk = c->chunk.chunk;
    return chunk->level_begin[0][chunk->patch_count];
}

/* The rank that read a record. */
static unsigned reader_of(const stp_tree_params *params, uint64_t record)
{
    return stp_ranks_find(params->ranks, params->numbers.begins, record);
}

/* Lists records by the rank that read them. */
static void ask(number_round *r, const stp_tree_params *params, const uint64_t *records,
                uint32_t count)
{
    const unsigned ranks = params->ranks->count;
    memset(r->counts, 0, ranks * sizeof *r->counts);
    for (uint32_t i = 0; i < count; i++)
        if (records[i] != STP_SOURCE_NONE)
            r->counts[reader_of(params, records[i])]++;
    for (size_t rank = 0, sum = 0; rank < ranks; sum += r->counts[rank++])
        r->next[rank] = sum;
    for (uint32_t i = 0; i < count; i++)
        if (records[i] != STP_SOURCE_NONE)
            r->asked[r->next[reader_of(params, records[i])]++] = records[i];
}

/* Packs the numbers of a record that another rank asks for. */
static stp_status answer(const void *context, uint64_t record, stp_bytes *out, stp_error *err)
{
    const stp_point_numbers *numbers = context;
    const size_t stride = stp_attribute_list_bytes(numbers->list);
    return stp_bytes_append(out, numbers->packed + (record - numbers->first) * stride, stride, err);
}

/* Fetches the numbers of some records into out. */
static stp_status run_round(number_round *r, const maker *m, const uint64_t *records,
                            uint32_t count, uint8_t *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = m->params->ranks;
    const size_t stride = stp_attribute_list_bytes(m->params->numbers.list);
    ask(r, m->params, records, count);
    stp_spill_relieve(m->spill);
    STP_TRY(stp_ranks_ask(ranks, r->asked, r->counts, answer, &m->params->numbers, &r->in, err));
    for (size_t rank = 0, sum = 0; rank < ranks->count; sum += stride * r->counts[rank++])
        r->next[rank] = sum;
    for (uint32_t i = 0; i < count; i++) {
        if (records[i] == STP_SOURCE_NONE)
            continue;
        size_t *next = &r->next[reader_of(m->params, records[i])];
        memcpy(out + i * stride, r->in.data + *next, stride);
        *next += stride;
    }
done:
    return status;
}

/* Fetches the numbers of all records. */
static stp_status fetch(const maker *m, const uint64_t *records, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = m->params->ranks;
    const size_t stride = stp_attribute_list_bytes(m->params->numbers.list);
    const uint32_t most = (uint32_t)(ROUND_BYTES / (stride * ranks->count)) + 1;
    number_round r = {0};
    STP_TRY(stp_alloc(&r.asked, most, sizeof *r.asked, "attributes", err));
    STP_TRY(stp_alloc(&r.counts, 2 * (size_t)ranks->count, sizeof *r.counts, "ranks", err));
    r.next = r.counts + ranks->count;
    for (uint32_t at = 0;;) {
        uint64_t left = count - at;
        STP_TRY(stp_ranks_sum(ranks, &left, 1, err));
        if (left == 0)
            break;
        const uint32_t here = count - at < most ? count - at : most;
        STP_TRY(run_round(&r, m, records + at, here, m->rows + at * stride, err));
        at += here;
    }
done:
    free(r.asked);
    free(r.counts);
    free(r.in.data);
    return status;
}

/* Fetches the numbers of all samples. */
static stp_status fetch_rows(maker *m, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *records = NULL;
    STP_TRY(stp_alloc(&m->firsts, (size_t)count + 1, sizeof *m->firsts, "chunks", err));
    for (uint32_t c = 0; c < count; c++)
        m->firsts[c + 1] = m->firsts[c] + sample_count(&m->chunks[c]);
    STP_TRY(stp_alloc(&records, m->firsts[count], sizeof *records, "attributes", err));
    for (uint32_t c = 0; c < count; c++) {
        const uint64_t *sources = m->chunks[c].chunk.sources;
        for (uint32_t i = m->firsts[c]; i < m->firsts[c + 1]; i++)
            records[i] = sources ? sources[i - m->firsts[c]] : STP_SOURCE_NONE;
    }
    STP_TRY(stp_spill_alloc(m->spill, &m->rows, m->firsts[count],
                            stp_attribute_list_bytes(m->params->numbers.list), "attributes", err));
    STP_TRY(fetch(m, records, m->firsts[count], err));
done:
    free(records);
    return status;
}

static stp_status make_one(void *context, size_t index, unsigned worker, stp_error *err)
{
    const maker *m = context;
    stp_tier_chunk *c = &m->chunks[index];
    const size_t stride = stp_attribute_list_bytes(m->params->numbers.list);
    (void)worker;
    const stp_status status =
        stp_chunk_numbers_make(&c->numbers, &c->chunk, &m->params->numbers,
                               m->rows ? m->rows + m->firsts[index] * stride : NULL, m->spill, err);
    stp_tier_chunk_forget_sources(c);
    return status;
}

stp_status stp_tier_numbers_make(stp_tier_chunk *chunks, uint32_t count,
                                 const stp_tree_params *params, const stp_cloud *cloud,
                                 stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    maker m = {.chunks = chunks, .params = params, .spill = cloud->spill};
    if (params->numbers.begins)
        STP_TRY(fetch_rows(&m, count, err));
    STP_TRY(stp_cloud_run(cloud, pool, count, make_one, &m, err));
done:
    stp_spill_free(cloud->spill, m.rows);
    free(m.firsts);
    return status;
}
