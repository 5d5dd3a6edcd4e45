/* Searches the one flipped bit of checked bytes by their checksum. */
#include "formats/chunk/repair/mend_bit.h"

#include "formats/chunk/layout.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <xxhash.h>

/* Bytes whose bits one task tries. */
#define TASK_BYTES 64u
#define SECTOR_RUN 256u
/* A header has long runs of zeros, and is searched at once. */
#define SHORT_BYTES 1024u

typedef struct search {
    const uint8_t *bytes;
    size_t size;
    uint64_t hash, mask;
    const stp_progress *progress;
    atomic_size_t bit;
    atomic_size_t done_bytes;
} search;

/* Bytes lost with their sector read as zeros, or as one byte repeated. */
static bool has_long_run(const uint8_t *bytes, size_t size)
{
    size_t run = 1;
    for (size_t i = 1; i < size; i++) {
        run = bytes[i] == bytes[i - 1] ? run + 1 : 1;
        if (run >= SECTOR_RUN)
            return true;
    }
    return false;
}

/* Hashes on from the state before `at`, with one of the bytes changed. */
static uint64_t hash_changed(const search *s, const XXH3_state_t *before, XXH3_state_t *state,
                             size_t at, uint8_t changed)
{
    XXH3_copyState(state, before);
    XXH3_64bits_update(state, &changed, 1);
    XXH3_64bits_update(state, s->bytes + at + 1, s->size - at - 1);
    return XXH3_64bits_digest(state);
}

static void try_bytes(search *s, XXH3_state_t *before, XXH3_state_t *state, size_t begin)
{
    size_t end = s->size - begin < TASK_BYTES ? s->size : begin + TASK_BYTES;
    XXH3_64bits_reset(before);
    XXH3_64bits_update(before, s->bytes, begin);
    for (size_t at = begin; at < end; at++) {
        for (unsigned b = 0; b < 8; b++)
            if (((hash_changed(s, before, state, at, (uint8_t)(s->bytes[at] ^ 1u << b)) ^ s->hash) &
                 s->mask) == 0)
                atomic_store(&s->bit, 8 * at + b);
        XXH3_64bits_update(before, s->bytes + at, 1);
    }
}

static stp_status run_task(void *context, size_t index, unsigned worker, stp_error *err)
{
    search *s = context;
    stp_status status = STP_OK;
    (void)worker;
    if (atomic_load(&s->bit) != STP_NO_BIT)
        return STP_OK;
    XXH3_state_t *before = XXH3_createState();
    XXH3_state_t *state = XXH3_createState();
    if (before && state)
        try_bytes(s, before, state, index * TASK_BYTES);
    else
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to look for a flipped bit");
    XXH3_freeState(before);
    XXH3_freeState(state);
    if (status == STP_OK)
        status = stp_progress_update(s->progress, "bits",
                                     atomic_fetch_add(&s->done_bytes, TASK_BYTES) + TASK_BYTES,
                                     s->size, err);
    return status;
}

stp_status stp_mend_bit(const uint8_t *bytes, size_t size, uint64_t hash, uint64_t mask,
                        stp_pool *pool, const stp_progress *progress, size_t *bit, stp_error *err)
{
    search s = {.bytes = bytes, .size = size, .hash = hash, .mask = mask, .progress = progress};
    uint64_t difference = (stp_hash(bytes, size) ^ hash) & mask;
    atomic_init(&s.bit, STP_NO_BIT);
    atomic_init(&s.done_bytes, 0);
    *bit = STP_NO_BIT;
    if (__builtin_popcountll(difference) == 1) {
        *bit = 8 * size + (size_t)__builtin_ctzll(difference);
        return STP_OK;
    }
    if (size == 0 || size > STP_MEND_BYTES_LIMIT ||
        (size > SHORT_BYTES && has_long_run(bytes, size)))
        return STP_OK;
    stp_status status = stp_pool_run(pool, (size - 1) / TASK_BYTES + 1, run_task, &s, err);
    if (status == STP_OK)
        *bit = atomic_load(&s.bit);
    return status;
}
