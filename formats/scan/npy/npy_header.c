/* The header of a .npy file of NumPy. */
#include "formats/scan/npy/npy_header.h"

#include "base/checked.h"
#include "formats/scan/number.h"

#include <stdio.h>
#include <string.h>

#define HEADER_BYTES_LIMIT 65536u
#define PREFIX_BYTES 12u
#define AXES_LIMIT 3u
#define RECORD_BYTES_LIMIT 4096u

/* What is left of the header's text, a dictionary as Python writes it. */
typedef struct cursor {
    const char *path, *at, *end;
} cursor;

static stp_status unreadable(const cursor *c, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: its NumPy header cannot be read: save the array again (numpy.save)",
                         c->path);
}

static stp_status no_points(const cursor *c, stp_error *err)
{
    return stp_error_set(err, STP_UNSUPPORTED,
                         "%s: this array is no list of points: save one of N x 3 numbers or more, "
                         "or records with x, y and z; heights as TIFF",
                         c->path);
}

static bool skip(cursor *c, char expected)
{
    while (c->at < c->end && (*c->at == ' ' || *c->at == '\n'))
        c->at++;
    if (c->at == c->end || *c->at != expected)
        return false;
    c->at++;
    return true;
}

/* Goes behind the key of the dictionary. */
static bool find(cursor *c, const char *key)
{
    const char *at = memmem(c->at, (size_t)(c->end - c->at), key, strlen(key));
    if (!at)
        return false;
    c->at = at + strlen(key);
    return true;
}

static bool next_text(cursor *c, stp_field *text)
{
    if (!skip(c, '\''))
        return false;
    const char *stop = memchr(c->at, '\'', (size_t)(c->end - c->at));
    if (!stop)
        return false;
    *text = (stp_field){c->at, stop};
    c->at = stop + 1;
    return true;
}

/* Takes a type such as <f4, and puts the column behind those that are there. */
static stp_status add_column(stp_npy_header *h, const cursor *c, stp_field type, stp_error *err)
{
    uint64_t bytes = 0;
    if (type.end - type.begin < 3 || h->column_count == STP_COLUMNS_MAX ||
        !stp_number_parse_u64(type.begin + 2, type.end, &bytes))
        return no_points(c, err);
    const char order = type.begin[0], kind = type.begin[1];
    const bool whole = strchr("iu", kind) && (bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8);
    if (kind == '\0' ||
        !(whole || (kind == 'f' && (bytes == 4 || bytes == 8)) || (kind == 'b' && bytes == 1)))
        return stp_error_set(
            err, STP_UNSUPPORTED,
            "%s: numbers of type `%.*s` are not read: save them as float32 or "
            "float64 (astype)",
            c->path, (int)(type.end - type.begin < 16 ? type.end - type.begin : 16), type.begin);
    h->columns[h->column_count++] = (stp_npy_column){
        .kind = kind, .bytes = (uint8_t)bytes, .big = order == '>', .offset = h->stride};
    h->stride += bytes;
    return STP_OK;
}

/* Passes over bytes that are no number, as gaps between fields (|V4) and texts (S8, U5) are. */
static bool skip_bytes(stp_npy_header *h, stp_field type)
{
    uint64_t bytes = 0;
    if (type.end - type.begin < 3 || !strchr("VSU", type.begin[1]) ||
        !stp_number_parse_u64(type.begin + 2, type.end, &bytes) || bytes > RECORD_BYTES_LIMIT)
        return false;
    h->stride += bytes * (type.begin[1] == 'U' ? 4 : 1);
    return h->stride <= RECORD_BYTES_LIMIT;
}

/* Puts the name behind the others. Commas are between names. */
static void add_name(stp_npy_header *h, stp_field name)
{
    size_t used = strlen(h->names);
    if (h->column_count > 1)
        h->names[used++] = ',';
    stp_column_copy_name(h->names + used, STP_ATTRIBUTE_NAME_BYTES - 1, name);
    for (char *c = h->names + used; *c; c++)
        *c = *c == ',' || *c == '"' ? '_' : *c;
}

