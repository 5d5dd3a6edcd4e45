/* Packs the samples of a patch into texels. */
#include "runtime/stream/texels.h"

#include <string.h>

enum { X, Y, Z, U, V, FLAGS, RADIUS, RED, GREEN, BLUE, CLASS, INTENSITY, FIELDS };

/* Where each field's bits are among the two words of widths, and how many bits tell them. */
static const struct {
    uint8_t at, bits;
    bool is_signed;
} fields[FIELDS] = {{0, 5, true},  {5, 5, true},   {10, 5, true},  {15, 4, true},
                    {19, 4, true}, {23, 4, false}, {32, 4, false}, {36, 4, true},
                    {40, 4, true}, {44, 4, true},  {48, 4, false}, {52, 4, true}};
enum {
    NORMAL_SHIFT_AT = 27,
    RADIUS_SHIFT_AT = 31,
    PLACE_SHIFT_AT = 56,
    U_QUARTERS_AT = 60,
    Z_QUARTERS_AT = 62
};
/* Radii are shifted by so many bits, or not at all. */
#define RADIUS_SHIFT 2u
/* Zero lies in the middle of a signed field's range, unless the field says otherwise. */
#define MIDDLE 2u
/* Texels behind those that every patch has. */
enum { WIDTHS, ERRORS_2, LEVELS, ERRORS_1 };

static uint32_t normal_of(const stp_sample *s)
{
    return s->normal[0] | (uint32_t)s->normal[1] << 8 | (uint32_t)s->normal[2] << 16;
}

/* The difference of two numbers of so many bits, half of all negative. */
static int32_t wrap(uint32_t number, uint32_t from, unsigned bits)
{
    const uint32_t half = 1u << (bits - 1), difference = (number - from) & (2 * half - 1);
    return (int32_t)(difference ^ half) - (int32_t)half;
}

/* What is stored of a sample, before signed fields become unsigned. radius: of its level. */
static void differences(const stp_sample *s, const stp_sample *vertex, uint8_t radius,
                        int32_t out[FIELDS])
{
    const uint32_t normal = normal_of(s), mean = normal_of(vertex);
    const unsigned flags = s->flags ^ vertex->flags;
    for (int k = 0; k < 3; k++) {
        out[X + k] = wrap(s->position[k], vertex->position[k], 16);
        out[RED + k] = wrap(s->rgb[k], vertex->rgb[k], 8);
    }
    out[U] = wrap(normal, mean, 12);
    out[V] = wrap(normal >> 12, mean >> 12, 12);
    out[FLAGS] = (uint8_t)(flags << 2 | flags >> 6);
    out[RADIUS] = (uint8_t)(radius - s->radius);
    out[CLASS] = s->class_id ^ vertex->class_id;
    out[INTENSITY] = wrap(s->intensity, vertex->intensity, 8);
}

static unsigned bits_of(uint32_t number)
{
    return number == 0 ? 0 : 32 - (unsigned)__builtin_clz(number);
}

/* The bits of a patch's fields, by how many bits their steps are shifted, and where zero lies in
 * their ranges, in quarters. */
typedef struct widths {
    unsigned of[FIELDS], shift[FIELDS], quarters[FIELDS], total;
} widths;

/* How many bits are zero in all of these numbers. */
static unsigned shift_of(int32_t a, int32_t b)
{
    return (a | b) != 0 ? (unsigned)__builtin_ctz((uint32_t)(a | b)) : 0;
}

/* What is added to a field, so that it is not negative. */
static uint32_t bias_of(const widths *w, int f)
{
    return w->quarters[f] << w->of[f] >> 2;
}

/* Takes a bit from a field if there is room for all from least to most with zero elsewhere. */
static void narrow(int f, int32_t least, int32_t most, widths *w)
{
    widths one_less = *w;
    one_less.of[f]--;
    for (unsigned quarters = 0; quarters < 4 && w->of[f] > 1; quarters++) {
        one_less.quarters[f] = quarters;
        const int32_t bias = (int32_t)bias_of(&one_less, f);
        if (least + bias >= 0 && most + bias < 1 << one_less.of[f]) {
            *w = one_less;
            return;
        }
    }
}

