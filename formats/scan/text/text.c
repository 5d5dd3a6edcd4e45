/* Reads lines of text as points. */
#include "formats/scan/text/text.h"

#include "base/memory.h"
#include "formats/scan/mesh/point_mesh.h"
#include "formats/scan/number.h"
#include "formats/scan/value_range.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STP_TEXT_SAMPLE_BLOCKS 64u
#define STP_TEXT_SAMPLE_BYTES 65536u
/* Of degrees: least digits after the point, least extent of heights in degrees. */
#define DEGREE_DECIMALS 5u
#define NEEDLE 20.0
/* As floats, the bits of colours are below this if alpha is 0, and above that if alpha is 255. */
#define PACKED_LOW 0x1p-125
#define PACKED_HIGH 0x1p100

/* Fails if lines end in CR alone: the whole file would be one line. */
static stp_status check_line_ends(stp_text *text, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *bytes;
    size_t available;
    STP_TRY(stp_source_peek(&text->source, STP_TEXT_LINE_MAX, &bytes, &available, err));
    const unsigned char *cr = available > 0 ? memchr(bytes, '\r', available) : NULL;
    if (cr && cr + 1 < bytes + available && cr[1] != '\n' && !memchr(bytes, '\n', available))
        status =
            stp_error_set(err, STP_UNSUPPORTED,
                          "%s: its lines end in CR alone, as on old Macintoshes: give them \\n "
                          "(tr '\\r' '\\n')",
                          text->source.path);
done:
    return status;
}

stp_status stp_text_open(stp_text *text, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *bytes;
    size_t available;
    STP_TRY(stp_source_open(&text->source, path, err));
    size_t mark;
    STP_TRY(stp_source_peek(&text->source, STP_WIDE_BYTES, &bytes, &available, err));
    const uint8_t wide = stp_source_is_wide(bytes, available, &mark);
    if (wide > 0) {
        stp_source_widen(&text->source, wide);
        stp_source_seek(&text->source, mark, 0);
    } else if (available >= 3 && memcmp(bytes, "\xef\xbb\xbf", 3) == 0) {
        stp_source_consume(&text->source, 3);
    }
    text->first_offset = text->source.offset;
    STP_TRY(check_line_ends(text, err));
done:
    return status;
}

void stp_text_close(stp_text *text)
{
    stp_source_close(&text->source);
    free(text->marks);
    stp_text_numbers_clear(&text->numbers);
}

stp_status stp_text_next(stp_text *text, const char **begin, const char **end, stp_error *err)
{
    stp_status status = STP_OK;
    do {
        STP_TRY(stp_source_line(&text->source, begin, end, err));
    } while (*begin && !stp_line_counts(*begin, *end));
done:
    return status;
}

void stp_text_rewind(stp_text *text)
{
    stp_source_seek(&text->source, text->first_offset, text->first_line);
}

stp_status stp_text_count(stp_text *text, uint64_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    const char *begin, *end;
    uint64_t lines = 0;
    text->mark_count = 0;
    for (;; lines++) {
        const stp_text_mark here = {text->source.offset, text->source.line};
        STP_TRY(stp_text_next(text, &begin, &end, err));
        if (!begin)
            break;
        if (lines % STP_TEXT_MARK_LINES > 0)
            continue;
        STP_TRY(stp_grow(&text->marks, &text->mark_capacity, text->mark_count + 1,
                         sizeof *text->marks, "lines", err));
        text->marks[text->mark_count++] = here;
    }
    *count = lines;
done:
    return status;
}

void stp_text_seek(stp_text *text, uint64_t line)
{
    const stp_text_mark *mark = &text->marks[line / STP_TEXT_MARK_LINES];
    stp_source_seek(&text->source, mark->offset, mark->line);
}

