/* Codes the colours of level 0 of squares by rows. */
#include "formats/chunk/codec/square/square_colours.h"

#include "base/memory.h"
#include "base/wide.h"
#include "formats/chunk/codec/square/square_slope.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Each channel follows those before it. */
#define CHANNELS 3
static const uint8_t channel[CHANNELS] = {1, 0, 2}; /* green, red, blue */
/* Samples around that come before: left, above, and above to the left and the right. */
#define NEAR 4
/* Other parents around a parent. */
#define PARENTS 8
#define PARENTS_SHARE 0.25f /* so that they do not outweigh all else where weights learn */
/* What tells of a channel: how far those around are off what was expected of them; what is left of
 * the parent; how far the first channel is off, and of the third one the second. If it is told by
 * parents, also how far those around are off in these two channels, and how much the other parents
 * around differ from the own one. */
enum { LEFT = NEAR, FIRST, SECOND, PLAIN_COUNT = 8, OTHERS = 8, BESIDE = 16, INPUT_COUNT = 24 };
typedef float four __attribute__((vector_size(sizeof(float) * NEAR)));
typedef union inputs {
    float of[INPUT_COUNT]; /* that of PLAIN_COUNT - 1 is 0 */
    four part[INPUT_COUNT / NEAR];
} inputs;
/* Kinds of a child: the place among four; the last one of less than four; others. */
enum { LAST_OF_FEW = 4, OF_FEW, KIND_COUNT };
/* In sixteenths: how much each input counts at first. */
static const int8_t first_weights[KIND_COUNT][PLAIN_COUNT] = {
    {6, 7, -2, -1, 0, 6, 1}, {1, 5, 0, 1, 12, 8, 0}, {4, 4, -1, -3, 13, 4, -1},
    {1, 1, 0, 0, 15, 1, 0},  {0, 0, 0, 0, 16, 0, 0}, {2, 2, 0, 0, 10, 10, 2},
};
/* The same of channels behind the first one, if they follow that. */
static const int8_t following[PLAIN_COUNT] = {[FIRST] = 16};
/* If it is told by parents, in 64ths: of blocks whose channels do not follow, then of those that
 * do, by kind, channel and input. */
static const int8_t first_by_parents[] = {
#include "formats/chunk/codec/square/colour_weights.inc"
};
_Static_assert(sizeof first_by_parents == (size_t)2 * KIND_COUNT * CHANNELS * INPUT_COUNT,
               "weights of all inputs");
/* The last child is off what is left of the parent's by its rounding alone. What odds it has, if it
 * is told by parents: by how far what is hoped is off that, in halves up to OFF_MOST, and by a
 * class: four children of an even or an odd parent, one or two, three. */
#define OFF_MOST 1.5f
#define OFF_STEPS 7u
enum { OF_ONE_OR_TWO = 2, OF_THREE, CLASS_COUNT };
_Static_assert(CLASS_COUNT *OFF_STEPS == STP_KNOWN_NUMBERS, "odds of last children");
/* How fast weights move, and what keeps them where inputs are small. */
#define RATE (5.0f / 64.0f)
#define POWER_LEAST 4.0f
/* The bits of the first means: of the first channel of elder children, and of the others. */
#define FIRST_MEAN 9
#define OTHER_MEAN 8

/* Colours are noise, for which rows do not pay, if samples less half of what those to the left, or
 * those above, are off have more than this part of their own squares (5/4 where they have nothing
 * to do with each other), and the square of a channel's is more than NOISE_LEAST on average. Every
 * so manieth patch is judged. */
#define NOISE_BESIDE 1.15
#define NOISE_LEAST 4.0
/* Where what is beside tells less than this, weights that photographs taught are worse than none.
 */
#define TELLS_BESIDE 1.1
#define JUDGED_EVERY 4u
#define MANY_PATCHES 32u

typedef struct spot {
    float off[CHANNELS]; /* what is expected; when it is known, the value less that */
    uint32_t parent;
    uint8_t size[CHANNELS]; /* magnitudes of cells */
} spot;

typedef struct brood {
    float left[CHANNELS];   /* what is expected less what came, of all children so far */
    int16_t rest[CHANNELS]; /* of the parent's times `count`, less the children so far */
    uint8_t count, known;   /* children in all, and so far */
} brood;

