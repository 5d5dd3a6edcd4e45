/* `stipple verify`: checks every checksum and invariant of a chunk file and names the first fault,
 * or repairs the file. */
#include "tools/cli/cli.h"

#include "base/file.h"
#include "base/pool.h"
#include "formats/chunk/repair/repair.h"
#include "formats/chunk/verify/verify.h"
#include "preprocess/tree/rebuild.h"
#include "tools/file/sandbox_options.h"
#include "tools/file/source_options.h"

#include <inttypes.h>
#include <stdio.h>

static int run(int argc, char **argv);

const cli_command cli_verify = {
    .name = "verify",
    .summary = "check every checksum and invariant of a chunk file, or repair it",
    .usage = "stipple verify M.stipple [options]",
    .details =
        "Decodes every chunk. If there is a fault, verify names the first one with its chunk, "
        "patch\n"
        "and byte, and exits with 1.\n"
        "--repair flips wrong bits back and rebuilds the header, the directory and inner chunks.\n"
        "It names what is lost. Coarser samples stand in for lost points; export leaves them out.\n"
        "It exits with 0 if the file was sound (then it writes nothing) or if nothing is lost, "
        "with\n"
        "1 if something is lost.\n"
        "--force without -o replaces the file itself, but only if nothing is lost.",
    .run = run,
};

typedef struct verify_options {
    const char *path;
    bool repair, no_sandbox;
    const char *output;
    bool force;
    double timeout_s;
    cli_common common;
} verify_options;

static stp_status verify(const verify_options *o, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_file *file = NULL;
    const stp_byte_source_params params = source_options_params(NULL, 0, o->timeout_s);
    STP_TRY(source_options_open(&file, o->path, &params, err));
    STP_TRY(stp_chunk_file_verify(file, pool, cli_progress(&o->common), err));
    cli_progress_end();
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    if (!o->common.quiet)
        printf("%s: sound: %" PRIu64 " points in %" PRIu32 " chunks\n", stp_chunk_file_path(file),
               info->point_count, info->chunk_count);
done:
    cli_progress_end();
    stp_chunk_file_close(&file);
    return status;
}

/* ---- repair ---- */

static void say(void *context, const char *line)
{
    const verify_options *o = context;
    cli_progress_end();
    if (!o->common.quiet)
        printf("%s: %s\n", o->path, line);
}

/* Reports the result. Losses are a failure, although the output exists. */
static stp_status sum_up(const verify_options *o, const stp_repair_result *result, stp_error *err)
{
    const char *output = o->output ? o->output : o->path;
    if (result->sound) {
        if (!o->common.quiet)
            printf("%s: sound: nothing to repair, nothing written\n", o->path);
    } else if (result->whole) {
        if (!o->common.quiet)
            printf("%s: repaired: nothing is lost\n", output);
    } else if (result->points_lost > 0) {
        return stp_error_set(err, STP_CORRUPT,
                             "%s is repaired, but %" PRIu64 " points are lost: %" PRIu64
                             " samples stand in for them, as its metadata says",
                             output, result->points_lost, result->stand_ins);
    } else {
        return stp_error_set(err, STP_CORRUPT, "%s is repaired with all points, but its %s lost",
                             output, result->attributes_lost ? "attributes are" : "metadata is");
    }
    return STP_OK;
}

static stp_status repair(verify_options *o, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    const char *const outputs[CLI_OUTPUT_LIMIT] = {o->output};
    stp_repair_result result = {0};
    const stp_repair_params params = {.output = o->output ? o->output : o->path,
                                      .force = o->force,
                                      .build_parent = stp_rebuild_parent,
                                      .pool = pool,
                                      .progress = cli_progress(&o->common),
                                      .say = say,
                                      .context = o};
    STP_TRY(cli_check_outputs(outputs, &o->path, 1, o->force, err));
    STP_TRY(stp_chunk_file_repair(o->path, &params, &result, err));
    cli_progress_end();
    STP_TRY(sum_up(o, &result, err));
done:
    cli_progress_end();
    return status;
}

static int run(int argc, char **argv)
{
    verify_options o = {.timeout_s = SOURCE_TIMEOUT_S};
    size_t count = 0;
    stp_pool *pool = NULL;
    stp_error err = {0};
    const cli_option options[] = {
        source_options_timeout(&o.timeout_s),
        sandbox_options_off(&o.no_sandbox),
        {.name = "--repair",
         .kind = CLI_FLAG,
         .target = &o.repair,
         .help = "write a repaired file, with everything that can be saved"},
        {.name = "--output",
         .letter = 'o',
         .kind = CLI_STRING,
         .target = &o.output,
         .argument = "OUT.stipple",
         .help = "the repaired file"},
        {.name = "--force",
         .letter = 'f',
         .kind = CLI_FLAG,
         .target = &o.force,
         .help = "replace an existing file"},
    };
    int code = cli_parse(&cli_verify, options, sizeof options / sizeof *options, argc, argv,
                         &o.path, 1, 1, &count, &o.common);
    if (code != CLI_CONTINUE)
        return code;
    if (o.repair && !o.output && !o.force)
        return cli_usage(&cli_verify,
                         "no output given: add -o OUT.stipple, or --force to replace %s", o.path);
    if (!o.repair && (o.output || o.force))
        return cli_usage(&cli_verify, "nothing is written without --repair");
    if (o.repair && stp_is_address(o.path))
        return cli_usage(&cli_verify, "--repair reads local files only: copy the file here");
    const char *output = !o.repair ? NULL : o.output ? o.output : o.path;
    stp_status status = sandbox_options_enter(o.no_sandbox, o.path, output, &err);
    if (status == STP_OK)
        status = stp_pool_create(&pool, (unsigned)o.common.threads, &err);
    if (status == STP_OK)
        status = o.repair ? repair(&o, pool, &err) : verify(&o, pool, &err);
    stp_pool_destroy(&pool);
    return status == STP_OK ? CLI_DONE : cli_fail(&cli_verify, &err);
}
