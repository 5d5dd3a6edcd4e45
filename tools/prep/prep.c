/* stipple prep: converts scans to one chunk file. */
#include "tools/commands.h"

#include "base/json.h"
#include "preprocess/cloud/nearest_list.h"
#include "tools/cli/cli_value.h"
#include "tools/file/codec_options.h"
#include "tools/prep/prep_append.h"
#include "tools/prep/prep_grids.h"
#include "tools/prep/prep_inputs.h"
#include "tools/prep/prep_maps.h"
#include "tools/prep/prep_meshes.h"
#include "tools/prep/prep_paths.h"
#include "tools/prep/prep_plan.h"
#include "tools/prep/prep_ranks.h"
#include "tools/prep/prep_report.h"
#include "tools/prep/prep_run.h"
#include "tools/prep/prep_values.h"

#include <stdio.h>
#include <string.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

/* The choice "2" among FORMAT_CHOICES. */
#define DEFAULT_FORMAT 1

typedef struct prep_options {
    const char *output, *orient, *stats, *temp, *rejects, *columns, *precision, *normal_bits,
        *system, *attributes, *where, *sample;
    uint64_t neighbours, seed, memory;
    double outlier_distance, line_radius;
    bool recompute_normals, hybrid, strict, force, append, salvage, plan;
    int lines;    /* 1: meshes of plants become lines */
    int withheld; /* 1: withheld points are kept */
    int codec, format, progress, outliers, shade;
    int layers; /* 1: overlapping layers are joined */
    prep_grid grid;
    prep_region region;
    prep_maps maps;
    cli_common common;
    prep_ranks ranks;
} prep_options;

/* Runs the stages. The files of rejects and statistics appear after the model. */
static stp_status run_stages(const prep_options *o, prep_inputs *in, stp_prep_params *params,
                             const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    stp_pool *pool = NULL;
    stp_prep_source source = {0};
    stp_prep_stats stats = {0};
    stp_append_result appended = {0};
    stp_mesh *mesh = NULL;
    bool is_added = false;
    STP_TRY(prep_inputs_survey(in, &source, err));
    STP_TRY(prep_ranks_agree(&o->ranks, in, err));
    if (params->maps)
        STP_TRY(prep_meshes_read(in, &mesh, err));
    source.mesh = mesh;
    STP_TRY(stp_pool_create(&pool, (unsigned)o->common.threads, err));
    if (o->plan) {
        status = prep_plan_print(o->output, &source, params, stp_pool_thread_count(pool), err);
        goto done;
    }
    in->params.pool = pool;
    if (!o->append && stp_prep_size_of(&source, params).grid)
        in->params.recompute_normals = true; /* a grid computes its own */
    if (o->rejects)
        STP_TRY(prep_inputs_begin_rejects(in, o->rejects, o->force, err));
    else
        source.rejected = NULL;
    status = o->append ? stp_append_run(o->output, &source, params, pool, progress, &stats,
                                        &appended, err)
                       : stp_prep_run(o->output, &source, params, pool, progress, &stats, err);
    cli_progress_end();
    if (status != STP_OK)
        goto done;
    is_added = o->append;
    STP_TRY(prep_inputs_end_rejects(in, err));
    if (o->stats)
        STP_TRY(stp_json_save(prep_report_json(&stats, in), o->stats, o->force, err));
    if (!o->common.quiet && o->append)
        prep_append_print(&appended, &stats, in);
    else if (!o->common.quiet)
        prep_report_print(&stats, in);
    if (!o->common.quiet)
        prep_grids_print(&stats, in, params, o->append);
done:
    if (status != STP_OK && is_added) {
        const stp_error reason = *err;
        status = stp_error_set(err, status, "the points were added, but %s", reason.message);
    }
    stp_mesh_destroy(&mesh);
    stp_pool_destroy(&pool);
    return status;
}