/* rows: differences() of count samples. */
static widths measure(int32_t (*rows)[FIELDS], unsigned count)
{
    int32_t any[FIELDS] = {0}, least[FIELDS] = {0}, most[FIELDS] = {0};
    widths w = {.total = 0};
    for (unsigned i = 0; i < count; i++)
        for (int f = 0; f < FIELDS; f++) {
            any[f] |= rows[i][f];
            least[f] = rows[i][f] < least[f] ? rows[i][f] : least[f];
            most[f] = rows[i][f] > most[f] ? rows[i][f] : most[f];
        }
    w.shift[X] = w.shift[Y] = shift_of(any[X], any[Y]);
    w.shift[U] = w.shift[V] = shift_of(any[U], any[V]);
    w.shift[RADIUS] = shift_of(any[RADIUS], 1 << RADIUS_SHIFT) & RADIUS_SHIFT;
    for (int f = 0; f < FIELDS; f++) {
        const unsigned sign = fields[f].is_signed && any[f] != 0;
        w.quarters[f] = fields[f].is_signed ? MIDDLE : 0;
        w.of[f] =
            bits_of((uint32_t)(least[f] < 0 ? ~least[f] | most[f] : most[f]) >> w.shift[f]) + sign;
        if (f == U || f == Z)
            narrow(f, least[f] >> w.shift[f], most[f] >> w.shift[f], &w);
        w.total += w.of[f];
    }
    return w;
}

static uint64_t widths_pack(const widths *w)
{
    uint64_t texel = (uint64_t)w->shift[U] << NORMAL_SHIFT_AT |
                     (uint64_t)(w->shift[RADIUS] > 0) << RADIUS_SHIFT_AT |
                     (uint64_t)w->shift[X] << PLACE_SHIFT_AT |
                     (uint64_t)w->quarters[U] << U_QUARTERS_AT |
                     (uint64_t)w->quarters[Z] << Z_QUARTERS_AT;
    for (int f = 0; f < FIELDS; f++)
        texel |= (uint64_t)w->of[f] << fields[f].at;
    return texel;
}

static widths widths_unpack(uint64_t texel)
{
    widths w = {.total = 0};
    w.shift[U] = w.shift[V] = texel >> NORMAL_SHIFT_AT & 15u;
    w.shift[RADIUS] = texel >> RADIUS_SHIFT_AT & 1u ? RADIUS_SHIFT : 0;
    w.shift[X] = w.shift[Y] = texel >> PLACE_SHIFT_AT & 15u;
    for (int f = 0; f < FIELDS; f++) {
        w.of[f] = (unsigned)(texel >> fields[f].at) & ((1u << fields[f].bits) - 1);
        w.quarters[f] = fields[f].is_signed ? MIDDLE : 0;
        w.total += w.of[f];
    }
    w.quarters[U] = texel >> U_QUARTERS_AT & 3u;
    w.quarters[Z] = (unsigned)(texel >> Z_QUARTERS_AT);
    return w;
}

/* Texels that are written one after the other: the memory may be slow to read. */
typedef struct bit_writer {
    uint64_t *out, texel;
    unsigned filled;
} bit_writer;

/* width: up to 48. */
static void put(bit_writer *b, uint64_t bits, unsigned width)
{
    b->texel |= bits << b->filled;
    b->filled += width;
    if (b->filled < 64)
        return;
    *b->out++ = b->texel;
    b->filled -= 64;
    b->texel = b->filled == 0 ? 0 : bits >> (width - b->filled);
}

static void put_fields(bit_writer *b, const int32_t row[FIELDS], const widths *w, int first,
                       int end)
{
    uint64_t bits = 0;
    unsigned width = 0;
    for (int f = first; f < end; f++) {
        const int32_t d = row[f] >> w->shift[f];
        bits |= (uint64_t)((uint32_t)d + bias_of(w, f)) << width;
        width += w->of[f];
    }
    put(b, bits, width);
}

int stp_texels_finest(const stp_chunk *chunk, uint32_t patch)
{
    int level = chunk->finest_level;
    while (chunk->level_begin[level][patch] == chunk->level_begin[level][patch + 1])
        level++;
    return level;
}

bool stp_texels_apart(const stp_chunk *chunk, uint32_t patch)
{
    const stp_sample *vertex = &chunk->samples[3][chunk->level_begin[3][patch]];
    return memcmp(vertex->position, chunk->patches[patch].bound_centre, sizeof vertex->position) !=
           0;
}

uint32_t stp_texels_head(bool apart, int finest)
{
    return 2 + (uint32_t)apart + (finest == 3 ? 0 : finest == 2 ? LEVELS : ERRORS_1 + 1);
}

static uint64_t errors_of(const stp_patch *patch, int level)
{
    uint64_t texel = 0;
    memcpy(&texel, patch->quarter_error[level - 1], STP_PATCH_QUARTERS);
    memcpy((uint8_t *)&texel + STP_PATCH_QUARTERS, patch->quarter_tangential_error[level - 1],
           STP_PATCH_QUARTERS);
    return texel;
}

static uint64_t levels_of(const stp_patch *p)
{
    const uint8_t bytes[STP_TEXEL_BYTES] = {
        p->radius[0],       p->radius[1], p->colour_error[2],    p->colour_error[1],
        p->colour_error[0], p->error[0],  p->tangential_error[0]};
    uint64_t texel;
    memcpy(&texel, bytes, sizeof texel);
    return texel;
}

