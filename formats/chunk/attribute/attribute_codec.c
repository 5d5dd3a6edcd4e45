/* Codes the numbers of an attribute: a prediction, and the difference in pieces of 16 bits. */
#include "formats/chunk/attribute/attribute_codec.h"

#include "base/memory.h"
#include "base/sort.h"
#include "formats/chunk/layout.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The head of a part: how numbers are predicted; pieces of a difference; decimals; the base. */
#define HEAD_BYTES 11u
#define PIECES_AT 1u
#define PIECES_MOST 4u
#define DECIMALS_NONE 255u
#define DECIMALS_MOST 9
/* Numbers that a difference may be counted from: those that ended the last few sequences. */
#define SEQUENCES 4u
/* A greater difference begins a sequence of its own. */
#define SEQUENCE_STEP ((int64_t)1 << 20)
/* Groups of columns: what a difference is parted to. */
#define GROUPS (STP_STEPS_LIMIT + 1)
/* Behind the head, if there are steps: how many, then each with the pieces of the group behind it.
 */
#define STEP_BYTES 9u

typedef enum prediction {
    FROM_BASE,      /* all by one number */
    FROM_BEFORE,    /* by the number before */
    FROM_SEQUENCES, /* by the last number of one of the latest sequences; the first column says
                       which */
    FROM_GUESS,     /* by what the sample's 8 bits say */
    FROM_STEPS,     /* as FROM_SEQUENCES, and differences are parted by steps of a clock */
    PREDICTION_COUNT
} prediction;

/* Differences wrap around, so that all words can be told. */
static int64_t difference(uint64_t a, uint64_t b)
{
    return (int64_t)(a - b);
}

static uint64_t magnitude(int64_t value)
{
    return value < 0 ? 0 - (uint64_t)value : (uint64_t)value;
}

/* ---- decimals ---- */

static const double tens[DECIMALS_MOST + 1] = {1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};

static double to_double(stp_attribute_type type, uint64_t word)
{
    const stp_attribute plain = {.type = type, .scale = 1.0};
    return stp_attribute_value(&plain, word);
}

static uint64_t from_decimal(stp_attribute_type type, uint64_t whole, unsigned decimals)
{
    const double value = (double)(int64_t)whole / tens[decimals];
    uint64_t word = 0;
    memcpy(&word, &value, sizeof word);
    return stp_attribute_convert(STP_ATTRIBUTE_F64, word, type);
}

/* The number with this many decimals. False if it is another. */
static bool to_decimal(stp_attribute_type type, uint64_t word, unsigned decimals, uint64_t *out)
{
    const double scaled = nearbyint(to_double(type, word) * tens[decimals]);
    if (!(fabs(scaled) < 0x1p53))
        return false;
    *out = (uint64_t)(int64_t)scaled;
    return from_decimal(type, *out, decimals) == word;
}

/* Makes floats whole numbers if all are decimals. Returns how many decimals, or DECIMALS_NONE. */
static unsigned make_whole(stp_attribute_type type, const uint64_t *words, uint32_t count,
                           uint64_t *out)
{
    unsigned decimals = 0;
    uint32_t i = 0;
    if (!stp_attribute_is_float(type))
        return DECIMALS_NONE;
    while (i < count && decimals <= DECIMALS_MOST) {
        if (to_decimal(type, words[i], decimals, &out[i])) {
            i++;
        } else { /* all again with one more */
            decimals++;
            i = 0;
        }
    }
    return decimals <= DECIMALS_MOST ? decimals : DECIMALS_NONE;
}

/* ---- predictions ---- */

/* The last numbers of the latest sequences, the latest first. */
typedef struct sequences {
    uint64_t last[SEQUENCES];
} sequences;

/* Takes the number of sequence `which` to the front, or a new one if which is SEQUENCES. */
static void sequences_take(sequences *s, unsigned which, uint64_t word)
{
    const unsigned to = which < SEQUENCES ? which : SEQUENCES - 1;
    memmove(s->last + 1, s->last, to * sizeof *s->last);
    s->last[0] = word;
}

static unsigned nearest_sequence(const sequences *s, uint64_t word)
{
    unsigned best = 0;
    for (unsigned i = 1; i < SEQUENCES; i++)
        if (magnitude(difference(word, s->last[i])) < magnitude(difference(word, s->last[best])))
            best = i;
    return magnitude(difference(word, s->last[best])) > (uint64_t)SEQUENCE_STEP ? SEQUENCES : best;
}

/* What differences are counted with. */
typedef struct coder {
    prediction how;
    uint64_t base;
    const uint64_t *guesses;
    stp_steps steps; /* of FROM_STEPS */
} coder;

static bool has_sequences(const coder *c)
{
    return c->how == FROM_SEQUENCES || c->how == FROM_STEPS;
}

