/* Writes symbols as bytes, the last one first. */
#include "formats/chunk/codec/odds/symbols.h"

#include "base/memory.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#define STATE_BYTES 8u
#define STATES_BYTES (STATE_BYTES * STP_SYMBOL_LANES)
#define WORD_BYTES 4u
/* States of as many bytes as they need: three bytes of the first; a byte with bit 6 set unless odds
 * are known, bytes of the second state less 1 in bits 3-5, further bytes of the first in bits 0-2;
 * these; the second state. Or bits 0-2 are LONG_MARK: then bits 3-5 are the further bytes of both.
 */
#define SIZED_AT 4u
#define SIZED_MARK 0x40u
#define SIZE_BITS 3u
#define SIZE_MASK ((1u << SIZE_BITS) - 1)
#define LONG_MARK 6u
#define FIRST_MORE_LIMIT (STATE_BYTES - SIZED_AT + 1)

stp_status stp_symbols_reserve(stp_symbol_writer *w, size_t more, stp_error *err)
{
    return stp_grow(&w->items, &w->capacity, w->count + more, sizeof *w->items, "symbols", err);
}

/* Items as states that a reader begins with, and words. Free `words`. */
typedef struct code {
    uint64_t state[STP_SYMBOL_LANES];
    uint32_t *words; /* the last one first */
    size_t count;
} code;

/* The state after an item; `words` gets the word that leaves the state, if one must. */
static inline uint64_t push(uint64_t state, const stp_symbol_item *item, uint32_t *words,
                            size_t *count)
{
    const uint64_t odds = item->odds;
    /* 2^31 / 2^(15 + bits) * 2^32 * odds */
    const bool full = state >= odds << (31 - STP_ODDS_BITS + STP_SYMBOL_WORD_BITS - item->bits);
    words[*count] = (uint32_t)state;
    *count += full;
    state = (full ? state >> STP_SYMBOL_WORD_BITS : state) << item->bits | item->plain;
    return (state / odds << STP_ODDS_BITS) + state % odds + item->below;
}

_Static_assert(STP_SYMBOL_LANES == 2, "both states are looked at below");

/* Encodes items from the last one on, from both states at `last`. False if a state was less than
 * 2^31 behind the first word, where a reader would take the next word for it: then not all items
 * are encoded. Once both states are greater, they stay so. */
static bool encode(const stp_symbol_writer *w, uint64_t last, code *c)
{
    uint64_t state[STP_SYMBOL_LANES] = {last, last};
    const stp_symbol_item *item = w->items + w->count;
    uint32_t *words = c->words;
    size_t count = 0;
    while (item > w->items &&
           (state[0] < STP_SYMBOL_STATE_LEAST || state[1] < STP_SYMBOL_STATE_LEAST)) {
        uint64_t *own = &state[(--item)->lane];
        if (count > 0 && *own < STP_SYMBOL_STATE_LEAST)
            return false;
        *own = push(*own, item, words, &count);
    }
    while (item > w->items) { /* a choice of two registers would tie the lanes to each other */
        uint64_t *own = &state[(--item)->lane];
        *own = push(*own, item, words, &count);
    }
    memcpy(c->state, state, sizeof state);
    c->count = count;
    return true;
}

/* Appends a head and the words behind it. */
static stp_status append(const code *c, const uint8_t *head, size_t head_bytes, stp_bytes *out,
                         stp_error *err)
{
    stp_status status = stp_bytes_append(out, head, head_bytes, err);
    const size_t begin = out->size;
    if (status == STP_OK)
        status = stp_bytes_append(out, NULL, WORD_BYTES * c->count, err);
    for (size_t i = 0; i < c->count && status == STP_OK; i++)
        stp_put_u32(out->data + begin + WORD_BYTES * i, c->words[c->count - 1 - i]);
    return status;
}

stp_status stp_symbols_write(const stp_symbol_writer *w, stp_bytes *out, stp_error *err)
{
    code c = {0};
    uint8_t head[STATES_BYTES];
    stp_status status = stp_alloc_unset(&c.words, w->count + 1, sizeof *c.words, "symbols", err);
    if (status != STP_OK)
        return status;
    (void)encode(w, STP_SYMBOL_STATE_LEAST, &c);
    for (unsigned k = 0; k < STP_SYMBOL_LANES; k++)
        stp_put_u64(head + (size_t)STATE_BYTES * k, c.state[k]);
    status = append(&c, head, sizeof head, out, err);
    free(c.words);
    return status;
}

/* Appends the low bytes of a state to a head. */
static size_t put_state(uint64_t state, size_t bytes, uint8_t *head, size_t at)
{
    for (size_t i = 0; i < bytes; i++)
        head[at + i] = (uint8_t)(state >> 8 * i);
    return at + bytes;
}

