/* The fixed structures of the chunk file as bytes, and the checks of header and entries. */
#include "formats/chunk/layout.h"

#include "base/checked.h"

#include <float.h>
#include <inttypes.h>
#include <string.h>
#include <xxhash.h>

static const uint8_t magic[8] = {'S', 'T', 'I', 'P', 'P', 'L', 'E', 0};

uint64_t stp_hash(const void *bytes, size_t size)
{
    return XXH3_64bits(bytes, size);
}

static void put_f32(uint8_t *bytes, float value)
{
    uint32_t word;
    memcpy(&word, &value, sizeof word);
    stp_put_u32(bytes, word);
}

static float get_f32(const uint8_t *bytes)
{
    uint32_t word = stp_get_u32(bytes);
    float value;
    memcpy(&value, &word, sizeof value);
    return value;
}

void stp_put_f64(uint8_t *bytes, double value)
{
    uint64_t word;
    memcpy(&word, &value, sizeof word);
    stp_put_u64(bytes, word);
}

double stp_get_f64(const uint8_t *bytes)
{
    uint64_t word = stp_get_u64(bytes);
    double value;
    memcpy(&value, &word, sizeof value);
    return value;
}

static void put_dvec3(uint8_t *bytes, stp_dvec3 v)
{
    stp_put_f64(bytes, v.x);
    stp_put_f64(bytes + 8, v.y);
    stp_put_f64(bytes + 16, v.z);
}

static stp_dvec3 get_dvec3(const uint8_t *bytes)
{
    return (stp_dvec3){stp_get_f64(bytes), stp_get_f64(bytes + 8), stp_get_f64(bytes + 16)};
}

void stp_put_floats(uint8_t *bytes, const float *values, int count)
{
    for (int i = 0; i < count; i++)
        put_f32(bytes + 4 * i, values[i]);
}

void stp_get_floats(const uint8_t *bytes, float *values, int count)
{
    for (int i = 0; i < count; i++)
        values[i] = get_f32(bytes + 4 * i);
}

/* ---- header ---- */

#define GENERATION_AT 152u
#define SECTION_COUNT_AT 160u
#define SECTIONS_AT 168u
#define SECTION_BYTES 32u

uint64_t stp_payloads_end(const stp_header *header)
{
    return header->section_count > 0 ? header->sections[0].offset : header->metadata_offset;
}

const stp_section *stp_header_section(const stp_header *header, uint32_t kind)
{
    for (uint32_t i = 0; i < header->section_count; i++)
        if (header->sections[i].kind == kind)
            return &header->sections[i];
    return NULL;
}

const stp_section *stp_header_blocks(const stp_header *header)
{
    static const uint32_t kinds[] = {STP_SECTION_PACKED_BLOCKS, STP_SECTION_BLOCKS,
                                     STP_SECTION_WIDE_BLOCKS};
    const stp_section *found = NULL;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds && !found; i++)
        found = stp_header_section(header, kinds[i]);
    return found;
}

static void sections_write(const stp_header *header, uint8_t *bytes)
{
    stp_put_u64(bytes + GENERATION_AT, header->generation);
    stp_put_u32(bytes + SECTION_COUNT_AT, header->section_count);
    for (uint32_t i = 0; i < header->section_count; i++) {
        uint8_t *at = bytes + SECTIONS_AT + i * SECTION_BYTES;
        stp_put_u32(at, header->sections[i].kind);
        stp_put_u32(at + 4, header->sections[i].flags);
        stp_put_u64(at + 8, header->sections[i].offset);
        stp_put_u64(at + 16, header->sections[i].bytes);
        stp_put_u64(at + 24, header->sections[i].hash);
    }
}

static void sections_parse(const uint8_t *bytes, stp_header *h)
{
    h->generation = stp_get_u64(bytes + GENERATION_AT);
    h->section_count = stp_get_u32(bytes + SECTION_COUNT_AT);
    for (uint32_t i = 0; i < h->section_count && i < STP_SECTIONS_LIMIT; i++) {
        const uint8_t *at = bytes + SECTIONS_AT + i * SECTION_BYTES;
        h->sections[i] = (stp_section){stp_get_u32(at), stp_get_u32(at + 4), stp_get_u64(at + 8),
                                       stp_get_u64(at + 16), stp_get_u64(at + 24)};
    }
}