/* Keeps freed memory for the next unit or chunk, which needs as much as the last. Otherwise the
 * system takes it back and clears it anew. Saves 3 % of the time of 4 M points, half of the
 * system's time. */
static void keep_freed_memory(void)
{
#ifdef __GLIBC__
    (void)mallopt(M_MMAP_THRESHOLD, 32 << 20); /* the largest value allowed */
    (void)mallopt(M_TRIM_THRESHOLD, 512 << 20);
#endif
}

static stp_status parse_values(const prep_options *o, stp_prep_params *params,
                               stp_grid_params *grid, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(prep_parse_orient(o->orient, params, err));
    STP_TRY(prep_parse_precision(o->precision, params, err));
    STP_TRY(prep_parse_normal_bits(o->normal_bits, params, err));
    STP_TRY(prep_parse_grid(&o->grid, grid, err));
done:
    return status;
}

static stp_prep_params prep_params(const prep_options *o)
{
    stp_prep_params params = prep_run_defaults(o->common.quiet);
    params.neighbour_count = (unsigned)o->neighbours;
    params.codec = codec_options_codec(o->codec);
    params.format = o->format + 1;
    params.join_layers = o->layers == 1;
    params.outliers = (stp_outlier_mode)o->outliers;
    params.unlit = o->shade == 1;
    params.holes_grow = o->grid.holes == 1;
    params.maps = o->maps.wanted ? &o->maps.params : NULL;
    params.outlier_distance = o->outlier_distance;
    params.force = o->force;
    params.memory_bytes = o->memory;
    params.temp_folder = o->temp;
    params.ranks = stp_meeting_ranks(o->ranks.meeting);
    return params;
}

/* A model that is added to must be there, the other outputs must not. */
static stp_status check_outputs(const prep_options *o, const prep_paths *paths, stp_error *err)
{
    stp_status status = STP_OK;
    const char *const outputs[CLI_OUTPUT_LIMIT] = {o->append ? NULL : o->output, o->stats,
                                                   o->rejects};
    for (size_t i = 0; o->append && i < paths->count; i++)
        STP_TRY(stp_output_check_input(o->output, paths->list[i], err));
    for (size_t i = 1; o->append && i < CLI_OUTPUT_LIMIT; i++)
        if (outputs[i])
            STP_TRY(stp_output_check_input(outputs[i], o->output, err));
    STP_TRY(
        cli_check_outputs(outputs, (const char *const *)paths->list, paths->count, o->force, err));
done:
    return status;
}

/* What was made although some inputs could not be read. */
static stp_status say_unreadable(const prep_options *o, const prep_inputs *in, stp_error *err)
{
    return stp_error_set(err, STP_IO, "%zu of %zu inputs could not be read, as said above: %s%s%s",
                         prep_inputs_unreadable(in), in->count,
                         o->plan ? "the plan is of the others" : o->output,
                         o->plan     ? ""
                         : o->append ? " has the points of the others"
                                     : " was written of the others",
                         o->plan ? "" : " (--strict: nothing then)");
}

