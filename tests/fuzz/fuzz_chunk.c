/* Fuzz target for the chunk file: any bytes, with checksums made right, through reader and verify.
 *
 * Needs no corpus: an empty input mutates into a small valid file. Mutations prefer header,
 * directory and payloads in place, so that the file's frame stays; TestOneInput then recomputes all
 * checksums, or the code behind them would never be reached. */
#include "formats/chunk/verify.h"
#include "tests/chunk_fixture.h"
#include "tests/chunk_reseal.h"

#include <sys/mman.h>

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t capacity);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static size_t valid_file(uint8_t *data, size_t capacity, unsigned seed)
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
static void mutate_in_place(uint8_t *data, size_t size, uint64_t begin, uint64_t length)
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

static void read_everything(const char *path)
{
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    if (stp_chunk_file_open(&file, path, NULL) != STP_OK)
        return;
    uint32_t count = stp_chunk_file_get_info(file)->chunk_count;
    for (uint32_t id = 0; id < count; id++) {
        for (int level = 2; level >= 0; level -= 2) {
            stp_chunk *chunk = NULL;
            (void)stp_chunk_file_read(file, id, level, &chunk, NULL);
            stp_chunk_destroy(&chunk);
        }
    }
    if (stp_pool_create(&pool, 1, NULL) == STP_OK)
        (void)stp_chunk_file_verify(file, pool, NULL, NULL);
    stp_pool_destroy(&pool);
    stp_chunk_file_close(&file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[64];
    int descriptor = memfd_create("fuzz", MFD_CLOEXEC);
    uint8_t *copy = malloc(size + 1);
    fixture_require(descriptor >= 0 && copy != NULL);
    memcpy(copy, data, size);
    reseal(copy, size, true);
    fixture_require(write(descriptor, copy, size) == (ssize_t)size);
    snprintf(path, sizeof path, "/proc/self/fd/%d", descriptor);
    read_everything(path);
    free(copy);
    close(descriptor);
    return 0;
}
