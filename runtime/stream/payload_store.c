/* Keeps the payloads used last in one mapped region. */
#include "runtime/stream/payload_store.h"

#include "base/memory.h"
#include "formats/chunk/chunk_file.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

stp_status stp_payload_store_create(stp_payload_store *out, uint64_t bytes, stp_error *err)
{
    uint64_t units = bytes / STP_PAYLOAD_UNIT_BYTES;
    units = units < UINT32_MAX ? units : UINT32_MAX;
    stp_payload_store s = {.region_bytes = units * STP_PAYLOAD_UNIT_BYTES,
                           .ranges = {.capacity = (uint32_t)units}};
    void *region = mmap(NULL, s.region_bytes, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (region == MAP_FAILED)
        return stp_error_set(err, STP_OUT_OF_MEMORY,
                             "no room for %llu bytes of payloads: give a smaller --cpu-memory",
                             (unsigned long long)s.region_bytes);
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

static void forget(stp_payload_store *s, size_t i)
{
    stp_range_pool_give(&s->ranges, s->payloads[i].range);
    s->payloads[i] = s->payloads[--s->count];
}

/* The index of a chunk's payload; `count` if there is none. */
static size_t find_chunk(const stp_payload_store *s, uint32_t chunk)
{
    size_t i = 0;
    while (i < s->count && s->payloads[i].chunk != chunk)
        i++;
    return i;
}

/* The index of a pinned payload, which must exist. */
static size_t find_range(const stp_payload_store *s, stp_range range)
{
    size_t i = 0;
    while (i + 1 < s->count && s->payloads[i].range.begin != range.begin)
        i++;
    return i;
}

bool stp_payload_store_find(stp_payload_store *s, uint32_t chunk, uint32_t bytes, stp_range *out)
{
    size_t i = find_chunk(s, chunk);
    if (i == s->count || s->payloads[i].bytes < bytes)
        return false;
    s->payloads[i].pins++;
    s->payloads[i].last_used = ++s->clock;
    *out = s->payloads[i].range;
    return true;
}

/* Forgets the payload used longest ago; false if all are pinned. */
static bool forget_oldest(stp_payload_store *s)
{
    size_t oldest = s->count;
    for (size_t i = 0; i < s->count; i++)
        if (s->payloads[i].pins == 0 &&
            (oldest == s->count || s->payloads[i].last_used < s->payloads[oldest].last_used))
            oldest = i;
    if (oldest == s->count)
        return false;
    forget(s, oldest);
    return true;
}

/* Moves the shorter prefix that exists to where the longer one will be. */
static uint32_t take_over(stp_payload_store *s, size_t old, stp_range range)
{
    uint32_t bytes = s->payloads[old].bytes;
    memcpy(stp_payload_memory(s, range), stp_payload_memory(s, s->payloads[old].range), bytes);
    s->payloads[old].chunk = STP_CHUNK_NONE;
    if (s->payloads[old].pins == 0)
        forget(s, old);
    return bytes;
}

bool stp_payload_store_make(stp_payload_store *s, uint32_t chunk, uint32_t bytes, stp_range *out,
                            uint32_t *known, stp_status *status, stp_error *err)
{
    uint32_t units =
        (uint32_t)(((uint64_t)bytes + STP_PAYLOAD_UNIT_BYTES) / STP_PAYLOAD_UNIT_BYTES);
    stp_range range = {0, 0};
    *status = stp_grow(&s->payloads, &s->capacity, s->count + 1, sizeof *s->payloads,
                       "a list of payloads", err);
    while (*status == STP_OK && !stp_range_pool_take(&s->ranges, units, &range, status, err))
        if (*status != STP_OK || !forget_oldest(s))
            return false;
    if (*status != STP_OK)
        return false;
    size_t old = find_chunk(s, chunk);
    *known = old < s->count ? take_over(s, old, range) : 0;
    s->payloads[s->count++] = (stp_payload){
        .chunk = chunk, .range = range, .bytes = *known, .pins = 1, .last_used = ++s->clock};
    *out = range;
    return true;
}

void stp_payload_store_filled(stp_payload_store *s, stp_range range, uint32_t bytes)
{
    s->payloads[find_range(s, range)].bytes = bytes;
}

void stp_payload_store_unpin(stp_payload_store *s, stp_range range)
{
    size_t i = find_range(s, range);
    if (--s->payloads[i].pins == 0 && s->payloads[i].chunk == STP_CHUNK_NONE)
        forget(s, i);
}

void stp_payload_store_discard(stp_payload_store *s, stp_range range)
{
    s->payloads[find_range(s, range)].chunk = STP_CHUNK_NONE;
    stp_payload_store_unpin(s, range);
}
