/* `stipple info`: prints what is in a chunk file, from its header and directory, and from its
 * payloads if bytes are to be counted. */
#include "tools/file/info_bytes.h"
#include "tools/file/sandbox_options.h"
#include "tools/file/source_options.h"

#include "base/memory.h"
#include "formats/chunk/attribute/attribute_file.h"
#include "formats/chunk/attribute/attribute_json.h"
#include "formats/chunk/convert.h"
#include "formats/chunk/free_ranges.h"
#include "formats/chunk/repair/repair_note.h"
#include "formats/chunk/sample/normal_grid.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define METADATA_SHOWN 300 /* bytes; --json prints all */

static int run(int argc, char **argv);

const cli_command cli_info = {
    .name = "info",
    .summary = "print what is in a chunk file",
    .usage = "stipple info M.stipple [--bytes] [--json]",
    .details =
        "Reads header, directory and metadata. Lengths are in the scan's own units.\n"
        "--bytes decodes every chunk and says how many bytes hold positions, normals, radii\n"
        "and so on. If the codec is zstd, this is an estimate by entropy; else it is exact.",
    .run = run,
};

/* Sums over the chunks of one depth. */
typedef struct depth_summary {
    uint32_t chunk_count;
    uint64_t patch_count;
    uint64_t sample_count[STP_LEVEL_COUNT];
    uint64_t payload_bytes;
    unsigned codecs; /* by codec without blocks, a bit for each that a chunk has */
    double error[STP_LEVEL_COUNT], tangential_error[STP_LEVEL_COUNT], colour_error[STP_LEVEL_COUNT];
    double radius_min, radius_max;
} depth_summary;

/* What is printed beside what the header says. */
typedef struct file_facts {
    depth_summary *depths;   /* by depth */
    const info_bytes *bytes; /* NULL: they were not counted */
    uint64_t unused_bytes;
    stp_attribute_list extra;
} file_facts;

static void add_entry(depth_summary *sum, const stp_chunk_entry *e)
{
    if (sum->chunk_count == 0)
        sum->radius_min = INFINITY;
    sum->chunk_count++;
    sum->patch_count += e->patch_count;
    sum->codecs |= 1u << (e->codec < STP_CODEC_COUNT ? stp_codec_of_part((stp_codec)e->codec)
                                                     : STP_CODEC_COUNT); /* any unknown one */
    sum->payload_bytes += e->segment_end[STP_SEGMENT_COUNT - 1];
    sum->radius_min = fmin(sum->radius_min, (double)e->radius_min);
    sum->radius_max = fmax(sum->radius_max, (double)e->radius_max);
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        sum->sample_count[l] += e->sample_count[l];
        sum->error[l] = fmax(sum->error[l], (double)e->error[l]);
        sum->tangential_error[l] = fmax(sum->tangential_error[l], (double)e->tangential_error[l]);
        sum->colour_error[l] = fmax(sum->colour_error[l], (double)e->colour_error[l]);
    }
}

/* *depths has info->depth elements; free with free(). */
static stp_status summarise(stp_chunk_file *file, depth_summary **depths, stp_error *err)
{
    stp_status status = STP_OK;
    depth_summary *sums = NULL;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    STP_TRY(stp_alloc(&sums, info->depth, sizeof *sums, "summary", err));
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        stp_chunk_entry entry;
        STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
        add_entry(&sums[entry.depth], &entry);
    }
    *depths = sums;
    sums = NULL;
done:
    free(sums);
    return status;
}

/* "draco", or several names with spaces between them. */
static void name_codecs(const depth_summary *depths, uint32_t count, char out[64])
{
    static const char *const names[] = {[STP_CODEC_RAW] = "raw",
                                        [STP_CODEC_DRACO] = "draco",
                                        [STP_CODEC_ZSTD] = "zstd",
                                        [STP_CODEC_PAPER] = "paper"};
    unsigned codecs = 0;
    out[0] = '\0';
    for (uint32_t d = 0; d < count; d++)
        codecs |= depths[d].codecs;
    for (unsigned c = 0; c < sizeof names / sizeof *names; c++)
        if (codecs >> c & 1u)
            snprintf(out + strlen(out), 64 - strlen(out), "%s%s", out[0] ? " " : "", names[c]);
    if (codecs >> (sizeof names / sizeof *names))
        snprintf(out + strlen(out), 64 - strlen(out), "%sunknown", out[0] ? " " : "");
}