void stp_header_write(const stp_header *header, uint8_t *bytes)
{
    const size_t hashed = header->header_bytes - STP_HASH_BYTES;
    memset(bytes, 0, header->header_bytes);
    memcpy(bytes, magic, sizeof magic);
    stp_put_u16(bytes + 8, header->version_major);
    stp_put_u16(bytes + 10, header->version_minor);
    stp_put_u32(bytes + 12, header->header_bytes);
    stp_put_u32(bytes + 16, header->chunk_count);
    stp_put_u32(bytes + 20, header->page_entries);
    stp_put_u32(bytes + 24, header->entry_bytes);
    stp_put_u32(bytes + 28, header->depth);
    stp_put_u64(bytes + 32, header->directory_offset);
    stp_put_u64(bytes + 40, header->metadata_offset);
    stp_put_u64(bytes + 48, header->metadata_bytes);
    stp_put_u64(bytes + 56, header->metadata_hash);
    stp_put_u64(bytes + 64, header->point_count);
    stp_put_u32(bytes + 72, header->attributes);
    stp_put_u32(bytes + 76, header->orientation);
    stp_put_f64(bytes + 80, header->lambda);
    put_dvec3(bytes + 88, header->box.min);
    put_dvec3(bytes + 112, header->box.max);
    stp_put_u32(bytes + 136, header->root);
    stp_put_u64(bytes + 144, header->file_bytes);
    if (header->version_major >= 2)
        sections_write(header, bytes);
    stp_put_u64(bytes + hashed, stp_hash(bytes, hashed));
}

stp_status stp_header_peek(const uint8_t *bytes, uint32_t *header_bytes, stp_error *err)
{
    if (memcmp(bytes, magic, sizeof magic) != 0)
        return stp_error_set(
            err, STP_FORMAT,
            "not a stipple chunk file: its first bytes are not STIPPLE: make one of "
            "a scan with stipple prep");
    unsigned major = stp_get_u16(bytes + 8);
    unsigned minor = stp_get_u16(bytes + 10);
    if (major > STP_CHUNK_FILE_MAJOR)
        return stp_error_set(err, STP_VERSION,
                             "version %u.%u is newer than this program, which reads up to %d.x: "
                             "use a newer stipple",
                             major, minor, STP_CHUNK_FILE_MAJOR);
    if (major == 0)
        return stp_error_set(err, STP_CORRUPT, "byte 8: version %u.%u does not exist", major,
                             minor);
    uint32_t size = stp_get_u32(bytes + 12);
    /* In version 2 the size is fixed, so that the second copy is found without the first. */
    const uint32_t least = major == 1 ? STP_HEADER_BYTES : STP_HEADER_BYTES_2;
    const uint32_t most = major == 1 ? STP_HEADER_BYTES_LIMIT : STP_HEADER_BYTES_2;
    if (size < least || size > most)
        return stp_error_set(err, STP_CORRUPT,
                             "byte 12: the header has %" PRIu32 " bytes, expected %" PRIu32
                             " to %" PRIu32,
                             size, least, most);
    *header_bytes = size;
    return STP_OK;
}

static void header_parse(const uint8_t *bytes, stp_header *h)
{
    h->version_major = stp_get_u16(bytes + 8);
    h->version_minor = stp_get_u16(bytes + 10);
    h->header_bytes = stp_get_u32(bytes + 12);
    h->chunk_count = stp_get_u32(bytes + 16);
    h->page_entries = stp_get_u32(bytes + 20);
    h->entry_bytes = stp_get_u32(bytes + 24);
    h->depth = stp_get_u32(bytes + 28);
    h->directory_offset = stp_get_u64(bytes + 32);
    h->metadata_offset = stp_get_u64(bytes + 40);
    h->metadata_bytes = stp_get_u64(bytes + 48);
    h->metadata_hash = stp_get_u64(bytes + 56);
    h->point_count = stp_get_u64(bytes + 64);
    h->attributes = stp_get_u32(bytes + 72);
    h->orientation = stp_get_u32(bytes + 76);
    h->lambda = stp_get_f64(bytes + 80);
    h->box.min = get_dvec3(bytes + 88);
    h->box.max = get_dvec3(bytes + 112);
    h->root = stp_get_u32(bytes + 136);
    h->file_bytes = stp_get_u64(bytes + 144);
    if (h->version_major >= 2)
        sections_parse(bytes, h);
}

