/* The fixed structures of the chunk file as bytes: header, directory entries and pages, patches and
 * samples of the raw codec. formats/SPEC.md describes the same bytes.
 *
 * Pure conversions and checks; reads and writes no files. Little-endian on every machine. Threads:
 * any. */
#ifndef STP_FORMATS_CHUNK_LAYOUT_H
#define STP_FORMATS_CHUNK_LAYOUT_H

#include "base/error.h"
#include "formats/chunk/chunk_file.h"

#include <stddef.h>
#include <stdint.h>

#define STP_HEADER_BYTES 256u    /* of version 1 */
#define STP_HEADER_BYTES_2 1024u /* of version 2, which has two copies */
#define STP_SECTIONS_LIMIT 16u
#define STP_HEADER_BYTES_LIMIT 65536u
#define STP_ENTRY_BYTES 256u
#define STP_ENTRY_BYTES_LIMIT 4096u
#define STP_BLOCK_BYTES 56u       /* a record of the table of blocks */
#define STP_WIDE_BLOCK_BYTES 104u /* the same in files of before */
#define STP_PAGE_ENTRIES 64u
#define STP_FREE_BYTES 16u /* a record of the section FREE */
#define STP_HASH_BYTES 8u
#define STP_PATCH_BYTES 64u
#define STP_LINK_BYTES 2u /* follow each patch in a linked chunk */
#define STP_SAMPLE_BYTES 16u
#define STP_METADATA_BYTES_LIMIT (64u << 20)
#define STP_DEPTH_LIMIT 256u
#define STP_EXPONENT_LIMIT 200
/* Discs reach beyond the points, and so do the boxes of chunks. */
#define STP_REACH_LIMIT (8.0 * STP_COORDINATE_LIMIT)

static inline void stp_put_u16(uint8_t *bytes, uint16_t value)
{
    bytes[0] = (uint8_t)value;
    bytes[1] = (uint8_t)(value >> 8);
}

static inline void stp_put_u32(uint8_t *bytes, uint32_t value)
{
    stp_put_u16(bytes, (uint16_t)value);
    stp_put_u16(bytes + 2, (uint16_t)(value >> 16));
}

static inline void stp_put_u64(uint8_t *bytes, uint64_t value)
{
    stp_put_u32(bytes, (uint32_t)value);
    stp_put_u32(bytes + 4, (uint32_t)(value >> 32));
}

static inline uint16_t stp_get_u16(const uint8_t *bytes)
{
    return (uint16_t)(bytes[0] | bytes[1] << 8);
}

static inline uint32_t stp_get_u32(const uint8_t *bytes)
{
    return (uint32_t)stp_get_u16(bytes) | (uint32_t)stp_get_u16(bytes + 2) << 16;
}

static inline uint64_t stp_get_u64(const uint8_t *bytes)
{
    return (uint64_t)stp_get_u32(bytes) | (uint64_t)stp_get_u32(bytes + 4) << 32;
}

void stp_put_f64(uint8_t *bytes, double value);
double stp_get_f64(const uint8_t *bytes);

/* A part of a file of version 2 besides payloads, metadata and directory. */
typedef struct stp_section {
    uint32_t kind;  /* STP_SECTION_*, four letters */
    uint32_t flags; /* STP_SECTION_NEEDED */
    uint64_t offset, bytes, hash;
} stp_section;

#define STP_SECTION_BLOCKS UINT32_C(0x324b4c42)        /* "BLK2": the table of blocks */
#define STP_SECTION_PACKED_BLOCKS UINT32_C(0x334b4c42) /* "BLK3": the same, packed */
#define STP_SECTION_WIDE_BLOCKS UINT32_C(0x534b4c42)   /* "BLKS": the same in wide records */
#define STP_SECTION_NUMBERS UINT32_C(0x44545441)       /* "ATTD": the numbers of attributes */
#define STP_SECTION_ATTRIBUTES UINT32_C(0x52545441)    /* "ATTR": their list, and where they lie */
#define STP_SECTION_FREE UINT32_C(0x45455246)          /* "FREE": bytes that belong to nothing */
#define STP_SECTION_NEEDED 1u  /* a reader that does not know the kind must refuse the file */
#define STP_SECTION_COUNT_AT 1 /* of a packed table of blocks: the bit where its count begins */

/* IEEE 754 single precision. */
void stp_put_floats(uint8_t *bytes, const float *values, int count);
void stp_get_floats(const uint8_t *bytes, float *values, int count);

/* The header as stored. header_bytes and entry_bytes are those of the file, at least those of
 * version 1. */
