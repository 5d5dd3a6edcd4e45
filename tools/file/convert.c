/* `stipple convert`: rewrites a chunk file with another codec or another default threshold. */
#include "tools/cli/cli.h"

#include "base/file.h"
#include "formats/chunk/convert.h"
#include "tools/file/codec_options.h"
#include "tools/file/sandbox_options.h"
#include "tools/file/source_options.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

static int run(int argc, char **argv);

const cli_command cli_convert = {
    .name = "convert",
    .summary = "rewrite a chunk file with another codec, without loss",
    .usage = "stipple convert M.stipple -o N.stipple [options]",
    .details = "Every sample and everything that the file says about samples stays the same.\n"
               "zstd decodes several times as fast as draco and takes about a third more space;\n"
               "raw is for tests. Without --codec and --format the payloads are copied.\n"
               "--format 2 cuts chunks into blocks, so that views read less. --threshold is the\n"
               "threshold that drawing commands use if they are given none.",
    .run = run,
};

typedef struct convert_options {
    const char *path, *output;
    int codec, format;
    uint64_t block_samples;
    double threshold_px, timeout_s;
    bool has_codec, has_format, has_threshold, drop_attributes, force, no_sandbox;
    cli_common common;
} convert_options;

static stp_status convert(const convert_options *o, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    const char *const outputs[CLI_OUTPUT_LIMIT] = {o->output};
    const stp_byte_source_params source = source_options_params(NULL, 0, o->timeout_s);
    stp_convert_params params = {.keep_codec = !o->has_codec,
                                 .codec = codec_options_codec(o->codec),
                                 .format = o->has_format ? o->format + 1 : 0,
                                 .block_samples = (uint32_t)o->block_samples,
                                 .threshold_px = o->has_threshold ? o->threshold_px : 0.0,
                                 .drop_attributes = o->drop_attributes,
                                 .force = o->force,
                                 .progress = cli_progress(&o->common)};
    STP_TRY(sandbox_options_enter(o->no_sandbox, o->path, o->output, err));
    STP_TRY(cli_check_outputs(outputs, &o->path, 1, o->force, err));
    STP_TRY(source_options_open(&file, o->path, &source, err));
    STP_TRY(stp_pool_create(&pool, (unsigned)o->common.threads, err));
    params.pool = pool;
    uint64_t before = stp_chunk_file_get_info(file)->file_bytes;
    STP_TRY(stp_chunk_file_convert(file, o->output, &params, err));
    cli_progress_end();
    stp_chunk_file_close(&file);
    STP_TRY(stp_chunk_file_open(&file, o->output, err));
    uint64_t after = stp_chunk_file_get_info(file)->file_bytes;
    if (!o->common.quiet)
        printf("%s: %" PRIu64 " bytes, %.3f of what they were\n", o->output, after,
               (double)after / (double)before);
done:
    cli_progress_end();
    stp_pool_destroy(&pool);
    stp_chunk_file_close(&file);
    return status;
}

static int run(int argc, char **argv)
{
    convert_options o = {.timeout_s = SOURCE_TIMEOUT_S};
    size_t count = 0;
    stp_error err = {0};
    const cli_option options[] = {
        {"--output", 'o', CLI_STRING, &o.output, "N.stipple", "the chunk file to write", NULL},
        {"--codec", 0, CLI_CHOICE, &o.codec, CODEC_CHOICES,
         "codec of the payloads (the file's own)", &o.has_codec},
        {"--format", 0, CLI_CHOICE, &o.format, FORMAT_CHOICES,
         "version of the file; 2 is in blocks (the file's own)", &o.has_format},
        {"--block", 0, CLI_UINT, &o.block_samples, "SAMPLES",
         "least samples of a block (350; zstd 6800): small ones read less but take room", NULL},
        {"--threshold", 0, CLI_NUMBER, &o.threshold_px, "PX",
         "default threshold of drawing commands (the file's own)", &o.has_threshold},
        {"--drop-attributes", 0, CLI_FLAG, &o.drop_attributes, NULL,
         "leave out what prep --attributes kept", NULL},
        {"--force", 'f', CLI_FLAG, &o.force, NULL, "replace an existing file", NULL},
        source_options_timeout(&o.timeout_s),
        sandbox_options_off(&o.no_sandbox),
    };
    int code = cli_parse(&cli_convert, options, sizeof options / sizeof *options, argc, argv,
                         &o.path, 1, 1, &count, &o.common);
    if (code != CLI_CONTINUE)
        return code;
    if (!o.output)
        return cli_usage(&cli_convert, "no output given: add -o N.stipple");
    if (o.has_threshold && !(isfinite(o.threshold_px) && o.threshold_px > 0.0))
        return cli_usage(&cli_convert, "--threshold: give pixels above 0");
    if (o.block_samples > 0 && o.has_format && o.format == 0)
        return cli_usage(&cli_convert, "--block: files of format 1 have no blocks");
    if (o.block_samples > STP_CHUNK_SAMPLES_LIMIT)
        return cli_usage(&cli_convert, "--block: a chunk has at most 65536 samples");
    return convert(&o, &err) == STP_OK ? CLI_DONE : cli_fail(&cli_convert, &err);
}
