/* The models of LAZ's arithmetic code. */
#include "formats/scan/las/laz/laz_model.h"

#define BIT_TOTAL_LIMIT (1u << STP_LAZ_BIT_SHIFT)
#define BIT_CYCLE_FIRST 4u
#define BIT_CYCLE_LIMIT 64u
#define SYMBOL_TOTAL_LIMIT (1u << STP_LAZ_SYMBOL_SHIFT)
/* Shares are below it. */
#define NO_SHARE UINT16_MAX

/* Entries of the table of a model: as many as symbols, so that one entry rarely leaves a choice. */
static unsigned table_bits(unsigned count)
{
    unsigned bits = 5;
    while (count > 1u << bits)
        bits++;
    return count > STP_LAZ_TABLE_SYMBOLS ? bits : 0;
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
    arena->used += (size_t)count + (bits ? count + (1u << bits) + 2 : STP_LAZ_TABLE_SYMBOLS);
}

/* Halves the counts if they grew too large, and makes probabilities of them. */
void stp_laz_symbols_update(stp_laz_symbols *m)
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

void stp_laz_symbols_begin(stp_laz_symbols *m, uint32_t epoch)
{
    m->epoch = epoch;
    m->total = 0;
    m->cycle = m->count;
    for (unsigned i = 0; i < m->count; i++)
        m->counts[i] = 1;
    for (unsigned i = m->count; i < STP_LAZ_TABLE_SYMBOLS; i++)
        m->distribution[i] = NO_SHARE;
    stp_laz_symbols_update(m);
    m->cycle = m->left = (m->count + 6u) >> 1;
}

void stp_laz_bit_update(stp_laz_bit *m)
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

void stp_laz_bit_begin(stp_laz_bit *m, uint32_t epoch)
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
        stp_laz_symbols_place(&m->corrections[k],
                              1u << (k < STP_LAZ_MODELLED_BITS ? k : STP_LAZ_MODELLED_BITS), arena);
}