static unsigned group_count(const coder *c)
{
    return c->how == FROM_STEPS ? c->steps.count + 1 : 1;
}

/* The words before. */
typedef struct history {
    uint64_t before;
    sequences latest;
} history;

static history history_begin(const coder *c)
{
    return (history){c->base, {{c->base, c->base, c->base, c->base}}};
}

/* What word i is counted from. which: its sequence, for FROM_SEQUENCES. */
static uint64_t predict(const coder *c, const history *h, uint32_t i, unsigned which)
{
    switch (c->how) {
    case FROM_BEFORE:
        return h->before;
    case FROM_SEQUENCES:
    case FROM_STEPS:
        return h->latest.last[which % SEQUENCES];
    case FROM_GUESS:
        return c->guesses[i];
    default:
        return c->base;
    }
}

static void history_take(const coder *c, history *h, unsigned which, uint64_t word)
{
    h->before = word;
    if (has_sequences(c))
        sequences_take(&h->latest, which, word);
}

/* Differences of all words, by group; which: by word, of sequences. */
static void differ(const coder *c, const uint64_t *words, uint32_t count,
                   int64_t *const out[GROUPS], int16_t *which)
{
    history h = history_begin(c);
    const unsigned groups = group_count(c);
    for (uint32_t i = 0; i < count; i++) {
        const unsigned k = has_sequences(c) ? nearest_sequence(&h.latest, words[i]) : 0;
        int64_t parts[GROUPS] = {difference(words[i], predict(c, &h, i, k))};
        if (c->how == FROM_STEPS)
            stp_steps_part(&c->steps, parts[0], parts);
        which[i] = (int16_t)k;
        for (unsigned g = 0; g < groups; g++)
            out[g][i] = parts[g];
        history_take(c, &h, k, words[i]);
    }
}

/* The inverse. False if `which` names no sequence, or a difference is no such number. */
static bool add_up(const coder *c, int64_t *const differences[GROUPS], const int16_t *which,
                   uint32_t count, uint64_t *words)
{
    history h = history_begin(c);
    const unsigned groups = group_count(c);
    for (uint32_t i = 0; i < count; i++) {
        const int16_t told = has_sequences(c) ? which[i] : (int16_t)0;
        int64_t parts[GROUPS];
        for (unsigned g = 0; g < groups; g++)
            parts[g] = differences[g][i];
        if (told < 0 || told > (int16_t)SEQUENCES ||
            (c->how == FROM_STEPS && !stp_steps_join(&c->steps, parts, &parts[0])))
            return false;
        words[i] = predict(c, &h, i, (unsigned)told) + (uint64_t)parts[0];
        history_take(c, &h, (unsigned)told, words[i]);
    }
    return true;
}

/* ---- choosing ---- */

#define SMALL 64
#define CLASSES (2 * SMALL + 64)

/* Symbols of small differences; greater ones by their bits, which come besides. */
static unsigned class_of(int64_t d, unsigned *bits)
{
    *bits = 0;
    if (d >= -SMALL && d < SMALL)
        return (unsigned)(d + SMALL);
    *bits = 64u - (unsigned)__builtin_clzll(magnitude(d));
    return 2 * SMALL - 1 + *bits;
}

/* About how many bits the differences take. */
static double cost(const int64_t *differences, uint32_t count)
{
    uint32_t counts[CLASSES + 1] = {0};
    double bits = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        unsigned own = 0;
        counts[class_of(differences[i], &own)]++;
        bits += own;
    }
    for (unsigned k = 0; k <= CLASSES; k++)
        if (counts[k] > 0)
            bits += counts[k] * log2((double)count / counts[k]);
    return bits;
}

static double cost_of_which(const int16_t *which, uint32_t count, int64_t *work)
{
    for (uint32_t i = 0; i < count; i++)
        work[i] = which[i];
    return cost(work, count);
}

/* The middle one of a sample of the words: most often the commonest, if there are few. */
static uint64_t middle_word(const uint64_t *words, uint32_t count)
{
    int64_t some[33];
    uint32_t n = 0;
    for (uint32_t i = 0; i < 33; i++)
        some[n++] = (int64_t)words[(uint64_t)i * count / 33];
    stp_sort_i64(some, n);
    return (uint64_t)some[n / 2];
}

/* Memory for one part. */
typedef struct work {
    uint64_t *words; /* floats as whole numbers */
    int64_t *differences[GROUPS], *other;
    int16_t *which, *cells;
} work;

static void work_free(work *w)
{
    free(w->words);
    for (unsigned g = 0; g < GROUPS; g++)
        free(w->differences[g]);
    free(w->other);
    free(w->which);
    free(w->cells);
}