/* Sections follow each other from the end of the payloads to the metadata. */
static stp_status header_check_sections(const stp_header *h, stp_error *err)
{
    if (h->version_major >= 2 && h->generation == 0)
        return stp_error_set(err, STP_CORRUPT, "byte %u: generation 0, expected at least 1",
                             GENERATION_AT);
    if (h->section_count > STP_SECTIONS_LIMIT)
        return stp_error_set(err, STP_CORRUPT, "byte %u: %" PRIu32 " sections, expected at most %u",
                             SECTION_COUNT_AT, h->section_count, STP_SECTIONS_LIMIT);
    uint64_t at = h->section_count > 0 ? h->sections[0].offset : h->metadata_offset;
    if (at < stp_header_span(h))
        return stp_error_set(err, STP_CORRUPT, "byte %u: the first section begins at byte %" PRIu64,
                             SECTIONS_AT, at);
    for (uint32_t i = 0; i < h->section_count; i++) {
        const stp_section *s = &h->sections[i];
        if (s->offset != at || !stp_range_inside(at, s->bytes, h->metadata_offset))
            return stp_error_set(err, STP_CORRUPT,
                                 "byte %u: section %" PRIu32 " at byte %" PRIu64
                                 " does not follow what is before it",
                                 SECTIONS_AT + i * SECTION_BYTES, i, s->offset);
        const bool packed = s->kind == STP_SECTION_PACKED_BLOCKS;
        const bool blocks =
            packed || s->kind == STP_SECTION_BLOCKS || s->kind == STP_SECTION_WIDE_BLOCKS;
        const bool known = blocks || s->kind == STP_SECTION_NUMBERS ||
                           s->kind == STP_SECTION_ATTRIBUTES || s->kind == STP_SECTION_FREE;
        if ((blocks && stp_header_blocks(h) != s) ||
            (blocks && !packed && s->bytes % stp_record_bytes(s) != 0) ||
            (s->kind == STP_SECTION_FREE && s->bytes % STP_FREE_BYTES != 0) ||
            (known && stp_header_section(h, s->kind) != s))
            return stp_error_set(err, STP_CORRUPT,
                                 "byte %u: section %" PRIu32
                                 " is the second of its kind, or has a part of a record",
                                 SECTIONS_AT + i * SECTION_BYTES, i);
        if (!known && s->flags & STP_SECTION_NEEDED)
            return stp_error_set(err, STP_VERSION,
                                 "it needs a part that this program does not know: use a newer "
                                 "stipple");
        at += s->bytes;
    }
    return at == h->metadata_offset ? STP_OK
                                    : stp_error_set(err, STP_CORRUPT,
                                                    "byte %u: the sections end at byte %" PRIu64
                                                    ", the metadata begins at byte %" PRIu64,
                                                    SECTIONS_AT, at, h->metadata_offset);
}

/* Metadata and directory must follow each other, up to the file's end. */
static stp_status header_check_places(const stp_header *h, uint64_t file_bytes, stp_error *err)
{
    uint64_t directory_bytes;
    uint64_t end;
    /* Version 2 ignores what an interrupted change left behind the end. */
    if (h->version_major == 1 ? h->file_bytes != file_bytes : h->file_bytes > file_bytes)
        return stp_error_set(err, STP_CORRUPT,
                             "the file has %" PRIu64 " bytes, its header says %" PRIu64
                             ": it was cut or appended to; copy it again",
                             file_bytes, h->file_bytes);
    if (h->chunk_count == 0 || h->page_entries != STP_PAGE_ENTRIES ||
        h->entry_bytes < STP_ENTRY_BYTES || h->entry_bytes > STP_ENTRY_BYTES_LIMIT)
        return stp_error_set(err, STP_CORRUPT,
                             "byte 16: %" PRIu32 " chunks, %" PRIu32 " entries a page, %" PRIu32
                             " bytes an entry, expected at least 1, %u, %u to %u",
                             h->chunk_count, h->page_entries, h->entry_bytes, STP_PAGE_ENTRIES,
                             STP_ENTRY_BYTES, STP_ENTRY_BYTES_LIMIT);
    directory_bytes =
        (uint64_t)h->chunk_count * h->entry_bytes + (uint64_t)stp_page_count(h) * STP_HASH_BYTES;
    if (!stp_add_u64(h->directory_offset, directory_bytes, &end) || end != h->file_bytes)
        return stp_error_set(err, STP_CORRUPT,
                             "byte 32: a directory of %" PRIu64 " bytes at byte %" PRIu64
                             " does not end at the file's end, byte %" PRIu64,
                             directory_bytes, h->directory_offset, h->file_bytes);
    if (h->metadata_bytes > STP_METADATA_BYTES_LIMIT || h->metadata_offset < stp_header_span(h) ||
        !stp_add_u64(h->metadata_offset, h->metadata_bytes, &end) || end != h->directory_offset)
        return stp_error_set(err, STP_CORRUPT,
                             "byte 40: metadata of %" PRIu64 " bytes at byte %" PRIu64
                             " does not end at the directory, byte %" PRIu64,
                             h->metadata_bytes, h->metadata_offset, h->directory_offset);
    return STP_OK;
}

