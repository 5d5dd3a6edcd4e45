/* Codes one column of small integers: high bits through Draco, low bits as they are. */
#include "formats/chunk/codec/table/column.h"

#include "base/memory.h"
#include "formats/chunk/codec/table/draco_shim.h"
#include "formats/chunk/layout.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define HEAD_BYTES 4u
#define STREAM_BYTES_BITS 24u
#define STREAM_BYTES_MASK ((1u << STREAM_BYTES_BITS) - 1u)
/* The running mean of magnitudes follows about the last eight cells. */
#define MEAN_SHIFT 3u
/* If the mean, in halves, is no more than this, all bits go to Draco. */
#define LOW_BITS_MEAN_HALVES 3u
/* Bits of a symbol that Draco sees, at most. A short column gets fewer: its table of symbols must
 * be short. */
#define KEPT_BITS 2u
#define KEPT_BITS_SHORT 1u
#define SHORT_COLUMN 3000u
/* A block's columns try from 0 (if the mean is not above ALL_BITS_MEAN) to this many. */
#define KEPT_BITS_MOST 4u
#define ALL_BITS_MEAN 255u
/* What Draco's table takes for a symbol that occurs, about. */
#define BITS_OF_TABLE_SYMBOL 10.0

stp_status stp_bytes_append(stp_bytes *bytes, const void *data, size_t size, stp_error *err)
{
    stp_status status =
        stp_grow(&bytes->data, &bytes->capacity, bytes->size + size, 1, "payload", err);
    if (status != STP_OK || size == 0)
        return status;
    if (data)
        memcpy(bytes->data + bytes->size, data, size);
    else
        memset(bytes->data + bytes->size, 0, size);
    bytes->size += size;
    return STP_OK;
}

/* ---- how many bits are low ---- */

static unsigned bit_length(uint32_t value)
{
    return value ? 32u - (unsigned)__builtin_clz(value) : 0;
}

/* The running mean of magnitudes, and how many bits it makes low. kept = 0: no cell has low bits.
 */
typedef struct spread {
    uint32_t mean; /* in eighths */
    unsigned kept;
} spread;

static spread spread_begin(unsigned kept, unsigned first)
{
    return (spread){.mean = (1u << MEAN_SHIFT) << first, .kept = kept};
}

static inline unsigned spread_low_bits(const spread *s)
{
    return bit_length(s->mean >> (MEAN_SHIFT + s->kept));
}

static inline void spread_take(spread *s, int16_t cell)
{
    s->mean = s->mean - (s->mean >> MEAN_SHIFT) + (uint32_t)abs(cell);
}

/* A cell of k low bits is high * 2^k + low - half, low from 0 to 2^k - 1. */
static inline int32_t half_of(unsigned bits)
{
    return (int32_t)(1u << bits >> 1);
}

/* ---- encoding ---- */

/* Writes bits, beginning with the least of the first byte. */
typedef struct bit_writer {
    uint8_t *bytes;
    size_t size;
    uint64_t held;
    unsigned held_bits;
} bit_writer;

static inline void put_bits(bit_writer *w, uint32_t value, unsigned bits)
{
    w->held |= (uint64_t)value << w->held_bits;
    w->held_bits += bits;
    while (w->held_bits >= 8) {
        w->bytes[w->size++] = (uint8_t)w->held;
        w->held >>= 8;
        w->held_bits -= 8;
    }
}

static void put_rest(bit_writer *w)
{
    if (w->held_bits > 0)
        w->bytes[w->size++] = (uint8_t)w->held;
}

/* Splits cells into high parts and low bits. */
static void split(const int16_t *cells, uint32_t count, spread s, int16_t *high, bit_writer *low)
{
    for (uint32_t i = 0; i < count; i++) {
        unsigned bits = spread_low_bits(&s);
        int32_t raised = cells[i] + half_of(bits);
        high[i] = (int16_t)(raised >> bits);
        put_bits(low, (uint32_t)raised & ((1u << bits) - 1u), bits);
        spread_take(&s, cells[i]);
    }
    put_rest(low);
}

static stp_status append_parts(const int16_t *high, uint32_t count, unsigned kept, unsigned first,
                               const bit_writer *low, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    void *stream = NULL;
    size_t stream_bytes = 0;
    uint8_t head[HEAD_BYTES];
    STP_TRY(stp_draco_encode(high, count, &stream, &stream_bytes, err));
    if (stream_bytes > STREAM_BYTES_MASK) {
        status = stp_error_set(err, STP_INTERNAL, "Draco made %zu bytes of %u cells", stream_bytes,
                               count);
        goto done;
    }
    stp_put_u32(head, (uint32_t)stream_bytes | first << 24 | kept << 28);
    STP_TRY(stp_bytes_append(out, head, sizeof head, err));
    STP_TRY(stp_bytes_append(out, stream, stream_bytes, err));
    STP_TRY(stp_bytes_append(out, low->bytes, low->size, err));
done:
    free(stream);
    return status;
}