static stp_status run_prep(const prep_options *o, const char *const *arguments, size_t count,
                           stp_error *err)
{
    stp_status status = STP_OK;
    prep_paths paths = {0};
    stp_grid_params grid = {0};
    stp_scan_region region = {0};
    prep_inputs in = {.params = {.seed = o->seed,
                                 .line_radius = o->line_radius,
                                 .hybrid = o->hybrid,
                                 .columns = o->columns,
                                 .recompute_normals = o->recompute_normals,
                                 .keep_withheld = o->withheld == 1,
                                 .keep_grid = o->grid.keep,
                                 .salvage = o->salvage},
                      .plants = o->lines == 1};
    stp_prep_params params = prep_params(o);
    cli_progress_stage stages[STP_PREP_STAGE_COUNT];
    const stp_progress *progress = cli_progress(&o->common); /* Ctrl-C works from here on */
    prep_run_expect(&params, o->progress == 1, stages);
    STP_TRY(stp_meeting_at(o->ranks.meeting, o->output, progress, err));
    STP_TRY(parse_values(o, &params, &grid, err));
    STP_TRY(prep_parse_sample(o->sample, &in.params.sample_count, &in.vertices, err));
    STP_TRY(prep_parse_region(&o->region, &region, &in.params.region, err));
    in.temp = o->temp;
    in.params.grid = prep_grid_is_given(&o->grid) ? &grid : NULL;
    in.exact = params.exact;
    in.strict = o->strict;
    in.system.wanted = o->system;
    in.numbers.wanted = o->attributes;
    STP_TRY(prep_where_parse(&in.where, o->where, err));
    in.params.numbers = prep_numbers_wanted(&in.numbers) || o->where;
    for (size_t i = 0; i < count; i++)
        STP_TRY(prep_paths_add(&paths, arguments[i], err));
    in.paths = paths.list;
    in.count = paths.count;
    if (!o->common.quiet)
        prep_report_sweep(o->output);
    STP_TRY(check_outputs(o, &paths, err));
    if (o->append)
        STP_TRY(prep_append_begin(&in.system, o->output, err));
    status = run_stages(o, &in, &params, progress, err);
    prep_report_unreadable(&in);
    if (status == STP_OK && prep_inputs_unreadable(&in) > 0) {
        STP_TRY(prep_ranks_let_first_end(&o->ranks, err));
        status = say_unreadable(o, &in, err);
    }
done:
    prep_run_end();
    prep_inputs_clear(&in);
    prep_paths_clear(&paths);
    return status;
}

static int prep_main(int argc, char **argv);

const cli_command cli_prep = {
    .name = "prep",
    .summary = "convert scans to one chunk file",
    .usage = "stipple prep IN... -o M.stipple [options]",
    .details =
        "Reads PLY, LAS, LAZ, COPC, EPT, PCD, E57, OBJ, OFF, STL, glTF, XYZ, TXT, CSV, PTS, PTX,\n"
        "NPY, .bin of KITTI and COLMAP, and heights as TIFF, PNG, EXR, PFM, PGM, ESRI ASCII,\n"
        "Surfer, HGT, AL3D or raw squares (.r16, .raw, .r32).\n"
        "Several inputs become one model.\n"
        "An input is a file, a folder (all scans in it and below, but no images; one EPT, if it\n"
        "holds ept.json), a pattern in quotes, an address (https://...), or @list.txt with one\n"
        "input per line. If one of several inputs cannot be read, or breaks "
        "off,\n"
        "prep leaves that whole input out, names it at the end and exits with code 1.\n"
        "\n"
        "--orient auto: if the input has normals, they decide which side is the front. If it has\n"
        "none, normals point to the scanner that saw the point, where the input says so (see the\n"
        "README). Otherwise each normal takes its direction from its neighbours.\n"
        "\n"
        "Lines: edges of a PLY file (element edge: vertex1, vertex2) and l lines of an OBJ file.\n"
        "They become ribbons if their vertices have normals, else tubes. Half their width is the\n"
        "property radius of a vertex, else --line-radius. A side of a face does not become a "
        "line.\n"
        "Vertices of faces, and vertices that no edge uses, become points.\n"
        "\n"
        "Heights: a row for each y, the top one first; a column for each x. The file says how far\n"
        "they are apart and where they lie (GeoTIFF, ESRI, Surfer, HGT, AL3D), else --spacing.\n"
        "With --pinhole the numbers are depths of a camera, or with --disparity disparities.\n"
        "The image of a usual depth camera is known without it, unless --spacing says heights.\n"
        "\n"
        "Meshes: the vertices are the points, or --sample N. A mesh whose faces are large, such "
        "as\n"
        "a drawn house, is sampled without being asked, and stored as by --hybrid.\n"
        "\n"
        "--hybrid stores the large triangles of a mesh as triangles and the others as points. A\n"
        "triangle is large if it would get 8 points or more of --sample N, or if all would on\n"
        "average. Without --sample, N is the number of vertices; then a triangle as long as a\n"
        "large one is large, too. Triangles and points blend where they meet.\n"
        "\n"
        "--lines auto turns meshes of plants into lines: leaves become ribbons, branches become\n"
        "tubes. The trunk, and what is neither leaf nor branch, stays triangles.\n"
        "\n"
        "--layers joined moves points along their normals, by no more than their noise, onto the\n"
        "surface that they share with their neighbours. Scans that overlap with a registration\n"
        "error become one surface; folds finer than the sampling are lost. prep prints how far it\n"
        "moved the points and stores that in the model (see info).\n"
        "\n"
        "--maps cuts the surface into maps, each a grid of heights over a plane, and stores their\n"
        "samples in place of the points. prep prints how far the points are from that surface.\n"
        "Points that are no surface stay. A larger --cone gives fewer maps, with coarser slopes.\n"
        "The maps of a mesh are samples of its faces.\n"
        "\n"
        "--outliers looks for points, and groups of at most K points (--neighbours K), far from "
        "all\n"
        "others. The unit is the spacing of those others, so a sparse part of a scan is no "
        "outlier.\n"
        "mark: outliers are stored with a mark, which export writes. drop: outliers are rejected\n"
        "(see --rejects).",
    .run = prep_main,
};

