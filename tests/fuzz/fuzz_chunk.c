/* Fuzz target for the chunk file: any bytes, with checksums made right, through reader and verify.
 *
 * Needs no corpus: an empty input mutates into a small valid file (fuzz_chunk.h). TestOneInput
 * recomputes all checksums, or the code behind them would never be reached. What verify calls sound
 * must go through export, convert and repair, and be sound after it. */
#include "tests/fuzz/fuzz_chunk.h"
#include "formats/chunk/convert.h"
#include "formats/chunk/repair/repair.h"
#include "formats/chunk/verify/verify.h"
#include "tools/file/export_file.h"

static void require_sound(const char *path, stp_pool *pool)
{
    stp_chunk_file *file = NULL;
    fixture_require(stp_chunk_file_open(&file, path, NULL) == STP_OK);
    fixture_require(stp_chunk_file_verify(file, pool, NULL, NULL) == STP_OK);
    stp_chunk_file_close(&file);
}

static void go_through(const char *path, stp_chunk_file *file, stp_pool *pool)
{
    const char *output = fixture_path("out.stipple"), *ply = fixture_path("out.ply");
    const bool newer = stp_chunk_file_get_info(file)->version_minor > STP_CHUNK_FILE_MINOR;
    const export_params export = {.output = ply};
    uint64_t left_out = 0;
    stp_repair_result result = {0};
    const stp_repair_params repair = {.output = output, .pool = pool};
    stp_status status = export_file(file, &export, &left_out, NULL);
    fixture_require(status == STP_OK || status == STP_EMPTY);
    unlink(ply);
    for (int codec = 0; codec <= STP_CODEC_ZSTD; codec++) {
        const stp_convert_params params = {.codec = (stp_codec)codec, .pool = pool};
        status = stp_chunk_file_convert(file, output, &params, NULL);
        fixture_require(status == (newer ? STP_UNSUPPORTED : STP_OK));
        if (!newer)
            require_sound(output, pool);
        unlink(output);
    }
    fixture_require(stp_chunk_file_repair(path, &repair, &result, NULL) == STP_OK && result.sound);
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
    const export_params export = {.output = fixture_path("out.ply")};
    uint64_t left_out = 0;
    (void)export_file(file, &export, &left_out, NULL);
    unlink(export.output);
    fixture_require(stp_pool_create(&pool, 1, NULL) == STP_OK);
    if (stp_chunk_file_verify(file, pool, NULL, NULL) == STP_OK)
        go_through(path, file, pool);
    stp_pool_destroy(&pool);
    stp_chunk_file_close(&file);
    fixture_remove_folder(NULL);
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
