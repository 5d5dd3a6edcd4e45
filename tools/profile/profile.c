/* `stipple profile`: the heights of a model along a line, as a table or a chart. */
#include "base/file.h"
#include "tools/cli/cli.h"
#include "tools/file/sandbox_options.h"
#include "tools/file/source_options.h"
#include "tools/profile/profile_write.h"

#include <math.h>
#include <stdio.h>

static int run(int argc, char **argv);

const cli_command cli_profile = {
    .name = "profile",
    .summary = "write the heights along a line, as CSV or as a chart",
    .usage = "stipple profile M.stipple --line x0,y0,x1,y1 -o F.csv [options]",
    .details =
        "Takes every point whose place on the map (x, y) is at most half the width away from the\n"
        "line. A CSV file has a line for each, \"distance,x,y,z,r,g,b\", by distance from the\n"
        "line's beginning. An SVG file is a chart of the heights. Only the parts of the model "
        "that\n"
        "the line crosses are read.",
    .run = run,
};

typedef struct request {
    profile_line line;
    const char *model, *output;
    bool force, chart;
    double timeout_s;
} request;

static stp_status parse_line(const char *text, profile_line *line, stp_error *err)
{
    int used = 0;
    const int count = sscanf(text, "%lf,%lf,%lf,%lf%n", &line->from[0], &line->from[1],
                             &line->to[0], &line->to[1], &used);
    const double length = hypot(line->to[0] - line->from[0], line->to[1] - line->from[1]);
    if (count != 4 || text[used] || !isfinite(length) || !(length > 0.0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--line %s: give x0,y0,x1,y1, two different places on the map", text);
    return STP_OK;
}

static stp_status write_profile(const request *r, const cli_common *common, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_file *file = NULL;
    stp_output *output = NULL;
    profile found = {0};
    const stp_byte_source_params source = source_options_params(NULL, 0, r->timeout_s);
    STP_TRY(stp_output_check_input(r->output, r->model, err));
    STP_TRY(source_options_open(&file, r->model, &source, err));
    STP_TRY(stp_output_create(&output, r->output, r->force, err));
    STP_TRY(profile_find(&found, file, &r->line, cli_progress(common), err));
    cli_progress_end();
    STP_TRY(r->chart ? profile_write_svg(&found, output, err)
                     : profile_write_csv(&found, output, err));
    STP_TRY(stp_output_commit(&output, err));
    if (!common->quiet)
        fprintf(stderr, "%zu points along %.6g, within %.4g on both sides of the line\n",
                found.count, found.length, 0.5 * found.width);
done:
    cli_progress_end();
    profile_clear(&found);
    stp_output_destroy(&output);
    stp_chunk_file_close(&file);
    return status;
}

static int run(int argc, char **argv)
{
    request r = {.timeout_s = SOURCE_TIMEOUT_S};
    const char *line = NULL;
    bool no_sandbox = false;
    size_t count = 0;
    cli_common common = {0};
    stp_error err = {0};
    const cli_option options[] = {
        {"--line", 0, CLI_STRING, &line, "x0,y0,x1,y1", "from and to, in the scan's coordinates",
         NULL},
        {"--width", 0, CLI_NUMBER, &r.line.width, "W",
         "of the strip of points that count (twice the spacing of the points)", NULL},
        {"--where", 0, CLI_STRING, &r.line.where, "CONDITION",
         "take only points that fulfil it, like 'return==1 && class!=7' (as export --where)", NULL},
        {"--output", 'o', CLI_STRING, &r.output, "F.csv|F.svg", "the file to write", NULL},
        {"--force", 'f', CLI_FLAG, &r.force, NULL, "replace an existing file", NULL},
        source_options_timeout(&r.timeout_s),
        sandbox_options_off(&no_sandbox),
    };
    int code = cli_parse(&cli_profile, options, sizeof options / sizeof *options, argc, argv,
                         &r.model, 1, 1, &count, &common);
    if (code != CLI_CONTINUE)
        return code;
    if (!line)
        return cli_usage(&cli_profile, "no line given: add --line x0,y0,x1,y1");
    if (!r.output || (!stp_path_ends_in(r.output, ".csv") && !stp_path_ends_in(r.output, ".svg")))
        return cli_usage(&cli_profile, "no output given: add -o F.csv or -o F.svg");
    if (r.line.width < 0.0)
        return cli_usage(&cli_profile, "--width: give a number above 0");
    r.chart = stp_path_ends_in(r.output, ".svg");
    if (parse_line(line, &r.line, &err) != STP_OK ||
        sandbox_options_enter(no_sandbox, r.model, r.output, &err) != STP_OK ||
        write_profile(&r, &common, &err) != STP_OK)
        return cli_fail(&cli_profile, &err);
    return CLI_DONE;
}