static stp_status work_create(work *w, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    *w = (work){0};
    STP_TRY(stp_alloc(&w->words, count, sizeof *w->words, "an attribute", err));
    for (unsigned g = 0; g < GROUPS; g++)
        STP_TRY(stp_alloc(&w->differences[g], count, sizeof(int64_t), "an attribute", err));
    STP_TRY(stp_alloc(&w->other, count, sizeof *w->other, "an attribute", err));
    STP_TRY(stp_alloc(&w->which, count, sizeof *w->which, "an attribute", err));
    STP_TRY(stp_alloc(&w->cells, count, sizeof *w->cells, "an attribute", err));
done:
    return status;
}

static bool may_predict(const coder *c, stp_attribute_type type)
{
    return !(c->how == FROM_GUESS && !c->guesses) &&
           !(c->how == FROM_SEQUENCES && stp_attribute_bytes(type) < 4) &&
           !(c->how == FROM_STEPS && c->steps.count == 0);
}

static prediction choose(coder *c, stp_attribute_type type, const uint64_t *words, uint32_t count,
                         work *w)
{
    prediction best = FROM_BASE;
    double least = INFINITY;
    for (int how = FROM_BASE; how < PREDICTION_COUNT; how++) {
        c->how = (prediction)how;
        if (!may_predict(c, type))
            continue;
        differ(c, words, count, w->differences, w->which);
        double bits = has_sequences(c) ? cost_of_which(w->which, count, w->other) : 0.0;
        for (unsigned g = 0; g < group_count(c); g++)
            bits += cost(w->differences[g], count);
        best = bits < least ? c->how : best;
        least = fmin(least, bits);
    }
    return best;
}

/* ---- pieces ---- */

/* Takes the lowest piece off every difference. Overflow is no harm: pieces are added up modulo
 * 2^64.
 */
static void take_piece(int64_t *differences, uint32_t count, int16_t *cells)
{
    for (uint32_t i = 0; i < count; i++) {
        cells[i] = (int16_t)(differences[i] & 0xffff);
        differences[i] = (int64_t)((uint64_t)differences[i] - (uint64_t)(int64_t)cells[i]) >> 16;
    }
}

static bool is_any_left(const int64_t *differences, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        if (differences[i] != 0)
            return true;
    return false;
}

/* Appends the columns of a group, and counts them in the byte at `counter`. */
static stp_status encode_group(int64_t *differences, uint32_t count, int16_t *cells, size_t counter,
                               stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    while (is_any_left(differences, count) && out->data[counter] < PIECES_MOST) {
        take_piece(differences, count, cells);
        STP_TRY(stp_column_encode(cells, count, true, out, err));
        out->data[counter]++;
    }
done:
    return status;
}

/* Appends the head, with no pieces yet. */
static stp_status encode_head(const coder *c, unsigned decimals, stp_bytes *out, stp_error *err)
{
    uint8_t head[HEAD_BYTES + 1 + STP_STEPS_LIMIT * STEP_BYTES] = {0};
    size_t size = HEAD_BYTES;
    head[0] = (uint8_t)c->how;
    head[2] = (uint8_t)decimals;
    stp_put_u64(head + 3, c->base);
    if (c->how == FROM_STEPS) {
        head[size++] = (uint8_t)c->steps.count;
        for (unsigned k = 0; k < c->steps.count; k++, size += STEP_BYTES)
            stp_put_f64(head + size, c->steps.of[k]);
    }
    return stp_bytes_append(out, head, size, err);
}

/* Where the byte is that counts the pieces of a group, from the begin of the head. */
static size_t pieces_at(unsigned group)
{
    return group == 0 ? PIECES_AT : HEAD_BYTES + (size_t)group * STEP_BYTES;
}

stp_status stp_attribute_encode(stp_attribute_type type, const uint64_t *words,
                                const uint64_t *guesses, const stp_steps *steps, uint32_t count,
                                stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    work w = {0};
    if (count == 0)
        return STP_OK;
    STP_TRY(work_create(&w, count, err));
    const unsigned decimals = make_whole(type, words, count, w.words);
    const uint64_t *numbers = decimals == DECIMALS_NONE ? words : w.words;
    coder c = {.base = middle_word(numbers, count),
               .guesses = decimals == DECIMALS_NONE ? guesses : NULL};
    if (steps && steps->decimals == decimals)
        c.steps = *steps;
    c.how = choose(&c, type, numbers, count, &w);
    differ(&c, numbers, count, w.differences, w.which);
    const size_t begin = out->size;
    STP_TRY(encode_head(&c, decimals, out, err));
    if (has_sequences(&c))
        STP_TRY(stp_column_encode(w.which, count, true, out, err));
    for (unsigned g = 0; g < group_count(&c); g++)
        STP_TRY(encode_group(w.differences[g], count, w.cells, begin + pieces_at(g), out, err));
done:
    work_free(&w);
    return status;
}

