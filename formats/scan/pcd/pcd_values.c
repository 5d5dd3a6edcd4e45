/* Reads the values of PCD records as columns of numbers, in any encoding. */
#include "formats/scan/pcd/pcd_values.h"

#include "base/checked.h"
#include "base/memory.h"
#include "formats/scan/number.h"
#include "formats/scan/value_range.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define BLOCK_BYTES ((size_t)1 << 20)
#define SAMPLE_BLOCKS 64u
#define SAMPLE_PREFIX 65536u

/* Loads a column of one type as doubles: values lie stride bytes apart, little-endian. */
#define LOAD_COLUMN(value_type)                                                                    \
    for (size_t i = 0; i < count; i++, bytes += stride) {                                          \
        value_type value;                                                                          \
        memcpy(&value, bytes, sizeof value);                                                       \
        out[i] = (double)value;                                                                    \
    }

static void load_float(uint32_t size, const unsigned char *bytes, size_t stride, size_t count,
                       double *out)
{
    if (size == 4) {
        LOAD_COLUMN(float)
    } else {
        LOAD_COLUMN(double)
    }
}

static void load_signed(uint32_t size, const unsigned char *bytes, size_t stride, size_t count,
                        double *out)
{
    if (size == 1) {
        LOAD_COLUMN(int8_t)
    } else if (size == 2) {
        LOAD_COLUMN(int16_t)
    } else if (size == 4) {
        LOAD_COLUMN(int32_t)
    } else {
        LOAD_COLUMN(int64_t)
    }
}

static void load_unsigned(uint32_t size, const unsigned char *bytes, size_t stride, size_t count,
                          double *out)
{
    if (size == 1) {
        LOAD_COLUMN(uint8_t)
    } else if (size == 2) {
        LOAD_COLUMN(uint16_t)
    } else if (size == 4) {
        LOAD_COLUMN(uint32_t)
    } else {
        LOAD_COLUMN(uint64_t)
    }
}

static void load_field(stp_pcd_values *v, const stp_pcd_field *field, const unsigned char *bytes,
                       size_t stride, size_t count)
{
    if (field->target == STP_PCD_PACKED)
        for (size_t i = 0; i < count; i++)
            memcpy(&v->packed[i], bytes + i * stride, sizeof *v->packed);
    else if (field->type == 'F')
        load_float(field->size, bytes, stride, count, v->columns[field->target]);
    else if (field->type == 'I')
        load_signed(field->size, bytes, stride, count, v->columns[field->target]);
    else
        load_unsigned(field->size, bytes, stride, count, v->columns[field->target]);
}

static stp_status cut(const stp_pcd_values *v, stp_error *err)
{
    const bool ascii = v->header.encoding == STP_PCD_ASCII;
    return stp_error_set(
        err, STP_CORRUPT,
        "%s ends at %s %llu after %llu of %llu points: the file was cut; copy or export it again",
        v->source.path, ascii ? "line" : "byte",
        (unsigned long long)(ascii ? v->source.line : v->source.size), (unsigned long long)v->index,
        (unsigned long long)v->header.points);
}

/* True if the text can only be a float as a program prints it: it has a fraction, or is rounded
 * above the ones (4.2108e+06). A 3-byte integer in that form would lose its blue. */
static bool is_float_text(const char *token, const char *end, double value)
{
    const char *point = memchr(token, '.', (size_t)(end - token));
    const char *mark = token;
    double exponent = 0.0;
    if (!isfinite(value) || value != floor(value))
        return isfinite(value);
    while (mark < end && *mark != 'e' && *mark != 'E')
        mark++;
    const char *digits = mark + 1 < end && mark[1] == '+' ? mark + 2 : mark + 1;
    if (mark == end || !stp_number_parse(digits, end, &exponent))
        return false;
    return exponent > (point ? (double)(mark - point - 1) : 0.0);
}

/* Converts a packed colour in text to its bits. A whole number from 1 on is the integer itself,
 * unless the column is known to be floats: as a float it would have bits above red, which no colour
 * has. Any other number is a float whose bits are the colour. */
