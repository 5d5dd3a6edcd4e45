/* PCD files written by the tests, in each of the three encodings. */
#ifndef STP_TESTS_PCD_FIXTURE_H
#define STP_TESTS_PCD_FIXTURE_H

#include "tests/lzf_fixture.h"

typedef enum pcd_encoding {
    PCD_ASCII,
    PCD_BINARY,
    PCD_COMPRESSED,
    PCD_ENCODING_COUNT
} pcd_encoding;

static const char *const pcd_encoding_names[PCD_ENCODING_COUNT] = {"ascii", "binary",
                                                                   "binary_compressed"};

/* A field: values[point * count + k]. Type P: a packed colour as type F, its bits in the value. */
typedef struct pcd_column {
    const char *name;
    char type;
    unsigned size, count;
    const double *values;
} pcd_column;

typedef struct pcd_file {
    const pcd_column *columns;
    size_t column_count;
    size_t width, height;
    const char *viewpoint; /* NULL: no such line */
} pcd_file;

static inline void pcd_header_line(byte_row *out, const pcd_file *file, const char *keyword)
{
    bytes_text(out, keyword);
    for (size_t i = 0; i < file->column_count; i++) {
        const pcd_column *c = &file->columns[i];
        char text[80];
        if (strcmp(keyword, "FIELDS") == 0)
            snprintf(text, sizeof text, " %s", c->name);
        else if (strcmp(keyword, "TYPE") == 0)
            snprintf(text, sizeof text, " %c", c->type == 'P' ? 'F' : c->type);
        else
            snprintf(text, sizeof text, " %u", strcmp(keyword, "SIZE") == 0 ? c->size : c->count);
        bytes_text(out, text);
    }
    bytes_text(out, "\n");
}

static inline void pcd_header(byte_row *out, const pcd_file *file, pcd_encoding encoding)
{
    static const char *const lines[] = {"FIELDS", "SIZE", "TYPE", "COUNT"};
    char text[400];
    bytes_text(out, "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n");
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++)
        pcd_header_line(out, file, lines[i]);
    snprintf(text, sizeof text, "WIDTH %zu\nHEIGHT %zu\n%s%s%sPOINTS %zu\nDATA %s\n", file->width,
             file->height, file->viewpoint ? "VIEWPOINT " : "",
             file->viewpoint ? file->viewpoint : "", file->viewpoint ? "\n" : "",
             file->width * file->height, pcd_encoding_names[encoding]);
    bytes_text(out, text);
}

static inline void pcd_binary_value(byte_row *out, const pcd_column *c, double value)
{
    if (c->type == 'F' && c->size == 4)
        bytes_float(out, (float)value);
    else if (c->type == 'F')
        bytes_double(out, value);
    else if (c->type == 'I')
        bytes_integer(out, (uint64_t)(int64_t)value, c->size);
    else
        bytes_integer(out, (uint64_t)value, c->size);
}

static inline void pcd_text_value(byte_row *out, const pcd_column *c, double value)
{
    char text[64];
    const uint32_t bits = c->type == 'P' ? (uint32_t)value : 0;
    float packed;
    memcpy(&packed, &bits, sizeof packed);
    snprintf(text, sizeof text, "%.17g ", c->type == 'P' ? (double)packed : value);
    bytes_text(out, text);
}

static inline void pcd_record(byte_row *out, const pcd_file *file, size_t point, bool is_text)
{
    for (size_t i = 0; i < file->column_count; i++)
        for (unsigned k = 0; k < file->columns[i].count; k++) {
            const double value = file->columns[i].values[point * file->columns[i].count + k];
            if (is_text)
                pcd_text_value(out, &file->columns[i], value);
            else
                pcd_binary_value(out, &file->columns[i], value);
        }
}

/* As the library writes it: field by field, without padding. */
static inline void pcd_compressed(byte_row *out, const pcd_file *file)
{
    byte_row plain = {0}, packed = {0};
    for (size_t i = 0; i < file->column_count; i++)
        for (size_t v = 0; v < file->width * file->height * file->columns[i].count; v++)
            if (strcmp(file->columns[i].name, "_") != 0)
                pcd_binary_value(&plain, &file->columns[i], file->columns[i].values[v]);
    lzf_compress(&packed, plain.data, plain.size);
    bytes_integer(out, packed.size, 4);
    bytes_integer(out, plain.size, 4);
    bytes_add(out, packed.data, packed.size);
    bytes_free(&plain);
    bytes_free(&packed);
}

/* The whole file; free with bytes_free. */
static inline byte_row pcd_make(const pcd_file *file, pcd_encoding encoding)
{
    byte_row out = {0};
    pcd_header(&out, file, encoding);
    if (encoding == PCD_COMPRESSED) {
        pcd_compressed(&out, file);
        return out;
    }
    for (size_t p = 0; p < file->width * file->height; p++) {
        pcd_record(&out, file, p, encoding == PCD_ASCII);
        if (encoding == PCD_ASCII)
            bytes_text(&out, "\n");
    }
    return out;
}

#endif