uint32_t stp_texels_write(uint64_t *out, const stp_chunk *chunk, uint32_t patch)
{
    int32_t rows[STP_TEXELS_PACKED_LIMIT][FIELDS];
    unsigned count = 0;
    const stp_patch *p = &chunk->patches[patch];
    const stp_sample *vertex = &chunk->samples[3][chunk->level_begin[3][patch]];
    const int finest = stp_texels_finest(chunk, patch);
    const bool apart = stp_texels_apart(chunk, patch);
    uint64_t *head = out + 2 + apart;
    memcpy(out, vertex, sizeof *vertex);
    if (apart) {
        out[2] = 0;
        memcpy(&out[2], p->bound_centre, sizeof p->bound_centre);
    }
    for (int l = 2; l >= finest; l--)
        for (uint32_t i = chunk->level_begin[l][patch]; i < chunk->level_begin[l][patch + 1]; i++)
            differences(&chunk->samples[l][i], vertex, p->radius[l], rows[count++]);
    bit_writer b = {.out = out + stp_texels_head(apart, finest)};
    if (count == 0)
        return (uint32_t)(b.out - out);
    const widths w = measure(rows, count);
    head[WIDTHS] = widths_pack(&w);
    head[ERRORS_2] = errors_of(p, 2);
    if (finest < 2) {
        head[LEVELS] = levels_of(p);
        head[ERRORS_1] = errors_of(p, 1);
    }
    for (unsigned i = 0; i < count; i++) {
        put_fields(&b, rows[i], &w, X, U);
        put_fields(&b, rows[i], &w, U, RADIUS);
        put_fields(&b, rows[i], &w, RADIUS, FIELDS);
    }
    if (b.filled > 0)
        *b.out++ = b.texel;
    return (uint32_t)(b.out - out);
}

/* Field f of a sample whose bits begin at `at` in packed texels, as differences() has it, modulo
 * 2^32. */
static uint32_t take(const uint64_t *packed, uint32_t *at, const widths *w, int f)
{
    const unsigned width = w->of[f], low = *at & 63u;
    const uint64_t *from = &packed[*at >> 6];
    const uint64_t bits = from[0] >> low | from[1] << 1 << (63 - low);
    *at += width;
    return (((uint32_t)bits & ((1u << width) - 1)) - bias_of(w, f)) << w->shift[f];
}

/* Adds differences to the vertex. radius: of the sample's level. */
static void add(stp_sample *vertex, const uint32_t d[FIELDS], uint8_t radius)
{
    stp_sample s = *vertex;
    const uint32_t mean = normal_of(&s);
    const uint32_t u = mean + d[U], v = (mean >> 12) + d[V];
    for (int k = 0; k < 3; k++) {
        s.position[k] = (uint16_t)(s.position[k] + d[X + k]);
        s.rgb[k] = (uint8_t)(s.rgb[k] + d[RED + k]);
    }
    s.normal[0] = (uint8_t)u;
    s.normal[1] = (uint8_t)((u >> 8 & 15u) | v << 4);
    s.normal[2] = (uint8_t)(v >> 4);
    s.flags = (uint8_t)(s.flags ^ (d[FLAGS] >> 2 | d[FLAGS] << 6));
    s.radius = (uint8_t)(radius - d[RADIUS]);
    s.class_id = (uint8_t)(s.class_id ^ d[CLASS]);
    s.intensity = (uint8_t)(s.intensity + d[INTENSITY]);
    *vertex = s;
}

bool stp_texels_read(const uint64_t *texels, const stp_gpu_patch *patch, uint32_t number,
                     stp_sample *out)
{
    const bool apart = (patch->flags & STP_GPU_PATCH_APART) != 0;
    const int finest = stp_gpu_patch_finest(patch);
    const uint64_t *head = texels + 2 + apart;
    const widths w = widths_unpack(head[WIDTHS]);
    const uint8_t radius[3] = {(uint8_t)head[LEVELS], (uint8_t)(head[LEVELS] >> 8),
                               patch->radius[1]};
    uint32_t d[FIELDS], at = (number - 1) * w.total;
    int level = 2;
    memcpy(out, texels, sizeof *out);
    if (number == 0)
        return true;
    while (level > 0 && number >= stp_level_number(stp_gpu_patch_count(patch), level - 1))
        level--;
    if (number > STP_TEXELS_PACKED_LIMIT || w.total > 8 * sizeof *out || level < finest)
        return false;
    for (int f = 0; f < FIELDS; f++)
        d[f] = take(texels + stp_texels_head(apart, finest), &at, &w, f);
    add(out, d, radius[level]);
    return true;
}
