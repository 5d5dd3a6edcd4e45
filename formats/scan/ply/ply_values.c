/* Reads the values of PLY records. */
#include "formats/scan/ply/ply_values.h"

#include "base/checked.h"
#include "formats/scan/number.h"

#include <string.h>

static uint16_t load_u16(const unsigned char *bytes, bool swap)
{
    uint16_t value;
    memcpy(&value, bytes, sizeof value);
    return swap ? __builtin_bswap16(value) : value;
}

static uint32_t load_u32(const unsigned char *bytes, bool swap)
{
    uint32_t value;
    memcpy(&value, bytes, sizeof value);
    return swap ? __builtin_bswap32(value) : value;
}

static double load_float(const unsigned char *bytes, bool swap)
{
    uint32_t bits = load_u32(bytes, swap);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

static uint64_t load_u64(const unsigned char *bytes, bool swap)
{
    uint64_t value;
    memcpy(&value, bytes, sizeof value);
    return swap ? __builtin_bswap64(value) : value;
}

static double load_double(const unsigned char *bytes, bool swap)
{
    const uint64_t bits = load_u64(bytes, swap);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

void stp_ply_load_column(stp_ply_type type, stp_ply_encoding encoding, const unsigned char *bytes,
                         size_t stride, size_t count, double *out)
{
    const bool host_is_big = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;
    const bool swap = (encoding == STP_PLY_BINARY_BIG_ENDIAN) != host_is_big;
#define COLUMN(value)                                                                              \
    for (size_t i = 0; i < count; i++, bytes += stride)                                            \
        out[i] = (double)(value);                                                                  \
    return
    switch (type) {
    case STP_PLY_INT8:
        COLUMN((int8_t)*bytes);
    case STP_PLY_UINT8:
        COLUMN(*bytes);
    case STP_PLY_INT16:
        COLUMN((int16_t)load_u16(bytes, swap));
    case STP_PLY_UINT16:
        COLUMN(load_u16(bytes, swap));
    case STP_PLY_INT32:
        COLUMN((int32_t)load_u32(bytes, swap));
    case STP_PLY_UINT32:
        COLUMN(load_u32(bytes, swap));
    case STP_PLY_INT64:
        COLUMN((int64_t)load_u64(bytes, swap));
    case STP_PLY_UINT64:
        COLUMN(load_u64(bytes, swap));
    case STP_PLY_FLOAT32:
        COLUMN(load_float(bytes, swap));
    case STP_PLY_FLOAT64:
        COLUMN(load_double(bytes, swap));
    }
#undef COLUMN
}

/* A plain plural of the element's name. */
static const char *plural(const stp_ply_element *element)
{
    if (strcmp(element->name, "vertex") == 0)
        return "vertices";
    return strcmp(element->name, "face") == 0 ? "faces" : element->name;
}

stp_status stp_ply_cut(const stp_ply_cursor *c, stp_error *err)
{
    const bool ascii = c->encoding == STP_PLY_ASCII;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: ends at %s %llu after %llu of %llu %s: the file was cut; copy or "
                         "export it again",
                         c->source->path, ascii ? "line" : "byte",
                         (unsigned long long)(ascii ? c->source->line : c->source->size),
                         (unsigned long long)c->index, (unsigned long long)c->element->count,
                         plural(c->element));
}

stp_status stp_ply_record_begin(stp_ply_cursor *c, stp_error *err)
{
    stp_status status = STP_OK;
    if (c->encoding != STP_PLY_ASCII)
        return STP_OK;
    for (;;) {
        STP_TRY(stp_source_line(c->source, &c->at, &c->end, err));
        if (!c->at)
            return stp_ply_cut(c, err);
        const char *probe = c->at;
        if (stp_token(&probe, c->end) || c->element->property_count == 0)
            break;
    }
done:
    return status;
}

static stp_status next_token_value(stp_ply_cursor *c, double *value, stp_error *err)
{
    const char *token = stp_token(&c->at, c->end);
    if (!token) {
        if (c->source->offset >= c->source->size)
            return stp_ply_cut(c, err);
        return stp_error_set(err, STP_CORRUPT,
                             "%s: line %llu has fewer values than the header declares for %s "
                             "%llu of %llu: mend the line or export the file again",
                             c->source->path, (unsigned long long)c->source->line, c->element->name,
                             (unsigned long long)c->index, (unsigned long long)c->element->count);
    }
    if (!stp_number_parse(token, c->at, value))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: line %llu: `%.*s` is not a number (%s %llu of %llu): mend the "
                             "line or export the file again",
                             c->source->path, (unsigned long long)c->source->line,
                             (int)(c->at - token < 40 ? c->at - token : 40), token,
                             c->element->name, (unsigned long long)c->index,
                             (unsigned long long)c->element->count);
    return STP_OK;
}