/* Bytes that a number takes, at least `least`. */
static size_t byte_length(uint64_t number, size_t least)
{
    size_t bytes = least;
    while (bytes < STATE_BYTES && number >> 8 * bytes)
        bytes++;
    return bytes;
}

stp_status stp_symbols_write_known(const stp_symbol_writer *w, stp_bytes *out, stp_error *err)
{
    code c = {0};
    uint8_t head[SIZED_AT + STATES_BYTES];
    stp_status status = stp_alloc_unset(&c.words, w->count + 1, sizeof *c.words, "symbols", err);
    if (status != STP_OK)
        return status;
    const bool is_short = encode(w, STP_SYMBOL_STATE_SHORT, &c);
    if (!is_short)
        (void)encode(w, STP_SYMBOL_STATE_LEAST, &c);
    size_t first = byte_length(c.state[0], SIZED_AT), second = byte_length(c.state[1], 1);
    if (!is_short)
        first = second = first > second ? first : second;
    const size_t more = first - SIZED_AT + 1;
    size_t at = put_state(c.state[0], SIZED_AT - 1, head, 0);
    head[at++] =
        (uint8_t)(is_short ? (second - 1) << SIZE_BITS | more : more << SIZE_BITS | LONG_MARK);
    at = put_state(c.state[0] >> 8 * (SIZED_AT - 1), more, head, at);
    at = put_state(c.state[1], second, head, at);
    status = append(&c, head, at, out, err);
    free(c.words);
    return status;
}

stp_status stp_symbols_begin(stp_symbol_reader *r, const uint8_t *bytes, size_t size,
                             stp_error *err)
{
    if (size < STATES_BYTES)
        return stp_error_set(err, STP_CORRUPT, "a table's symbols do not fit into it");
    *r = (stp_symbol_reader){
        .next = bytes + STATES_BYTES, .end = bytes + size, .last = STP_SYMBOL_STATE_LEAST};
    for (unsigned k = 0; k < STP_SYMBOL_LANES; k++)
        r->state[k] = stp_get_u64(bytes + (size_t)STATE_BYTES * k);
    return STP_OK;
}

static uint64_t get_state(const uint8_t *bytes, size_t count)
{
    uint64_t state = 0;
    for (size_t i = 0; i < count; i++)
        state |= (uint64_t)bytes[i] << 8 * i;
    return state;
}

bool stp_symbols_are_sized(const uint8_t *bytes, size_t size, bool known)
{
    const unsigned sizes = size >= SIZED_AT ? bytes[SIZED_AT - 1] : 0;
    const unsigned mark = known ? 0 : SIZED_MARK;
    unsigned more = sizes & SIZE_MASK;
    if (known && more == LONG_MARK)
        more = sizes >> SIZE_BITS & SIZE_MASK;
    return sizes >> 2 * SIZE_BITS == mark >> 2 * SIZE_BITS && more > 0 && more <= FIRST_MORE_LIMIT;
}

stp_status stp_symbols_begin_sized(stp_symbol_reader *r, const uint8_t *bytes, size_t size,
                                   stp_error *err)
{
    const unsigned sizes = bytes[SIZED_AT - 1], other = sizes >> SIZE_BITS & SIZE_MASK;
    const bool is_long = (sizes & SIZE_MASK) == LONG_MARK;
    const size_t more = is_long ? other : sizes & SIZE_MASK;
    const size_t second = is_long ? SIZED_AT - 1 + more : other + 1;
    if (size < SIZED_AT + more + second)
        return stp_error_set(err, STP_CORRUPT, "a table's symbols do not fit into it");
    *r = (stp_symbol_reader){.next = bytes + SIZED_AT + more + second,
                             .end = bytes + size,
                             .last = is_long ? STP_SYMBOL_STATE_LEAST : STP_SYMBOL_STATE_SHORT};
    r->state[0] = get_state(bytes, SIZED_AT - 1) | get_state(bytes + SIZED_AT, more)
                                                       << 8 * (SIZED_AT - 1);
    r->state[1] = get_state(bytes + SIZED_AT + more, second);
    return STP_OK;
}

stp_status stp_symbols_end(const stp_symbol_reader *r, stp_error *err)
{
    bool ended = r->next == r->end;
    if (r->missing > 0)
        return stp_error_set(err, STP_CORRUPT,
                             "a table ends %" PRIu32 " words before its last symbol", r->missing);
    for (unsigned k = 0; k < STP_SYMBOL_LANES; k++)
        ended = ended && r->state[k] == r->last;
    return ended ? STP_OK
                 : stp_error_set(err, STP_CORRUPT, "a table does not end with its last symbol");
}