/* Memory to encode a column. */
typedef struct work {
    int16_t *high;
    bit_writer low;
    uint8_t *lengths; /* by cell: how many bits are low if none goes to Draco */
    uint32_t *counts; /* of symbols, the least at 0; all 0 between uses */
    int32_t least;    /* high parts are no less than this */
} work;

static void work_destroy(work *w)
{
    free(w->high);
    free(w->low.bytes);
    free(w->lengths);
    free(w->counts);
}

static stp_status work_create(work *w, uint32_t cell_count, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&w->high, cell_count, sizeof *w->high, "a column", err));
    STP_TRY(stp_alloc(&w->low.bytes, 2 * (size_t)cell_count + 1, 1, "a column", err));
done:
    return status;
}

/* Splits the cells so that `kept` bits of a cell go to Draco; 0: all bits. */
static void split_for(const int16_t *cells, uint32_t count, unsigned kept, unsigned first, work *w)
{
    w->low = (bit_writer){.bytes = w->low.bytes};
    if (kept > 0)
        split(cells, count, spread_begin(kept, first), w->high, &w->low);
    else
        memcpy(w->high, cells, count * sizeof *cells);
}

/* How many bytes the parts take if `kept` bits of a cell go to Draco: the low bits, and by the
 * entropy of the high parts. */
static double estimate(const int16_t *cells, uint32_t count, unsigned kept, work *w)
{
    uint64_t low_bits = 0;
    double bits = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        const unsigned low = kept > 0 && w->lengths[i] > kept ? w->lengths[i] - kept : 0;
        const int32_t high = (cells[i] + half_of(low)) >> low;
        low_bits += low;
        w->high[i] = (int16_t)(high - w->least);
        bits += w->counts[high - w->least]++ == 0 ? BITS_OF_TABLE_SYMBOL : 0.0;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t *symbols = &w->counts[(uint16_t)w->high[i]];
        if (*symbols > 0)
            bits += (double)*symbols * log2((double)count / (double)*symbols);
        *symbols = 0;
    }
    const uint64_t low_bytes = (low_bits + 7) / 8;
    return (double)low_bytes + bits / 8.0;
}

static stp_status prepare_estimates(const int16_t *cells, uint32_t count, unsigned first, work *w,
                                    stp_error *err)
{
    stp_status status = STP_OK;
    int32_t least = 0, most = 0;
    spread s = spread_begin(0, first);
    STP_TRY(stp_alloc(&w->lengths, count, sizeof *w->lengths, "a column", err));
    for (uint32_t i = 0; i < count; i++) {
        w->lengths[i] = (uint8_t)spread_low_bits(&s);
        spread_take(&s, cells[i]);
        least = cells[i] < least ? cells[i] : least;
        most = cells[i] > most ? cells[i] : most;
    }
    w->least = least;
    /* rounding may raise the greatest high part by 1 */
    STP_TRY(stp_alloc(&w->counts, (size_t)(most - least) + 2, sizeof *w->counts, "a column", err));
done:
    return status;
}

/* The number of bits for Draco that makes the parts smallest. */
static stp_status find_smallest(const int16_t *cells, uint32_t count, uint32_t mean, unsigned first,
                                work *w, unsigned *out, stp_error *err)
{
    double least = INFINITY;
    stp_status status = prepare_estimates(cells, count, first, w, err);
    for (unsigned kept = mean > ALL_BITS_MEAN ? 1 : 0; status == STP_OK && kept <= KEPT_BITS_MOST;
         kept++) {
        const double bytes = estimate(cells, count, kept, w);
        *out = bytes < least ? kept : *out;
        least = fmin(least, bytes);
    }
    return status;
}

stp_status stp_column_encode(const int16_t *cells, uint32_t count, bool smallest, stp_bytes *out,
                             stp_error *err)
{
    stp_status status = STP_OK;
    work w = {0};
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++)
        sum += (uint64_t)abs(cells[i]);
    const uint32_t mean = count > 0 ? (uint32_t)(sum / count) : 0;
    const unsigned first = bit_length(mean >> 1);
    unsigned kept = count < SHORT_COLUMN ? KEPT_BITS_SHORT : KEPT_BITS;
    if (2 * sum <= (uint64_t)LOW_BITS_MEAN_HALVES * count)
        kept = 0;
    STP_TRY(work_create(&w, count, err));
    if (smallest)
        STP_TRY(find_smallest(cells, count, mean, first, &w, &kept, err));
    split_for(cells, count, kept, first, &w);
    STP_TRY(append_parts(w.high, count, kept, kept > 0 ? first : 0, &w.low, out, err));
