/* Fuzz target for the chunk file: any bytes, with checksums made right, through reader and verify.
 *
 * Needs no corpus: an empty input mutates into a small valid file (fuzz_chunk.h). TestOneInput
 * recomputes all checksums, or the code behind them would never be reached. */
#include "tests/fuzz/fuzz_chunk.h"
#include "formats/chunk/verify.h"

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
    uint8_t *copy = malloc(size + 1);
    fixture_require(copy != NULL);
    memcpy(copy, data, size);
    reseal(copy, size, true);
    int descriptor = fuzz_memory_file(copy, size, path);
    read_everything(path);
    free(copy);
    close(descriptor);
    return 0;
}
