/* Decodes the arithmetic code of LAZ. */
#include "formats/scan/las/laz_decoder.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

#define BIT_TOTAL_LIMIT (1u << STP_LAZ_BIT_SHIFT)
#define BIT_CYCLE_FIRST 4u
#define BIT_CYCLE_LIMIT 64u
#define SYMBOL_TOTAL_LIMIT (1u << STP_LAZ_SYMBOL_SHIFT)
/* Models with more symbols find a symbol by a table first. The others compare with all of these at
 * once, without a branch that could be foretold wrongly. */
#define TABLE_SYMBOLS 16u
/* Shares are below it. */
#define NO_SHARE UINT16_MAX
/* Bits of a correction that a model codes; the rest stands as it is. */
#define MODELLED_BITS 8u
/* Bits that one step of the decoder can take. */
#define STEP_BITS 19u

/* ---- bytes ---- */

void stp_laz_decoder_open(stp_laz_decoder *d, int descriptor, uint64_t begin, uint64_t end)
{
    d->descriptor = descriptor;
    d->next = begin;
    d->end = end;
    d->at = d->stop = d->buffer;
    d->cut = false;
    d->io_error = 0;
}

/* Reads the next bytes. At the end of the range, or if reading fails, a zero. */
static void refill(stp_laz_decoder *d)
{
    const uint64_t left = d->end - d->next;
    const size_t wanted = left < sizeof d->buffer ? (size_t)left : sizeof d->buffer;
    ssize_t got = 0;
    if (wanted > 0 && !d->cut) {
        do
            got = pread(d->descriptor, d->buffer, wanted, (off_t)d->next);
        while (got < 0 && errno == EINTR);
        d->io_error = got < 0 ? errno : 0;
    }
    if (got <= 0) {
        d->cut = true;
        d->buffer[0] = 0;
        d->at = d->buffer;
        d->stop = d->buffer + 1;
        return;
    }
    d->next += (uint64_t)got;
    d->at = d->buffer;
    d->stop = d->buffer + got;
}

static inline unsigned next_byte(stp_laz_decoder *d)
{
    if (__builtin_expect(d->at == d->stop, 0))
        refill(d);
    return *d->at++;
}

void stp_laz_decoder_raw(stp_laz_decoder *d, unsigned char *out, size_t size)
{
    for (size_t i = 0; i < size; i++)
        out[i] = (unsigned char)next_byte(d);
}

void stp_laz_decoder_begin(stp_laz_decoder *d, uint32_t epoch)
{
    d->epoch = epoch;
    d->length = UINT32_MAX;
    d->value = 0;
    for (int i = 0; i < 4; i++)
        d->value = d->value << 8 | next_byte(d);
    /* No encoder writes this value. Below, value < length always. */
    if (d->value == UINT32_MAX) {
        d->cut = true;
        d->value = 0;
    }
}

static inline void renormalise(stp_laz_decoder *d)
{
    while (d->length < STP_LAZ_LENGTH_LEAST) {
        d->value = d->value << 8 | next_byte(d);
        d->length <<= 8;
    }
}

/* ---- models ---- */

/* Entries of the table of a model: as many as symbols, so that one entry rarely leaves a choice. */
static unsigned table_bits(unsigned count)
{
    unsigned bits = 5;
    while (count > 1u << bits)
        bits++;
    return count > TABLE_SYMBOLS ? bits : 0;
}

void stp_laz_symbols_place(stp_laz_symbols *m, unsigned count, stp_laz_arena *arena)
{
    const unsigned bits = table_bits(count);
    *m = (stp_laz_symbols){.count = (uint16_t)count};
    m->table_shift = (uint8_t)(bits ? STP_LAZ_SYMBOL_SHIFT - bits : 0);
    if (arena->words) {
        m->counts = arena->words + arena->used;
        m->distribution = m->counts + count;
        m->table = m->distribution + count;
    }
    arena->used += (size_t)count + (bits ? count + (1u << bits) + 2 : TABLE_SYMBOLS);
}

