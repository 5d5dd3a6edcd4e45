/* stipple prep: scans to one chunk file. */
#include "tools/commands.h"

#include "base/clock.h"
#include "base/memory.h"
#include "formats/scan/scan.h"
#include "preprocess/prep.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define INPUTS_LIMIT 4096

typedef struct prep_options {
    const char *output, *orient, *stats, *temp;
    uint64_t neighbours, sample, seed, memory;
    double precision;
    bool recompute_normals, force;
    int codec;
    cli_common common;
} prep_options;

/* Several scans, one after the other. */
typedef struct inputs {
    const char *const *paths;
    size_t count, current;
    stp_scan_params params;
    stp_scan *scan;
    stp_dvec3 *stations; /* of all inputs, one after the other */
    size_t station_count, station_capacity;
    uint32_t stations_before; /* of the inputs before the current one */
} inputs;

static stp_status read_inputs(void *context, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    inputs *in = context;
    stp_status status = STP_OK;
    *count = 0;
    while (*count == 0 && in->current < in->count) {
        if (!in->scan)
            STP_TRY(stp_scan_open(&in->scan, in->paths[in->current], &in->params, err));
        STP_TRY(stp_scan_read(in->scan, points, capacity, count, err));
        for (size_t i = 0; i < *count; i++)
            if (points[i].station > 0)
                points[i].station = (uint16_t)(points[i].station + in->stations_before);
        if (*count == 0) {
            in->stations_before += stp_scan_get_info(in->scan)->station_count;
            stp_scan_close(&in->scan);
            in->current++;
        }
    }
done:
    return status;
}

static stp_status add_stations(inputs *in, const stp_scan_info *info, const char *path,
                               stp_error *err)
{
    stp_status status = STP_OK;
    size_t count = in->station_count + info->station_count;
    if (count > STP_STATION_LIMIT)
        return stp_error_set(err, STP_LIMIT,
                             "%s: with it the inputs have more than %u scanner stations: give it "
                             "to another model",
                             path, STP_STATION_LIMIT);
    STP_TRY(stp_grow(&in->stations, &in->station_capacity, count, sizeof *in->stations, "stations",
                     err));
    if (info->station_count > 0)
        memcpy(in->stations + in->station_count, info->stations,
               info->station_count * sizeof *in->stations);
    in->station_count = count;
done:
    return status;
}

/* What all inputs together are; every file is opened once, so that a wrong one fails at once. */
static stp_status survey(inputs *in, stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t all = UINT32_MAX;
    uint32_t any = 0;
    for (size_t i = 0; i < in->count; i++) {
        stp_scan *scan = NULL;
        STP_TRY(stp_scan_open(&scan, in->paths[i], &in->params, err));
        const stp_scan_info *info = stp_scan_get_info(scan);
        status = add_stations(in, info, in->paths[i], err);
        source->point_count += info->point_count;
        all &= info->attributes;
        any |= info->attributes;
        if (info->coordinate_step > 0.0 &&
            (source->coordinate_step == 0.0 || info->coordinate_step < source->coordinate_step))
            source->coordinate_step = info->coordinate_step;
        stp_scan_close(&scan);
        if (status != STP_OK)
            goto done;
    }
    source->stations = in->stations;
    source->station_count = (uint32_t)in->station_count;
    /* Normals orient the model only if every scan has them. */
    source->attributes = (any & ~(uint32_t)STP_POINT_HAS_NORMAL) | (all & STP_POINT_HAS_NORMAL);
done:
    return status;
}

static stp_status parse_orient(const char *text, stp_prep_params *params, stp_error *err)
{
    static const char *const words[] = {"auto", "file", "propagate", "none"};
    static const stp_orient_mode modes[] = {STP_ORIENT_AUTO, STP_ORIENT_FILE, STP_ORIENT_PROPAGATE,
                                            STP_ORIENT_NONE};
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcmp(text, words[i]) == 0) {
            params->orient = modes[i];
            return STP_OK;
        }
    }
    stp_dvec3 *p = &params->orient_position;
    int used = 0;
    if (sscanf(text, "%lf,%lf,%lf%n", &p->x, &p->y, &p->z, &used) == 3 && !text[used] &&
        stp_dvec3_finite(*p)) {
        params->orient = STP_ORIENT_POSITION;
        return STP_OK;
    }
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "--orient %s: give auto, file, propagate, none or a position x,y,z", text);
}