/* The samples around one that come before. */
typedef struct around {
    const spot *of[NEAR]; /* `nothing` where there is none */
    uint32_t share;       /* what a magnitude counts, in 2^-16; 0: there is none at all */
} around;
static const spot nothing;

/* Numbers of elder or of last children. */
typedef struct numbers {
    stp_number_odds odds[CHANNELS];
    uint32_t mean[CHANNELS];
    uint32_t rows;
    int known; /* 1: what the odds began with was known */
} numbers;

typedef struct coder {
    const stp_chunk *block;
    spot *spots;
    brood *broods;
    float (*beside)[CHANNELS][PARENTS]; /* by parent: what others differ; NULL: nobody asks */
    bool *done;                         /* by grid */
    inputs weights[KIND_COUNT][CHANNELS];
    numbers of[2]; /* elder, last */
} coder;

/* Where cells go, or come from: one of both. */
typedef struct cells {
    stp_symbol_writer w;
    stp_symbol_reader r;
} cells;

/* ---- what the parents tell ---- */

/* How much the parents around one differ from it. */
STP_INLINE void compare_parents(const stp_square_level *on, uint32_t parent,
                                const double *const *values, float out[CHANNELS][PARENTS])
{
    const int column = stp_square_cell(on->column[parent], 1);
    const int row = stp_square_cell(on->row[parent], 1);
    for (int i = 0; i < PARENTS; i++) {
        const int place = i < PARENTS / 2 ? i : i + 1; /* the parent's own place is left out */
        const int32_t other = stp_square_at(on, column + place % 3 - 1, row + place / 3 - 1);
        for (int v = 0; v < CHANNELS; v++)
            out[v][i] =
                other < 0 ? 0.0f : (float)(values[v][other] - values[v][parent]) * PARENTS_SHARE;
    }
}

/* values: of the parents, by channel. Of every so manieth patch. */
STP_WIDE
static void expect(coder *c, const stp_square_map *map, const double *const *values, uint32_t every)
{
    const stp_chunk *block = c->block;
    for (uint32_t p = 0; p < block->patch_count; p += every) {
        const stp_square_grid *grid = stp_square_grid_of(map, p);
        const unsigned parents = block->patches[p].counts[1];
        const unsigned children = block->patches[p].counts[0];
        for (unsigned j = 0; j < parents; j++) {
            const uint32_t parent = block->level_begin[1][p] + j;
            const unsigned begin = stp_level_children_begin(j, parents, children);
            const unsigned count = stp_level_children_begin(j + 1, parents, children) - begin;
            const stp_square_field field =
                stp_square_field_at(&grid->level[1], 1, (int32_t)parent, values, CHANNELS);
            brood *b = &c->broods[parent];
            *b = (brood){.count = (uint8_t)count};
            for (int v = 0; v < CHANNELS; v++)
                b->rest[v] = (int16_t)(count * (unsigned)values[v][parent]);
            if (c->beside)
                compare_parents(&grid->level[1], parent, values, c->beside[parent]);
            for (unsigned k = 0; k < count; k++) {
                const uint32_t child = block->level_begin[0][p] + begin + k;
                double expected[CHANNELS];
                spot *s = &c->spots[child];
                s->parent = parent;
                stp_square_expect(&field, &grid->level[0], 0, child, count, CHANNELS, expected);
                for (int v = 0; v < CHANNELS; v++)
                    s->off[v] = (float)expected[v];
            }
        }
    }
}

/* ---- a sample ---- */

/* The sum of the products of so many parts of inputs. */
STP_INLINE float sum_of(const inputs *a, const inputs *b, unsigned parts)
{
    four p = a->part[0] * b->part[0];
    for (unsigned i = 1; i < parts; i++)
        p += a->part[i] * b->part[i];
    return (p[0] + p[1]) + (p[2] + p[3]);
}

STP_INLINE void learn(inputs *weights, const inputs *in, float off, unsigned parts)
{
    const float step = off * RATE / (POWER_LEAST + sum_of(in, in, parts));
    for (unsigned i = 0; i < parts; i++)
        weights->part[i] += in->part[i] * step;
}