static bool within(stp_dvec3 p)
{
    return fabs(p.x) <= STP_REACH_LIMIT && fabs(p.y) <= STP_REACH_LIMIT &&
           fabs(p.z) <= STP_REACH_LIMIT;
}

static stp_status header_check_facts(const stp_header *h, stp_error *err)
{
    if (h->root != 0)
        return stp_error_set(err, STP_CORRUPT, "byte 136: the root is chunk %" PRIu32 ", not 0",
                             h->root);
    if (h->depth == 0 || h->depth > STP_DEPTH_LIMIT || h->depth > h->chunk_count)
        return stp_error_set(err, STP_CORRUPT,
                             "byte 28: a tree of %" PRIu32 " chunks is %" PRIu32 " levels deep",
                             h->chunk_count, h->depth);
    if (h->point_count == 0 || h->point_count > (uint64_t)h->chunk_count * STP_CHUNK_SAMPLES_LIMIT)
        return stp_error_set(err, STP_CORRUPT, "byte 64: %" PRIu64 " points in %" PRIu32 " chunks",
                             h->point_count, h->chunk_count);
    if (h->orientation > STP_ORIENTATION_MIXED)
        return stp_error_set(err, STP_CORRUPT, "byte 76: orientation %" PRIu32 " is unknown",
                             h->orientation);
    if (!isfinite(h->lambda) || !(h->lambda > 0.0))
        return stp_error_set(err, STP_CORRUPT, "byte 80: lambda is %g", h->lambda);
    if (!within(h->box.min) || !within(h->box.max) || stp_dbox_is_empty(&h->box))
        return stp_error_set(err, STP_CORRUPT,
                             "byte 88: the box is empty, or reaches farther than %g",
                             STP_COORDINATE_LIMIT);
    return STP_OK;
}

stp_status stp_header_read(const uint8_t *bytes, uint32_t header_bytes, uint64_t file_bytes,
                           stp_header *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_header header = {0};
    uint32_t peeked = 0;
    STP_TRY(stp_header_peek(bytes, &peeked, err));
    size_t hashed = header_bytes - STP_HASH_BYTES;
    if (peeked != header_bytes || stp_hash(bytes, hashed) != stp_get_u64(bytes + hashed)) {
        status = stp_error_set(err, STP_CORRUPT,
                               "the header's checksum (byte %zu) does not match: the file is "
                               "damaged; copy it again",
                               hashed);
        goto done;
    }
    header_parse(bytes, &header);
    STP_TRY(header_check_places(&header, file_bytes, err));
    STP_TRY(header_check_sections(&header, err));
    STP_TRY(header_check_facts(&header, err));
    *out = header;
done:
    return status;
}

uint32_t stp_page_count(const stp_header *header)
{
    return (header->chunk_count - 1u) / STP_PAGE_ENTRIES + 1u;
}

uint64_t stp_page_offset(const stp_header *header, uint32_t page)
{
    uint64_t full = (uint64_t)header->entry_bytes * STP_PAGE_ENTRIES + STP_HASH_BYTES;
    return header->directory_offset + full * page;
}

uint32_t stp_page_entry_count(const stp_header *header, uint32_t page)
{
    uint32_t left = header->chunk_count - page * STP_PAGE_ENTRIES;
    return left < STP_PAGE_ENTRIES ? left : STP_PAGE_ENTRIES;
}

size_t stp_page_bytes(const stp_header *header, uint32_t page)
{
    return (size_t)stp_page_entry_count(header, page) * header->entry_bytes + STP_HASH_BYTES;
}

