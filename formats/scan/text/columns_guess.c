/* Guesses columns from their numbers. */
#include "formats/scan/text/columns.h"

#include "formats/scan/scan.h"

#include <math.h>
#include <string.h>

/* Largest difference of a unit normal's squared length from 1. Allows normals of three digits. */
#define STP_UNIT_TOLERANCE 0.02
/* The share of the lines that must fit a normal. */
#define STP_UNIT_SHARE 0.99

static bool is_written_whole(stp_field field)
{
    for (const char *at = field.begin; at < field.end; at++)
        if (*at == '.' || *at == ',' || *at == 'e' || *at == 'E')
            return false;
    return true;
}

static uint32_t decimals_of(stp_field field)
{
    const char *point = NULL, *last = field.begin;
    for (const char *at = field.begin; at < field.end; at++) {
        if (*at == 'e' || *at == 'E' || *at == 'd' || *at == 'D')
            return UINT32_MAX;
        if (*at == '.' || *at == ',')
            point = at;
        last = *at != '0' ? at : last;
    }
    return point && last > point ? (uint32_t)(last - point) : 0;
}

static void add_number(stp_column_range *range, double value, stp_field field)
{
    if (!isfinite(value))
        return;
    if (range->count++ == 0) {
        range->min = range->max = range->second = value;
        range->whole = range->written_whole = true;
    }
    if (value < range->min)
        range->second = range->min;
    else if (value > range->min && (range->second == range->min || value < range->second))
        range->second = value;
    range->min = fmin(range->min, value);
    range->max = fmax(range->max, value);
    range->whole = range->whole && floor(value) == value;
    range->written_whole = range->written_whole && is_written_whole(field);
    const uint32_t decimals = decimals_of(field);
    range->decimals = range->decimals > decimals ? range->decimals : decimals;
}

static void add_hex(stp_column_range *range, double value, stp_field field)
{
    if (!stp_field_is_hex(field, true))
        return;
    range->hexes++;
    range->padded = range->padded || (isfinite(value) && *field.begin == '0');
}

void stp_columns_sample_add(stp_columns_sample *sample, stp_separator separator, const char *begin,
                            const char *end)
{
    double values[STP_COLUMNS_MAX] = {0.0};
    stp_field fields[STP_COLUMNS_MAX] = {{NULL, NULL}}, field;
    uint32_t count = 0;
    for (const char *at = begin; stp_field_next(separator, &at, end, &field); count++)
        if (count < STP_COLUMNS_MAX)
            fields[count] = field;
    const uint32_t kept = count < STP_COLUMNS_MAX ? count : STP_COLUMNS_MAX;
    if (kept < sample->count || (kept > sample->count && !sample->open_end))
        return;
    for (uint32_t i = 0; i < sample->count; i++) {
        if (!stp_field_number(separator, fields[i], &values[i]))
            values[i] = NAN;
        add_number(&sample->ranges[i], values[i], fields[i]);
        add_hex(&sample->ranges[i], values[i], fields[i]);
    }
    for (uint32_t i = 0; i + 1 < sample->count; i++) {
        stp_column_range *range = &sample->ranges[i];
        const double *v = values + i;
        const double step = fabs(v[0] - v[1]);
        range->step += isfinite(step) ? step : 0.0;
        if (i + 2 == sample->count)
            continue;
        const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        range->unit += fabs(square - 1.0) <= STP_UNIT_TOLERANCE;
        range->zero += square == 0.0;
    }
    sample->successors += sample->rows > 0 && values[0] == sample->ranges[0].last + 1.0;
    sample->repeats += sample->rows > 0 && values[0] == sample->ranges[0].last;
    for (unsigned k = 0; sample->rows > 0 && sample->count > 1 && k < 2; k++) {
        const double outer = values[k] - sample->ranges[k].last;
        const bool after =
            outer > 0.0 || (outer == 0.0 && values[1 - k] > sample->ranges[1 - k].last);
        sample->behind[k] += !after;
    }
    for (uint32_t i = 0; i < sample->count; i++) {
        stp_column_range *range = &sample->ranges[i];
        range->falls += sample->rows > 0 && !(values[i] >= range->last);
        range->last = values[i];
    }
    sample->rows++;
}