static stp_status sample_block(stp_text *text, uint64_t offset, uint64_t stop,
                               stp_separator separator, stp_columns_sample *sample, stp_error *err)
{
    stp_status status = STP_OK;
    const char *begin, *end;
    stp_source_seek(&text->source, offset, 0);
    if (offset > text->first_offset) /* offset is inside a line: skip its rest */
        STP_TRY(stp_source_line(&text->source, &begin, &end, err));
    while (text->source.offset < stop) {
        STP_TRY(stp_text_next(text, &begin, &end, err));
        if (!begin)
            break;
        stp_columns_sample_add(sample, separator, begin, end);
    }
done:
    return status;
}

stp_status stp_text_sample(stp_text *text, stp_separator separator, stp_columns_sample *sample,
                           stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t size = text->source.size - text->first_offset;
    const uint64_t blocks = STP_TEXT_SAMPLE_BLOCKS;
    if (size <= blocks * STP_TEXT_SAMPLE_BYTES) {
        STP_TRY(sample_block(text, text->first_offset, text->source.size, separator, sample, err));
    } else {
        for (uint64_t i = 0; i < blocks; i++) {
            const uint64_t offset = text->first_offset + size / blocks * i;
            STP_TRY(
                sample_block(text, offset, offset + STP_TEXT_SAMPLE_BYTES, separator, sample, err));
        }
    }
    stp_text_rewind(text);
done:
    return status;
}

stp_status stp_text_guess(stp_text *text, const char *begin, const char *end, bool intensity_first,
                          stp_columns_sample *sample, stp_error *err)
{
    stp_status status = STP_OK;
    bool is_number[STP_COLUMNS_MAX] = {false};
    stp_field field;
    double value;
    uint32_t count = 0, numbers = 0;
    const stp_separator separator = stp_separator_find(begin, end);
    for (const char *at = begin; stp_field_next(separator, &at, end, &field); count++)
        if (count < STP_COLUMNS_MAX)
            numbers += is_number[count] = stp_field_number(separator, field, &value);
    if (numbers < 3)
        return stp_error_set(err, STP_FORMAT,
                             "%s: line %llu has %u numbers where a point needs three: give "
                             "--columns, put # before lines that are no points, or export the file "
                             "again",
                             text->source.path, (unsigned long long)text->first_line + 1, numbers);
    sample->count = count < STP_COLUMNS_MAX ? count : STP_COLUMNS_MAX;
    STP_TRY(stp_text_sample(text, separator, sample, err));
    text->columns = (stp_columns){.separator = separator, .open_end = count > STP_COLUMNS_MAX};
    (void)stp_columns_guess(&text->columns, sample, is_number, intensity_first);
    count = 0;
    for (const char *at = begin; stp_field_next(separator, &at, end, &field); count++)
        if (count < text->columns.count && stp_field_is_hex(field, false) &&
            !(stp_columns_attributes(&text->columns) & STP_POINT_HAS_COLOUR))
            text->columns.targets[count] = STP_COLUMN_PACKED;
done:
    return status;
}

stp_status stp_text_use_list(stp_text *text, const char *list, const char *begin, const char *end,
                             stp_error *err)
{
    stp_status status = STP_OK;
    text->given = true;
    text->columns.separator = stp_separator_find(begin, end);
    STP_TRY(stp_columns_from_list(&text->columns, list, text->numbers.keep, err));
    const uint32_t fields = stp_fields_count(text->columns.separator, begin, end).fields;
    if (begin && fields < text->columns.count)
        status = stp_error_set(err, STP_INVALID_ARGUMENT,
                               "--columns %.200s: names %u columns, but the first point of %s has "
                               "%u: name those alone",
                               list, text->columns.count, text->source.path, fields);
done:
    return status;
}

/* Colours that are all zero are none: a program wrote them for want of any. So are white ones that
 * would hide intensities. */