/* Returns CLI_CONTINUE if the options of maps fit together with the others. */
static int check_maps(prep_options *o)
{
    const char *fault = prep_maps_check(&o->maps);
    if (fault)
        return cli_usage(&cli_prep, "%s", fault);
    if (!o->maps.wanted)
        return CLI_CONTINUE;
    if (o->precision && strcmp(o->precision, "exact") == 0)
        return cli_usage(&cli_prep, "--maps resamples points, --precision exact keeps them: give "
                                    "one of them");
    if (o->attributes && strcmp(o->attributes, "none") != 0)
        return cli_usage(&cli_prep, "--maps resamples points, and samples have no --attributes: "
                                    "give one of them");
    if (strcmp(o->orient, "none") == 0)
        return cli_usage(&cli_prep, "--maps needs normals that agree: leave out --orient none");
    if (o->maps.params.paper && o->format == 0)
        return cli_usage(&cli_prep, "--map-codec paper needs blocks: leave out --format 1");
    return CLI_CONTINUE;
}

/* Returns CLI_CONTINUE if the options fit together. */
static int check_options(const prep_options *o)
{
    if (!o->output)
        return cli_usage(&cli_prep, "no output: give -o M.stipple");
    if (o->neighbours != 0 && (o->neighbours < 3 || o->neighbours > STP_NEIGHBOURS_LIMIT))
        return cli_usage(&cli_prep, "--neighbours: give 3 to %d", STP_NEIGHBOURS_LIMIT);
    if (o->lines == 1 && (o->hybrid || o->sample))
        return cli_usage(&cli_prep, "--lines auto leaves no faces for --hybrid or --sample: give "
                                    "one of them");
    if (o->outlier_distance != 0.0 && o->outliers == STP_OUTLIERS_KEEP)
        return cli_usage(&cli_prep, "--outlier-distance: give --outliers mark or drop, too");
    if (o->outlier_distance != 0.0 && !(o->outlier_distance >= 1.0))
        return cli_usage(&cli_prep, "--outlier-distance: give 1 or more");
    if (o->layers == 1 && o->precision && strcmp(o->precision, "exact") == 0)
        return cli_usage(&cli_prep, "--layers joined moves points, --precision exact keeps them: "
                                    "give one of them");
    if (o->attributes && strcmp(o->attributes, "none") != 0 && o->format == 0)
        return cli_usage(&cli_prep, "--attributes: files of version 1 have none: leave out "
                                    "--format 1");
    if (o->append && (o->outliers != STP_OUTLIERS_KEEP || o->layers == 1 || o->attributes ||
                      o->hybrid || o->lines == 1 || o->codec != 0 || o->format == 0 ||
                      o->shade == 1 || o->grid.holes == 1 || o->maps.wanted))
        return cli_usage(&cli_prep, "--append: the model has its form; leave out --outliers, "
                                    "--layers, --attributes, --hybrid, --lines, --codec, "
                                    "--format, --shade, --holes and --maps");
    if (o->append && o->plan)
        return cli_usage(&cli_prep, "--plan plans a new model: leave out --append");
    if (o->append && o->ranks.meeting)
        return cli_usage(&cli_prep, "--append: one process adds points: leave out mpirun");
    if (o->line_radius < 0.0)
        return cli_usage(&cli_prep, "--line-radius: give a positive length");
    return CLI_CONTINUE;
}