/* ---- text ---- */

static void print_attributes(uint32_t attributes, const stp_attribute_list *extra)
{
    printf("attributes     normal%s%s%s%s%s%s\n", attributes & STP_HAS_COLOUR ? " colour" : "",
           attributes & STP_HAS_INTENSITY ? " intensity" : "",
           attributes & STP_HAS_CLASS ? " class" : "",
           attributes & STP_HAS_OUTLIERS ? " outlier" : "",
           attributes & STP_HAS_LINES ? " lines" : "",
           attributes & STP_HAS_TRIANGLES ? " triangles" : "");
    for (uint32_t i = 0; i < extra->count; i++)
        printf("%s%s%s", i ? ", " : "               ", extra->items[i].name,
               i + 1 < extra->count ? "" : "\n");
}

/* Prints "12 marked, more than 3 local spacings from everything else", as prep counted. */
static void print_outliers(const stp_chunk_file_info *info)
{
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *outliers = cJSON_GetObjectItemCaseSensitive(metadata, "outliers");
    const cJSON *distance = cJSON_GetObjectItemCaseSensitive(outliers, "distance");
    static const char *const words[] = {"marked", "dropped"};
    for (size_t i = 0; i < 2; i++) {
        const cJSON *count = cJSON_GetObjectItemCaseSensitive(outliers, words[i]);
        if (cJSON_IsNumber(count) && cJSON_IsNumber(distance))
            printf("outliers       %.0f %s, more than %g local spacings from everything else\n",
                   count->valuedouble, words[i], distance->valuedouble);
    }
    cJSON_Delete(metadata);
}

/* Prints the range of intensities in the scans' own numbers. */
static void print_intensity(const stp_chunk_file_info *info)
{
    double top = stp_chunk_file_intensity_top(info);
    if ((info->attributes & STP_HAS_INTENSITY) && top > 0.0)
        printf("intensity      0 to %.6g as in the scans, stored in steps of %.3g\n", top,
               top / 255.0);
}

/* Prints how many bits prep left of normals, if it rounded them. */
static void print_normal_bits(const cJSON *metadata)
{
    const cJSON *bits = cJSON_GetObjectItemCaseSensitive(metadata, "normal_bits");
    const cJSON *step = cJSON_GetObjectItemCaseSensitive(metadata, "normal_step");
    const bool told = cJSON_IsNumber(step) && step->valuedouble >= 1.0;
    if (cJSON_IsNumber(bits))
        printf("normals        of 2 x %.3g bits where they are computed\n",
               told ? STP_NORMAL_BITS - log2(step->valuedouble) : bits->valuedouble);
}

/* Prints what becomes of the holes of a grid or image. */
static void print_holes(const cJSON *metadata)
{
    const cJSON *holes = cJSON_GetObjectItemCaseSensitive(metadata, "holes");
    const bool grow = cJSON_IsString(holes) && !strcmp(holes->valuestring, "grow");
    if (grow || cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(metadata, "grid")))
        printf("holes          %s\n", grow ? "only grow: nothing is drawn over a missing sample"
                                           : "keep their width within the threshold");
}

/* Prints "by 0.002 at most, 0.0001 on average": how far prep moved points. */
static void print_joined(const cJSON *metadata)
{
    const cJSON *joined = cJSON_GetObjectItemCaseSensitive(metadata, "joined");
    const cJSON *greatest = cJSON_GetObjectItemCaseSensitive(joined, "greatest");
    const cJSON *mean = cJSON_GetObjectItemCaseSensitive(joined, "mean");
    if (cJSON_IsNumber(greatest) && cJSON_IsNumber(mean))
        printf("layers         joined: points were moved by %.3g at most, %.3g on average\n",
               greatest->valuedouble, mean->valuedouble);
}

