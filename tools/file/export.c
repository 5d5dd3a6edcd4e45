/* `stipple export`: writes the level-0 samples of the leaf chunks as PLY, with edges and faces, or
 * as LAS or LAZ. */
#include "tools/cli/cli.h"

#include "base/file.h"
#include "tools/file/export_file.h"
#include "tools/file/sandbox_options.h"
#include "tools/file/source_options.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>

static int run(int argc, char **argv);

const cli_command cli_export = {
    .name = "export",
    .summary = "write the points and lines of a chunk file as PLY, LAS or LAZ",
    .usage = "stipple export M.stipple -o F.ply [options]",
    .details =
        "Writes level 0 of the leaf chunks: every point of the input once, as quantised.\n"
        "If floats cannot hold the coordinates, they are doubles. Unknown normals are 0 0 0.\n"
        "If prep marked outliers, the property outlier is 1 for them and 0 for other points.\n"
        "If prep made elevation maps (--maps), their samples are written: resampled points.\n"
        "Ribbons and tubes become edges between their vertices. Their property radius is half the\n"
        "width. Normals of tubes are 0 0 0. Triangles become faces.\n"
        "Attributes that prep kept are properties by their names.\n"
        "A name that ends in .las gets LAS 1.4: points without normals, with every attribute that\n"
        "prep kept, on the lattice and in the coordinate system of the first scan. A name that "
        "ends\n"
        "in .laz gets the same, packed without loss (LAZ).\n"
        "--where takes fields, numbers, == != < <= > >=, !, &&, || and brackets. Fields are x, y, "
        "z,\n"
        "intensity, class, outlier, red, green and blue (0 to 255), and the kept attributes, "
        "whose\n"
        "numbers go before those. A part of a name will do: --where 'return==1 && class!=7'.\n"
        "--level 1 or 2 writes fewer points: the samples that stand for them when seen from "
        "far.\n"
        "A repaired file has samples that stand in for lost points: export leaves them out and\n"
        "prints how many.",
    .run = run,
};

/* Says so if the file's points are samples of maps. */
static void note_resampled(const stp_chunk_file *file)
{
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *resampled = cJSON_GetObjectItemCaseSensitive(metadata, "resampled");
    const cJSON *samples = cJSON_GetObjectItemCaseSensitive(resampled, "samples");
    const cJSON *greatest = cJSON_GetObjectItemCaseSensitive(resampled, "greatest");
    if (cJSON_IsNumber(samples) && cJSON_IsNumber(greatest) && samples->valuedouble > 0.0)
        fprintf(stderr,
                "%s holds resampled points: %.0f samples of elevation maps, whose surface is at "
                "most %.3g from the points that were read\n",
                stp_chunk_file_path(file), samples->valuedouble, greatest->valuedouble);
    cJSON_Delete(metadata);
}

static stp_status export_path(const char *path, const export_params *params, double timeout_s,
                              const cli_common *common, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_file *file = NULL;
    uint64_t left_out = 0;
    const stp_byte_source_params source = source_options_params(NULL, 0, timeout_s);
    STP_TRY(stp_output_check_input(params->output, path, err));
    STP_TRY(source_options_open(&file, path, &source, err));
    if (!common->quiet)
        note_resampled(file);
    STP_TRY(export_file(file, params, &left_out, err));
    cli_progress_end();
    if (left_out > 0 && !common->quiet)
        fprintf(stderr,
                "%s was repaired: %" PRIu64 " samples that stand in for lost points are "
                "left out\n",
                stp_chunk_file_path(file), left_out);
done:
    cli_progress_end();
    stp_chunk_file_close(&file);
    return status;
}

static int run(int argc, char **argv)
{
    const char *path = NULL;
    const char *output = NULL;
    bool force = false, no_sandbox = false;
    export_choice choice = {0};
    double timeout_s = SOURCE_TIMEOUT_S;
    size_t count = 0;
    cli_common common = {0};
    stp_error err = {0};
    const cli_option options[] = {
        source_options_timeout(&timeout_s),
        sandbox_options_off(&no_sandbox),
        {.name = "--output",
         .letter = 'o',
         .kind = CLI_STRING,
         .target = &output,
         .argument = "FILE",
         .help = "the file to write; its ending says which format"},
        {.name = "--force",
         .letter = 'f',
         .kind = CLI_FLAG,
         .target = &force,
         .help = "replace an existing file"},
        {"--where", 0, CLI_STRING, &choice.where, "CONDITION", "only points that fulfil it", NULL},
        {"--clip", 0, CLI_STRING, &choice.clip, "x0,y0,z0,x1,y1,z1", "only points in this box",
         NULL},
        {"--level", 0, CLI_CHOICE, &choice.level, "0|1|2", "how coarse (0: every point)", NULL},
    };
    int code = cli_parse(&cli_export, options, sizeof options / sizeof *options, argc, argv, &path,
                         1, 1, &count, &common);
    if (code != CLI_CONTINUE)
        return code;
    if (!output)
        return cli_usage(&cli_export, "no output given: add -o F.ply, -o F.las or -o F.laz");
    const export_params params = {output, force, choice, cli_progress(&common)};
    if (sandbox_options_enter(no_sandbox, path, output, &err) != STP_OK ||
        export_path(path, &params, timeout_s, &common, &err) != STP_OK)
        return cli_fail(&cli_export, &err);
    return CLI_DONE;
}