/* Halves the counts if they grew too large, and makes probabilities of them. */
static void symbols_update(stp_laz_symbols *m)
{
    const unsigned count = m->count;
    m->total += m->cycle;
    if (m->total > SYMBOL_TOTAL_LIMIT) {
        m->total = 0;
        for (unsigned i = 0; i < count; i++) {
            m->counts[i] = (uint16_t)((m->counts[i] + 1u) >> 1);
            m->total += m->counts[i];
        }
    }
    const uint32_t scale = (UINT32_C(1) << 31) / (m->total > 0 ? m->total : 1);
    uint32_t sum = 0;
    unsigned filled = 0;
    for (unsigned i = 0; i < count; i++) {
        m->distribution[i] = (uint16_t)((scale * sum) >> (31u - STP_LAZ_SYMBOL_SHIFT));
        sum += m->counts[i];
        if (m->table_shift)
            for (const unsigned w = (unsigned)m->distribution[i] >> m->table_shift; filled < w;)
                m->table[++filled] = (uint16_t)(i - 1u);
    }
    if (m->table_shift) {
        const unsigned size = 1u << (STP_LAZ_SYMBOL_SHIFT - m->table_shift);
        m->table[0] = 0;
        while (filled <= size)
            m->table[++filled] = (uint16_t)(count - 1);
    }
    const uint32_t most = (count + 6) << 3;
    m->cycle = (5 * m->cycle) >> 2;
    m->cycle = m->cycle < most ? m->cycle : most;
    m->left = m->cycle;
}

static void symbols_begin(stp_laz_symbols *m, uint32_t epoch)
{
    m->epoch = epoch;
    m->total = 0;
    m->cycle = m->count;
    for (unsigned i = 0; i < m->count; i++)
        m->counts[i] = 1;
    for (unsigned i = m->count; i < TABLE_SYMBOLS; i++)
        m->distribution[i] = NO_SHARE;
    symbols_update(m);
    m->cycle = m->left = (m->count + 6u) >> 1;
}

static void bit_update(stp_laz_bit *m)
{
    m->total += m->cycle;
    if (m->total > BIT_TOTAL_LIMIT) {
        m->total = (m->total + 1) >> 1;
        m->zeros = (m->zeros + 1) >> 1;
        m->total += m->zeros == m->total ? 1u : 0u;
    }
    m->zero_probability = (m->zeros * ((UINT32_C(1) << 31) / m->total)) >> (31 - STP_LAZ_BIT_SHIFT);
    m->cycle = (5 * m->cycle) >> 2;
    m->cycle = m->cycle < BIT_CYCLE_LIMIT ? m->cycle : BIT_CYCLE_LIMIT;
    m->left = m->cycle;
}

static void bit_begin(stp_laz_bit *m, uint32_t epoch)
{
    *m = (stp_laz_bit){.epoch = epoch,
                       .zeros = 1,
                       .total = 2,
                       .cycle = BIT_CYCLE_FIRST,
                       .left = BIT_CYCLE_FIRST,
                       .zero_probability = 1u << (STP_LAZ_BIT_SHIFT - 1)};
}

void stp_laz_integer_place(stp_laz_integer *m, unsigned bits, unsigned contexts,
                           stp_laz_arena *arena)
{
    m->bits = bits;
    m->size = 0;
    m->unit.epoch = 0;
    for (unsigned i = 0; i < contexts; i++)
        stp_laz_symbols_place(&m->sizes[i], bits + 1, arena);
    for (unsigned k = 1; k < STP_LAZ_INTEGER_BITS && k <= bits; k++)
        stp_laz_symbols_place(&m->corrections[k], 1u << (k < MODELLED_BITS ? k : MODELLED_BITS),
                              arena);
}

/* ---- decoding ---- */