/* Prints how many points maps stand for, and how far those are from the stored surface. */
static void print_resampled(const cJSON *metadata)
{
    static const char *const names[] = {"maps",      "samples",  "represented",
                                        "as_points", "greatest", "mean"};
    const cJSON *resampled = cJSON_GetObjectItemCaseSensitive(metadata, "resampled");
    double values[sizeof names / sizeof *names];
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const cJSON *value = cJSON_GetObjectItemCaseSensitive(resampled, names[i]);
        if (!cJSON_IsNumber(value))
            return;
        values[i] = value->valuedouble;
    }
    printf("resampled      %.0f maps of %.0f samples stand for %.0f points; %.0f stay points\n"
           "               the surface is at most %.3g from the points, %.3g on average\n",
           values[0], values[1], values[2], values[3], values[4], values[5]);
    const cJSON *between = cJSON_GetObjectItemCaseSensitive(resampled, "between");
    const cJSON *open = cJSON_GetObjectItemCaseSensitive(resampled, "open_edges");
    if (cJSON_IsNumber(between) && cJSON_IsNumber(open))
        printf("               %.0f triangles fill the gaps between maps; %.0f edges stay open\n",
               between->valuedouble, open->valuedouble);
}

/* Prints "0.0004 at most, 0.0002 on average", as prep measured. */
static void print_displacement(const stp_chunk_file_info *info)
{
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *d = cJSON_GetObjectItemCaseSensitive(metadata, "displacement");
    const cJSON *greatest = cJSON_GetObjectItemCaseSensitive(d, "greatest");
    const cJSON *mean = cJSON_GetObjectItemCaseSensitive(d, "mean");
    const cJSON *beyond = cJSON_GetObjectItemCaseSensitive(d, "beyond");
    if (cJSON_IsNumber(greatest) && cJSON_IsNumber(mean))
        printf("displacement   of stored points: %.3g at most, %.3g on average",
               greatest->valuedouble, mean->valuedouble);
    if (cJSON_IsNumber(beyond) && beyond->valuedouble > 0.0)
        printf("; %.0f are farther off than the input resolves", beyond->valuedouble);
    if (d)
        printf("\n");
    print_normal_bits(metadata);
    print_holes(metadata);
    print_joined(metadata);
    print_resampled(metadata);
    cJSON_Delete(metadata);
}

static void print_depths(const depth_summary *depths, uint32_t count)
{
    printf("\n%5s %9s %11s %13s %14s %11s %11s %11s\n", "depth", "chunks", "patches", "samples",
           "payload bytes", "error 0", "error 3", "radius");
    for (uint32_t d = 0; d < count; d++)
        printf("%5" PRIu32 " %9" PRIu32 " %11" PRIu64 " %13" PRIu64 " %14" PRIu64
               " %11.4g %11.4g %11.4g\n",
               d, depths[d].chunk_count, depths[d].patch_count, depths[d].sample_count[0],
               depths[d].payload_bytes, depths[d].error[0], depths[d].error[STP_LEVEL_COUNT - 1],
               depths[d].radius_max);
    printf(
        "samples: of level 0; errors and radius: the greatest; the points are the samples of the "
        "leaves\n");
}

/* Prints text of the file. Control characters but line breaks are not passed to the terminal. */
static void print_foreign(const char *text, size_t length)
{
    for (size_t i = 0; i < length;) {
        const size_t control = text[i] == '\n' ? 0 : cli_control_bytes(text + i, length - i);
        putchar(control > 0 ? ' ' : text[i]);
        i += control > 0 ? control : 1;
    }
}

/* Prints the metadata's beginning; a model proven closed has kilobytes of it. */
static void print_metadata(const stp_chunk_file_info *info)
{
    const char *text = info->metadata_json;
    size_t shown = info->metadata_bytes;
    if (shown > METADATA_SHOWN)
        for (shown = METADATA_SHOWN; shown > 0 && (text[shown] & 0xc0) == 0x80;)
            shown--; /* no part of a character */
    printf("\nmetadata       ");
    print_foreign(text, shown);
    if (shown < info->metadata_bytes)
        printf(" ... (%zu bytes: --json prints them)", (size_t)info->metadata_bytes);
    putchar('\n');
}