static uint32_t packed_of_text(const stp_pcd_values *v, const stp_pcd_field *field, double value)
{
    const bool whole = value >= 1.0 && value <= 4294967295.0 && value == floor(value);
    uint32_t bits = 0;
    if (whole && !v->packed_floats)
        return (uint32_t)value;
    if (field->type == 'F' && fabs(value) <= 3.4e38) {
        const float f = (float)value;
        memcpy(&bits, &f, sizeof bits);
    } else if (value < 0.0 && value >= -2147483648.0) {
        bits = (uint32_t)(int32_t)value;
    }
    return bits;
}

/* A token of a field, and the number of its value among those of the record. */
typedef struct token {
    const char *begin, *end;
    uint64_t k;
} token;

static stp_status bad_token(const stp_pcd_values *v, const token *t, const stp_pcd_field *field,
                            stp_error *err)
{
    const int length = (int)(t->end - t->begin < 40 ? t->end - t->begin : 40);
    const bool typed = field->extra > 0;
    char type[128] = "";
    if (typed)
        snprintf(type, sizeof type, " that fits field `%s` (TYPE %c, SIZE %u)", field->name,
                 field->type, field->size);
    return stp_error_set(err, STP_CORRUPT,
                         "%s: line %llu: `%.*s` is not a number%s (point %llu of %llu): mend the "
                         "line or export the file again",
                         v->source.path, (unsigned long long)v->source.line, length, t->begin, type,
                         (unsigned long long)v->index, (unsigned long long)v->header.points);
}

/* Puts a value of a field that is kept into a packed point. */
static stp_status keep_token(const stp_pcd_values *v, const stp_pcd_field *field, const token *t,
                             uint8_t *numbers, stp_error *err)
{
    const stp_pcd_extra *extra = &v->numbers.extras[field->extra - 1];
    uint64_t word = 0;
    if (!stp_pcd_number_parse(extra->type, t->begin, t->end, &word))
        return bad_token(v, t, field, err);
    stp_attribute_put(extra->type, word, numbers + extra->at + t->k * field->size);
    return STP_OK;
}

static stp_status read_token(stp_pcd_values *v, const stp_pcd_field *field, const token *t,
                             size_t row, stp_error *err)
{
    double value;
    if (!stp_number_parse(t->begin, t->end, &value))
        return bad_token(v, t, field, err);
    if (field->target == STP_PCD_PACKED) {
        v->float_seen =
            v->float_seen || (field->type == 'F' && is_float_text(t->begin, t->end, value));
        v->packed[row] = packed_of_text(v, field, value);
    } else {
        v->columns[field->target][row] = value;
    }
    return STP_OK;
}

/* Reads the values of one field of a line. */
static stp_status read_field(stp_pcd_values *v, const stp_pcd_field *field, const char **at,
                             const char *end, size_t row, uint8_t *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    for (token t = {.k = 0}; t.k < field->count; t.k++) {
        t.begin = stp_token(at, end);
        t.end = *at;
        if (!t.begin)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: line %llu has fewer values than the %llu that the header "
                                 "declares (point %llu of %llu): mend the line or export the file "
                                 "again",
                                 v->source.path, (unsigned long long)v->source.line,
                                 (unsigned long long)v->header.values, (unsigned long long)v->index,
                                 (unsigned long long)v->header.points);
        if (field->target != STP_PCD_TARGET_COUNT)
            STP_TRY(read_token(v, field, &t, row, err));
        if (field->extra > 0 && numbers)
            STP_TRY(keep_token(v, field, &t, numbers, err));
    }
done:
    return status;
}

static stp_status read_line(stp_pcd_values *v, size_t row, uint8_t *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    const char *at, *end, *ahead;
    do {
        STP_TRY(stp_source_line(&v->source, &at, &end, err));
        if (!at)
            return cut(v, err);
        ahead = at;
    } while (!stp_token(&ahead, end));
    for (size_t i = 0; i < v->header.field_count; i++)
        STP_TRY(read_field(v, &v->header.fields[i], &at, end, row, numbers, err));
    if (stp_token(&at, end))
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: line %llu has more values than the %llu that the header "
                               "declares (point %llu of %llu): mend the header or export the file "
                               "again",
                               v->source.path, (unsigned long long)v->source.line,
                               (unsigned long long)v->header.values, (unsigned long long)v->index,
                               (unsigned long long)v->header.points);
    else
        v->index++;
done:
    return status;
}

