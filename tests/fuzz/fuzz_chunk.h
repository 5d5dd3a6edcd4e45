/* What the fuzz targets of the chunk file share: a small valid file, and its mutations.
 *
 * Mutations prefer header, directory and payloads in place, so that the file's frame stays. */
#ifndef STP_TESTS_FUZZ_CHUNK_H
#define STP_TESTS_FUZZ_CHUNK_H

#include "tests/chunk_fixture.h"
#include "tests/chunk_reseal.h"
#include "tests/fuzz/fuzz_memory.h"

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t capacity);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static inline size_t valid_file(uint8_t *data, size_t capacity, unsigned seed)
{
    fixture_tree tree;
    size_t size = 0;
    const char *path = fixture_path("fuzz.stipple");
    if (seed & 1u)
        fixture_tree_of_seven(&tree, 2 + seed / 2 % 8, 1 + seed / 16 % 64);
    else
        fixture_single(&tree, 1 + seed / 2 % 20, 1 + seed / 16 % 64);
    fixture_require(
        fixture_write(&tree, path, seed & 1024u ? STP_CODEC_RAW : STP_CODEC_DRACO, NULL) == STP_OK);
    uint8_t *bytes = fixture_read_file(path, &size);
    fixture_remove_folder(NULL);
    fixture_destroy(&tree);
    size = size < capacity ? size : capacity;
    memcpy(data, bytes, size);
    free(bytes);
    return size;
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
        mutate_in_place(data, size, 8, STP_HEADER_BYTES - 8);
        return size;
    case 2:
        mutate_in_place(data, size, entry, known ? STP_ENTRY_BYTES : 0);
        return size;
    case 3:
        mutate_in_place(data, size, metadata, directory - metadata);
        return size;
    default:
        if (known)
            mutate_in_place(data, size, stp_get_u64(data + entry), stp_get_u32(data + entry + 16));
        return size;
    }
}

#endif