/* Prints nothing if the first view is the whole model. */
static void print_first_view(const stp_chunk_file_info *info)
{
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *first = cJSON_GetObjectItemCaseSensitive(metadata, "first_view");
    const cJSON *why = cJSON_GetObjectItemCaseSensitive(first, "why");
    const cJSON *eye = cJSON_GetObjectItemCaseSensitive(first, "eye");
    double at[3];
    for (int i = 0; i < 3; i++) {
        const cJSON *number = cJSON_GetArrayItem(eye, i);
        at[i] = cJSON_IsNumber(number) ? number->valuedouble : NAN;
    }
    if (cJSON_IsString(why) && isfinite(at[0] + at[1] + at[2]))
        printf("first view     from %.6g %.6g %.6g: %s\n", at[0], at[1], at[2],
               strcmp(why->valuestring, "scanner") == 0    ? "where the scanner was"
               : strcmp(why->valuestring, "interior") == 0 ? "inside"
               : strcmp(why->valuestring, "main") == 0     ? "all but what lies far away"
               : strcmp(why->valuestring, "part") == 0     ? "the part with the most points"
               : strcmp(why->valuestring, "side") == 0     ? "the broad side of a flat thing"
                                                           : "for another reason");
    cJSON_Delete(metadata);
}

/* Prints "3 strips, 120 vertices, 117 segments", as prep counted, without the samples of points. */
static void print_shapes(const stp_chunk_file_info *info)
{
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *lines = cJSON_GetObjectItemCaseSensitive(metadata, "lines");
    const cJSON *strips = cJSON_GetObjectItemCaseSensitive(lines, "strips");
    const cJSON *vertices = cJSON_GetObjectItemCaseSensitive(lines, "vertices");
    const cJSON *segments = cJSON_GetObjectItemCaseSensitive(lines, "segments");
    const cJSON *samples = cJSON_GetObjectItemCaseSensitive(lines, "samples");
    if (cJSON_IsNumber(strips) && cJSON_IsNumber(vertices) && cJSON_IsNumber(segments) &&
        cJSON_IsNumber(samples))
        printf("lines          %.0f strips, %.0f vertices, %.0f segments; %.0f of the points are "
               "theirs\n",
               strips->valuedouble, vertices->valuedouble, segments->valuedouble,
               samples->valuedouble);
    const cJSON *triangles = cJSON_GetObjectItemCaseSensitive(metadata, "triangles");
    if (cJSON_IsNumber(triangles))
        printf("triangles      %.0f; %.0f of the points are their corners\n",
               triangles->valuedouble, 3.0 * triangles->valuedouble);
    cJSON_Delete(metadata);
}

/* Says that a file was repaired, so that nobody takes it for a whole one. */
static void print_repairs(const stp_chunk_file_info *info)
{
    stp_repair_sum sum = stp_repair_note_sum(info->metadata_json);
    if (sum.repairs > 0)
        printf("repaired       %" PRIu32
               " time%s: %.0f points are lost, %.0f of the points stand in "
               "for such\n",
               sum.repairs, sum.repairs == 1 ? "" : "s", sum.points_lost, sum.stand_ins);
}

static void print_text(const stp_chunk_file *file, const file_facts *facts)
{
    const depth_summary *depths = facts->depths;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    char codecs[64];
    printf("file           %s\n", stp_chunk_file_path(file));
    printf("version        %u.%u\n", info->version_major, info->version_minor);
    printf("points         %" PRIu64 "\n", info->point_count);
    print_shapes(info);
    print_repairs(info);
    printf("chunks         %" PRIu32 " in %" PRIu32 " level%s\n", info->chunk_count, info->depth,
           info->depth == 1 ? "" : "s");
    if (info->block_count > 0)
        printf("blocks         %" PRIu64 "\n", info->block_count);
    name_codecs(depths, info->depth, codecs);
    printf("codec          %s\n", codecs);
    printf("bytes          %" PRIu64 ", %.2f a point\n", info->file_bytes,
           (double)info->file_bytes / (double)info->point_count);
    if (facts->unused_bytes > 0)
        printf("unused         %" PRIu64
               " bytes, left by prep --append: convert makes a file without them\n",
               facts->unused_bytes);
    print_attributes(info->attributes, &facts->extra);
    print_intensity(info);
    print_outliers(info);
    print_displacement(info);
    print_first_view(info);
    printf("orientation    %s\n", stp_orientation_name(info->orientation));
    printf("lambda         %g\n", info->lambda);
    printf("box            %.17g %.17g %.17g\n", info->box.min.x, info->box.min.y, info->box.min.z);
    printf("               %.17g %.17g %.17g\n", info->box.max.x, info->box.max.y, info->box.max.z);
    if (stp_chunk_file_threshold(info) > 0.0)
        printf("threshold      %g px by default\n", stp_chunk_file_threshold(info));
    print_depths(depths, info->depth);
    if (facts->bytes)
        info_bytes_print(facts->bytes, info);
    print_metadata(info);
}