static stp_status read_binary(stp_pcd_values *v, size_t count, uint8_t *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t bytes = count * v->header.stride;
    const unsigned char *data;
    size_t available;
    STP_TRY(stp_source_peek(&v->source, bytes, &data, &available, err));
    if (available < bytes)
        return cut(v, err);
    for (size_t i = 0; i < v->header.field_count; i++) {
        const stp_pcd_field *field = &v->header.fields[i];
        if (field->target != STP_PCD_TARGET_COUNT)
            load_field(v, field, data + field->offset, v->header.stride, count);
    }
    for (uint32_t e = 0; numbers && e < v->numbers.count; e++) {
        const stp_pcd_extra *extra = &v->numbers.extras[e];
        const size_t offset = v->header.fields[extra->field].offset;
        for (size_t i = 0; i < count; i++)
            memcpy(numbers + i * v->numbers.stride + extra->at,
                   data + i * v->header.stride + offset, extra->bytes);
    }
    stp_source_consume(&v->source, bytes);
    v->index += count;
done:
    return status;
}

static stp_status read_compressed(stp_pcd_values *v, size_t count, uint8_t *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    unsigned char bytes[8 * STP_PCD_BLOCK_POINTS];
    for (int t = 0; t < STP_PCD_TARGET_COUNT; t++) {
        const stp_pcd_field *field = stp_pcd_header_find(&v->header, (stp_pcd_target)t);
        if (!field)
            continue;
        STP_TRY(stp_lzf_read(&v->decoders[t], bytes, count * field->size, err));
        load_field(v, field, bytes, field->size, count);
    }
    for (uint32_t e = 0; numbers && e < v->numbers.count; e++) {
        const stp_pcd_extra *extra = &v->numbers.extras[e];
        for (size_t i = 0; i < count; i++)
            STP_TRY(stp_lzf_read(&v->decoders[STP_PCD_TARGET_COUNT + e],
                                 numbers + i * v->numbers.stride + extra->at, extra->bytes, err));
    }
    v->index += count;
done:
    return status;
}

stp_status stp_pcd_values_read(stp_pcd_values *v, size_t count, uint8_t *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    if (v->header.encoding == STP_PCD_BINARY)
        return read_binary(v, count, numbers, err);
    if (v->header.encoding == STP_PCD_COMPRESSED)
        return read_compressed(v, count, numbers, err);
    for (size_t row = 0; row < count; row++)
        STP_TRY(read_line(v, row, numbers ? numbers + row * v->numbers.stride : NULL, err));
done:
    return status;
}

/* Rejects a count that the file cannot hold, before anyone allocates by it. */
static stp_status check_count(stp_pcd_values *v, stp_error *err)
{
    stp_pcd_header *h = &v->header;
    const bool ascii = h->encoding == STP_PCD_ASCII;
    const uint64_t left = v->source.size - v->source.offset;
    /* ASCII: a digit and a separator per value; the last separator may be missing. */
    const uint64_t fit = ascii ? (left + 1) / (2 * h->values) : left / h->stride;
    if (h->points <= fit)
        return STP_OK;
    if (v->salvage && stp_salvage_count(&h->points, fit, &v->lost_count))
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: the PCD header declares %llu points, but the %llu bytes from byte "
                         "%llu on hold %s%llu: the file was cut or its header is wrong; copy or "
                         "export it again",
                         v->source.path, (unsigned long long)h->points, (unsigned long long)left,
                         (unsigned long long)h->data_offset, ascii ? "at most " : "",
                         (unsigned long long)fit);
}

/* The compressed bytes [begin, end) of the file, and their decoded size. */
typedef struct compressed_block {
    uint64_t begin, end, size;
    bool padded; /* the block includes the fields that only fill up records: writers differ */
} compressed_block;

