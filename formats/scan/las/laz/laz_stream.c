/* Codes numbers by the arithmetic code of LAZ, both ways. */
#include "formats/scan/las/laz/laz_stream.h"

#include "base/memory.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Bits that one step of the coder can take. */
#define STEP_BITS 19u

/* ---- bytes to read ---- */

void stp_laz_stream_open(stp_laz_stream *s, int descriptor, uint64_t begin, uint64_t end)
{
    s->descriptor = descriptor;
    s->next = begin;
    s->end = end;
    s->at = s->stop = s->buffer;
    s->cut = false;
    s->io_error = 0;
}

/* Reads the next bytes. At the end of the range, or if reading fails, a zero. */
static void refill(stp_laz_stream *s)
{
    const uint64_t left = s->end - s->next;
    const size_t wanted = left < sizeof s->buffer ? (size_t)left : sizeof s->buffer;
    ssize_t got = 0;
    if (wanted > 0 && !s->cut) {
        do
            got = pread(s->descriptor, s->buffer, wanted, (off_t)s->next);
        while (got < 0 && errno == EINTR);
        s->io_error = got < 0 ? errno : 0;
    }
    if (got <= 0) {
        s->cut = true;
        s->buffer[0] = 0;
        s->at = s->buffer;
        s->stop = s->buffer + 1;
        return;
    }
    s->next += (uint64_t)got;
    s->at = s->buffer;
    s->stop = s->buffer + got;
}

static inline unsigned next_byte(stp_laz_stream *s)
{
    if (__builtin_expect(s->at == s->stop, 0))
        refill(s);
    return *s->at++;
}

void stp_laz_stream_raw(stp_laz_stream *s, unsigned char *out, size_t size)
{
    for (size_t i = 0; i < size; i++)
        out[i] = (unsigned char)next_byte(s);
}

void stp_laz_stream_begin(stp_laz_stream *s, uint32_t epoch)
{
    s->epoch = epoch;
    s->length = UINT32_MAX;
    s->value = 0;
    for (int i = 0; i < 4; i++)
        s->value = s->value << 8 | next_byte(s);
    /* No encoder writes this value. Below, value < length always. */
    if (s->value == UINT32_MAX) {
        s->cut = true;
        s->value = 0;
    }
}

/* Takes as many bytes as make the interval long enough. Four bytes in memory spare a loop whose
 * branch no processor foretells. */
static inline void renormalise(stp_laz_stream *s)
{
    if (__builtin_expect(s->stop - s->at >= 4, 1)) {
        const unsigned bytes = (unsigned)__builtin_clz(s->length) / 8;
        uint32_t next;
        memcpy(&next, s->at, sizeof next);
        const uint64_t both = (uint64_t)s->value << 32 | __builtin_bswap32(next);
        s->value = (uint32_t)(both >> (32 - 8 * bytes));
        s->length <<= 8 * bytes;
        s->at += bytes;
        return;
    }
    while (s->length < STP_LAZ_LENGTH_LEAST) {
        s->value = s->value << 8 | next_byte(s);
        s->length <<= 8;
    }
}

/* ---- decoding ---- */

