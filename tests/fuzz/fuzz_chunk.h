/* Helpers for the fuzz targets of the chunk file: a small valid file, and its mutations.
 *
 * Mutations prefer to change header, directory and payloads in place, so that the file's frame
 * stays. */
#ifndef STP_TESTS_FUZZ_FUZZ_CHUNK_H
#define STP_TESTS_FUZZ_FUZZ_CHUNK_H

#include "tests/fixtures/chunk_fixture.h"
#include "tests/fixtures/chunk_reseal.h"
#include "tests/fuzz/fuzz_memory.h"
#include "tests/fuzz/fuzz_target.h"

/* Of every four patches, makes two strips and one triangles. Kinds and flags are right; the stated
 * errors need not be. */
static inline void make_shapes(stp_chunk *chunk)
{
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        stp_patch *patch = &chunk->patches[p];
        bool strip = p % 4 < 2, triangles = p % 4 == 2 && patch->counts[0] % 3 == 0;
        unsigned kind = triangles ? STP_KIND_POLYGON : p % 2 ? STP_KIND_TUBE : STP_KIND_RIBBON;
        if (!strip && !triangles)
            continue;
        patch->flags |= strip ? STP_PATCH_STRIP | STP_PATCH_TWO_SIDED : STP_PATCH_TRIANGLES;
        if (strip && patch->counts[0] > 1 && p > 0)
            patch->flags |= STP_PATCH_CONTINUES;
        for (int l = 0; l < STP_LEVEL_COUNT; l++) {
            patch->tangential_error[l] = strip ? 0 : patch->tangential_error[l];
            for (unsigned i = 0; i < patch->counts[l]; i++) {
                stp_sample *sample = &chunk->samples[l][chunk->level_begin[l][p] + i];
                sample->flags |= (uint8_t)(kind << STP_SAMPLE_KIND_SHIFT);
                sample->flags &= (uint8_t) ~(strip ? STP_SAMPLE_ORIENTED : 0);
            }
        }
        if (strip)
            memset(patch->quarter_tangential_error, 0, sizeof patch->quarter_tangential_error);
    }
}

/* Makes all samples closed, except those of strips, which nothing can close. */
static inline void make_closed(stp_chunk *chunk)
{
    const unsigned flags = STP_SAMPLE_CLOSED | STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        stp_patch *patch = &chunk->patches[p];
        if (patch->flags & STP_PATCH_STRIP)
            continue;
        patch->flags =
            (uint8_t)((patch->flags & ~(unsigned)STP_PATCH_TWO_SIDED) | STP_PATCH_CLOSED);
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            for (unsigned i = 0; i < patch->counts[l]; i++)
                chunk->samples[l][chunk->level_begin[l][p] + i].flags |= (uint8_t)flags;
    }
}

/* Texts that replace the metadata; they have what info, verify and the renderer look for. */
static const char *const metadata_texts[] = {
    "{\"closed\":{\"points\":9,\"origin\":[-300,-300,50],\"cell\":500,\"cells\":[1,2,2],"
    "\"outside\":[1,2,1],\"openings\":[[0,0,100,50],[1,2,3,1e9]]}}",
    "{\"first_view\":{\"eye\":[0,-900,90],\"look\":[0,0,80],\"up\":[0,0,1],\"fovy_deg\":70,"
    "\"aspect\":1.5,\"why\":\"interior\"},\"up\":[0,1,0]}",
    "{\"threshold_px\":1.25,\"shade\":\"unlit\",\"outliers\":{\"marked\":3,\"distance\":6}}",
    "{\"repaired\":[{\"points_lost\":7,\"stand_ins\":0,\"lost\":[{\"chunk\":1}]}]}",
    "{\"lines\":{\"strips\":2,\"vertices\":9,\"segments\":7,\"samples\":9},\"triangles\":4,"
    "\"joined\":{\"greatest\":1,\"mean\":0.5},\"displacement\":{\"greatest\":1e-3,"
    "\"mean\":1e-4,\"beyond\":2}}",
};

/* Replaces the metadata by one of the texts and moves the directory, which follows. */
static inline size_t replace_metadata(uint8_t *data, size_t size, size_t capacity, unsigned which)
{
    const uint64_t metadata = stp_get_u64(data + 40), directory = stp_get_u64(data + 32);
    const char *text = metadata_texts[which % (sizeof metadata_texts / sizeof *metadata_texts)];
    const size_t length = strlen(text);
    if (metadata < STP_HEADER_BYTES || metadata > directory || directory > size ||
        metadata + length + (size - directory) > capacity)
        return size;
    const bool copies = stp_get_u16(data + 8) == 2 && metadata >= 2 * STP_HEADER_BYTES_2;
    memmove(data + metadata + length, data + directory, size - directory);
    memcpy(data + metadata, text, length);
    stp_put_u64(data + 32, metadata + length);
    stp_put_u64(data + 48, length);
    if (copies)
        memcpy(data + STP_HEADER_BYTES_2, data, STP_HEADER_BYTES_2);
    return metadata + length + (size - directory);
}