/* ---- directory entries ---- */

void stp_entry_write(const stp_chunk_entry *e, uint8_t *bytes)
{
    memset(bytes, 0, STP_ENTRY_BYTES);
    stp_put_u64(bytes, e->offset);
    stp_put_u32(bytes + 20, e->parent);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        stp_put_u32(bytes + 8 + 4 * s, e->segment_end[s]);
        stp_put_u64(bytes + 24 + 8 * s, e->segment_hash[s]);
    }
    stp_put_u32(bytes + 48, e->first_child);
    stp_put_u32(bytes + 52, e->child_count);
    stp_put_u32(bytes + 56, e->patch_count);
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        stp_put_u32(bytes + 60 + 4 * l, e->sample_count[l]);
    bytes[76] = e->codec;
    bytes[77] = e->depth;
    bytes[78] = e->flags;
    stp_put_u64(bytes + 80, e->points_under);
    put_dvec3(bytes + 88, e->origin);
    stp_put_floats(bytes + 112, e->box_min.raw, 3);
    stp_put_floats(bytes + 124, e->box_max.raw, 3);
    stp_put_floats(bytes + 136, e->cone_axis.raw, 3);
    put_f32(bytes + 148, e->cone_angle);
    stp_put_floats(bytes + 152, e->error, STP_LEVEL_COUNT);
    stp_put_floats(bytes + 168, e->tangential_error, STP_LEVEL_COUNT);
    stp_put_floats(bytes + 184, e->colour_error, STP_LEVEL_COUNT);
    put_f32(bytes + 200, e->radius_min);
    put_f32(bytes + 204, e->radius_max);
    stp_put_u32(bytes + 208, e->first_block);
    stp_put_u32(bytes + 212, e->block_count);
    stp_put_u64(bytes + 216, e->blocks_hash);
}

static void entry_parse(const uint8_t *bytes, stp_chunk_entry *e)
{
    e->offset = stp_get_u64(bytes);
    e->parent = stp_get_u32(bytes + 20);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        e->segment_end[s] = stp_get_u32(bytes + 8 + 4 * s);
        e->segment_hash[s] = stp_get_u64(bytes + 24 + 8 * s);
    }
    e->first_child = stp_get_u32(bytes + 48);
    e->child_count = stp_get_u32(bytes + 52);
    e->patch_count = stp_get_u32(bytes + 56);
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        e->sample_count[l] = stp_get_u32(bytes + 60 + 4 * l);
    e->codec = bytes[76];
    e->depth = bytes[77];
    e->flags = bytes[78];
    e->points_under = stp_get_u64(bytes + 80);
    e->origin = get_dvec3(bytes + 88);
    stp_get_floats(bytes + 112, e->box_min.raw, 3);
    stp_get_floats(bytes + 124, e->box_max.raw, 3);
    stp_get_floats(bytes + 136, e->cone_axis.raw, 3);
    e->cone_angle = get_f32(bytes + 148);
    stp_get_floats(bytes + 152, e->error, STP_LEVEL_COUNT);
    stp_get_floats(bytes + 168, e->tangential_error, STP_LEVEL_COUNT);
    stp_get_floats(bytes + 184, e->colour_error, STP_LEVEL_COUNT);
    e->radius_min = get_f32(bytes + 200);
    e->radius_max = get_f32(bytes + 204);
    e->first_block = stp_get_u32(bytes + 208);
    e->block_count = stp_get_u32(bytes + 212);
    e->blocks_hash = stp_get_u64(bytes + 216);
}

