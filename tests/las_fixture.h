/* LAS files for tests, put together byte by byte from the standard's tables, without our writer. */
#ifndef STP_TESTS_LAS_FIXTURE_H
#define STP_TESTS_LAS_FIXTURE_H

#include "tests/scan_fixture.h"

#include <stdbool.h>

typedef struct las_file {
    unsigned char bytes[1 << 17];
    size_t size;
} las_file;

/* Record lengths of point formats 0 to 10, and where colour stands (0: nowhere): LAS 1.4 R15,
 * tables 7 to 17. */
static const unsigned las_record_bytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
static const unsigned las_rgb_at[] = {0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
/* The least version of a format. */
static const unsigned las_least_minor[] = {0, 0, 2, 2, 3, 3, 4, 4, 4, 4, 4};

/* A little-endian number of so many bytes at a place. */
static inline void las_put(las_file *f, size_t at, size_t bytes, uint64_t value)
{
    assert_true(at + bytes <= sizeof f->bytes);
    for (size_t i = 0; i < bytes; i++)
        f->bytes[at + i] = (unsigned char)(value >> (8 * i) & 0xff);
}

static inline void las_put_double(las_file *f, size_t at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    las_put(f, at, 8, bits);
}

static inline unsigned las_header_bytes(unsigned minor)
{
    return minor >= 4 ? 375 : minor == 3 ? 235 : 227;
}

/* A header for points that follow it at once; scales 0.5, 0.25, 0.125, offsets 1000, -2000, 3000.
 */
static inline void las_begin(las_file *f, unsigned minor, unsigned format, unsigned record_bytes)
{
    memset(f->bytes, 0, sizeof f->bytes);
    memcpy(f->bytes, "LASF", 4);
    f->bytes[24] = 1;
    f->bytes[25] = (unsigned char)minor;
    las_put(f, 94, 2, las_header_bytes(minor));
    las_put(f, 96, 4, las_header_bytes(minor));
    f->bytes[104] = (unsigned char)format;
    las_put(f, 105, 2, record_bytes);
    for (unsigned axis = 0; axis < 3; axis++) {
        las_put_double(f, 131 + 8 * axis, 0.5 / (1 << axis));
        las_put_double(f, 155 + 8 * axis, 1000.0 * (axis == 1 ? -2.0 : axis + 1.0));
    }
    f->size = las_header_bytes(minor);
}

/* Both counts, as a good writer sets them. */
static inline void las_set_count(las_file *f, uint64_t count)
{
    if (f->bytes[25] >= 4)
        las_put(f, 247, 8, count);
    las_put(f, 107, 4, (f->bytes[104] & 0x3f) <= 5 ? count : 0);
}

static inline uint64_t las_get(const las_file *f, size_t at, size_t bytes)
{
    uint64_t value = 0;
    for (size_t i = 0; i < bytes; i++)
        value |= (uint64_t)f->bytes[at + i] << (8 * i);
    return value;
}

/* Appends a variable length record, whose length has so many bytes. */
static inline void las_add_record(las_file *f, const char *user, unsigned id, const void *content,
                                  size_t length, size_t length_bytes)
{
    const size_t at = f->size, head = 52 + length_bytes;
    assert_true(at + head + length <= sizeof f->bytes);
    memcpy(f->bytes + at + 2, user, strlen(user));
    las_put(f, at + 18, 2, id);
    las_put(f, at + 20, length_bytes, length);
    memcpy(f->bytes + at + head, content, length);
    f->size += head + length;
}

/* Appends a record (user id, record id, content) between header and points; before the points. */
static inline void las_add_vlr(las_file *f, const char *user, unsigned id, const void *content,
                               size_t length)
{
    las_add_record(f, user, id, content, length, 2);
    las_put(f, 96, 4, f->size);
    las_put(f, 100, 4, las_get(f, 100, 4) + 1);
}

/* Appends a record behind the points. */
static inline void las_add_evlr(las_file *f, const char *user, unsigned id, const void *content,
                                size_t length)
{
    if (las_get(f, 243, 4) == 0)
        las_put(f, 235, 8, f->size);
    las_put(f, 243, 4, las_get(f, 243, 4) + 1);
    las_add_record(f, user, id, content, length, 8);
}

/* Appends a record of the file's length: X, Y, Z, then zeros; where it begins. */
static inline size_t las_add_point(las_file *f, int32_t x, int32_t y, int32_t z)
{
    const size_t at = f->size;
    las_put(f, at, 4, (uint32_t)x);
    las_put(f, at + 4, 4, (uint32_t)y);
    las_put(f, at + 8, 4, (uint32_t)z);
    f->size += las_get(f, 105, 2);
    return at;
}

static inline void las_save(const las_file *f, const char *path)
{
    scan_fixture_bytes(path, f->bytes, f->size);
}

/* A note of a file, copied to text; empty if there is none. */
static inline void las_note(const char *path, const char *name, char *text, size_t size)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    text[0] = '\0';
    if (stp_scan_open(&scan, path, NULL, &err) != STP_OK)
        fail_msg("%s", err.message);
    const stp_scan_info *info = stp_scan_get_info(scan);
    for (uint32_t i = 0; i < info->note_count; i++)
        if (strcmp(info->notes[i].name, name) == 0)
            snprintf(text, size, "%s", info->notes[i].text);
    stp_scan_close(&scan);
}

static inline void las_expect_note(const char *path, const char *name, const char *expected)
{
    char text[4096];
    las_note(path, name, text, sizeof text);
    if (strcmp(text, expected) != 0)
        fail_msg("%s: note %s is `%s`, expected `%s`", path, name, text, expected);
}

#endif
