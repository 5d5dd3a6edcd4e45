/* Codes the numbers of an attribute: a prediction, and the difference in pieces of 16 bits. */
#include "formats/chunk/attribute/attribute_codec.h"

#include "base/memory.h"
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

typedef enum prediction {
    FROM_BASE,      /* all by one number */
    FROM_BEFORE,    /* by the number before */
    FROM_SEQUENCES, /* by the last number of one of the latest sequences; the first column says
                       which */
    FROM_GUESS,     /* by what the sample's 8 bits say */
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
} coder;

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
    if (c->how == FROM_SEQUENCES)
        sequences_take(&h->latest, which, word);
}

/* Differences of all words; which: by word, for FROM_SEQUENCES. */
static void differ(const coder *c, const uint64_t *words, uint32_t count, int64_t *out,
                   int16_t *which)
{
    history h = history_begin(c);
    for (uint32_t i = 0; i < count; i++) {
        const unsigned k = c->how == FROM_SEQUENCES ? nearest_sequence(&h.latest, words[i]) : 0;
        which[i] = (int16_t)k;
        out[i] = difference(words[i], predict(c, &h, i, k));
        history_take(c, &h, k, words[i]);
    }
}

/* The inverse. False if `which`, of FROM_SEQUENCES, names no sequence. */
static bool add_up(const coder *c, const int64_t *differences, const int16_t *which, uint32_t count,
                   uint64_t *words)
{
    history h = history_begin(c);
    for (uint32_t i = 0; i < count; i++) {
        const int16_t told = c->how == FROM_SEQUENCES ? which[i] : (int16_t)0;
        if (told < 0 || told > (int16_t)SEQUENCES)
            return false;
        words[i] = predict(c, &h, i, (unsigned)told) + (uint64_t)differences[i];
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

static int compare_words(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

/* The middle one of a sample of the words: most often the commonest, if there are few. */
static uint64_t middle_word(const uint64_t *words, uint32_t count)
{
    int64_t some[33];
    uint32_t n = 0;
    for (uint32_t i = 0; i < 33; i++)
        some[n++] = (int64_t)words[(uint64_t)i * count / 33];
    qsort(some, n, sizeof *some, compare_words);
    return (uint64_t)some[n / 2];
}

/* Memory for one part. */
typedef struct work {
    uint64_t *words; /* floats as whole numbers */
    int64_t *differences, *other;
    int16_t *which, *cells;
} work;

static void work_free(work *w)
{
    free(w->words);
    free(w->differences);
    free(w->other);
    free(w->which);
    free(w->cells);
}

static stp_status work_create(work *w, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    *w = (work){0};
    STP_TRY(stp_alloc(&w->words, count, sizeof *w->words, "an attribute", err));
    STP_TRY(stp_alloc(&w->differences, count, sizeof *w->differences, "an attribute", err));
    STP_TRY(stp_alloc(&w->other, count, sizeof *w->other, "an attribute", err));
    STP_TRY(stp_alloc(&w->which, count, sizeof *w->which, "an attribute", err));
    STP_TRY(stp_alloc(&w->cells, count, sizeof *w->cells, "an attribute", err));
done:
    return status;
}

static prediction choose(coder *c, stp_attribute_type type, const uint64_t *words, uint32_t count,
                         work *w)
{
    prediction best = FROM_BASE;
    double least = INFINITY;
    for (int how = FROM_BASE; how < PREDICTION_COUNT; how++) {
        if ((how == FROM_GUESS && !c->guesses) ||
            (how == FROM_SEQUENCES && stp_attribute_bytes(type) < 4))
            continue;
        c->how = (prediction)how;
        differ(c, words, count, w->differences, w->which);
        const double bits =
            cost(w->differences, count) +
            (how == FROM_SEQUENCES ? cost_of_which(w->which, count, w->other) : 0.0);
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

stp_status stp_attribute_encode(stp_attribute_type type, const uint64_t *words,
                                const uint64_t *guesses, uint32_t count, stp_bytes *out,
                                stp_error *err)
{
    stp_status status = STP_OK;
    work w = {0};
    uint8_t head[HEAD_BYTES];
    if (count == 0)
        return STP_OK;
    STP_TRY(work_create(&w, count, err));
    const unsigned decimals = make_whole(type, words, count, w.words);
    const uint64_t *numbers = decimals == DECIMALS_NONE ? words : w.words;
    coder c = {.base = middle_word(numbers, count),
               .guesses = decimals == DECIMALS_NONE ? guesses : NULL};
    c.how = choose(&c, type, numbers, count, &w);
    differ(&c, numbers, count, w.differences, w.which);
    const size_t begin = out->size;
    head[0] = (uint8_t)c.how;
    head[1] = 0;
    head[2] = (uint8_t)decimals;
    stp_put_u64(head + 3, c.base);
    STP_TRY(stp_bytes_append(out, head, sizeof head, err));
    if (c.how == FROM_SEQUENCES)
        STP_TRY(stp_column_encode(w.which, count, true, out, err));
    while (is_any_left(w.differences, count) && out->data[begin + PIECES_AT] < PIECES_MOST) {
        take_piece(w.differences, count, w.cells);
        STP_TRY(stp_column_encode(w.cells, count, true, out, err));
        out->data[begin + PIECES_AT]++;
    }
done:
    work_free(&w);
    return status;
}

static stp_status corrupt(const char *what, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT, "numbers of an attribute %s", what);
}

/* Reads the pieces of the differences from the columns behind the head. */
static stp_status read_columns(const coder *c, unsigned pieces, const uint8_t *bytes, size_t size,
                               uint32_t count, work *w, stp_error *err)
{
    stp_status status = STP_OK;
    size_t used = 0;
    if (c->how == FROM_SEQUENCES) {
        STP_TRY(stp_column_decode(bytes, size, w->which, count, &used, err));
        bytes += used;
        size -= used;
    }
    for (unsigned p = 0; p < pieces; p++) {
        STP_TRY(stp_column_decode(bytes, size, w->cells, count, &used, err));
        for (uint32_t i = 0; i < count; i++)
            w->differences[i] = (int64_t)((uint64_t)w->differences[i] +
                                          ((uint64_t)(int64_t)w->cells[i] << (16 * p)));
        bytes += used;
        size -= used;
    }
    if (size > 0)
        status = corrupt("have bytes to spare", err);
done:
    return status;
}

stp_status stp_attribute_decode(stp_attribute_type type, const uint8_t *bytes, size_t size,
                                const uint64_t *guesses, uint32_t count, uint64_t *words,
                                stp_error *err)
{
    stp_status status = STP_OK;
    work w = {0};
    if (count == 0)
        return size == 0 ? STP_OK : corrupt("have bytes to spare", err);
    if (size < HEAD_BYTES || count > STP_ATTRIBUTE_PART_LIMIT)
        return corrupt("are cut off", err);
    const coder c = {(prediction)bytes[0], stp_get_u64(bytes + 3), guesses};
    const unsigned pieces = bytes[1], decimals = bytes[2];
    const bool whole = decimals <= DECIMALS_MOST && stp_attribute_is_float(type);
    if (bytes[0] >= PREDICTION_COUNT || pieces > PIECES_MOST || (c.how == FROM_GUESS && !guesses) ||
        (!whole && decimals != DECIMALS_NONE))
        return corrupt("have an unknown head", err);
    STP_TRY(work_create(&w, count, err));
    memset(w.differences, 0, count * sizeof *w.differences);
    STP_TRY(read_columns(&c, pieces, bytes + HEAD_BYTES, size - HEAD_BYTES, count, &w, err));
    if (!add_up(&c, w.differences, w.which, count, words)) {
        status = corrupt("name an unknown sequence", err);
        goto done;
    }
    for (uint32_t i = 0; whole && i < count; i++)
        words[i] = from_decimal(type, words[i], decimals);
done:
    work_free(&w);
    return status;
}