static void find_colour_scale(stp_text *text, const stp_columns_sample *sample)
{
    double greatest = 0.0, least = INFINITY;
    bool written_whole = true;
    uint32_t places[3];
    for (unsigned k = 0; k < 3; k++) {
        places[k] = stp_columns_find(&text->columns, (stp_column)(STP_COLUMN_RED + k));
        const stp_column_range *range = &sample->ranges[places[k]];
        greatest = fmax(greatest, range->max);
        least = fmin(least, range->min);
        written_whole = written_whole && (range->written_whole || range->count == 0);
    }
    text->colour_scale =
        stp_value_range_scale(stp_value_range_guess_colour(!written_whole, 0, greatest));
    const bool white =
        text->attributes & STP_POINT_HAS_INTENSITY && stp_value_is_white(least, greatest);
    if ((greatest > 0.0 && !white) || sample->rows == 0)
        return;
    text->attributes &= ~(uint32_t)STP_POINT_HAS_COLOUR;
    for (unsigned k = 0; k < 3; k++)
        text->columns.targets[places[k]] = STP_COLUMN_NONE;
}

/* Decides what a column of colours in one piece has: hexadecimal digits or numbers, which may as
 * well be grey ones, or words that are no colours. */
static void find_packed(stp_text *text, const stp_columns_sample *sample)
{
    stp_columns *c = &text->columns;
    const uint32_t place = stp_columns_find(c, STP_COLUMN_PACKED);
    if (place >= sample->count)
        return;
    const stp_column_range *range = &sample->ranges[place];
    const double most = fmax(fabs(range->min), fabs(range->max));
    const bool words = range->hexes == 0 && range->count == 0;
    const bool large = range->min < -65536.0 || range->max > 65535.0;
    const bool bits = most < PACKED_LOW || most > PACKED_HIGH;
    c->hex = range->hexes > range->count || (range->padded && range->hexes == range->count);
    if (text->given || sample->rows == 0 || c->hex || (!words && (range->whole ? large : bits)))
        return;
    const bool grey = range->count > 0 && most > 0.0 &&
                      stp_columns_find(c, STP_COLUMN_INTENSITY) == STP_COLUMNS_MAX;
    c->targets[place] = grey ? STP_COLUMN_INTENSITY : STP_COLUMN_NONE;
}

/* A class in words is none that is read. */
static void drop_words(stp_text *text, const stp_columns_sample *sample)
{
    const uint32_t place = stp_columns_find(&text->columns, STP_COLUMN_CLASS);
    if (!text->given && place < sample->count && sample->rows > 0 &&
        sample->ranges[place].count == 0)
        text->columns.targets[place] = STP_COLUMN_NONE;
}

static void find_intensity_scale(stp_text *text, const stp_columns_sample *sample)
{
    const uint32_t place = stp_columns_find(&text->columns, STP_COLUMN_INTENSITY);
    const stp_column_range *range = &sample->ranges[place];
    const stp_value_range full = stp_value_range_guess_intensity(
        !range->written_whole, 0, (stp_value_span){range->min, range->max, !range->whole});
    text->intensity_low = full.low;
    text->intensity_scale = stp_value_range_scale(full);
}

/* The step of the coordinates: 1, 0.1, 0.01 or 0.001 if all sampled coordinates are written with at
 * most three digits after the point, as surveys are; else 0: they are floats. */
static double step_of(const stp_text *text, const stp_columns_sample *sample)
{
    static const double steps[] = {1.0, 0.1, 0.01, 0.001};
    uint32_t decimals = 0;
    for (unsigned k = 0; k < 3; k++) {
        const uint32_t place = stp_columns_find(&text->columns, (stp_column)(STP_COLUMN_X + k));
        if (place == STP_COLUMNS_MAX || sample->ranges[place].count == 0)
            return 0.0;
        if (sample->ranges[place].decimals > decimals)
            decimals = sample->ranges[place].decimals;
    }
    return decimals < sizeof steps / sizeof *steps ? steps[decimals] : 0.0;
}

static double extent_of(const stp_column_range *range)
{
    return range->max - range->min;
}

static bool is_within(const stp_column_range *range, double limit)
{
    return range->count > 0 && range->min >= -limit && range->max <= limit;
}