/* The symbol whose share of the interval holds the value. */
static inline unsigned find_symbol(const stp_laz_stream *s, const stp_laz_symbols *m)
{
    const uint16_t share = (uint16_t)(s->value / s->length);
    if (!m->table_shift) {
        uint16_t below = 0;
        for (unsigned i = 0; i < STP_LAZ_TABLE_SYMBOLS; i++)
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

static inline unsigned decode_symbol(stp_laz_stream *s, stp_laz_symbols *m)
{
    if (__builtin_expect(m->epoch != s->epoch, 0))
        stp_laz_symbols_begin(m, s->epoch);
    const uint32_t whole = s->length;
    s->length >>= STP_LAZ_SYMBOL_SHIFT;
    const unsigned symbol = find_symbol(s, m);
    const uint32_t begin = m->distribution[symbol] * s->length;
    const uint32_t end = symbol + 1u == m->count ? whole : m->distribution[symbol + 1] * s->length;
    s->value -= begin;
    s->length = end - begin;
    renormalise(s);
    m->counts[symbol]++;
    if (--m->left == 0)
        stp_laz_symbols_update(m);
    return symbol;
}

unsigned stp_laz_decode_symbol(stp_laz_stream *s, stp_laz_symbols *m)
{
    return decode_symbol(s, m);
}

static inline unsigned decode_bit(stp_laz_stream *s, stp_laz_bit *m)
{
    if (m->epoch != s->epoch)
        stp_laz_bit_begin(m, s->epoch);
    const uint32_t zero = m->zero_probability * (s->length >> STP_LAZ_BIT_SHIFT);
    const unsigned bit = s->value >= zero;
    if (bit) {
        s->value -= zero;
        s->length -= zero;
    } else {
        s->length = zero;
        m->zeros++;
    }
    renormalise(s);
    if (--m->left == 0)
        stp_laz_bit_update(m);
    return bit;
}

static inline uint32_t decode_few_bits(stp_laz_stream *s, unsigned bits)
{
    s->length >>= bits;
    const uint32_t value = s->value / s->length;
    s->value -= value * s->length;
    renormalise(s);
    return value;
}

uint32_t stp_laz_decode_bits(stp_laz_stream *s, unsigned bits)
{
    if (bits <= STEP_BITS)
        return decode_few_bits(s, bits);
    const uint32_t low = decode_few_bits(s, 16);
    return decode_few_bits(s, bits - 16) << 16 | low;
}

uint64_t stp_laz_decode_u64(stp_laz_stream *s)
{
    const uint32_t low = stp_laz_decode_bits(s, 32);
    return (uint64_t)stp_laz_decode_bits(s, 32) << 32 | low;
}

/* The correction of k bits, k > 0: half of all are negative. */
static inline uint32_t decode_correction(stp_laz_stream *s, stp_laz_integer *m, unsigned k)
{
    if (k >= STP_LAZ_INTEGER_BITS)
        return UINT32_C(1) << 31;
    uint32_t c = decode_symbol(s, &m->corrections[k]);
    if (k > STP_LAZ_MODELLED_BITS)
        c = c << (k - STP_LAZ_MODELLED_BITS) | stp_laz_decode_bits(s, k - STP_LAZ_MODELLED_BITS);
    return c >= UINT32_C(1) << (k - 1) ? c + 1 : c - ((UINT32_C(1) << k) - 1);
}

int32_t stp_laz_decode_integer(stp_laz_stream *s, stp_laz_integer *m, int32_t predicted,
                               unsigned context)
{
    const unsigned k = decode_symbol(s, &m->sizes[context]);
    const uint32_t correction = k > 0 ? decode_correction(s, m, k) : decode_bit(s, &m->unit);
    const uint32_t sum = (uint32_t)predicted + correction;
    m->size = k;
    return (int32_t)(m->bits < 32 ? sum & ((UINT32_C(1) << m->bits) - 1) : sum);
}

/* ---- bytes to write ---- */

void stp_laz_stream_pack(stp_laz_stream *s, uint32_t epoch)
{
    s->packs = true;
    s->cut = false;
    s->needed = false;
    s->at = s->packed;
    s->stop = s->packed ? s->packed + s->capacity : NULL;
    s->value = 0;
    s->length = UINT32_MAX;
    s->epoch = epoch;
}

void stp_laz_stream_free(stp_laz_stream *s)
{
    free(s->packed);
    s->packed = NULL;
    s->capacity = 0;
}

/* Makes room. Without memory, what follows is lost. */
static void make_room(stp_laz_stream *s)
{
    const size_t used = s->cut ? 0 : s->capacity;
    if (!s->cut && stp_grow(&s->packed, &s->capacity, used + STP_LAZ_BUFFER_BYTES, 1, "LAZ layers",
                            NULL) == STP_OK) {
        s->at = s->packed + used;
        s->stop = s->packed + s->capacity;
    } else {
        s->cut = true;
        s->at = s->buffer;
        s->stop = s->buffer + sizeof s->buffer;
    }
}

static inline void put_byte(stp_laz_stream *s, unsigned byte)
{
    if (__builtin_expect(s->at == s->stop, 0))
        make_room(s);
    *s->at++ = (unsigned char)byte;
}

/* Adds one to the bytes that were written. */
static void carry(stp_laz_stream *s)
{
    const unsigned char *begin = s->cut ? s->buffer : s->packed;
    unsigned char *byte = s->at;
    while (byte > begin && ++*--byte == 0)
        ;
}

/* Leaves the part of the interval that begins at `begin`. */
static inline void narrow(stp_laz_stream *s, uint32_t begin, uint32_t length)
{
    s->value += begin;
    s->length = length;
    if (s->value < begin)
        carry(s);
    while (s->length < STP_LAZ_LENGTH_LEAST) {
        put_byte(s, s->value >> 24);
        s->value <<= 8;
        s->length <<= 8;
    }
}

/* Writes as few bytes as tell the interval, then zeros up to the four that a decoder begins with.
 */
size_t stp_laz_stream_finish(stp_laz_stream *s)
{
    const bool is_long = s->length > 2 * STP_LAZ_LENGTH_LEAST;
    narrow(s, is_long ? STP_LAZ_LENGTH_LEAST : STP_LAZ_LENGTH_LEAST >> 1,
           is_long ? STP_LAZ_LENGTH_LEAST >> 1 : STP_LAZ_LENGTH_LEAST >> 9);
    for (int i = 0; i < (is_long ? 3 : 2); i++)
        put_byte(s, 0);
    return s->cut ? 0 : (size_t)(s->at - s->packed);
}

/* ---- encoding ---- */

void stp_laz_encode_symbol(stp_laz_stream *s, stp_laz_symbols *m, unsigned symbol)
{
    if (m->epoch != s->epoch)
        stp_laz_symbols_begin(m, s->epoch);
    const uint32_t share = s->length >> STP_LAZ_SYMBOL_SHIFT;
    const uint32_t begin = m->distribution[symbol] * share;
    const uint32_t end = symbol + 1u == m->count ? s->length : m->distribution[symbol + 1] * share;
    narrow(s, begin, end - begin);
    m->counts[symbol]++;
    if (--m->left == 0)
        stp_laz_symbols_update(m);
}

static void encode_bit(stp_laz_stream *s, stp_laz_bit *m, unsigned bit)
{
    if (m->epoch != s->epoch)
        stp_laz_bit_begin(m, s->epoch);
    const uint32_t zero = m->zero_probability * (s->length >> STP_LAZ_BIT_SHIFT);
    narrow(s, bit ? zero : 0, bit ? s->length - zero : zero);
    m->zeros += !bit;
    if (--m->left == 0)
        stp_laz_bit_update(m);
}

static void encode_few_bits(stp_laz_stream *s, unsigned bits, uint32_t value)
{
    const uint32_t share = s->length >> bits;
    narrow(s, value * share, share);
}

void stp_laz_encode_bits(stp_laz_stream *s, unsigned bits, uint32_t value)
{
    if (bits > STEP_BITS) {
        encode_few_bits(s, 16, value & 0xffff);
        value >>= 16;
        bits -= 16;
    }
    encode_few_bits(s, bits, value);
}

/* The correction of k bits, 0 < k < STP_LAZ_INTEGER_BITS, by its place among those of k bits. */
static void encode_correction(stp_laz_stream *s, stp_laz_integer *m, unsigned k, uint32_t place)
{
    if (k <= STP_LAZ_MODELLED_BITS) {
        stp_laz_encode_symbol(s, &m->corrections[k], place);
        return;
    }
    const unsigned low = k - STP_LAZ_MODELLED_BITS;
    stp_laz_encode_symbol(s, &m->corrections[k], place >> low);
    stp_laz_encode_bits(s, low, place & ((UINT32_C(1) << low) - 1));
}

void stp_laz_encode_integer(stp_laz_stream *s, stp_laz_integer *m, int32_t predicted,
                            unsigned context, int32_t value)
{
    const uint32_t half = UINT32_C(1) << (m->bits - 1);
    uint32_t c = (uint32_t)value - (uint32_t)predicted;
    if (m->bits < 32)
        c = ((c + half) & (2 * half - 1)) - half;
    const bool positive = c - 1 < half - 1;
    const uint32_t size = positive ? c - 1 : 0 - c;
    const unsigned k = size > 0 ? 32 - (unsigned)__builtin_clz(size) : 0;
    stp_laz_encode_symbol(s, &m->sizes[context], k);
    if (k == 0)
        encode_bit(s, &m->unit, c & 1);
    else if (k < STP_LAZ_INTEGER_BITS)
        encode_correction(s, m, k, positive ? c - 1 : c + (UINT32_C(1) << k) - 1);
    m->size = k;
}