stp_status stp_ply_next_value(stp_ply_cursor *c, stp_ply_type type, double *value, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *bytes;
    size_t available, size = stp_ply_type_size(type);
    if (c->encoding == STP_PLY_ASCII)
        return next_token_value(c, value, err);
    STP_TRY(stp_source_peek(c->source, size, &bytes, &available, err));
    if (available < size)
        return stp_ply_cut(c, err);
    stp_ply_load_column(type, c->encoding, bytes, size, 1, value);
    stp_source_consume(c->source, size);
done:
    return status;
}

stp_status stp_ply_next_length(stp_ply_cursor *c, const stp_ply_property *list, uint64_t *length,
                               stp_error *err)
{
    stp_status status = STP_OK;
    double value = 0.0;
    STP_TRY(stp_ply_next_value(c, list->count_type, &value, err));
    const bool ascii = c->encoding == STP_PLY_ASCII;
    const uint64_t left = ascii ? (uint64_t)(c->end - c->at) : c->source->size - c->source->offset;
    /* An ASCII entry takes at least a space and a digit. */
    const uint64_t room = left / (ascii ? 2 : stp_ply_type_size(list->type));
    if (!(value >= 0.0 && value <= (double)room && value == (double)(uint64_t)value)) {
        status = stp_error_set(
            err, STP_CORRUPT,
            "%s: %s %llu: list `%s` of %s %llu declares %.17g entries where %llu fit: the file is "
            "damaged or cut; copy or export it again",
            c->source->path, ascii ? "line" : "byte",
            (unsigned long long)(ascii ? c->source->line : c->source->offset), list->name,
            c->element->name, (unsigned long long)c->index, value, (unsigned long long)room);
        goto done;
    }
    *length = (uint64_t)value;
done:
    return status;
}

stp_status stp_ply_skip_property(stp_ply_cursor *c, const stp_ply_property *property,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    double ignored;
    uint64_t length = 1;
    if (property->is_list)
        STP_TRY(stp_ply_next_length(c, property, &length, err));
    if (c->encoding != STP_PLY_ASCII && property->is_list) {
        /* next_length checked that these bytes exist. */
        stp_source_skip(c->source, length * stp_ply_type_size(property->type));
        goto done;
    }
    for (uint64_t i = 0; i < length; i++)
        STP_TRY(stp_ply_next_value(c, property->type, &ignored, err));
done:
    return status;
}

stp_status stp_ply_record_end(stp_ply_cursor *c, stp_error *err)
{
    if (c->encoding == STP_PLY_ASCII && stp_token(&c->at, c->end))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: line %llu has more values than the header declares for %s %llu "
                             "of %llu: mend the header or export the file again",
                             c->source->path, (unsigned long long)c->source->line, c->element->name,
                             (unsigned long long)c->index, (unsigned long long)c->element->count);
    c->index++;
    return STP_OK;
}

stp_status stp_ply_skip_element(stp_ply_cursor *c, const stp_ply_header *header,
                                const stp_ply_element *element, stp_error *err)
{
    stp_status status = STP_OK;
    c->element = element;
    c->index = 0;
    if (c->encoding != STP_PLY_ASCII && !element->has_lists) {
        uint64_t bytes, left = c->source->size - c->source->offset;
        if (!stp_mul_u64(element->count, element->stride, &bytes) || bytes > left) {
            c->index = left / element->stride;
            return stp_ply_cut(c, err);
        }
        stp_source_skip(c->source, bytes);
        return STP_OK;
    }
    while (c->index < element->count) {
        STP_TRY(stp_ply_record_begin(c, err));
        for (size_t i = 0; i < element->property_count; i++)
            STP_TRY(
                stp_ply_skip_property(c, &header->properties[element->property_first + i], err));
        STP_TRY(stp_ply_record_end(c, err));
    }
done:
    return status;
}