STP_INLINE four off_around(const around *near, int v)
{
    return (four){near->of[0]->off[v], near->of[1]->off[v], near->of[2]->off[v],
                  near->of[3]->off[v]};
}

/* What tells of a channel. left: of the parent's; before: how far the first two channels are off.
 */
STP_INLINE void gather(const coder *c, const around *near, uint32_t parent, int v, float left,
                       const float before[CHANNELS], bool by_parents, inputs *out)
{
    out->part[0] = off_around(near, v);
    out->part[1] = (four){left, before[0], before[1], 0.0f};
    for (int u = 0; by_parents && u < 2; u++)
        out->part[OTHERS / NEAR + u] = u < v ? off_around(near, u) : (four){0.0f};
    if (by_parents)
        memcpy(&out->of[BESIDE], c->beside[parent][v], sizeof c->beside[parent][v]);
}

/* The mean of a channel's magnitudes around, in 1/256; `mean` if there is none. */
STP_INLINE uint32_t mean_around(const around *a, int v, uint32_t mean)
{
    const uint32_t sum =
        2u * a->of[0]->size[v] + 2u * a->of[1]->size[v] + a->of[2]->size[v] + a->of[3]->size[v];
    return a->share > 0 ? sum * a->share >> (16 - STP_MEAN_BITS) : mean;
}

/* The number of least magnitude that equals x modulo 256. */
STP_INLINE int32_t least(int32_t x)
{
    return ((x + 128) & 255) - 128;
}

/* Codes a value with the cell of least magnitude, which it returns. way: `beside` becomes what the
 * cell is beside the next one. */
STP_INLINE int32_t code(cells *to, stp_odds *odds, stp_number_way *way, int32_t predicted,
                        uint8_t *value, bool decode)
{
    if (!decode) {
        const int32_t cell = least(*value - predicted);
        way->beside = stp_number_put(&to->w, odds, way, cell);
        return cell;
    }
    const int32_t cell = least(stp_number_get(&to->r, odds, way, &way->beside));
    *value = (uint8_t)(predicted + cell);
    return cell;
}

/* Codes the last child: `rest` is all but the rounding of its parent's. */
STP_INLINE int32_t code_last(cells *to, stp_odds *odds, stp_number_way *way, const brood *b, int v,
                             uint8_t parent, float hoped, uint8_t *value, bool decode)
{
    const int32_t rest = b->rest[v];
    const unsigned few = b->count == 3 ? OF_THREE : OF_ONE_OR_TWO;
    const unsigned class = b->count == 4 ? parent & 1u : few;
    float off = hoped - (float)rest;
    off = off > -OFF_MOST ? (off < OFF_MOST ? off : OFF_MOST) : -OFF_MOST;
    const unsigned place = (unsigned)(off * 2.0f + (float)OFF_STEPS / 2.0f);
    way->mean = 0;
    way->beside = STP_BESIDE_ABSENT;
    return code(to, &odds[class * OFF_STEPS + place], way, rest, value, decode);
}