/* Whether numbers alone say that x and y are degrees: the rule is in the header. */
static bool look_like_degrees(const stp_column_range *x, const stp_column_range *y,
                              const stp_column_range *z)
{
    const uint32_t fine = x->decimals < y->decimals ? x->decimals : y->decimals;
    const double wide = fmax(extent_of(x), extent_of(y));
    return fmax(x->decimals, y->decimals) < UINT32_MAX && fine >= DEGREE_DECIMALS &&
           z->decimals <= fine - 2 && wide > 0.0 && extent_of(z) >= NEEDLE * wide;
}

/* Finds out whether x and y are degrees, and which is the longitude. */
static void find_degrees(stp_text *text, const stp_columns_sample *sample)
{
    uint32_t places[3];
    for (unsigned k = 0; k < 3; k++) {
        places[k] = stp_columns_find(&text->columns, (stp_column)(STP_COLUMN_X + k));
        if (places[k] >= sample->count)
            return;
    }
    const stp_column_range *x = &sample->ranges[places[0]], *y = &sample->ranges[places[1]];
    const bool swapped = !text->columns.angles && is_within(x, 90.0) && !is_within(y, 90.0);
    text->degrees = is_within(x, 360.0) && is_within(y, swapped ? 360.0 : 90.0) &&
                    (text->columns.angles || look_like_degrees(x, y, &sample->ranges[places[2]]));
    if (!text->degrees || !swapped)
        return;
    text->columns.targets[places[0]] = STP_COLUMN_Y;
    text->columns.targets[places[1]] = STP_COLUMN_X;
}

/* What programs write where a grid of heights has no sample; NaN: the numbers have none. */
static double find_no_height(const stp_text *text, const stp_columns_sample *sample)
{
    const uint32_t place = stp_columns_find(&text->columns, STP_COLUMN_Z);
    const stp_column_range *z = &sample->ranges[place];
    return place < sample->count && stp_is_usual_none(z->min) && z->second > 0.9 * z->min
               ? z->min
               : (double)NAN;
}

void stp_text_decide(stp_text *text, const stp_columns_sample *sample)
{
    const uint32_t z = stp_columns_find(&text->columns, STP_COLUMN_Z);
    text->z_down = text->columns.depths && z < sample->count && sample->ranges[z].max > 0.0;
    find_degrees(text, sample);
    text->no_height = find_no_height(text, sample);
    find_packed(text, sample);
    drop_words(text, sample);
    text->attributes = stp_columns_attributes(&text->columns);
    text->packed = stp_columns_find(&text->columns, STP_COLUMN_PACKED) < STP_COLUMNS_MAX;
    if (text->attributes & STP_POINT_HAS_COLOUR && !text->packed)
        find_colour_scale(text, sample);
    if (text->attributes & STP_POINT_HAS_INTENSITY)
        find_intensity_scale(text, sample);
    const bool byte_intensity =
        text->intensity_low == 0.0 && text->intensity_scale == 65535.0 / 255.0;
    stp_text_numbers_find(&text->numbers, &text->columns, sample->ranges, byte_intensity);
}

/* What a column is read as; NULL: it is not read. */
static const char *meaning_of(const stp_text *text, uint32_t i)
{
    const stp_columns *c = &text->columns;
    if (c->targets[i] != STP_COLUMN_NONE)
        return stp_column_name((stp_column)c->targets[i]);
    return text->numbers.keep && c->extras[i] > 0 ? text->numbers.list.items[c->extras[i] - 1].name
                                                  : NULL;
}

void stp_text_note_columns(stp_text *text, const char *from, const char *header,
                           const char *header_end, stp_separator header_separator,
                           uint32_t field_count)
{
    char name[48];
    stp_field field;
    const char *at = header;
    const stp_columns *c = &text->columns;
    size_t used = 0;
    text->left_out = (stp_name_list){{0}};
    for (uint32_t i = 0; i < field_count || i < c->count; i++) {
        const char *meaning = i < c->count ? meaning_of(text, i) : NULL;
        const bool named =
            header && stp_columns_next_name(header_separator, &at, header_end, &field);
        if (i < c->count)
            used += (size_t)snprintf(text->order + used, sizeof text->order - used, "%s%s",
                                     i > 0 ? "," : "", meaning ? meaning : "_");
        if (meaning)
            continue;
        snprintf(name, sizeof name, "column %u", i + 1);
        if (named && field.begin < field.end)
            stp_column_copy_name(name, sizeof name, field);
        stp_name_list_add(&text->left_out, name);
    }
    snprintf(text->order + used, sizeof text->order - used, " (%s)", from);
}

