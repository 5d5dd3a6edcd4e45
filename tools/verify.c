/* `stipple verify`: every checksum and invariant of a chunk file; the first fault is named. */
#include "tools/cli.h"

#include "base/pool.h"
#include "formats/chunk/verify.h"

#include <inttypes.h>
#include <stdio.h>

static int run(int argc, char **argv);

const cli_command cli_verify = {
    .name = "verify",
    .summary = "check every checksum and invariant of a chunk file",
    .usage = "stipple verify M.stipple",
    .details =
        "Decodes every chunk. Names the first fault with its chunk, patch and byte, and exits 1.",
    .run = run,
};

static stp_status verify(const char *path, const cli_common *common, stp_chunk_file **file,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_pool *pool = NULL;
    STP_TRY(stp_chunk_file_open(file, path, err));
    STP_TRY(stp_pool_create(&pool, (unsigned)common->threads, err));
    STP_TRY(stp_chunk_file_verify(*file, pool, cli_progress(common), err));
done:
    stp_pool_destroy(&pool);
    cli_progress_end();
    return status;
}

static int run(int argc, char **argv)
{
    const char *path = NULL;
    size_t count = 0;
    cli_common common = {0};
    stp_chunk_file *file = NULL;
    stp_error err = {0};
    int code = cli_parse(&cli_verify, NULL, 0, argc, argv, &path, 1, 1, &count, &common);
    if (code != CLI_CONTINUE)
        return code;
    if (verify(path, &common, &file, &err) != STP_OK) {
        stp_chunk_file_close(&file);
        return cli_fail(&cli_verify, &err);
    }
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    if (!common.quiet)
        printf("%s: sound: %" PRIu64 " points in %" PRIu32 " chunks\n", path, info->point_count,
               info->chunk_count);
    stp_chunk_file_close(&file);
    return CLI_DONE;
}
