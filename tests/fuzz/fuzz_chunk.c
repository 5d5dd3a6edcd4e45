/* Fuzz target for the chunk file: corrects the checksums of any bytes, then runs everything that
 * reads a chunk file.
 *
 * Needs no corpus: an empty input mutates into a small valid file (fuzz_chunk.h). TestOneInput
 * recomputes all checksums; otherwise the code behind them would never be reached. If verify calls
 * the file sound, info, a picture, export, convert and repair must succeed and give sound files. If
 * the file is not sound but opens, info, export and a picture run on it. */
#include "tests/fuzz/fuzz_chunk.h"
#include "formats/chunk/block/block.h"
#include "formats/chunk/convert.h"
#include "formats/chunk/repair/repair.h"
#include "formats/chunk/verify/verify.h"
#include "tests/fuzz/cpu_picture.h"
#include "tools/cli/cli.h"
#include "tools/file/export_file.h"

#include <cjson/cJSON.h>

extern const cli_command cli_info;

static void require_sound(const char *path, stp_pool *pool)
{
    stp_chunk_file *file = NULL;
    fixture_require(stp_chunk_file_open(&file, path, NULL) == STP_OK);
    fixture_require(stp_chunk_file_verify(file, pool, NULL, NULL) == STP_OK);
    stp_chunk_file_close(&file);
}

static void go_through(const char *path, stp_chunk_file *file, uint64_t choice, stp_pool *pool)
{
    const char *output = fixture_path("out.stipple");
    const bool newer = stp_chunk_file_is_newer(stp_chunk_file_get_info(file)->version_major,
                                               stp_chunk_file_get_info(file)->version_minor);
    stp_repair_result result = {0};
    const stp_repair_params repair = {.output = output, .pool = pool};
    for (int codec = 0; codec <= STP_CODEC_ZSTD; codec++) {
        const stp_convert_params params = {.codec = (stp_codec)codec,
                                           .format = 1 + (int)((choice + (uint64_t)codec) % 2),
                                           .drop_attributes = true,
                                           .pool = pool};
        stp_status status = stp_chunk_file_convert(file, output, &params, NULL);
        fixture_require(status == (newer ? STP_UNSUPPORTED : STP_OK));
        if (!newer)
            require_sound(output, pool);
        unlink(output);
    }
    fixture_require(stp_chunk_file_repair(path, &repair, &result, NULL) == STP_OK && result.sound);
}

static void read_chunks(stp_chunk_file *file)
{
    const uint32_t count = stp_chunk_file_get_info(file)->chunk_count;
    for (uint32_t id = 0; id < count; id++) {
        for (int level = 2; level >= 0; level -= 2) {
            stp_chunk *chunk = NULL;
            (void)stp_chunk_file_read(file, id, level, &chunk, NULL);
            stp_chunk_destroy(&chunk);
        }
    }
}

static void read_block(stp_chunk_file *file, const stp_block *block, bool sound)
{
    uint8_t *payload = malloc((size_t)stp_block_payload_bytes(block, 0) + 1);
    fixture_require(payload != NULL);
    for (int level = 2; level >= 0; level--) {
        stp_chunk *chunk = NULL;
        stp_status status =
            stp_block_fetch(file, block, 0, stp_block_payload_bytes(block, level), payload, NULL);
        if (status == STP_OK)
            status = stp_block_decode(file, block, level, payload, NULL, &chunk, NULL);
        fixture_require(status == STP_OK || !sound);
        stp_chunk_destroy(&chunk);
    }
    free(payload);
}

static void read_blocks(stp_chunk_file *file, bool sound)
{
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        uint32_t count = 0;
        if (stp_chunk_file_block_count(file, id, &count, NULL) != STP_OK)
            continue;
        stp_block *blocks = calloc(count, sizeof *blocks);
        fixture_require(count > 0 && blocks != NULL);
        const stp_status status = stp_chunk_file_blocks(file, id, blocks, NULL);
        fixture_require(status == STP_OK || !sound);
        for (uint32_t b = 0; status == STP_OK && b < count; b++)
            read_block(file, &blocks[b], sound);
        free(blocks);
    }
}

static void export_ply(stp_chunk_file *file, bool sound)
{
    const export_params export = {.output = fixture_path("out.ply")};
    uint64_t left_out = 0;
    const stp_status status = export_file(file, &export, &left_out, NULL);
    fixture_require(status == STP_OK || status == STP_EMPTY || !sound);
    unlink(export.output);
}

/* ---- info ---- */

static void remove_folder(void)
{
    (void)fixture_remove_folder(NULL);
}

/* Makes the folder of outputs, and turns stdout into a file in memory: info prints there. */
static void begin(void)
{
    static bool begun;
    if (begun)
        return;
    const int descriptor = memfd_create("stdout", MFD_CLOEXEC);
    fixture_require(descriptor >= 0 && dup2(descriptor, STDOUT_FILENO) == STDOUT_FILENO);
    (void)fixture_path("out.ply");
    fixture_require(atexit(remove_folder) == 0);
    begun = true;
}

/* Returns what was printed; free it with free(). */
static char *take_stdout(size_t *size)
{
    fixture_require(fflush(stdout) == 0);
    const off_t end = lseek(STDOUT_FILENO, 0, SEEK_CUR);
    char *text = malloc((size_t)end + 1);
    fixture_require(end >= 0 && text != NULL);
    fixture_require(pread(STDOUT_FILENO, text, (size_t)end, 0) == end);
    fixture_require(ftruncate(STDOUT_FILENO, 0) == 0 && lseek(STDOUT_FILENO, 0, SEEK_SET) == 0);
    *size = (size_t)end;
    return text;
}

/* If the directory can be read, info must say what the file holds. */
static void run_info(const char *path, stp_chunk_file *file)
{
    char *arguments[] = {"info", "--no-sandbox", (char *)(uintptr_t)path, "--json", NULL};
    const uint32_t count = stp_chunk_file_get_info(file)->chunk_count;
    size_t size = 0;
    for (uint32_t id = 0; id < count; id++) {
        stp_chunk_entry entry;
        if (stp_chunk_file_entry(file, id, &entry, NULL) != STP_OK)
            return;
    }
    fixture_require(cli_info.run(3, arguments) == CLI_DONE);
    char *text = take_stdout(&size);
    fixture_require(size > 0 && memchr(text, '\x1b', size) == NULL);
    free(text);
    fixture_require(cli_info.run(4, arguments) == CLI_DONE);
    text = take_stdout(&size);
    cJSON *json = cJSON_ParseWithLength(text, size);
    fixture_require(cJSON_IsObject(json));
    cJSON_Delete(json);
    free(text);
}

/* ---- everything ---- */

static void read_everything(const char *path, uint64_t choice)
{
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    if (stp_chunk_file_open(&file, path, NULL) != STP_OK)
        return;
    fixture_require(stp_pool_create(&pool, 1, NULL) == STP_OK);
    read_chunks(file);
    const bool sound = stp_chunk_file_verify(file, pool, NULL, NULL) == STP_OK;
    read_blocks(file, sound);
    run_info(path, file);
    cpu_picture_draw(path, choice, sound, pool);
    export_ply(file, sound);
    if (sound)
        go_through(path, file, choice, pool);
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
    begin();
    int descriptor = fuzz_memory_file(copy, size, path);
    read_everything(path, stp_hash(data, size));
    free(copy);
    close(descriptor);
    return 0;
}