stp_status stp_attribute_steps(stp_attribute_type type, const uint64_t *words, uint32_t count,
                               stp_steps *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *numbers = NULL;
    *out = (stp_steps){0};
    if (stp_attribute_bytes(type) < 8 || count == 0)
        return STP_OK;
    STP_TRY(stp_alloc(&numbers, count, sizeof *numbers, "an attribute", err));
    out->decimals = make_whole(type, words, count, numbers);
    if (out->decimals == DECIMALS_NONE)
        memcpy(numbers, words, count * sizeof *numbers);
    STP_TRY(stp_steps_find((int64_t *)numbers, count, out, err));
done:
    free(numbers);
    return status;
}

static stp_status corrupt(const char *what, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT, "numbers of an attribute %s", what);
}

/* Adds up the pieces of a group. */
static stp_status read_group(stp_cursor *r, unsigned pieces, int64_t *differences, uint32_t count,
                             int16_t *cells, stp_error *err)
{
    stp_status status = STP_OK;
    memset(differences, 0, count * sizeof *differences);
    for (unsigned p = 0; p < pieces; p++) {
        STP_TRY(stp_column_read(r, cells, count, err));
        for (uint32_t i = 0; i < count; i++)
            differences[i] =
                (int64_t)((uint64_t)differences[i] + ((uint64_t)(int64_t)cells[i] << (16 * p)));
    }
done:
    return status;
}

/* Reads the columns behind the head. */
static stp_status read_columns(const coder *c, const uint8_t *head, stp_cursor *r, uint32_t count,
                               work *w, stp_error *err)
{
    stp_status status = STP_OK;
    if (has_sequences(c))
        STP_TRY(stp_column_read(r, w->which, count, err));
    for (unsigned g = 0; g < group_count(c); g++)
        STP_TRY(read_group(r, head[pieces_at(g)], w->differences[g], count, w->cells, err));
    if (r->left > 0)
        status = corrupt("have bytes to spare", err);
done:
    return status;
}

/* Reads the head and checks its numbers. */
static stp_status read_head(stp_attribute_type type, stp_cursor *r, coder *c, unsigned *decimals,
                            stp_error *err)
{
    const uint8_t *head = r->bytes;
    size_t size = HEAD_BYTES;
    if (r->left < size)
        return corrupt("are cut off", err);
    c->how = (prediction)head[0];
    c->base = stp_get_u64(head + 3);
    *decimals = head[2];
    const bool whole = *decimals <= DECIMALS_MOST && stp_attribute_is_float(type);
    bool known = head[0] < PREDICTION_COUNT && !(c->how == FROM_GUESS && !c->guesses) &&
                 (whole || *decimals == DECIMALS_NONE);
    if (known && c->how == FROM_STEPS) {
        c->steps.count = r->left > size ? head[size++] : 0;
        known = c->steps.count >= 1 && c->steps.count <= STP_STEPS_LIMIT &&
                r->left - size >= (size_t)c->steps.count * STEP_BYTES;
        for (unsigned k = 0; known && k < c->steps.count; k++, size += STEP_BYTES) {
            c->steps.of[k] = stp_get_f64(head + size);
            known = stp_step_is_valid(c->steps.of[k]);
        }
    }
    for (unsigned g = 0; known && g < group_count(c); g++)
        known = head[pieces_at(g)] <= PIECES_MOST;
    stp_cursor_skip(r, size);
    return known ? STP_OK : corrupt("have an unknown head", err);
}

stp_status stp_attribute_decode(stp_attribute_type type, const uint8_t *bytes, size_t size,
                                const uint64_t *guesses, uint32_t count, uint64_t *words,
                                stp_error *err)
{
    stp_status status = STP_OK;
    work w = {0};
    coder c = {.guesses = guesses};
    stp_cursor r = {bytes, size};
    unsigned decimals = DECIMALS_NONE;
    if (count == 0)
        return size == 0 ? STP_OK : corrupt("have bytes to spare", err);
    if (count > STP_ATTRIBUTE_PART_LIMIT)
        return corrupt("are too many", err);
    STP_TRY(read_head(type, &r, &c, &decimals, err));
    STP_TRY(work_create(&w, count, err));
    STP_TRY(read_columns(&c, bytes, &r, count, &w, err));
    if (!add_up(&c, w.differences, w.which, count, words)) {
        status = corrupt("name an unknown sequence or step", err);
        goto done;
    }
    for (uint32_t i = 0; decimals != DECIMALS_NONE && i < count; i++)
        words[i] = from_decimal(type, words[i], decimals);
done:
    work_free(&w);
    return status;
}