static cJSON *stats_json(const stp_prep_stats *s)
{
    double points = (double)s->points_out;
    cJSON *root = cJSON_CreateObject();
    cJSON_AddNumberToObject(root, "points_in", (double)s->points_in);
    cJSON_AddNumberToObject(root, "points_out", points);
    cJSON *rejected = cJSON_AddObjectToObject(root, "rejected");
    for (int r = STP_REJECT_NOT_FINITE; r < STP_REJECT_COUNT; r++)
        cJSON_AddNumberToObject(rejected, stp_reject_name((stp_reject)r), (double)s->rejected[r]);
    cJSON_AddNumberToObject(root, "chunks", s->tree.chunk_count);
    cJSON_AddNumberToObject(root, "patches", (double)s->tree.patch_count);
    cJSON_AddNumberToObject(root, "seconds", s->seconds);
    cJSON_AddNumberToObject(root, "points_per_second", points / s->seconds);
    cJSON_AddNumberToObject(root, "peak_rss_bytes", (double)stp_peak_rss_bytes());
    cJSON_AddNumberToObject(root, "temporary_bytes", (double)s->temporary_bytes);
    cJSON_AddNumberToObject(root, "file_bytes", (double)s->tree.file_bytes);
    cJSON_AddNumberToObject(root, "bytes_per_point", (double)s->tree.file_bytes / points);
    cJSON *stages = cJSON_AddObjectToObject(root, "stages");
    for (int i = 0; i < STP_PREP_STAGE_COUNT; i++)
        cJSON_AddNumberToObject(stages, stp_prep_stage_names[i], s->stage_seconds[i]);
    return root;
}

static void print_orientation(const stp_prep_stats *s)
{
    static const char *const words[] = {"unknown: drawn two-sided", "from the file",
                                        "from the scanner's position", "propagated",
                                        "known in part"};
    if (s->orientation == STP_ORIENTATION_POSITION && s->station_count > 1)
        fprintf(stderr, "orientation from %u scanner positions", s->station_count);
    else
        fprintf(stderr, "orientation %s", words[s->orientation]);
    if (s->points_unstationed > 0)
        fprintf(stderr, "; %" PRIu64 " points name no scanner whose position is known",
                s->points_unstationed);
    fprintf(stderr, "\n");
}

/* " (3 not finite, 10 without return)". */
static void print_rejects(const stp_prep_stats *s)
{
    static const char *const words[STP_REJECT_COUNT] = {
        [STP_REJECT_NOT_FINITE] = "not finite",
        [STP_REJECT_NO_RETURN] = "without a return",
        [STP_REJECT_INVALID] = "marked invalid",
    };
    const char *separator = " (";
    for (int r = STP_REJECT_NOT_FINITE; r < STP_REJECT_COUNT; r++) {
        if (s->rejected[r] == 0)
            continue;
        fprintf(stderr, "%s%" PRIu64 " %s", separator, s->rejected[r], words[r]);
        separator = ", ";
    }
    fprintf(stderr, "%s\n", *separator == ',' ? ")" : "");
}

static void print_stats(const stp_prep_stats *s)
{
    fprintf(stderr, "%" PRIu64 " points read, %" PRIu64 " stored, %" PRIu64 " rejected",
            s->points_in, s->points_out, s->points_in - s->points_out);
    print_rejects(s);
    fprintf(stderr, "%u chunks, %" PRIu64 " patches, %" PRIu64 " bytes (%.2f a point)\n",
            s->tree.chunk_count, s->tree.patch_count, s->tree.file_bytes,
            (double)s->tree.file_bytes / (double)s->points_out);
    print_orientation(s);
    for (int i = 0; i < STP_PREP_STAGE_COUNT; i++)
        fprintf(stderr, "  %-12s %8.2f s\n", stp_prep_stage_names[i], s->stage_seconds[i]);
    fprintf(stderr, "  %-12s %8.2f s  %.2f M points/s, peak memory %.2f GiB\n", "all", s->seconds,
            1e-6 * (double)s->points_out / s->seconds,
            (double)stp_peak_rss_bytes() / (1024.0 * 1024.0 * 1024.0));
}

/* Says how much room on disk will be taken, if any. */
static stp_status print_plan(const char *path, const stp_prep_source *source,
                             const stp_prep_params *params, const stp_pool *pool, stp_error *err)
{
    stp_prep_plan plan = {0};
    stp_status status = stp_prep_plan_make(&plan, path, source->point_count, params,
                                           stp_pool_thread_count(pool), err);
    if (status == STP_OK && plan.temporary_bytes > 0)
        fprintf(stderr, "temporary files: up to %.1f GB in %s (%.1f GB free)\n",
                1e-9 * (double)plan.temporary_bytes, plan.folder, 1e-9 * (double)plan.free_bytes);
    stp_prep_plan_clear(&plan);
    return status;
}

