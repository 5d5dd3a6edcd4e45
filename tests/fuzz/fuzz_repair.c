/* Fuzz target for the repair of chunk files: corrects the checksums of any bytes, damages the file
 * in up to four places, and runs stp_chunk_file_repair.
 *
 * Needs no corpus: an empty input mutates into a small valid file (fuzz_chunk.h). A repaired file
 * must be sound. If repair refuses, it must leave no file. */
#include "formats/chunk/repair/repair.h"
#include "formats/chunk/verify/verify.h"
#include "preprocess/tree/rebuild.h"
#include "tests/fuzz/fuzz_chunk.h"

/* Wipes some bytes of [begin, begin + length), or flips one bit there. */
static void damage_range(uint8_t *data, size_t size, uint64_t begin, uint64_t length, uint64_t r)
{
    if (length == 0 || !stp_range_inside(begin, length, size))
        return;
    uint64_t at = begin + (r >> 8) % length, end = begin + length;
    if (r & 1u) {
        data[at] ^= (uint8_t)(1u << (r >> 1) % 8);
        return;
    }
    for (uint64_t i = at; i < end && i < at + (r >> 4) % 300; i++)
        data[i] = r & 2u ? (uint8_t)(data[i] ^ 0x5au) : 0;
}

static void damage(uint8_t *data, size_t *size, uint64_t r)
{
    const uint64_t directory = stp_get_u64(data + 32), metadata = stp_get_u64(data + 40);
    const uint32_t count = stp_get_u32(data + 16);
    const uint64_t chunk = count ? (r >> 16) % count % STP_PAGE_ENTRIES : 0;
    const uint64_t entry = directory + chunk * STP_ENTRY_BYTES;
    const bool known = stp_range_inside(directory, (chunk + 1) * STP_ENTRY_BYTES, *size);
    const bool blocks = stp_get_u16(data + 8) == 2;
    const uint64_t table = stp_get_u64(data + RESEAL_SECTIONS_AT + 8);
    const uint64_t header = blocks ? 2 * STP_HEADER_BYTES_2 : STP_HEADER_BYTES;
    switch (r >> 56 & 7) {
    case 0:
        damage_range(data, *size, 0, header, r);
        return;
    case 1:
    case 2:
        if (blocks && r >> 55 & 1)
            damage_range(data, *size, table, metadata - table, r);
        else
            damage_range(data, *size, entry, known ? STP_ENTRY_BYTES : 0, r);
        return;
    case 3:
        damage_range(data, *size, metadata, directory - metadata, r);
        return;
    case 4:
        *size -= (r >> 8) % (r & 1u ? 300 : 3000) % *size;
        return;
    default:
        if (known)
            damage_range(data, *size, stp_get_u64(data + entry), stp_get_u32(data + entry + 16), r);
    }
}

static void repair(const char *path)
{
    const char *output = fixture_path("repaired.stipple");
    stp_repair_result result = {0};
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    fixture_require(stp_pool_create(&pool, 1, NULL) == STP_OK);
    const stp_repair_params params = {
        .output = output, .build_parent = stp_rebuild_parent, .pool = pool};
    stp_status status = stp_chunk_file_repair(path, &params, &result, NULL);
    bool written = status == STP_OK && !result.sound;
    fixture_require((access(output, F_OK) == 0) == written);
    if (written) {
        fixture_require(stp_chunk_file_open(&file, output, NULL) == STP_OK);
        fixture_require(stp_chunk_file_verify(file, pool, NULL, NULL) == STP_OK);
        stp_chunk_file_close(&file);
        unlink(output);
    }
    stp_pool_destroy(&pool);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[64];
    uint8_t *copy = malloc(size + 1);
    uint64_t seed = stp_hash(data, size);
    fixture_require(copy != NULL);
    memcpy(copy, data, size);
    reseal(copy, size, true);
    for (uint64_t i = 0; i < 1 + seed % 4 && size >= STP_HEADER_BYTES; i++)
        damage(copy, &size, stp_random_u64(seed, i));
    int descriptor = fuzz_memory_file(copy, size, path);
    repair(path);
    free(copy);
    close(descriptor);
    return 0;
}
