/* E57 files written by the tests: pages with checksums, sections with packets, and the XML. */
#ifndef STP_TESTS_E57_FIXTURE_H
#define STP_TESTS_E57_FIXTURE_H

#include "tests/byte_fixture.h"

#define E57_HEADER 48u
#define E57_STREAMS_MAX 80u

/* A file before its checksums; addresses in it are logical. */
typedef struct e57_file {
    byte_row logical;
    byte_row xml;
    size_t section, packet; /* the last vector's, and its first packet */
} e57_file;

/* The bytestream of a field, and how many bytes of it go into a packet (0: all, if they fit). */
typedef struct e57_stream {
    byte_row bytes;
    size_t part;
} e57_stream;

/* Bit by bit, unlike the reader's. */
static inline uint32_t e57_crc(const unsigned char *data, size_t size)
{
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t i = 0; i < size; i++) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc & 1u ? crc >> 1 ^ 0x82F63B78u : crc >> 1;
    }
    return ~crc;
}

static inline uint64_t e57_physical(size_t logical)
{
    return logical / 1020 * 1024 + logical % 1020;
}

/* The logical bytes in pages of 1,024 with their checksums; free with bytes_free. */
static inline byte_row e57_seal(const unsigned char *logical, size_t size)
{
    byte_row out = {0};
    for (size_t at = 0; at < size; at += 1020) {
        unsigned char page[1024] = {0};
        memcpy(page, logical + at, size - at < 1020 ? size - at : 1020);
        const uint32_t crc = e57_crc(page, 1020);
        for (int i = 0; i < 4; i++)
            page[1020 + i] = (unsigned char)(crc >> (24 - 8 * i));
        bytes_add(&out, page, sizeof page);
    }
    return out;
}

static inline void e57_align(byte_row *row)
{
    bytes_add(row, NULL, (4 - row->size % 4) % 4);
}

static inline void e57_begin(e57_file *file)
{
    *file = (e57_file){0};
    bytes_add(&file->logical, NULL, E57_HEADER);
    bytes_text(
        &file->xml,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<e57Root type=\"Structure\" "
        "xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\">\n"
        "<formatName type=\"String\"><![CDATA[ASTM E57 3D Imaging Data File]]></formatName>\n"
        "<versionMajor type=\"Integer\">1</versionMajor>\n"
        "<data3D type=\"Vector\" allowHeterogeneousChildren=\"1\">\n");
}

/* The next part of each bytestream; false where none has any left. */
static inline bool e57_packet(byte_row *row, const e57_stream *streams, size_t count, size_t *done)
{
    size_t parts[E57_STREAMS_MAX], size = 6 + 2 * count, sum = 0;
    for (size_t i = 0; i < count; i++) {
        const size_t left = streams[i].bytes.size - done[i];
        const size_t fits = (65536 - 6 - 2 * count) / count / 4 * 4;
        const size_t part = streams[i].part ? streams[i].part : fits;
        parts[i] = left < part ? left : part;
        sum += parts[i];
    }
    if (sum == 0)
        return false;
    size = (size + sum + 3) / 4 * 4;
    bytes_integer(row, 1, 1);
    bytes_integer(row, 0, 1);
    bytes_integer(row, size - 1, 2);
    bytes_integer(row, count, 2);
    for (size_t i = 0; i < count; i++)
        bytes_integer(row, parts[i], 2);
    for (size_t i = 0; i < count; i++) {
        if (parts[i] > 0)
            bytes_add(row, streams[i].bytes.data + done[i], parts[i]);
        done[i] += parts[i];
    }
    bytes_add(row, NULL, size - 6 - 2 * count - sum);
    return true;
}

/* A packet of another kind: 0 index, 2 empty. */
static inline void e57_other_packet(byte_row *row, unsigned type, size_t size)
{
    bytes_integer(row, type, 1);
    bytes_integer(row, 0, 1);
    bytes_integer(row, size - 1, 2);
    bytes_add(row, NULL, size - 4);
}

/* A compressed vector, with packets of other kinds between the data if wanted. */
static inline void e57_vector(e57_file *file, const e57_stream *streams, size_t count, bool others)
{
    byte_row *row = &file->logical;
    size_t done[E57_STREAMS_MAX] = {0};
    e57_align(row);
    file->section = row->size;
    bytes_add(row, NULL, 32);
    if (others)
        e57_other_packet(row, 2, 1000);
    file->packet = row->size;
    while (e57_packet(row, streams, count, done))
        if (others)
            e57_other_packet(row, 0, 32);
    bytes_set(row, file->section, 1, 1);
    bytes_set(row, file->section + 8, row->size - file->section, 8);
    bytes_set(row, file->section + 16, e57_physical(others ? file->packet - 1000 : file->packet),
              8);
}

/* A scan of the last vector: what stands before `points`, and the prototype's fields. */
static inline void e57_scan(e57_file *file, const char *before, uint64_t records,
                            const char *prototype)
{
    char text[200];
    bytes_text(&file->xml, "<vectorChild type=\"Structure\">\n");
    bytes_text(&file->xml, before);
    snprintf(text, sizeof text,
             "<points type=\"CompressedVector\" fileOffset=\"%llu\" recordCount=\"%llu\">\n"
             "<prototype type=\"Structure\">\n",
             (unsigned long long)e57_physical(file->section), (unsigned long long)records);
    bytes_text(&file->xml, text);
    bytes_text(&file->xml, prototype);
    bytes_text(&file->xml, "</prototype>\n<codecs type=\"Vector\"/>\n</points>\n</vectorChild>\n");
}

/* Adds the XML and the header; `after` stands behind data3D. The file is to be sealed. */
static inline void e57_end(e57_file *file, const char *after)
{
    byte_row *row = &file->logical;
    bytes_text(&file->xml, "</data3D>\n");
    bytes_text(&file->xml, after);
    bytes_text(&file->xml, "</e57Root>\n");
    e57_align(row);
    const size_t xml = row->size;
    bytes_add(row, file->xml.data, file->xml.size);
    memcpy(row->data, "ASTM-E57", 8);
    bytes_set(row, 8, 1, 4);
    bytes_set(row, 12, 0, 4);
    bytes_set(row, 16, (row->size + 1019) / 1020 * 1024, 8);
    bytes_set(row, 24, e57_physical(xml), 8);
    bytes_set(row, 32, file->xml.size, 8);
    bytes_set(row, 40, 1024, 8);
}

static inline void e57_free(e57_file *file)
{
    bytes_free(&file->logical);
    bytes_free(&file->xml);
}

#define E57_FLOAT(name, precision) "<" name " type=\"Float\" precision=\"" precision "\"/>\n"
#define E57_INTEGER(name, low, high)                                                               \
    "<" name " type=\"Integer\" minimum=\"" low "\" maximum=\"" high "\"/>\n"
#define E57_SCALED(name, low, high, scale, offset)                                                 \
    "<" name " type=\"ScaledInteger\" minimum=\"" low "\" maximum=\"" high "\" scale=\"" scale     \
    "\" offset=\"" offset "\"/>\n"
#define E57_NUMBER(name, value) "<" name " type=\"Float\">" value "</" name ">"

#endif