/* What is written comes last: a byte may be anything's, so all would be read anew. */
STP_INLINE void code_sample(coder *c, cells *to, uint32_t sample, const around *near,
                            bool by_parents, bool decode)
{
    static const float shares[] = {0.0f, 1.0f, 1.0f / 2.0f, 1.0f / 3.0f, 1.0f / 4.0f};
    stp_sample *out = &c->block->samples[0][sample];
    spot s = c->spots[sample];
    brood *b = &c->broods[s.parent];
    const unsigned k = b->known, count = b->count,
                   parts = (unsigned)(by_parents ? INPUT_COUNT : PLAIN_COUNT) / NEAR;
    const bool last = k + 1 == count;
    const unsigned kind = count == 4 ? k : last ? LAST_OF_FEW : OF_FEW;
    const float share = shares[count - k];
    const uint8_t *parent = c->block->samples[1][s.parent].rgb;
    numbers *of = &c->of[last];
    stp_number_way way = {.beside = STP_BESIDE_ABSENT,
                          .shift = stp_odds_shift(of->rows, of->known)};
    uint8_t value[CHANNELS];
    float before[CHANNELS] = {0.0f}; /* how far the first two channels are off */
    for (int v = 0; v < CHANNELS; v++)
        value[v] = out->rgb[channel[v]];
#pragma GCC unroll 3
    for (int v = 0; v < CHANNELS; v++) {
        inputs in, *weights = &c->weights[kind][v];
        gather(c, near, s.parent, v, share * b->left[v], before, by_parents, &in);
        const float expected = s.off[v], hoped = expected + sum_of(weights, &in, parts);
        way.lane = (unsigned)v & 1u;
        int32_t cell;
        if (by_parents && last) {
            cell = code_last(to, of->odds[v].of, &way, b, v, parent[channel[v]], hoped, &value[v],
                             decode);
        } else {
            const float limited = hoped > 0.0f ? (hoped < 255.0f ? hoped : 255.0f) : 0.0f;
            way.mean = last ? of->mean[v] : (of->mean[v] + mean_around(near, v, of->mean[v])) / 2;
            cell = code(to, of->odds[v].of, &way, (int32_t)(limited + 0.5f), &value[v], decode);
        }
        learn(weights, &in, value[v] - hoped, parts);
        of->mean[v] = stp_mean_after(of->mean[v], cell);
        s.size[v] = (uint8_t)abs(cell);
        s.off[v] = value[v] - expected;
        b->left[v] -= s.off[v];
        b->rest[v] = (int16_t)(b->rest[v] - value[v]);
        before[v] = s.off[v];
    }
    of->rows++;
    c->spots[sample] = s;
    b->known = (uint8_t)(k + 1);
    for (int v = 0; v < CHANNELS && decode; v++) /* encoding writes no samples */
        out->rgb[channel[v]] = value[v];
}

/* ---- a level ---- */

/* Codes the samples of a cell, the last one first. */
STP_INLINE void code_cell(coder *c, cells *to, const stp_square_level *on, int column, int row,
                          bool by_parents, bool decode)
{
    static const uint8_t counts[NEAR] = {2, 2, 1, 1};
    static const uint32_t shares[] = {0, 65536, 32768, 21845, 16384, 13107, 10922};
    const int32_t sample[NEAR] = {
        stp_square_at(on, column - 1, row), stp_square_at(on, column, row - 1),
        stp_square_at(on, column - 1, row - 1), stp_square_at(on, column + 1, row - 1)};
    around near;
    unsigned count = 0;
    for (int i = 0; i < NEAR; i++) {
        near.of[i] = sample[i] >= 0 ? &c->spots[sample[i]] : &nothing;
        count += sample[i] >= 0 ? counts[i] : 0;
    }
    near.share = shares[count];
    for (int32_t i = stp_square_at(on, column, row); i >= 0; i = on->before[i])
        code_sample(c, to, (uint32_t)i, &near, by_parents, decode);
}

/* Rasters come as patches come to them: in a file they have no other order. */
STP_INLINE void code_all(coder *c, cells *to, const stp_square_map *map, bool by_parents,
                         bool decode)
{
    cells own = *to; /* nothing else points to them: they stay in registers */
    for (uint32_t p = 0; p < c->block->patch_count; p++) {
        const stp_square_grid *grid = stp_square_grid_of(map, p);
        const stp_square_level *on = &grid->level[0];
        bool *done = &c->done[grid - map->grids];
        for (int row = 0; row < on->cell_rows && !*done; row++)
            for (int column = 0; column < on->cell_columns; column++)
                code_cell(c, &own, on, column, row, by_parents, decode);
        *done = true;
    }
    *to = own;
}

STP_WIDE
static void encode_all(coder *c, cells *to, const stp_square_map *map)
{
    code_all(c, to, map, true, false);
}

STP_WIDE
static void decode_all(coder *c, cells *to, const stp_square_map *map)
{
    code_all(c, to, map, true, true);
}

STP_WIDE
static void encode_plain(coder *c, cells *to, const stp_square_map *map)
{
    code_all(c, to, map, false, false);
}

STP_WIDE
static void decode_plain(coder *c, cells *to, const stp_square_map *map)
{
    code_all(c, to, map, false, true);
}

