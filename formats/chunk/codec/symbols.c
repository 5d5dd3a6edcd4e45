/* Writes symbols as bytes, the last one first. */
#include "formats/chunk/codec/symbols.h"

#include "base/memory.h"

#include <inttypes.h>
#include <stdlib.h>

#define STATE_BYTES 8u
#define STATES_BYTES (STATE_BYTES * STP_SYMBOL_LANES)
#define WORD_BYTES 4u

stp_status stp_symbols_reserve(stp_symbol_writer *w, size_t more, stp_error *err)
{
    return stp_grow(&w->items, &w->capacity, w->count + more, sizeof *w->items, "symbols", err);
}

/* The state after an item; `words` gets the word that leaves the state, if one must. */
static inline uint64_t push(uint64_t state, const stp_symbol_item *item, uint32_t *words,
                            size_t *count)
{
    const uint64_t odds = item->odds;
    /* 2^31 / 2^(15 + bits) * 2^32 * odds */
    if (state >= odds << (31 - STP_ODDS_BITS + STP_SYMBOL_WORD_BITS - item->bits)) {
        words[(*count)++] = (uint32_t)state;
        state >>= STP_SYMBOL_WORD_BITS;
    }
    state = state << item->bits | item->plain;
    return (state / odds << STP_ODDS_BITS) + state % odds + item->below;
}

stp_status stp_symbols_write(const stp_symbol_writer *w, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *words = NULL;
    size_t count = 0;
    uint64_t state[STP_SYMBOL_LANES];
    const size_t begin = out->size;
    STP_TRY(stp_alloc(&words, w->count + 1, sizeof *words, "symbols", err));
    for (unsigned k = 0; k < STP_SYMBOL_LANES; k++)
        state[k] = STP_SYMBOL_STATE_LEAST;
    for (size_t i = w->count; i > 0; i--) {
        const stp_symbol_item *item = &w->items[i - 1];
        state[item->lane] = push(state[item->lane], item, words, &count);
    }
    STP_TRY(stp_bytes_append(out, NULL, STATES_BYTES + WORD_BYTES * count, err));
    for (unsigned k = 0; k < STP_SYMBOL_LANES; k++)
        stp_put_u64(out->data + begin + (size_t)STATE_BYTES * k, state[k]);
    for (size_t i = 0; i < count; i++)
        stp_put_u32(out->data + begin + STATES_BYTES + WORD_BYTES * i, words[count - 1 - i]);
done:
    free(words);
    return status;
}

stp_status stp_symbols_begin(stp_symbol_reader *r, const uint8_t *bytes, size_t size,
                             stp_error *err)
{
    if (size < STATES_BYTES)
        return stp_error_set(err, STP_CORRUPT, "a table's symbols do not fit into it");
    *r = (stp_symbol_reader){.next = bytes + STATES_BYTES, .end = bytes + size};
    for (unsigned k = 0; k < STP_SYMBOL_LANES; k++)
        r->state[k] = stp_get_u64(bytes + (size_t)STATE_BYTES * k);
    return STP_OK;
}

stp_status stp_symbols_end(const stp_symbol_reader *r, stp_error *err)
{
    bool ended = r->next == r->end;
    if (r->missing > 0)
        return stp_error_set(err, STP_CORRUPT,
                             "a table ends %" PRIu32 " words before its last symbol", r->missing);
    for (unsigned k = 0; k < STP_SYMBOL_LANES; k++)
        ended = ended && r->state[k] == STP_SYMBOL_STATE_LEAST;
    return ended ? STP_OK
                 : stp_error_set(err, STP_CORRUPT, "a table does not end with its last symbol");
}