/* Finds the block from the two sizes before it and checks them against the header. */
static stp_status find_block(stp_pcd_values *v, compressed_block *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_pcd_header *h = &v->header;
    const unsigned char *bytes;
    size_t available, plain = 0;
    uint32_t sizes[2];
    uint64_t whole = 0, without = 0;
    STP_TRY(stp_source_peek(&v->source, sizeof sizes, &bytes, &available, err));
    if (available < sizeof sizes)
        return cut(v, err);
    memcpy(sizes, bytes, sizeof sizes);
    const uint64_t begin = h->data_offset + sizeof sizes;
    for (size_t i = 0; i < h->field_count; i++)
        if (!stp_pcd_field_is_padding(&h->fields[i]))
            plain += h->fields[i].size * (size_t)h->fields[i].count;
    const bool padded = stp_mul_u64(h->stride, h->points, &whole) && whole == sizes[1];
    if (!padded && !(stp_mul_u64(plain, h->points, &without) && without == sizes[1]))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: byte %llu: the compressed data declares %u bytes when decoded, "
                             "but the header %llu points of %zu: the file is damaged; copy or "
                             "export it again",
                             v->source.path, (unsigned long long)h->data_offset + 4, sizes[1],
                             (unsigned long long)h->points, plain);
    if (sizes[0] > v->source.size - begin)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: byte %llu: %u bytes of compressed data are declared, but %llu "
                             "follow: the file was cut; copy or export it again",
                             v->source.path, (unsigned long long)h->data_offset, sizes[0],
                             (unsigned long long)(v->source.size - begin));
    *out = (compressed_block){begin, begin + sizes[0], sizes[1], padded};
done:
    return status;
}

/* Decodes everything once and leaves a decoder at the first value of each wanted field. */
static stp_status open_compressed(stp_pcd_values *v, stp_error *err)
{
    stp_status status = STP_OK;
    stp_lzf *scout = NULL;
    compressed_block b = {0};
    if (v->header.points == 0)
        return STP_OK;
    STP_TRY(find_block(v, &b, err));
    STP_TRY(stp_alloc(&scout, 1, sizeof *scout, "decoder", err));
    STP_TRY(stp_alloc(&v->decoders,
                      STP_PCD_TARGET_COUNT + (v->keeps_numbers ? v->numbers.count : 0),
                      sizeof *v->decoders, "decoders", err));
    stp_lzf_init(scout, v->source.descriptor, v->source.path, b.begin, b.end, b.size);
    for (size_t i = 0; i < v->header.field_count; i++) {
        const stp_pcd_field *field = &v->header.fields[i];
        if (!b.padded && stp_pcd_field_is_padding(field))
            continue;
        if (field->target != STP_PCD_TARGET_COUNT)
            v->decoders[field->target] = *scout;
        if (field->extra > 0 && v->keeps_numbers)
            v->decoders[STP_PCD_TARGET_COUNT + field->extra - 1] = *scout;
        /* No overflow: all fields together are `size`. */
        STP_TRY(stp_lzf_read(scout, NULL, field->size * field->count * v->header.points, err));
    }
    STP_TRY(stp_lzf_finish(scout, err));
done:
    free(scout);
    return status;
}

stp_status stp_pcd_values_open(stp_pcd_values *v, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_source_open(&v->source, path, err));
    STP_TRY(stp_pcd_header_read(&v->header, &v->source, err));
    stp_pcd_numbers_find(&v->numbers, &v->header);
    v->block_points = BLOCK_BYTES / v->header.stride;
    if (v->block_points > STP_PCD_BLOCK_POINTS)
        v->block_points = STP_PCD_BLOCK_POINTS;
    if (v->block_points == 0)
        v->block_points = 1;
    if (v->header.encoding == STP_PCD_COMPRESSED)
        STP_TRY(open_compressed(v, err));
    else
        STP_TRY(check_count(v, err));
done:
    return status;
}

void stp_pcd_values_close(stp_pcd_values *v)
{
    stp_source_close(&v->source);
    stp_pcd_header_free(&v->header);
    stp_pcd_numbers_clear(&v->numbers);
    free(v->decoders);
    v->decoders = NULL;
}

static void add_columns(const stp_pcd_values *v, stp_pcd_target first, stp_pcd_target last,
                        size_t count, stp_value_span *span)
{
    for (int t = (int)first; t <= (int)last; t++)
        for (size_t i = 0; i < count; i++)
            stp_value_span_add(span,
                               t == STP_PCD_PACKED ? v->packed[i] & 0xFFFFFFu : v->columns[t][i]);
}

static size_t block_of(const stp_pcd_values *v, uint64_t left)
{
    return left < v->block_points ? (size_t)left : v->block_points;
}

void stp_pcd_values_seek(stp_pcd_values *v, uint64_t record)
{
    stp_source_seek(&v->source, v->header.data_offset + record * v->header.stride, 0);
    v->index = record;
}