static stp_status run_prep(const prep_options *o, const char *const *paths, size_t count,
                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_pool *pool = NULL;
    inputs in = {.paths = paths,
                 .count = count,
                 .params = {.sample_count = o->sample,
                            .seed = o->seed,
                            .recompute_normals = o->recompute_normals}};
    const char *name = strrchr(paths[0], '/');
    stp_prep_source source = {
        .context = &in, .read = read_inputs, .name = name ? name + 1 : paths[0]};
    stp_prep_params params = {.neighbour_count = (unsigned)o->neighbours,
                              .precision = o->precision,
                              .codec = o->codec == 0 ? STP_CODEC_DRACO : STP_CODEC_RAW,
                              .force = o->force,
                              .memory_bytes = o->memory,
                              .temp_folder = o->temp};
    stp_prep_stats stats = {0};
    const stp_progress *progress = cli_progress(&o->common); /* Ctrl-C is heard from here on */
    const char *const outputs[CLI_OUTPUT_LIMIT] = {o->output, o->stats};
    STP_TRY(cli_check_outputs(outputs, paths, count, o->force, err));
    STP_TRY(parse_orient(o->orient, &params, err));
    STP_TRY(survey(&in, &source, err));
    STP_TRY(stp_pool_create(&pool, (unsigned)o->common.threads, err));
    if (!o->common.quiet)
        STP_TRY(print_plan(o->output, &source, &params, pool, err));
    status = stp_prep_run(o->output, &source, &params, pool, progress, &stats, err);
    cli_progress_end();
    if (status != STP_OK)
        goto done;
    if (o->stats)
        STP_TRY(cli_write_json(o->stats, stats_json(&stats), o->force, err));
    if (!o->common.quiet)
        print_stats(&stats);
done:
    cli_progress_end();
    stp_scan_close(&in.scan);
    free(in.stations);
    stp_pool_destroy(&pool);
    return status;
}

static int prep_main(int argc, char **argv);

const cli_command cli_prep = {
    .name = "prep",
    .summary = "scans to a chunk file",
    .usage = "stipple prep IN... -o M.stipple [options]",
    .details =
        "Reads PLY, OBJ, OFF and STL; several inputs become one model.\n"
        "Normals point as the input's do, else to the scanner that saw them, where a PLY says so "
        "(see\nthe README), else as they are propagated from one to the next (--orient auto).",
    .run = prep_main,
};

static int prep_main(int argc, char **argv)
{
    static const char *paths[INPUTS_LIMIT];
    prep_options o = {.orient = "auto", .neighbours = 16};
    const cli_option options[] = {
        {"--output", 'o', CLI_STRING, &o.output, "M.stipple", "the chunk file to write", NULL},
        {"--neighbours", 0, CLI_UINT, &o.neighbours, "K", "neighbours of a point, 3 to 64 (16)",
         NULL},
        {"--orient", 0, CLI_STRING, &o.orient, "HOW",
         "auto, file, propagate, none or a scanner position x,y,z (auto)", NULL},
        {"--recompute-normals", 0, CLI_FLAG, &o.recompute_normals, NULL,
         "ignore the input's normals", NULL},
        {"--sample", 0, CLI_UINT, &o.sample, "N", "N points over a mesh's faces", NULL},
        {"--seed", 0, CLI_UINT, &o.seed, "K", "of --sample (0)", NULL},
        {"--precision", 0, CLI_NUMBER, &o.precision, "LENGTH",
         "greatest position error (half the input's own scale)", NULL},
        {"--codec", 0, CLI_CHOICE, &o.codec, "draco|raw", "of the payloads (draco)", NULL},
        {"--memory", 0, CLI_BYTES, &o.memory, "SIZE",
         "most the program holds (half the machine's); what is more lies in --temp", NULL},
        {"--temp", 0, CLI_STRING, &o.temp, "DIR", "folder of temporary files (the output's)", NULL},
        {"--stats", 0, CLI_STRING, &o.stats, "F.json", "write figures as JSON", NULL},
        {"--force", 'f', CLI_FLAG, &o.force, NULL, "replace existing files", NULL},
    };
    size_t count = 0;
    int code = cli_parse(&cli_prep, options, sizeof options / sizeof *options, argc, argv, paths, 1,
                         INPUTS_LIMIT, &count, &o.common);
    if (code != CLI_CONTINUE)
        return code;
    if (!o.output)
        return cli_usage(&cli_prep, "no output: give -o M.stipple");
    if (o.neighbours < 3 || o.neighbours > STP_NEIGHBOURS_LIMIT)
        return cli_usage(&cli_prep, "--neighbours: give 3 to %d", STP_NEIGHBOURS_LIMIT);
    if (o.precision < 0.0)
        return cli_usage(&cli_prep, "--precision: give a positive length");
    stp_error error = {0};
    if (run_prep(&o, paths, count, &error) != STP_OK)
        return cli_fail(&cli_prep, &error);
    return CLI_DONE;
}