/* ---- JSON ---- */

static cJSON *numbers(const double *values, int count)
{
    return cJSON_CreateDoubleArray(values, count);
}

static cJSON *json_depth(const depth_summary *sum)
{
    cJSON *out = cJSON_CreateObject();
    double samples[STP_LEVEL_COUNT];
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        samples[l] = (double)sum->sample_count[l];
    cJSON_AddNumberToObject(out, "chunks", sum->chunk_count);
    cJSON_AddNumberToObject(out, "patches", (double)sum->patch_count);
    cJSON_AddItemToObject(out, "samples", numbers(samples, STP_LEVEL_COUNT));
    cJSON_AddNumberToObject(out, "payload_bytes", (double)sum->payload_bytes);
    cJSON_AddItemToObject(out, "error", numbers(sum->error, STP_LEVEL_COUNT));
    cJSON_AddItemToObject(out, "tangential_error", numbers(sum->tangential_error, STP_LEVEL_COUNT));
    cJSON_AddItemToObject(out, "colour_error", numbers(sum->colour_error, STP_LEVEL_COUNT));
    cJSON_AddNumberToObject(out, "radius_min", sum->radius_min);
    cJSON_AddNumberToObject(out, "radius_max", sum->radius_max);
    return out;
}

static cJSON *json_attributes(uint32_t attributes)
{
    cJSON *out = cJSON_CreateArray();
    cJSON_AddItemToArray(out, cJSON_CreateString("normal"));
    if (attributes & STP_HAS_COLOUR)
        cJSON_AddItemToArray(out, cJSON_CreateString("colour"));
    if (attributes & STP_HAS_INTENSITY)
        cJSON_AddItemToArray(out, cJSON_CreateString("intensity"));
    if (attributes & STP_HAS_CLASS)
        cJSON_AddItemToArray(out, cJSON_CreateString("class"));
    if (attributes & STP_HAS_OUTLIERS)
        cJSON_AddItemToArray(out, cJSON_CreateString("outlier"));
    if (attributes & STP_HAS_LINES)
        cJSON_AddItemToArray(out, cJSON_CreateString("lines"));
    if (attributes & STP_HAS_TRIANGLES)
        cJSON_AddItemToArray(out, cJSON_CreateString("triangles"));
    return out;
}

static cJSON *json_info(const char *path, const stp_chunk_file_info *info,
                        const depth_summary *depths)
{
    cJSON *out = cJSON_CreateObject();
    char version[16], codecs[64];
    const double low[3] = {info->box.min.x, info->box.min.y, info->box.min.z};
    const double high[3] = {info->box.max.x, info->box.max.y, info->box.max.z};
    snprintf(version, sizeof version, "%u.%u", info->version_major, info->version_minor);
    cJSON_AddStringToObject(out, "file", path);
    cJSON_AddStringToObject(out, "version", version);
    cJSON_AddNumberToObject(out, "points", (double)info->point_count);
    cJSON_AddNumberToObject(out, "chunks", info->chunk_count);
    cJSON_AddNumberToObject(out, "blocks", (double)info->block_count);
    cJSON_AddNumberToObject(out, "depth", info->depth);
    cJSON_AddNumberToObject(out, "file_bytes", (double)info->file_bytes);
    cJSON_AddNumberToObject(out, "bytes_per_point",
                            (double)info->file_bytes / (double)info->point_count);
    cJSON_AddItemToObject(out, "attributes", json_attributes(info->attributes));
    cJSON_AddStringToObject(out, "orientation", stp_orientation_name(info->orientation));
    cJSON_AddNumberToObject(out, "lambda", info->lambda);
    cJSON_AddItemToObject(out, "box_min", numbers(low, 3));
    cJSON_AddItemToObject(out, "box_max", numbers(high, 3));
    if (stp_chunk_file_threshold(info) > 0.0)
        cJSON_AddNumberToObject(out, "threshold_px", stp_chunk_file_threshold(info));
    name_codecs(depths, info->depth, codecs);
    cJSON_AddStringToObject(out, "codec", codecs);
    cJSON *list = cJSON_AddArrayToObject(out, "depths");
    for (uint32_t d = 0; d < info->depth; d++)
        cJSON_AddItemToArray(list, json_depth(&depths[d]));
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *displacement = cJSON_GetObjectItemCaseSensitive(metadata, "displacement");
    if (displacement)
        cJSON_AddItemToObject(out, "displacement", cJSON_Duplicate(displacement, true));
    cJSON_AddItemToObject(out, "metadata", metadata ? metadata : cJSON_CreateNull());
    return out;
}