/* Each check returns NULL, or what is wrong. */
static const char *entry_check_payload(const stp_chunk_entry *e, const stp_header *header)
{
    if (e->block_count > e->patch_count ||
        !stp_range_inside(e->first_block, e->block_count, stp_header_block_count(header)))
        return "its blocks lie outside the file's table of blocks";
    if (e->codec < STP_CODEC_COUNT &&
        stp_codec_has_blocks((stp_codec)e->codec) != (e->block_count > 0))
        return "its codec has blocks and its block count is 0, or the reverse";
    if (e->offset < stp_header_span(header) ||
        !stp_range_inside(e->offset, e->segment_end[STP_SEGMENT_COUNT - 1],
                          stp_payloads_end(header)))
        return "its payload lies outside the file's payloads";
    for (int s = 1; s < STP_SEGMENT_COUNT; s++)
        if (e->segment_end[s] < e->segment_end[s - 1])
            return "its segments' ends decrease";
    if (e->patch_count == 0 || e->patch_count > STP_CHUNK_PATCHES_LIMIT ||
        e->sample_count[STP_LEVEL_COUNT - 1] != e->patch_count)
        return "its patch count is out of range or not the count of level 3";
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        if (e->sample_count[l] > STP_CHUNK_SAMPLES_LIMIT)
            return "a level has more samples than the limit";
    for (int l = 0; l + 1 < STP_LEVEL_COUNT; l++)
        if (e->sample_count[l] < e->sample_count[l + 1] ||
            e->sample_count[l] > 4u * e->sample_count[l + 1])
            return "a level's count is not 1 to 4 times the next coarser one's";
    return NULL;
}

static const char *entry_check_tree(const stp_chunk_entry *e, uint32_t id, const stp_header *header)
{
    if ((id == 0) != (e->parent == STP_CHUNK_NONE) || (id != 0 && e->parent >= id))
        return "its parent is not a chunk before it";
    if ((id == 0) != (e->depth == 0) || e->depth >= header->depth)
        return "its depth is out of range";
    if (e->child_count > STP_CHUNK_CHILDREN_LIMIT)
        return "it has more than 64 children";
    if (e->child_count == 0 && e->first_child != STP_CHUNK_NONE)
        return "it has a first child and no children";
    if (e->child_count != 0 &&
        (e->first_child <= id ||
         !stp_range_inside(e->first_child, e->child_count, header->chunk_count)))
        return "its children are not chunks after it";
    if (e->child_count != 0 && e->depth + 1u >= header->depth)
        return "it has children below the tree's depth";
    if (e->points_under == 0 || e->points_under > header->point_count ||
        (id == 0 && e->points_under != header->point_count) ||
        (e->child_count == 0 && e->points_under != e->sample_count[0]))
        return "its points_under contradicts its counts";
    return NULL;
}

static bool all_finite(const float *values, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(values[i]))
            return false;
    return true;
}

static bool all_bounds(const float *values, int count, double most)
{
    for (int i = 0; i < count; i++)
        if (!(values[i] >= 0.0f && (double)values[i] <= most))
            return false;
    return true;
}

static const char *entry_check_numbers(const stp_chunk_entry *e)
{
    if (!within(e->origin) || !within(stp_dvec3_from_float(e->box_min)) ||
        !within(stp_dvec3_from_float(e->box_max)) || !all_finite(e->cone_axis.raw, 3))
        return "its origin, box or cone is not finite, or reaches too far";
    for (int i = 0; i < 3; i++)
        if (e->box_min.raw[i] > e->box_max.raw[i])
            return "its box is empty";
    if (!all_bounds(&e->cone_angle, 1, (double)FLT_MAX))
        return "its cone's angle is negative or not finite";
    if (!all_bounds(e->error, STP_LEVEL_COUNT, STP_REACH_LIMIT) ||
        !all_bounds(e->tangential_error, STP_LEVEL_COUNT, STP_REACH_LIMIT) ||
        !all_bounds(e->colour_error, STP_LEVEL_COUNT, (double)FLT_MAX))
        return "an error is negative or not finite, or reaches too far";
    if (!all_bounds(&e->radius_min, 1, STP_REACH_LIMIT) ||
        !all_bounds(&e->radius_max, 1, STP_REACH_LIMIT) || e->radius_min > e->radius_max)
        return "its radius range is negative, reversed or not finite, or reaches too far";
    return NULL;
}

stp_status stp_entry_read(const uint8_t *bytes, uint32_t id, const stp_header *header,
                          stp_chunk_entry *out, stp_error *err)
{
    stp_chunk_entry entry;
    entry_parse(bytes, &entry);
    if (header->version_major < 2) {
        entry.first_block = entry.block_count = 0;
        entry.blocks_hash = 0;
    }
    const char *fault = entry_check_payload(&entry, header);
    if (!fault)
        fault = entry_check_tree(&entry, id, header);
    if (!fault)
        fault = entry_check_numbers(&entry);
    if (fault)
        return stp_error_set(err, STP_CORRUPT, "directory entry of chunk %" PRIu32 ": %s", id,
                             fault);
    *out = entry;
    return STP_OK;
}