/* first: NULL if odds are known. */
static void begin_odds(coder *c, stp_first_odds *first, bool follow)
{
    for (int t = 0; t < 2; t++) {
        const uint8_t *known =
            t == 1 && c->beside ? stp_known_last_colours() : stp_known_colours(t == 1);
        c->of[t].rows = 0;
        c->of[t].known = !first;
        for (int v = 0; v < CHANNELS; v++) {
            if (first)
                c->of[t].odds[v] = *stp_number_odds_first(first, 0);
            else
                stp_known_cells(known + (size_t)STP_KNOWN_COUNT * (unsigned)v, STP_KNOWN_NUMBERS,
                                c->of[t].odds[v].of);
            c->of[t].mean[v] = UINT32_C(1) << (t == 0 && v == 0 ? FIRST_MEAN : OTHER_MEAN);
        }
    }
    for (int kind = 0; kind < KIND_COUNT; kind++)
        for (int v = 0; v < CHANNELS; v++) {
            const size_t at =
                ((size_t)(follow ? KIND_COUNT : 0) + (size_t)kind) * CHANNELS + (size_t)v;
            const int8_t *by_parents = first_by_parents + at * INPUT_COUNT;
            const int8_t *plain = follow && v > 0 ? following : first_weights[kind];
            inputs *weights = &c->weights[kind][v];
            for (int i = 0; i < INPUT_COUNT && c->beside; i++)
                weights->of[i] = (float)by_parents[i] / 64.0f;
            for (int i = 0; i < PLAIN_COUNT && !c->beside; i++)
                weights->of[i] = (float)plain[i] / 16.0f;
        }
}

/* Whether the differences of channels are less than half as much off as they are. */
static bool would_follow(const coder *c)
{
    const stp_chunk *block = c->block;
    double alone = 0.0, together = 0.0;
    for (uint32_t i = 0; i < block->level_begin[0][block->patch_count]; i++) {
        float off[CHANNELS];
        for (int v = 0; v < CHANNELS; v++)
            off[v] = block->samples[0][i].rgb[channel[v]] - c->spots[i].off[v];
        for (int v = 1; v < CHANNELS; v++) {
            alone += fabs((double)off[v]);
            together += fabs((double)(off[v] - off[0]));
        }
    }
    return together < alone / 2.0;
}

/* Makes a coder that knows what the parents of every so manieth patch tell; clear it even if it
 * fails. by_parents: also what those around them tell. */
static stp_status coder_create(const stp_chunk *block, const stp_square_map *map, uint32_t every,
                               bool by_parents, coder *c, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = block->level_begin[0][block->patch_count];
    const uint32_t parents = block->level_begin[1][block->patch_count];
    const double *values[CHANNELS];
    c->block = block;
    c->spots = NULL;
    c->broods = NULL;
    c->beside = NULL;
    c->done = NULL;
    STP_TRY(stp_alloc_unset(&c->spots, count, sizeof *c->spots, "colours by rows", err));
    STP_TRY(stp_alloc_unset(&c->broods, parents, sizeof *c->broods, "colours by rows", err));
    if (by_parents)
        STP_TRY(stp_alloc_unset(&c->beside, parents, sizeof *c->beside, "colours by rows", err));
    STP_TRY(stp_alloc(&c->done, map->grid_count, sizeof *c->done, "colours by rows", err));
    for (int v = 0; v < CHANNELS; v++) {
        double *colours = map->sums + (size_t)v * parents;
        for (uint32_t i = 0; i < parents; i++)
            colours[i] = block->samples[1][i].rgb[channel[v]];
        values[v] = colours;
    }
    expect(c, map, values, every);
done:
    return status;
}

static void coder_clear(const coder *c)
{
    free(c->spots);
    free(c->broods);
    free(c->beside);
    free(c->done);
}

static bool colours_vary(const stp_chunk *block)
{
    const stp_sample *samples = block->samples[0];
    bool same = true;
    for (uint32_t i = 1; i < block->level_begin[0][block->patch_count] && same; i++)
        same = memcmp(samples[i].rgb, samples[0].rgb, CHANNELS) == 0;
    return !same;
}