static int run_checked(prep_options *o, const char *const *paths, size_t count)
{
    stp_error error = {0};
    int code = check_options(o);
    if (code == CLI_CONTINUE)
        code = check_maps(o);
    if (code != CLI_CONTINUE)
        return code;
    if (!stp_ranks_is_first(stp_meeting_ranks(o->ranks.meeting))) {
        o->common.quiet = true;
        o->stats = o->rejects = NULL;
    }
    keep_freed_memory();
    return run_prep(o, paths, count, &error) == STP_OK
               ? CLI_DONE
               : prep_ranks_fail(&o->ranks, &cli_prep, &error);
}

#define GROUPED_OPTIONS (PREP_GRID_OPTIONS + PREP_REGION_OPTIONS + PREP_MAPS_OPTIONS)

/* Fills the options that have files of their own. */
static void fill_groups(prep_options *o, cli_option out[GROUPED_OPTIONS])
{
    prep_grid_fill(&o->grid, out);
    prep_region_fill(&o->region, out + PREP_GRID_OPTIONS);
    prep_maps_fill(&o->maps, out + PREP_GRID_OPTIONS + PREP_REGION_OPTIONS);
}

/* Reads the options and the inputs. Returns CLI_CONTINUE, or what the program ends with. */
static int parse(prep_options *o, int argc, char **argv, const char **paths, size_t *count)
{
    const cli_option own[] = {
        {"--output", 'o', CLI_STRING, &o->output, "M.stipple", "the chunk file to write", NULL},
        {"--neighbours", 0, CLI_UINT, &o->neighbours, "K",
         "neighbours examined for each point, 3 to 64 (16; 64 if points lie in scan lines)", NULL},
        {"--orient", 0, CLI_STRING, &o->orient, "HOW",
         "auto, file, propagate, none or a scanner position x,y,z (auto)", NULL},
        {"--recompute-normals", 0, CLI_FLAG, &o->recompute_normals, NULL, "ignore given normals",
         NULL},
        {"--sample", 0, CLI_STRING, &o->sample, "N|none",
         "place N points on a mesh's faces (none, unless they are large)", NULL},
        {"--seed", 0, CLI_UINT, &o->seed, "K", "seed of the random numbers of --sample (0)", NULL},
        {"--columns", 0, CLI_STRING, &o->columns, "LIST",
         "columns of text files: x,y,z,r,g,b,rgb,i,nx,ny,nz,class, _ to skip (guessed)", NULL},
        {"--hybrid", 0, CLI_FLAG, &o->hybrid, NULL,
         "store large triangles as triangles, the others as points", NULL},
        {"--lines", 0, CLI_CHOICE, &o->lines, "edges|auto",
         "auto: turn meshes of plants into lines (edges)", NULL},
        {"--line-radius", 0, CLI_NUMBER, &o->line_radius, "LENGTH",
         "half the width of lines that have none (1/2000 of their diagonal)", NULL},
        {"--layers", 0, CLI_CHOICE, &o->layers, "measured|joined",
         "joined: move overlapping scans onto one shared surface (measured)", NULL},
        prep_system_option(&o->system),
        {"--attributes", 0, CLI_STRING, &o->attributes, "all|none|NAMES",
         "keep what the points have besides, as GPS time and returns (none)", NULL},
        {"--withheld", 0, CLI_CHOICE, &o->withheld, "drop|keep",
         "keep: also points that LAS, LAZ and EPT mark as withheld (drop)", NULL},
        {"--salvage", 0, CLI_FLAG, &o->salvage, NULL, "store what is whole of cut files", NULL},
        prep_where_option(&o->where),
        {"--outliers", 0, CLI_CHOICE, &o->outliers, "keep|mark|drop",
         "keep, mark or drop points far from everything else (keep)", NULL},
        {"--outlier-distance", 0, CLI_NUMBER, &o->outlier_distance, "SPACINGS",
         "distance in local spacings that makes a point an outlier, 1 or more (3)", NULL},
        {"--precision", 0, CLI_STRING, &o->precision, "LENGTH|exact",
         "largest position error (half the input's scale); exact: the input's numbers", NULL},
        {"--normal-bits", 0, CLI_STRING, &o->normal_bits, "auto|6..12",
         "bits of each coordinate of normals (auto: as many as their noise leaves)", NULL},
        {"--shade", 0, CLI_CHOICE, &o->shade, "phong|unlit",
         "default shading; unlit: for scans that carry their own light (phong)", NULL},
        {"--codec", 0, CLI_CHOICE, &o->codec, CODEC_CHOICES,
         "codec of the payloads (draco); zstd decodes faster, in 1.4 times the space", NULL},
        {"--format", 0, CLI_CHOICE, &o->format, FORMAT_CHOICES,
         "version of the file (2): 2 is in blocks, so that views read less", NULL},
        {"--memory", 0, CLI_BYTES, &o->memory, "SIZE",
         "memory limit (half the machine's); the rest goes to files in --temp", NULL},
        {"--temp", 0, CLI_STRING, &o->temp, "DIR", "for temporary files (output's folder)", NULL},
        {"--stats", 0, CLI_STRING, &o->stats, "F.json", "write statistics as JSON", NULL},
        {"--rejects", 0, CLI_STRING, &o->rejects, "F.csv", "list what is rejected, and why", NULL},
        {"--strict", 0, CLI_FLAG, &o->strict, NULL, "write nothing if an input is unreadable",
         NULL},
        {"--progress", 0, CLI_CHOICE, &o->progress, "text|json", "format of progress (text)", NULL},
        {"--plan", 0, CLI_FLAG, &o->plan, NULL, "print needs and time on 1 to 1024 machines", NULL},
        {"--append", 0, CLI_FLAG, &o->append, NULL, "add points to the model M.stipple", NULL},
        {"--force", 'f', CLI_FLAG, &o->force, NULL, "replace existing files", NULL},
    };
    cli_option options[sizeof own / sizeof *own + GROUPED_OPTIONS];
    memcpy(options, own, sizeof own);
    fill_groups(o, options + sizeof own / sizeof *own);
    return cli_parse(&cli_prep, options, sizeof options / sizeof *options, argc, argv, paths, 1,
                     PREP_PATHS_LIMIT, count, &o->common);
}

static int prep_main(int argc, char **argv)
{
    static const char *paths[PREP_PATHS_LIMIT];
    prep_options o = {.orient = "auto", .format = DEFAULT_FORMAT};
    size_t count = 0;
    stp_error error = {0};
    if (prep_ranks_begin(&o.ranks, argc, argv, &error) != STP_OK)
        return cli_fail(&cli_prep, &error);
    int code = parse(&o, argc, argv, paths, &count);
    if (code == CLI_CONTINUE)
        code = run_checked(&o, paths, count);
    return prep_ranks_end(&o.ranks, &cli_prep, code);
}