typedef struct stp_header {
    uint16_t version_major, version_minor;
    uint32_t header_bytes;
    uint32_t chunk_count;
    uint32_t page_entries;
    uint32_t entry_bytes;
    uint32_t depth;
    uint64_t directory_offset;
    uint64_t metadata_offset, metadata_bytes, metadata_hash;
    uint64_t point_count;
    uint32_t attributes;
    uint32_t orientation;
    double lambda;
    stp_dbox box;
    uint32_t root;
    uint64_t file_bytes;
    uint64_t generation; /* of version 2: grows with each change of the file */
    uint32_t section_count;
    stp_section sections[STP_SECTIONS_LIMIT];
} stp_header;

/* Bytes before the payloads. */
static inline uint64_t stp_header_span(const stp_header *header)
{
    return header->version_major >= 2 ? 2 * (uint64_t)header->header_bytes : header->header_bytes;
}
/* Where payloads end: at the first section, or at the metadata. */
uint64_t stp_payloads_end(const stp_header *header);
/* The section of a kind, or NULL. */
const stp_section *stp_header_section(const stp_header *header, uint32_t kind);
/* The table of blocks, of any kind; NULL: there is none. */
const stp_section *stp_header_blocks(const stp_header *header);
/* Bytes of a record of a table of blocks. */
static inline size_t stp_record_bytes(const stp_section *blocks)
{
    return blocks->kind == STP_SECTION_WIDE_BLOCKS ? STP_WIDE_BLOCK_BYTES : STP_BLOCK_BYTES;
}
/* The flags of a section; block_count: of a packed table of blocks. */
static inline uint32_t stp_section_flags(uint32_t kind, uint64_t block_count)
{
    if (kind == STP_SECTION_PACKED_BLOCKS)
        return STP_SECTION_NEEDED | (uint32_t)block_count << STP_SECTION_COUNT_AT;
    return kind == STP_SECTION_BLOCKS ? STP_SECTION_NEEDED : 0;
}
/* How many records the file's table of blocks has. */
static inline uint64_t stp_header_block_count(const stp_header *header)
{
    const stp_section *blocks = stp_header_blocks(header);
    if (!blocks)
        return 0;
    return blocks->kind == STP_SECTION_PACKED_BLOCKS ? blocks->flags >> STP_SECTION_COUNT_AT
                                                     : blocks->bytes / stp_record_bytes(blocks);
}

/* Writes header_bytes bytes, STP_HEADER_BYTES or STP_HEADER_BYTES_2, including their hash. */
void stp_header_write(const stp_header *header, uint8_t *bytes);

/* Reads magic, version and header_bytes from the first 16 bytes of a file, so that the whole header
 * can be read next. Errors: FORMAT, VERSION, CORRUPT (header_bytes out of range). */
stp_status stp_header_peek(const uint8_t *bytes, uint32_t *header_bytes, stp_error *err);
/* Reads a whole header of header_bytes and checks it against itself and file_bytes. Errors: as
 * peek; CORRUPT. */
stp_status stp_header_read(const uint8_t *bytes, uint32_t header_bytes, uint64_t file_bytes,
                           stp_header *out, stp_error *err);

/* Directory pages: how many there are, and offset, bytes and entry count of page i. The header must
 * be checked. */
uint32_t stp_page_count(const stp_header *header);
uint64_t stp_page_offset(const stp_header *header, uint32_t page);
uint32_t stp_page_entry_count(const stp_header *header, uint32_t page);
size_t stp_page_bytes(const stp_header *header, uint32_t page);

/* Writes STP_ENTRY_BYTES bytes. */
void stp_entry_write(const stp_chunk_entry *entry, uint8_t *bytes);
/* Reads the version 1 part of an entry and checks it against the header. Errors: CORRUPT. */
stp_status stp_entry_read(const uint8_t *bytes, uint32_t id, const stp_header *header,
                          stp_chunk_entry *out, stp_error *err);

/* Write and read STP_PATCH_BYTES and STP_SAMPLE_BYTES bytes. Reading accepts any bytes: check
 * patches afterwards. */
void stp_patch_write(const stp_patch *patch, uint8_t *bytes);
void stp_patch_read(const uint8_t *bytes, stp_patch *out);
void stp_sample_write(const stp_sample *sample, uint8_t *bytes);
void stp_sample_read(const uint8_t *bytes, stp_sample *out);

/* xxh3-64 with seed 0, the file's only checksum. */
uint64_t stp_hash(const void *bytes, size_t size);

#endif