/* How far a sample is off what its parent tells. */
STP_INLINE float off_of(const coder *c, uint32_t i, int v)
{
    return c->block->samples[0][i].rgb[channel[v]] - c->spots[i].off[v];
}

/* Sums of squares: how far samples are off, alone and less half of that beside. */
typedef struct verdict {
    double alone, beside, count;
} verdict;

/* Adds the samples of a patch that have one of another parent so many columns and rows before. */
static void judge(const coder *c, const stp_square_map *map, uint32_t p, int columns, int rows,
                  verdict *out)
{
    const uint32_t *begin = c->block->level_begin[0];
    const stp_square_level *on = &stp_square_grid_of(map, p)->level[0];
    for (uint32_t i = begin[p]; i < begin[p + 1]; i++) {
        const int32_t other =
            stp_square_at(on, (int)on->column[i] - columns, (int)on->row[i] - rows);
        if (other < (int32_t)begin[p] || other >= (int32_t)begin[p + 1] ||
            c->spots[other].parent == c->spots[i].parent)
            continue;
        for (int v = 0; v < CHANNELS; v++) {
            const float off = off_of(c, i, v), less = off - off_of(c, (uint32_t)other, v) / 2;
            out->alone += (double)(off * off);
            out->beside += (double)(less * less);
            out->count++;
        }
    }
}

static bool beside_tells(const verdict *v)
{
    return v->beside < TELLS_BESIDE * v->alone;
}

static bool is_noise(const verdict *v)
{
    return v->alone > NOISE_LEAST * v->count && v->beside > NOISE_BESIDE * v->alone;
}

stp_status stp_square_colours_pay(const stp_chunk *block, const stp_square_map *map, bool *pay,
                                  bool *by_parents, stp_error *err)
{
    stp_status status = STP_OK;
    coder c = {0};
    verdict left = {0}, above = {0};
    const uint32_t every = block->patch_count < MANY_PATCHES ? 1 : JUDGED_EVERY;
    *pay = colours_vary(block);
    *by_parents = false;
    if (!*pay)
        return STP_OK;
    STP_TRY(coder_create(block, map, every, false, &c, err));
    for (uint32_t p = 0; p < block->patch_count; p += every) {
        judge(&c, map, p, 1, 0, &left);
        judge(&c, map, p, 0, 1, &above);
    }
    *pay = !is_noise(&left) || !is_noise(&above);
    *by_parents = *pay && (beside_tells(&left) && beside_tells(&above));
done:
    coder_clear(&c);
    return status;
}

stp_status stp_square_colours_encode(const stp_chunk *block, const stp_square_map *map,
                                     bool by_parents, stp_symbol_writer *w, stp_error *err)
{
    stp_status status = STP_OK;
    coder c;
    cells to = {0};
    const size_t count = (size_t)CHANNELS * block->level_begin[0][block->patch_count];
    STP_TRY(coder_create(block, map, 1, by_parents, &c, err));
    STP_TRY(stp_symbols_reserve(w, 1 + STP_NUMBER_ITEMS * count, err));
    const bool follow = would_follow(&c);
    stp_symbol_put_bits(w, 0, follow, 1);
    begin_odds(&c, NULL, follow);
    to.w = *w;
    if (by_parents)
        encode_all(&c, &to, map);
    else
        encode_plain(&c, &to, map);
    *w = to.w;
done:
    coder_clear(&c);
    return status;
}

stp_status stp_square_colours_decode(const stp_chunk *block, const stp_square_map *map,
                                     bool by_parents, stp_tight_reader *tight, stp_error *err)
{
    stp_symbol_reader *r = &tight->symbols;
    coder c;
    cells to = {0};
    if (by_parents && !tight->known)
        return stp_error_set(err, STP_CORRUPT, "colours by parents have no known odds");
    const stp_status status = coder_create(block, map, 1, by_parents, &c, err);
    if (status == STP_OK) {
        begin_odds(&c, tight->known ? NULL : &tight->first, stp_symbol_get_bits(r, 0, 1));
        to.r = *r;
        if (by_parents)
            decode_all(&c, &to, map);
        else
            decode_plain(&c, &to, map);
        *r = to.r;
    }
    coder_clear(&c);
    return status;
}