/* A list of records' fields: ('x', '<f4'), and so on. */
static stp_status read_fields(stp_npy_header *h, cursor *c, stp_error *err)
{
    stp_status status = STP_OK;
    while (!skip(c, ']')) {
        stp_field name, type;
        if (!skip(c, '(') || !next_text(c, &name) || !skip(c, ',') || !next_text(c, &type) ||
            !skip(c, ')'))
            return no_points(c, err); /* fields of several numbers, or of other fields */
        if (!skip_bytes(h, type)) {
            STP_TRY(add_column(h, c, type, err));
            add_name(h, name);
        }
        (void)skip(c, ',');
    }
done:
    return status;
}

/* Takes (3000, 4). *axes: how many numbers it has. */
static bool read_shape(cursor *c, uint64_t shape[AXES_LIMIT], uint32_t *axes)
{
    *axes = 0;
    if (!skip(c, '('))
        return false;
    while (!skip(c, ')')) {
        while (c->at < c->end && *c->at == ' ')
            c->at++;
        const char *begin = c->at;
        while (c->at < c->end && *c->at >= '0' && *c->at <= '9')
            c->at++;
        if (*axes == AXES_LIMIT || !stp_number_parse_u64(begin, c->at, &shape[(*axes)++]))
            return false;
        (void)skip(c, ',');
    }
    return true;
}

static bool is_row(uint64_t count)
{
    return count >= 3 && count <= STP_COLUMNS_MAX;
}

/* Lays out the numbers of an array of one type, whose only column is there. */
static stp_status lay_out(stp_npy_header *h, const cursor *c, const uint64_t shape[AXES_LIMIT],
                          uint32_t axes, bool fortran, stp_error *err)
{
    const stp_npy_column first = h->columns[0];
    const uint64_t last = axes > 1 ? shape[axes - 1] : 0;
    const bool transposed = axes == 2 && is_row(shape[0]) && last > STP_COLUMNS_MAX;
    const uint64_t columns = transposed ? shape[0] : last;
    h->points = transposed ? last : shape[0];
    if (!is_row(columns) || (axes == 3 && !stp_mul_u64(shape[0], shape[1], &h->points)) ||
        h->points > UINT64_MAX / 8 / STP_COLUMNS_MAX)
        return no_points(c, err);
    h->apart = transposed != fortran;
    h->stride = h->apart ? first.bytes : columns * first.bytes;
    h->column_count = (uint32_t)columns;
    for (uint32_t i = 0; i < columns; i++) {
        h->columns[i] = first;
        h->columns[i].offset = i * (h->apart ? h->points * first.bytes : first.bytes);
    }
    return STP_OK;
}

static stp_status parse(stp_npy_header *h, const cursor *text, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t shape[AXES_LIMIT] = {0};
    uint32_t axes = 0;
    cursor type = *text, order = *text, size = *text;
    stp_field word;
    if (!find(&type, "'descr':") || !find(&order, "'fortran_order':") || !find(&size, "'shape':") ||
        !read_shape(&size, shape, &axes))
        return unreadable(text, err);
    if (!skip(&type, '[')) {
        if (!next_text(&type, &word))
            return unreadable(text, err);
        STP_TRY(add_column(h, text, word, err));
        return lay_out(h, text, shape, axes, skip(&order, 'T'), err);
    }
    STP_TRY(read_fields(h, &type, err));
    if (axes != 1 || h->column_count == 0)
        return no_points(text, err);
    h->points = shape[0];
done:
    return status;
}

stp_status stp_npy_header_read(stp_npy_header *out, stp_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    stp_npy_header h = {.begin = 0};
    const unsigned char *b;
    size_t available;
    cursor text = {.path = source->path};
    STP_TRY(stp_source_peek(source, PREFIX_BYTES, &b, &available, err));
    if (available < PREFIX_BYTES)
        return unreadable(&text, err);
    const bool wide = b[6] > 1; /* the version: from 2 on, lengths have 32 bits */
    const uint32_t length = (uint32_t)b[8] | (uint32_t)b[9] << 8 |
                            (wide ? (uint32_t)b[10] << 16 | (uint32_t)b[11] << 24 : 0u);
    const size_t before = wide ? 12 : 10;
    if (length > HEADER_BYTES_LIMIT)
        return unreadable(&text, err);
    STP_TRY(stp_source_peek(source, before + length, &b, &available, err));
    text.at = (const char *)b + before;
    text.end = (const char *)b + available;
    if (available < before + length)
        return unreadable(&text, err);
    STP_TRY(parse(&h, &text, err));
    h.begin = before + length;
    *out = h;
done:
    return status;
}