/* The symbol whose share of the interval holds the value. */
static inline unsigned find_symbol(const stp_laz_decoder *d, const stp_laz_symbols *m)
{
    const uint16_t share = (uint16_t)(d->value / d->length);
    if (!m->table_shift) {
        uint16_t below = 0;
        for (unsigned i = 0; i < TABLE_SYMBOLS; i++)
            below = (uint16_t)(below + (m->distribution[i] <= share));
        return below - 1u;
    }
    const unsigned t = share >> m->table_shift;
    unsigned low = m->table[t], high = m->table[t + 1] + 1u;
    while (high > low + 1) {
        const unsigned middle = (low + high) >> 1;
        if (m->distribution[middle] > share)
            high = middle;
        else
            low = middle;
    }
    return low;
}

static inline unsigned decode_symbol(stp_laz_decoder *d, stp_laz_symbols *m)
{
    if (__builtin_expect(m->epoch != d->epoch, 0))
        symbols_begin(m, d->epoch);
    const uint32_t whole = d->length;
    d->length >>= STP_LAZ_SYMBOL_SHIFT;
    const unsigned symbol = find_symbol(d, m);
    const uint32_t begin = m->distribution[symbol] * d->length;
    const uint32_t end = symbol + 1u == m->count ? whole : m->distribution[symbol + 1] * d->length;
    d->value -= begin;
    d->length = end - begin;
    renormalise(d);
    m->counts[symbol]++;
    if (--m->left == 0)
        symbols_update(m);
    return symbol;
}

unsigned stp_laz_decode_symbol(stp_laz_decoder *d, stp_laz_symbols *m)
{
    return decode_symbol(d, m);
}

static inline unsigned decode_bit(stp_laz_decoder *d, stp_laz_bit *m)
{
    if (m->epoch != d->epoch)
        bit_begin(m, d->epoch);
    const uint32_t zero = m->zero_probability * (d->length >> STP_LAZ_BIT_SHIFT);
    const unsigned bit = d->value >= zero;
    if (bit) {
        d->value -= zero;
        d->length -= zero;
    } else {
        d->length = zero;
        m->zeros++;
    }
    renormalise(d);
    if (--m->left == 0)
        bit_update(m);
    return bit;
}

static inline uint32_t decode_few_bits(stp_laz_decoder *d, unsigned bits)
{
    d->length >>= bits;
    const uint32_t value = d->value / d->length;
    d->value -= value * d->length;
    renormalise(d);
    return value;
}

uint32_t stp_laz_decode_bits(stp_laz_decoder *d, unsigned bits)
{
    if (bits <= STEP_BITS)
        return decode_few_bits(d, bits);
    const uint32_t low = decode_few_bits(d, 16);
    return decode_few_bits(d, bits - 16) << 16 | low;
}

uint64_t stp_laz_decode_u64(stp_laz_decoder *d)
{
    const uint32_t low = stp_laz_decode_bits(d, 32);
    return (uint64_t)stp_laz_decode_bits(d, 32) << 32 | low;
}

/* The correction of k bits, k > 0: half of all are negative. */
static inline uint32_t decode_correction(stp_laz_decoder *d, stp_laz_integer *m, unsigned k)
{
    if (k >= STP_LAZ_INTEGER_BITS)
        return UINT32_C(1) << 31;
    uint32_t c = decode_symbol(d, &m->corrections[k]);
    if (k > MODELLED_BITS)
        c = c << (k - MODELLED_BITS) | stp_laz_decode_bits(d, k - MODELLED_BITS);
    return c >= UINT32_C(1) << (k - 1) ? c + 1 : c - ((UINT32_C(1) << k) - 1);
}

int32_t stp_laz_decode_integer(stp_laz_decoder *d, stp_laz_integer *m, int32_t predicted,
                               unsigned context)
{
    const unsigned k = decode_symbol(d, &m->sizes[context]);
    const uint32_t correction = k > 0 ? decode_correction(d, m, k) : decode_bit(d, &m->unit);
    const uint32_t sum = (uint32_t)predicted + correction;
    m->size = k;
    return (int32_t)(m->bits < 32 ? sum & ((UINT32_C(1) << m->bits) - 1) : sum);
}