/* The share of lines where a point's number is one more than the last. */
#define SUCCESSOR_SHARE 0.9

static double greatest_part(const stp_column_range *range)
{
    return fmax(fabs(range->min), fabs(range->max));
}

/* Whether lines begin with the point's number. */
static bool begins_with_number(const stp_columns_sample *s)
{
    unsigned fractions = 0;
    for (uint32_t i = 1; i < 4; i++)
        fractions += !s->ranges[i].written_whole;
    const stp_column_range *last = &s->ranges[3]; /* of four, it may be the intensity */
    if (s->count == 4 && last->written_whole && last->min < last->max)
        return false;
    return s->ranges[0].written_whole && s->ranges[0].falls == 0 && s->repeats == 0 &&
           fractions >= 2 && (double)s->successors >= SUCCESSOR_SHARE * (double)(s->rows - 1);
}

/* Few lines say little of what numbers may be. */
#define ROWS_LEAST 100u

/* Whether the first number never falls, and has finer decimals than the next three, which differ
 * and have fractions, as coordinates do. */
static bool begins_with_finer(const stp_columns_sample *s)
{
    const stp_column_range *r = s->ranges;
    if (s->rows < ROWS_LEAST || r[0].falls > 0 || !(r[0].min < r[0].max) || r[0].decimals < 5 ||
        r[0].decimals == UINT32_MAX)
        return false;
    for (uint32_t i = 1; i < 4; i++)
        if (r[i].written_whole || !(r[i].min < r[i].max) || r[i].decimals + 2 > r[0].decimals)
            return false;
    return true;
}

/* Whether lines begin with a time since 1970, or with one that has finer decimals than x y z. */
static bool begins_with_time(const stp_columns_sample *s)
{
    const stp_column_range *range = s->ranges;
    bool known = false;
    if (begins_with_finer(s))
        return true;
    for (double unit = 1.0; unit <= 1e9; unit *= 1000.0) /* of the years from 2000 to 2040 */
        known = known || (range->min >= 0.95e9 * unit && range->max <= 2.2e9 * unit);
    for (uint32_t i = 1; i < 4; i++)
        known = known && greatest_part(&range[i]) < 0.01 * range->min;
    return known && range->falls == 0;
}

/* Whether lines begin with the row and the column of the point, as FARO's do. */
static bool begins_with_pixel(const stp_columns_sample *s)
{
    const stp_column_range *r = s->ranges;
    const uint64_t few = s->rows / 100;
    if (s->count < 6 || !r[5].written_whole)
        return false;
    for (uint32_t i = 0; i < 5; i++)
        if (r[i].written_whole != (i < 2) || (i < 2 && (r[i].min < 0.0 || r[i].max > 65535.0)))
            return false;
    return s->behind[0] <= few || s->behind[1] <= few;
}

static bool is_between(const stp_column_range *range, double low, double high)
{
    return range->min >= low && range->max <= high;
}

/* Least coordinates: surveyors put the origin far outside. Names and numbers of other things, as of
 * objects around a robot, are followed by any. */
#define LEAST_OF_NUMBERED 50.0
#define LEAST_OF_NAMED 1000.0

/* Whether lines are a surveyor's: a point's name or number, three coordinates, words that say what
 * it is. */
static bool is_survey(const stp_columns_sample *s, const bool *is_number)
{
    const stp_column_range *r = s->ranges;
    unsigned fractions = 0;
    if (s->count < 5)
        return false;
    const double least = is_number[0] ? LEAST_OF_NUMBERED : LEAST_OF_NAMED;
    if ((is_number[0] && (!r[0].written_whole || r[0].falls > 0 || s->repeats > 0)) ||
        r[1].min < least || r[2].min < least)
        return false;
    for (uint32_t i = 1; i < 4; i++)
        fractions += !r[i].written_whole;
    for (uint32_t i = 4; i < s->count; i++)
        if (is_number[i] || 2 * r[i].count > s->rows)
            return false;
    return fractions >= 2;
}

/* Whether it names the easting first: as UTM's, with or without the zone's number in front, as
 * those of Gauss and Krueger, which lie within 150 km of a meridian, or as Swiss ones (LV95). */
