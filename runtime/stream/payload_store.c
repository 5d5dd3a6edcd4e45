/* Keeps the payloads used last in one mapped region. */
#include "runtime/stream/payload_store.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

stp_status stp_payload_store_create(stp_payload_store *out, uint64_t bytes, uint32_t block_count,
                                    stp_error *err)
{
    uint64_t units = bytes / STP_PAYLOAD_UNIT_BYTES;
    units = units < UINT32_MAX ? units : UINT32_MAX;
    stp_payload_store s = {.region_bytes = units * STP_PAYLOAD_UNIT_BYTES,
                           .ranges = {.capacity = (uint32_t)units},
                           .block_count = block_count};
    stp_status status =
        stp_alloc(&s.payloads, block_count + 1u, sizeof *s.payloads, "a list of payloads", err);
    if (status != STP_OK)
        return status;
    void *region = mmap(NULL, s.region_bytes, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (region == MAP_FAILED) {
        free(s.payloads);
        return stp_error_set(err, STP_OUT_OF_MEMORY,
                             "no room for %llu bytes of payloads: give a smaller --cpu-memory",
                             (unsigned long long)s.region_bytes);
    }
    s.payloads[block_count].before = s.payloads[block_count].after = block_count;
    s.region = region;
    *out = s;
    return STP_OK;
}

void stp_payload_store_destroy(stp_payload_store *s)
{
    if (s->region)
        munmap(s->region, s->region_bytes);
    stp_range_pool_destroy(&s->ranges);
    free(s->payloads);
    *s = (stp_payload_store){0};
}

uint8_t *stp_payload_memory(const stp_payload_store *s, stp_range range)
{
    return s->region + (uint64_t)range.begin * STP_PAYLOAD_UNIT_BYTES;
}

static void take_out(stp_payload_store *s, uint32_t block)
{
    const stp_payload *p = &s->payloads[block];
    s->payloads[p->before].after = p->after;
    s->payloads[p->after].before = p->before;
}

/* Puts a payload last: it was used just now. */
static void put_last(stp_payload_store *s, uint32_t block)
{
    stp_payload *p = &s->payloads[block], *ends = &s->payloads[s->block_count];
    p->before = ends->before;
    p->after = s->block_count;
    s->payloads[p->before].after = block;
    ends->before = block;
}

static void forget(stp_payload_store *s, uint32_t block)
{
    take_out(s, block);
    stp_range_pool_give(&s->ranges, s->payloads[block].range);
    s->payloads[block] = (stp_payload){0};
}

bool stp_payload_store_find(stp_payload_store *s, uint32_t block, uint32_t bytes, stp_range *out)
{
    stp_payload *p = &s->payloads[block];
    if (p->range.count == 0 || p->bytes < bytes)
        return false;
    take_out(s, block);
    put_last(s, block);
    p->pinned = true;
    *out = p->range;
    return true;
}

uint32_t stp_payload_store_known(const stp_payload_store *s, uint32_t block)
{
    return s->payloads[block].bytes;
}

/* Forgets the payload used longest ago; false if all are pinned. */
static bool forget_oldest(stp_payload_store *s)
{
    uint32_t oldest = s->payloads[s->block_count].after;
    while (oldest != s->block_count && s->payloads[oldest].pinned)
        oldest = s->payloads[oldest].after;
    if (oldest == s->block_count)
        return false;
    forget(s, oldest);
    return true;
}

bool stp_payload_store_make(stp_payload_store *s, uint32_t block, uint32_t bytes, stp_range *out,
                            uint32_t *known, stp_status *status, stp_error *err)
{
    uint32_t units =
        (uint32_t)(((uint64_t)bytes + STP_PAYLOAD_UNIT_BYTES) / STP_PAYLOAD_UNIT_BYTES);
    stp_range range = {0, 0};
    while (!stp_range_pool_take(&s->ranges, units, &range, status, err))
        if (*status != STP_OK || !forget_oldest(s))
            return false;
    stp_payload *p = &s->payloads[block];
    *known = 0;
    if (p->range.count > 0) { /* a shorter prefix is there */
        *known = p->bytes;
        memcpy(stp_payload_memory(s, range), stp_payload_memory(s, p->range), p->bytes);
        forget(s, block);
    }
    *p = (stp_payload){.range = range, .bytes = *known, .pinned = true};
    put_last(s, block);
    *out = range;
    return true;
}

void stp_payload_store_filled(stp_payload_store *s, uint32_t block, uint32_t bytes)
{
    s->payloads[block].bytes = bytes;
}

void stp_payload_store_unpin(stp_payload_store *s, uint32_t block)
{
    s->payloads[block].pinned = false;
}

void stp_payload_store_discard(stp_payload_store *s, uint32_t block)
{
    forget(s, block);
}