static inline size_t valid_file(uint8_t *data, size_t capacity, unsigned seed)
{
    fixture_tree tree;
    size_t size = 0;
    const char *path = fixture_path("fuzz.stipple");
    if (seed & 1u)
        fixture_tree_of_seven(&tree, 2 + seed / 2 % 8 * (1 + (seed >> 19 & 3u)),
                              1 + seed / 16 % 64);
    else
        fixture_single(&tree, 1 + seed / 2 % 20, 1 + seed / 16 % 64);
    if (!(seed & 1u) && seed & 2048u) {
        make_shapes(tree.chunks[0]);
        tree.attributes_more = STP_HAS_LINES | STP_HAS_TRIANGLES;
    }
    if (!(seed & 1u) && seed & 8192u) {
        make_closed(tree.chunks[0]);
        tree.attributes_more |= STP_HAS_CLOSED;
    }
    static const stp_codec codecs[] = {
        STP_CODEC_DRACO,      STP_CODEC_RAW,          STP_CODEC_ZSTD, STP_CODEC_ZSTD_BLOCKS,
        STP_CODEC_RAW_BLOCKS, STP_CODEC_DRACO_BLOCKS, STP_CODEC_PAPER};
    const unsigned codec = (seed >> 10 & 1u) | (seed >> 12 & 1u) << 1 | (seed >> 18 & 1u) << 2;
    fixture_require(fixture_write(&tree, path, codecs[codec % 7], NULL) == STP_OK);
    uint8_t *bytes = fixture_read_file(path, &size);
    fixture_remove_folder(NULL);
    fixture_destroy(&tree);
    size = size < capacity ? size : capacity;
    memcpy(data, bytes, size);
    free(bytes);
    return seed & 16384u ? replace_metadata(data, size, capacity, seed >> 15) : size;
}

/* Mutates [begin, begin + length) without moving what follows. */
static inline void mutate_in_place(uint8_t *data, size_t size, uint64_t begin, uint64_t length)
{
    if (length == 0 || !stp_range_inside(begin, length, size))
        return;
    uint8_t *copy = malloc(length);
    fixture_require(copy != NULL);
    memcpy(copy, data + begin, length);
    size_t mutated = LLVMFuzzerMutate(copy, length, length);
    memcpy(data + begin, copy, mutated);
    free(copy);
}

/* Mutates the header, half of the time both copies of version 2 alike. */
static inline void mutate_header(uint8_t *data, size_t size, unsigned seed)
{
    const bool copies = stp_get_u16(data + 8) == 2 && size >= 2 * STP_HEADER_BYTES_2;
    if (copies && seed & 1u)
        mutate_in_place(data, size, seed & 2u ? 152 : STP_HEADER_BYTES_2, 168);
    else
        mutate_in_place(data, size, 8, STP_HEADER_BYTES - 8);
    if (copies && !(seed & 4u))
        memcpy(data + STP_HEADER_BYTES_2, data, STP_HEADER_BYTES_2);
}

/* Mutates a record of the table of blocks, or the index of a chunk's segment 0, whose rows have
 * five bytes or more. */
static inline void mutate_blocks(uint8_t *data, size_t size, uint64_t entry, unsigned seed)
{
    const uint8_t *section = data + RESEAL_SECTIONS_AT;
    const uint32_t count = stp_get_u32(data + entry + 212);
    if (stp_get_u16(data + 8) != 2 || count == 0 || stp_get_u64(section + 8) > size)
        return;
    if (seed & 1u)
        mutate_in_place(data, size, stp_get_u64(data + entry), 4 + 5 * (uint64_t)count);
    else
        mutate_in_place(data, size,
                        stp_get_u64(section + 8) +
                            ((uint64_t)stp_get_u32(data + entry + 208) + seed / 2 % count) *
                                STP_BLOCK_BYTES,
                        STP_BLOCK_BYTES);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    if (size < 2 * STP_HEADER_BYTES)
        return valid_file(data, capacity, seed);
    uint64_t directory = stp_get_u64(data + 32);
    uint64_t metadata = stp_get_u64(data + 40);
    uint32_t chunk = stp_get_u32(data + 16);
    chunk = chunk ? seed / 8 % chunk % STP_PAGE_ENTRIES : 0;
    uint64_t entry = directory + (uint64_t)chunk * STP_ENTRY_BYTES;
    bool known = stp_range_inside(directory, (uint64_t)(chunk + 1) * STP_ENTRY_BYTES, size);
    switch (seed % 8) {
    case 0:
        return LLVMFuzzerMutate(data, size, capacity);
    case 1:
        mutate_header(data, size, seed / 8);
        return size;
    case 2:
        mutate_in_place(data, size, entry, known ? STP_ENTRY_BYTES : 0);
        return size;
    case 3:
        if (seed / 8 % 4 == 0)
            return replace_metadata(data, size, capacity, seed / 32);
        mutate_in_place(data, size, metadata, directory - metadata);
        return size;
    case 4:
        if (known)
            mutate_blocks(data, size, entry, seed / 512);
        return size;
    default:
        if (known)
            mutate_in_place(data, size, stp_get_u64(data + entry), stp_get_u32(data + entry + 16));
        return size;
    }
}

#endif