static bool is_easting_first(const stp_column_range *easting, const stp_column_range *northing)
{
    const double zone = 1e6 * floor(easting->min / 1e6);
    const bool utm = is_between(easting, 1e5, 9e5) && is_between(northing, 1e6, 1e7);
    const bool prefixed = is_between(easting, 1e7, 61e6) && is_between(northing, 0.0, 1e7);
    const bool meridian = zone >= 2e6 && zone <= 5e6 &&
                          is_between(easting, zone + 3.5e5, zone + 6.5e5) &&
                          is_between(northing, 5.2e6, 6.15e6);
    const bool swiss = is_between(easting, 2.48e6, 2.84e6) && is_between(northing, 1.07e6, 1.3e6);
    return utm || prefixed || meridian || swiss;
}

/* The columns that have no meaning yet. */
typedef struct guess {
    const stp_columns_sample *sample;
    stp_columns columns;
    bool is_free[STP_COLUMNS_MAX +
                 4]; /* number columns without a meaning so far; false after the last */
} guess;

static bool three_free(const guess *g, uint32_t first)
{
    return g->is_free[first] && g->is_free[first + 1] && g->is_free[first + 2];
}

static void claim(guess *g, uint32_t place, stp_column column)
{
    g->columns.targets[place] = (uint8_t)column;
    g->is_free[place] = false;
}

static void claim_three(guess *g, uint32_t first, stp_column column)
{
    for (uint32_t k = 0; k < 3; k++)
        claim(g, first + k, (stp_column)(column + k));
}

static void guess_normal(guess *g)
{
    for (uint32_t i = 0; i < g->sample->count; i++) {
        const stp_column_range *range = &g->sample->ranges[i];
        if (!three_free(g, i) || range->unit == 0)
            continue;
        if ((double)(range->unit + range->zero) >= STP_UNIT_SHARE * (double)g->sample->rows) {
            claim_three(g, i, STP_COLUMN_NX);
            return;
        }
    }
}

static bool within(const stp_column_range *range, double limit)
{
    return range->count > 0 && range->min >= 0.0 && range->max <= limit;
}

/* Whether the numbers may be classes, returns or flags: whole ones of 5 bits. One number alone may
 * as well be a channel of one colour for all, unless it is small. */
static bool is_code(const stp_column_range *range)
{
    return range->written_whole && within(range, range->min < range->max ? 31.0 : 7.0);
}

static double greatest(const guess *g, uint32_t first)
{
    const stp_column_range *r = g->sample->ranges + first;
    return fmax(fmax(r[0].max, r[1].max), r[2].max);
}

static bool can_be_colour(const guess *g, uint32_t first)
{
    bool whole = true, fractions = true, one = true;
    unsigned codes = 0, counts = 0; /* of few returns or flags */
    if (!three_free(g, first))
        return false;
    for (uint32_t k = 0; k < 3; k++) {
        const stp_column_range *range = &g->sample->ranges[first + k];
        const bool code = is_code(range) && range->max > 0.0;
        one = one && range->min == range->max;
        codes += code;
        counts += code && range->max <= 7.0;
        whole = whole && range->whole && within(range, 65535.0);
        fractions = fractions && within(range, 1.0);
    }
    one = one && greatest(g, first) > 31.0; /* one colour for all */
    if (g->sample->rows >= ROWS_LEAST && !one && codes >= 2 && counts >= 1)
        return false;
    return whole || fractions;
}

/* True if the column after a colour always has its greatest value. */
static bool is_alpha(const guess *g, uint32_t colour)
{
    const stp_column_range *range = &g->sample->ranges[colour + 3];
    const double limit = greatest(g, colour) <= 1.0 ? 1.0 : 255.0;
    return g->is_free[colour + 3] && range->count == g->sample->rows &&
           greatest(g, colour) <= limit && range->min >= limit && range->max <= limit;
}

/* For four columns that can be i r g b or r g b i: true if they are i r g b. */
static bool is_intensity_first(const guess *g, uint32_t first)
{
    const stp_column_range *r = g->sample->ranges + first;
    if (is_alpha(g, first))
        return false;
    if ((greatest(g, first) > 255.0) != (greatest(g, first + 1) > 255.0))
        return greatest(g, first) > 255.0;
    return r[0].step >= r[2].step;
}