static stp_status sample_spread(stp_pcd_values *v, stp_pcd_target first, stp_pcd_target last,
                                stp_value_span *span, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t total = v->header.points, blocks = SAMPLE_BLOCKS;
    uint64_t next = 0;
    for (uint64_t block = 0; block < blocks && next < total; block++) {
        uint64_t at = stp_spread_begin(total, block, blocks);
        at = at > next ? at : next; /* else blocks of small files would overlap */
        const size_t count = block_of(v, total - at);
        stp_pcd_values_seek(v, at);
        STP_TRY(read_binary(v, count, NULL, err));
        add_columns(v, first, last, count, span);
        next = at + count;
    }
done:
    return status;
}

static stp_status sample_prefix(stp_pcd_values *v, stp_pcd_target first, stp_pcd_target last,
                                stp_value_span *span, stp_error *err)
{
    uint64_t left = v->header.points;
    while (left > 0 && (v->index < SAMPLE_PREFIX || (span->max <= 0.0 && first >= STP_PCD_RED))) {
        const size_t count = block_of(v, left);
        const bool beyond = v->index >= SAMPLE_PREFIX;
        const stp_status status = stp_pcd_values_read(v, count, NULL, beyond ? NULL : err);
        if (status != STP_OK)
            return beyond ? STP_OK : status; /* whoever reads the records will say why */
        add_columns(v, first, last, count, span);
        left -= count;
    }
    return STP_OK;
}

stp_status stp_pcd_values_find_packing(stp_pcd_values *v, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_pcd_field *field = stp_pcd_header_find(&v->header, STP_PCD_PACKED);
    stp_value_span unused = {0};
    if (v->header.encoding != STP_PCD_ASCII || !field || field->type != 'F')
        return STP_OK;
    STP_TRY(sample_prefix(v, STP_PCD_X, STP_PCD_X, &unused, err));
    v->packed_floats = v->float_seen;
    stp_source_seek(&v->source, v->header.data_offset, v->header.lines);
    v->index = 0;
done:
    return status;
}

/* Keeps the decoders of the first record. *marks: free it; NULL: there are none. */
static stp_status mark_first(const stp_pcd_values *v, stp_lzf **marks, stp_error *err)
{
    stp_status status = STP_OK;
    if (v->decoders) {
        STP_TRY(stp_alloc(marks, STP_PCD_TARGET_COUNT, sizeof **marks, "decoders", err));
        memcpy(*marks, v->decoders, STP_PCD_TARGET_COUNT * sizeof **marks);
    }
done:
    return status;
}

static void go_to_first(stp_pcd_values *v, const stp_lzf *marks)
{
    stp_source_seek(&v->source, v->header.data_offset, v->header.lines);
    v->index = 0;
    if (marks)
        memcpy(v->decoders, marks, STP_PCD_TARGET_COUNT * sizeof *marks);
}

stp_status stp_pcd_values_span(stp_pcd_values *v, stp_pcd_target first, stp_pcd_target last,
                               stp_value_span *span, stp_error *err)
{
    stp_status status = STP_OK;
    stp_lzf *marks = NULL;
    *span = (stp_value_span){0};
    STP_TRY(mark_first(v, &marks, err));
    STP_TRY(v->header.encoding == STP_PCD_BINARY ? sample_spread(v, first, last, span, err)
                                                 : sample_prefix(v, first, last, span, err));
    go_to_first(v, marks);
done:
    free(marks);
    return status;
}

stp_status stp_pcd_values_find_zeros(stp_pcd_values *v, bool *several, stp_error *err)
{
    stp_status status = STP_OK;
    stp_lzf *marks = NULL;
    unsigned zeros = 0;
    STP_TRY(mark_first(v, &marks, err));
    while (zeros < 2 && v->index < v->header.points) {
        const size_t count = block_of(v, v->header.points - v->index);
        if (stp_pcd_values_read(v, count, NULL, NULL) != STP_OK)
            break; /* whoever reads the records will say why */
        for (size_t i = 0; i < count; i++)
            zeros += v->columns[STP_PCD_X][i] == 0.0 && v->columns[STP_PCD_Y][i] == 0.0 &&
                     v->columns[STP_PCD_Z][i] == 0.0;
    }
    *several = zeros > 1;
    go_to_first(v, marks);
done:
    free(marks);
    return status;
}