void stp_text_fill_info(stp_text *text, const stp_columns_sample *sample, stp_scan_info *info)
{
    info->coordinate_step = sample ? step_of(text, sample) : 0.0;
    info->attributes = text->attributes;
    info->extra = text->numbers.list.count > 0 ? &text->numbers.list : NULL;
    info->note_count = 0;
    if (text->order[0])
        text->notes[info->note_count++] = (stp_scan_note){"columns", text->order};
    if (text->left_out.text[0])
        text->notes[info->note_count++] = (stp_scan_note){"left_out", text->left_out.text};
    if (text->degrees)
        text->notes[info->note_count++] = (stp_scan_note){
            "degrees", text->columns.angles ? "the columns' names say so" : "the numbers say so"};
    if (text->columns.northing_first)
        text->notes[info->note_count++] = (stp_scan_note){
            "order", "lines are taken as number, northing, easting, elevation, description, as "
                     "surveyors write them: if the easting comes first, give --columns _,x,y,z"};
    info->notes = text->notes;
}

static stp_status few_columns(const stp_text *text, uint32_t count, stp_error *err)
{
    const stp_source *s = &text->source;
    if (s->offset >= s->size)
        return stp_error_set(
            err, STP_CORRUPT,
            "%s: ends at line %llu, after %u of %u columns: the file was cut; copy "
            "or export it again",
            s->path, (unsigned long long)s->line, count, text->columns.count);
    return stp_error_set(err, STP_CORRUPT,
                         "%s: line %llu has %u columns where there should be %u: mend the line or "
                         "export the file again",
                         s->path, (unsigned long long)s->line, count, text->columns.count);
}

static stp_status bad_number(const stp_text *text, uint32_t place, stp_field field, stp_error *err)
{
    const int length = field.end - field.begin < 40 ? (int)(field.end - field.begin) : 40;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: line %llu: `%.*s` in column %u (%s) is not a number: mend the line, "
                         "name the columns with --columns or export the file again",
                         text->source.path, (unsigned long long)text->source.line, length,
                         field.begin, place + 1,
                         stp_column_name((stp_column)text->columns.targets[place]));
}

/* True if only separators are left, so that nothing is lost. */
static bool rest_is_empty(stp_separator separator, const char *at, const char *end)
{
    stp_field field;
    while (stp_field_next(separator, &at, end, &field))
        if (field.begin < field.end)
            return false;
    return true;
}

/* True if a line may end before its last column: a separator begins it, and the column is not read,
 * or the line is not cut off. */
static bool may_miss_last(const stp_text *text, const char *begin, const char *end)
{
    const stp_columns *columns = &text->columns;
    const stp_source *s = &text->source;
    const bool whole = s->begin > 0 && s->buffer[s->begin - 1] == '\n';
    return (whole || columns->targets[columns->count - 1] == STP_COLUMN_NONE) && end > begin &&
           columns->separator != STP_SEPARATOR_SPACE &&
           end[-1] == stp_separator_character(columns->separator);
}

/* Parses a number and the separator after it in one go. NULL: the slow path must look. */
static const char *fast_number(stp_separator separator, const char *at, const char *end,
                               double *value)
{
    const bool tabs = separator == STP_SEPARATOR_SPACE;
    while (at < end && (*at == ' ' || (tabs && *at == '\t')))
        at++;
    const char *stop = stp_number_scan(at, end, value);
    if (!stop || stop == end)
        return stop;
    return *stop == stp_separator_character(separator) || (tabs && *stop == '\t') ? stop + 1 : NULL;
}