static void guess_colour(guess *g, bool intensity_first)
{
    uint32_t first = 0;
    while (first < g->sample->count && !can_be_colour(g, first))
        first++;
    if (first == g->sample->count)
        return;
    if (can_be_colour(g, first + 1) && (intensity_first || is_intensity_first(g, first)))
        first++;
    const bool alpha = is_alpha(g, first);
    claim_three(g, first, STP_COLUMN_RED);
    g->is_free[first + 3] = g->is_free[first + 3] && !alpha;
}

/* Whether a column has the times at which the points were measured: they never fall, and are no
 * intensities. */
static bool is_time(const guess *g, uint32_t i)
{
    const stp_column_range *range = &g->sample->ranges[i];
    return g->sample->rows > 2 && range->falls == 0 && range->min < range->max &&
           (!range->written_whole || range->max > 65535.0);
}

/* The only number that may be a class is one. */
static void guess_class(guess *g)
{
    uint32_t codes = 0, place = 0;
    for (uint32_t i = 0; i < g->sample->count; i++)
        if (g->is_free[i] && is_code(&g->sample->ranges[i])) {
            codes++;
            place = i;
        }
    const stp_column_range *range = &g->sample->ranges[place];
    if (codes == 1 && g->sample->rows >= ROWS_LEAST && range->min < range->max)
        claim(g, place, STP_COLUMN_CLASS);
}

static void guess_intensity(guess *g)
{
    uint32_t count = 0, times = 0, codes = 0, place = 0;
    for (uint32_t i = 0; i < g->sample->count; i++) {
        count += g->is_free[i];
        times += g->is_free[i] && is_time(g, i);
        codes += g->is_free[i] && is_code(&g->sample->ranges[i]);
    }
    /* times and codes are passed over */
    const bool timed = count > 1 && times == 1;
    const bool coded = g->sample->rows >= ROWS_LEAST && codes > 0 && count > codes;
    for (uint32_t i = 0; i < g->sample->count; i++)
        place =
            g->is_free[i] && !(timed && is_time(g, i)) && !(coded && is_code(&g->sample->ranges[i]))
                ? i
                : place;
    if (count - (timed ? times : 0) - (coded ? codes : 0) != 1)
        return;
    const stp_column_range *range = &g->sample->ranges[place];
    const bool opaque = (range->min >= -16777216.0 && range->min < -65536.0 && range->max < 0.0) ||
                        (range->min >= 4278190080.0 && range->max < 4294967296.0);
    const bool packed = opaque && range->written_whole &&
                        !(stp_columns_attributes(&g->columns) & STP_POINT_HAS_COLOUR);
    claim(g, place, packed ? STP_COLUMN_PACKED : STP_COLUMN_INTENSITY);
}

bool stp_columns_guess(stp_columns *out, const stp_columns_sample *sample, const bool *is_number,
                       bool intensity_first)
{
    guess g = {.sample = sample, .columns = *out};
    uint32_t axes = 0;
    uint32_t first = 0;
    bool survey = false;
    g.columns.count = sample->count;
    if (sample->count > 3 && sample->rows > 2 && is_number[1] && is_number[2] && is_number[3]) {
        survey = is_survey(sample, is_number);
        first = begins_with_pixel(sample)                                          ? 2
                : survey || begins_with_number(sample) || begins_with_time(sample) ? 1
                                                                                   : 0;
    }
    memset(g.columns.targets, STP_COLUMN_NONE, sizeof g.columns.targets);
    for (uint32_t i = first; i < sample->count; i++) {
        if (is_number[i] && axes < 3)
            claim(&g, i, (stp_column)(STP_COLUMN_X + axes++));
        else
            g.is_free[i] = is_number[i];
    }
    if (axes < 3)
        return false;
    if (survey) { /* words may be many or none */
        g.columns.count = 4;
        g.columns.open_end = true;
        g.columns.northing_first = !is_easting_first(&sample->ranges[1], &sample->ranges[2]);
    }
    if (g.columns.northing_first) {
        g.columns.targets[1] = STP_COLUMN_Y;
        g.columns.targets[2] = STP_COLUMN_X;
    }
    guess_normal(&g);
    guess_colour(&g, intensity_first);
    guess_class(&g);
    guess_intensity(&g);
    *out = g.columns;
    return true;
}