done:
    work_destroy(&w);
    return status;
}

/* ---- decoding ---- */

/* The two ways in which Draco codes symbols, by Draco's own numbers. */
enum { STREAM_TAGGED = 0, STREAM_RAW = 1 };
#define STREAM_BIT_LENGTH_LIMIT 18u
#define STREAM_TAGS_LIMIT 33u
#define STREAM_SYMBOLS_LIMIT 65536u

/* Reads little-endian groups of seven bits; false if there are more than three, or the bytes end.
 */
static bool get_varint(const uint8_t *bytes, size_t size, uint32_t *out)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < 3 && i < size; i++) {
        value |= (uint32_t)(bytes[i] & 127u) << (7 * i);
        if (!(bytes[i] & 128u)) {
            *out = value;
            return true;
        }
    }
    return false;
}

stp_status stp_stream_check(const uint8_t *stream, size_t size, stp_error *err)
{
    uint32_t symbols = 0;
    if (size < 3 || stream[0] > STREAM_RAW)
        return stp_error_set(err, STP_CORRUPT, "a Draco stream is not coded as this format says");
    bool raw = stream[0] == STREAM_RAW;
    size_t head = raw ? 2 : 1;
    if ((raw && stream[1] > STREAM_BIT_LENGTH_LIMIT) ||
        !get_varint(stream + head, size - head, &symbols) ||
        symbols > (raw ? STREAM_SYMBOLS_LIMIT : STREAM_TAGS_LIMIT))
        return stp_error_set(err, STP_CORRUPT, "a Draco stream claims more symbols than exist");
    return STP_OK;
}

/* Reads the bit writer's bits. Behind the end it gives zeros, and used > 8 * size tells. */
typedef struct bit_reader {
    const uint8_t *bytes;
    size_t size, next; /* next byte to hold */
    uint64_t held;
    unsigned held_bits;
    size_t used; /* bits */
} bit_reader;

static inline void hold_more(bit_reader *r)
{
    if (r->next + 8 <= r->size) {
        r->held |= stp_get_u64(r->bytes + r->next) << r->held_bits;
        r->next += (63 - r->held_bits) >> 3;
        r->held_bits |= 56;
        return;
    }
    while (r->held_bits <= 56) {
        if (r->next < r->size)
            r->held |= (uint64_t)r->bytes[r->next++] << r->held_bits;
        r->held_bits += 8;
    }
}

static inline uint32_t get_bits(bit_reader *r, unsigned bits)
{
    if (r->held_bits < bits)
        hold_more(r);
    uint32_t value = (uint32_t)r->held & ((1u << bits) - 1u);
    r->held >>= bits;
    r->held_bits -= bits;
    r->used += bits;
    return value;
}

/* Joins the low bits to the high parts, in place. */
static void join(int16_t *cells, uint32_t count, spread s, bit_reader *low)
{
    for (uint32_t i = 0; i < count; i++) {
        unsigned bits = spread_low_bits(&s);
        int32_t high = (int32_t)((uint32_t)(int32_t)cells[i] << bits);
        cells[i] = (int16_t)(high + (int32_t)get_bits(low, bits) - half_of(bits));
        spread_take(&s, cells[i]);
    }
}

stp_status stp_column_decode(const uint8_t *bytes, size_t size, int16_t *cells, uint32_t count,
                             size_t *used, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t head = size < HEAD_BYTES ? 0 : stp_get_u32(bytes);
    size_t stream_bytes = head & STREAM_BYTES_MASK;
    unsigned first = head >> 24 & 15u;
    unsigned kept = head >> 28;
    if (size < HEAD_BYTES || stream_bytes > size - HEAD_BYTES)
        return stp_error_set(err, STP_CORRUPT, "a stream does not fit into its block");
    STP_TRY(stp_stream_check(bytes + HEAD_BYTES, stream_bytes, err));
    STP_TRY(stp_draco_decode(bytes + HEAD_BYTES, stream_bytes, cells, count, err));
    *used = HEAD_BYTES + stream_bytes;
    if (kept > 0) {
        bit_reader low = {.bytes = bytes + *used, .size = size - *used};
        join(cells, count, spread_begin(kept, first), &low);
        if (low.used > 8 * low.size)
            return stp_error_set(err, STP_CORRUPT, "a block ends within its low bits");
        *used += (low.used + 7) / 8;
    }
done:
    return status;
}

stp_status stp_column_read(stp_cursor *c, int16_t *cells, uint32_t count, stp_error *err)
{
    size_t used = 0;
    const stp_status status = stp_column_decode(c->bytes, c->left, cells, count, &used, err);
    if (status == STP_OK)
        stp_cursor_skip(c, used);
    return status;
}