/* Puts a number where the packed point has the attribute; extra: 1 + its index. */
static void keep_number(uint8_t *numbers, uint8_t extra, double value)
{
    uint64_t word;
    memcpy(&word, &value, sizeof word);
    stp_attribute_put(STP_ATTRIBUTE_F64, word, numbers + (extra - 1u) * sizeof value);
}

static stp_status read_values(const stp_text *text, const char *begin, const char *end,
                              double *values, uint8_t *numbers, stp_error *err)
{
    const stp_columns *c = &text->columns;
    const char *at = begin;
    for (uint32_t i = 0; i < c->count; i++) {
        const uint8_t target = c->targets[i], extra = numbers ? c->extras[i] : 0;
        stp_field field;
        double *value = &values[target];
        const char *next = NULL;
        if (target < STP_COLUMN_COUNT || extra > 0)
            next = fast_number(c->separator, at, end, value);
        if (next) {
            at = next;
        } else if (!stp_field_next(c->separator, &at, end, &field)) {
            if (i + 1 < c->count || !may_miss_last(text, begin, end))
                return few_columns(text, i, err);
            *value = (double)NAN;
            break;
        } else if (target == STP_COLUMN_NONE && extra == 0) {
            continue;
        } else if (target == STP_COLUMN_PACKED
                       ? !stp_field_colour(c->separator, field, c->hex, value)
                       : !stp_field_number(c->separator, field, value)) {
            if (target == STP_COLUMN_NONE)
                continue; /* stays missing */
            if (!stp_field_is_missing(field))
                return bad_number(text, i, field, err);
            *value = (double)NAN;
        }
        if (extra > 0)
            keep_number(numbers, extra, *value);
    }
    if (at < end && !c->open_end && !rest_is_empty(c->separator, at, end))
        return stp_error_set(
            err, STP_CORRUPT,
            "%s: line %llu has more than the %u columns that there should be: mend "
            "the line or export the file again",
            text->source.path, (unsigned long long)text->source.line, c->count);
    return STP_OK;
}

void stp_text_take(const stp_text *text, const double v[STP_COLUMN_PACKED + 1], stp_point *out)
{
    const double z = v[STP_COLUMN_Z];
    *out = (stp_point){.position = {v[STP_COLUMN_X], v[STP_COLUMN_Y], text->z_down ? -z : z}};
    if (z == text->no_height)
        out->reject = STP_REJECT_INVALID;
    if (text->attributes & STP_POINT_HAS_NORMAL)
        out->normal =
            stp_unit_normal((stp_dvec3){v[STP_COLUMN_NX], v[STP_COLUMN_NY], v[STP_COLUMN_NZ]});
    const uint32_t packed = (uint32_t)v[STP_COLUMN_PACKED];
    if (text->packed)
        for (int k = 0; k < 3; k++)
            out->rgb[k] = (uint16_t)((packed >> (16 - 8 * k) & 255u) * 257u);
    else if (text->attributes & STP_POINT_HAS_COLOUR)
        for (int k = 0; k < 3; k++)
            out->rgb[k] = stp_value_range_map(v[STP_COLUMN_RED + k], 0.0, text->colour_scale);
    if (text->attributes & STP_POINT_HAS_INTENSITY)
        out->intensity = stp_value_range_map(v[STP_COLUMN_INTENSITY], text->intensity_low,
                                             text->intensity_scale);
    if (text->attributes & STP_POINT_HAS_CLASS)
        out->class_id = stp_class_of(v[STP_COLUMN_CLASS]);
}

stp_status stp_text_point(const stp_text *text, const char *begin, const char *end, stp_point *out,
                          uint8_t *numbers, stp_error *err)
{
    double v[STP_COLUMN_PACKED + 1] = {0.0}; /* also of columns without a meaning */
    const stp_status status = read_values(text, begin, end, v, numbers, err);
    if (status == STP_OK)
        stp_text_take(text, v, out);
    return status;
}