/* Adds "extra_attributes": the list as the file has it. */
static stp_status add_extra(cJSON *json, const stp_attribute_list *extra, stp_error *err)
{
    char *text = NULL;
    stp_status status = stp_attribute_list_write(extra, &text, err);
    if (status == STP_OK)
        cJSON_AddItemToObject(json, "extra_attributes", cJSON_Parse(text));
    free(text);
    return status;
}

static stp_status print_json(const stp_chunk_file *file, const file_facts *facts, stp_error *err)
{
    const char *path = stp_chunk_file_path(file);
    cJSON *json = json_info(path, stp_chunk_file_get_info(file), facts->depths);
    if (facts->bytes)
        info_bytes_json(facts->bytes, json);
    if (facts->unused_bytes > 0)
        cJSON_AddNumberToObject(json, "unused_bytes", (double)facts->unused_bytes);
    const stp_status status = add_extra(json, &facts->extra, err);
    char *text = cJSON_Print(json);
    cJSON_Delete(json);
    if (status != STP_OK) {
        free(text);
        return status;
    }
    if (!text)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the JSON of %s", path);
    printf("%s\n", text);
    free(text);
    return STP_OK;
}

static int run(int argc, char **argv)
{
    const char *path = NULL;
    bool json = false, no_sandbox = false, count_bytes = false;
    info_bytes bytes = {0};
    double timeout_s = SOURCE_TIMEOUT_S;
    size_t count = 0;
    cli_common common = {0};
    stp_chunk_file *file = NULL;
    file_facts facts = {0};
    stp_attribute_file *attributes = NULL;
    stp_status status = STP_OK;
    stp_error err = {0};
    const cli_option options[] = {
        source_options_timeout(&timeout_s),
        sandbox_options_off(&no_sandbox),
        {.name = "--bytes",
         .kind = CLI_FLAG,
         .target = &count_bytes,
         .help = "what the bytes hold, by attribute; decodes every chunk"},
        {.name = "--json", .kind = CLI_FLAG, .target = &json, .help = "as one JSON object"},
    };
    int code = cli_parse(&cli_info, options, sizeof options / sizeof *options, argc, argv, &path, 1,
                         1, &count, &common);
    if (code != CLI_CONTINUE)
        return code;
    STP_TRY(sandbox_options_enter(no_sandbox, path, NULL, &err));
    const stp_byte_source_params source = source_options_params(NULL, 0, timeout_s);
    STP_TRY(source_options_open(&file, path, &source, &err));
    STP_TRY(summarise(file, &facts.depths, &err));
    if (stp_attribute_file_open(&attributes, file, &err) == STP_OK)
        facts.extra = *stp_attribute_file_list(attributes);
    else /* damage of a part leaves the rest to be told */
        fprintf(stderr, "attributes are not told: %s\n", err.message);
    if (stp_free_ranges_sum(file, &facts.unused_bytes, &err) != STP_OK)
        fprintf(stderr, "unused bytes are not told: %s\n", err.message);
    if (count_bytes)
        STP_TRY(info_bytes_count(file, &bytes, &err));
    facts.bytes = count_bytes ? &bytes : NULL;
    if (json)
        STP_TRY(print_json(file, &facts, &err));
    else
        print_text(file, &facts);
done:
    free(facts.depths);
    stp_attribute_file_close(&attributes);
    stp_chunk_file_close(&file);
    return status == STP_OK ? CLI_DONE : cli_fail(&cli_info, &err);
}
