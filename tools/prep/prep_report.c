/* The messages of prep. */
#include "tools/prep/prep_report.h"

#include "base/clock.h"
#include "base/file.h"
#include "formats/chunk/sample/normal_grid.h"
#include "tools/prep/prep_maps.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The number of stored samples: points, and vertices of lines and triangles as often as they are
 * stored. */
static double samples_of(const stp_prep_stats *s)
{
    return (double)(s->points_out + s->lines.samples + 3 * s->triangles.triangles);
}

typedef struct named_count {
    const char *name;
    uint64_t value;
} named_count;

static void add_counts(cJSON *to, const named_count *counts, size_t how_many)
{
    for (size_t i = 0; i < how_many; i++)
        cJSON_AddNumberToObject(to, counts[i].name, (double)counts[i].value);
}

#define ADD_COUNTS(to, counts) add_counts(to, counts, sizeof(counts) / sizeof *(counts))

static void add_lines(cJSON *to, const stp_line_counts *lines, const stp_edge_counts *edges)
{
    const named_count stored[] = {{"strips", lines->strips},
                                  {"vertices", lines->vertices},
                                  {"segments", lines->segments},
                                  {"samples", lines->samples},
                                  {"vertices_rejected", lines->rejected},
                                  {"edges_in", edges->read}};
    const named_count rejected[] = {{"no_vertex", edges->no_vertex},
                                    {"no_length", edges->no_length},
                                    {"repeated", edges->repeated},
                                    {"not_finite", edges->not_finite},
                                    {"of_faces", edges->of_faces}};
    ADD_COUNTS(to, stored);
    ADD_COUNTS(cJSON_AddObjectToObject(to, "edges_rejected"), rejected);
}

static void add_plants(cJSON *to, const stp_plant_report *plant)
{
    const named_count counts[] = {{"vertices_before", plant->vertices_before},
                                  {"positions_before", plant->positions_before},
                                  {"vertices_after", plant->vertices_after},
                                  {"triangles_in", plant->triangles},
                                  {"ribbon_triangles", plant->ribbon_triangles},
                                  {"tube_triangles", plant->tube_triangles},
                                  {"kept_triangles", plant->kept_triangles},
                                  {"ribbons", plant->ribbons},
                                  {"tubes", plant->tubes},
                                  {"rings", plant->rings}};
    ADD_COUNTS(to, counts);
}

static void add_displacement(cJSON *to, const stp_displacement *d)
{
    cJSON_AddNumberToObject(to, "greatest", d->greatest);
    cJSON_AddNumberToObject(to, "mean", stp_displacement_mean(d));
    cJSON_AddNumberToObject(to, "beyond", (double)d->beyond);
    cJSON_AddNumberToObject(to, "changed", (double)d->changed);
}

/* Bytes from rank to rank, by stage. */
static void add_ranks(cJSON *to, const stp_prep_stats *s)
{
    cJSON_AddNumberToObject(to, "ranks", s->rank_count);
    cJSON *sent = cJSON_AddObjectToObject(to, "stage_sent_bytes");
    for (int i = 0; i < STP_PREP_STAGE_COUNT; i++)
        if (s->stage_peak_bytes[i] > 0)
            cJSON_AddNumberToObject(sent, stp_prep_stage_names[i], (double)s->stage_sent_bytes[i]);
}

cJSON *prep_report_json(const stp_prep_stats *s, const prep_inputs *inputs)
{
    double points = (double)s->points_out;
    cJSON *root = cJSON_CreateObject();
    cJSON_AddNumberToObject(root, "points_in", (double)s->points_in);
    cJSON_AddNumberToObject(root, "points_out", points);
    cJSON *rejected = cJSON_AddObjectToObject(root, "rejected");
    for (int r = STP_REJECT_NOT_FINITE; r < STP_REJECT_COUNT; r++)
        cJSON_AddNumberToObject(rejected, stp_reject_name((stp_reject)r), (double)s->rejected[r]);
    cJSON *unreadable = cJSON_AddArrayToObject(root, "unreadable");
    for (size_t i = 0; i < inputs->count; i++) {
        if (!inputs->facts[i].why)
            continue;
        cJSON *input = cJSON_CreateObject();
        cJSON_AddStringToObject(input, "file", inputs->paths[i]);
        cJSON_AddStringToObject(input, "why", inputs->facts[i].why);
        cJSON_AddItemToArray(unreadable, input);
    }
    cJSON_AddNumberToObject(root, "outliers_marked",
                            s->outliers == STP_OUTLIERS_MARK ? (double)s->outlier_count : 0.0);
    cJSON_AddNumberToObject(root, "normals_grown", (double)s->normals_wide.grown);
    cJSON_AddNumberToObject(root, "normals_averaged", (double)s->normals_wide.averaged);
    cJSON_AddNumberToObject(root, "normals_seen", (double)s->normals_seen);
    cJSON_AddNumberToObject(root, "normal_bits", s->normal_bits);
    cJSON_AddNumberToObject(root, "normal_error_deg", s->normals_wide.normal_error * 180.0 / M_PI);
    add_lines(cJSON_AddObjectToObject(root, "lines"), &s->lines, &inputs->edges);
    if (inputs->plants)
        add_plants(cJSON_AddObjectToObject(root, "plants"), &inputs->plant);
    cJSON_AddNumberToObject(root, "triangles", (double)s->triangles.triangles);
    cJSON_AddNumberToObject(root, "triangles_rejected", (double)s->triangles.rejected);
    add_displacement(cJSON_AddObjectToObject(root, "displacement"), &s->tree.displacement);
    if (s->join_layers) {
        cJSON *joined = cJSON_AddObjectToObject(root, "joined");
        cJSON_AddNumberToObject(joined, "greatest", s->joined.greatest);
        cJSON_AddNumberToObject(joined, "mean", s->joined.mean);
    }
    prep_maps_json(root, s);
    cJSON_AddNumberToObject(root, "chunks", s->tree.chunk_count);
    cJSON_AddNumberToObject(root, "patches", (double)s->tree.patch_count);
    cJSON_AddNumberToObject(root, "seconds", s->seconds);
    cJSON_AddNumberToObject(root, "points_per_second", points / s->seconds);
    cJSON_AddNumberToObject(root, "peak_rss_bytes", (double)stp_peak_rss_bytes());
    cJSON_AddNumberToObject(root, "temporary_bytes", (double)s->temporary_bytes);
    cJSON_AddNumberToObject(root, "file_bytes", (double)s->tree.file_bytes);
    cJSON_AddNumberToObject(root, "bytes_per_point", (double)s->tree.file_bytes / samples_of(s));
    cJSON_AddNumberToObject(root, "points_closed", (double)s->closed_count);
    cJSON *stages = cJSON_AddObjectToObject(root, "stages");
    for (int i = 0; i < STP_PREP_STAGE_COUNT; i++)
        if (s->stage_peak_bytes[i] > 0)
            cJSON_AddNumberToObject(stages, stp_prep_stage_names[i], s->stage_seconds[i]);
    cJSON *peaks = cJSON_AddObjectToObject(root, "stage_peak_rss_bytes");
    for (int i = 0; i < STP_PREP_STAGE_COUNT; i++)
        if (s->stage_peak_bytes[i] > 0)
            cJSON_AddNumberToObject(peaks, stp_prep_stage_names[i], (double)s->stage_peak_bytes[i]);
    if (s->rank_count > 0)
        add_ranks(root, s);
    return root;
}

static void print_orientation(const stp_prep_stats *s)
{
    static const char *const words[] = {"unknown: drawn two-sided", "from the file",
                                        "from the scanner's position", "propagated and proven",
                                        "known in part"};
    static const char *const views[] = {[STP_FIRST_SCANNER] = "from where the scanner was",
                                        [STP_FIRST_INTERIOR] = "from inside",
                                        [STP_FIRST_MAIN] = "of all but what lies far away",
                                        [STP_FIRST_PART] =
                                            ("of the part that has the most points; others lie far "
                                             "away (--view whole shows all)"),
                                        [STP_FIRST_SIDE] = "of the broad side"};
    if (s->orientation == STP_ORIENTATION_POSITION && s->station_count > 1)
        fprintf(stderr, "orientation from %u scanner positions", s->station_count);
    else
        fprintf(stderr, "orientation %s", words[s->orientation]);
    if (s->closed_count > 0)
        fprintf(stderr, "; the backs of %.1f %% of the points are hidden: they are left out",
                100.0 * (double)s->closed_count / (double)s->points_out);
    if (s->points_unstationed > 0)
        fprintf(stderr, "; %" PRIu64 " points name no scanner whose position is known",
                s->points_unstationed);
    fprintf(stderr, "\n");
    if (s->line_neighbours > 0)
        fprintf(stderr, "points lie in scan lines: %u neighbours each tell of the surface\n",
                s->line_neighbours);
    if (s->stations_refused > 0)
        fprintf(stderr,
                "scanner positions of %" PRIu32 " file%s are not used: the points cannot have "
                "been seen from there\n",
                s->stations_refused, s->stations_refused > 1 ? "s" : "");
    if (s->intensity_greatest > s->intensity_max)
        fprintf(stderr,
                "intensities of more than %.2g %% of the greatest are stored as white: they are "
                "less than 1 %% of all (--attributes intensity keeps the numbers)\n",
                100.0 * s->intensity_max / s->intensity_greatest);
    if (s->first.why != STP_FIRST_WHOLE)
        fprintf(stderr, "first view %s\n", views[s->first.why]);
}

/* Prints " (3 not finite, 10 without return)". */
static void print_rejects(const stp_prep_stats *s)
{
    static const char *const words[STP_REJECT_COUNT] = {
        [STP_REJECT_NOT_FINITE] = "not finite",
        [STP_REJECT_NO_RETURN] = "without a return",
        [STP_REJECT_INVALID] = "marked invalid",
        [STP_REJECT_OUTLIER] = "outliers",
        [STP_REJECT_OUTSIDE] = "outside of --bounds",
        [STP_REJECT_WHERE] = "not as --where says",
        [STP_REJECT_LOST] = "lost",
        [STP_REJECT_TWICE] = "at a place of another file",
        [STP_REJECT_ORIGIN] = "at exactly (0, 0, 0), as holes of images are",
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

/* Prints the share of outliers, "0.012 %", in the records that could have been stored. */
static void print_outliers(const stp_prep_stats *s)
{
    bool marked = s->outliers == STP_OUTLIERS_MARK;
    double points = (double)(s->points_out + (marked ? 0 : s->outlier_count));
    if (s->outliers == STP_OUTLIERS_KEEP)
        return;
    fprintf(stderr,
            "outliers: %" PRIu64 " %s (%.3g %%), more than %g local spacings from everything else, "
            "alone or in small groups\n",
            s->outlier_count, marked ? "marked" : "dropped",
            100.0 * (double)s->outlier_count / points, s->outlier_distance);
}

/* Prints how far stored positions are off, and what to do if they are less exact than the input. */
static void print_displacement(const stp_prep_stats *s)
{
    const stp_displacement *d = &s->tree.displacement;
    const stp_resolution *r = &s->resolution;
    if (d->points == 0)
        return;
    fprintf(stderr, "stored positions are off by at most %.3g, by %.3g on average\n", d->greatest,
            stp_displacement_mean(d));
    if (r->exact && d->changed == 0)
        fprintf(stderr, "every stored position rounds to the very number that was read\n");
    else if (r->exact)
        fprintf(stderr,
                "%" PRIu64
                " stored positions do not round to the very numbers that were read: a patch "
                "has no bits for digits far below the distance to the next point\n",
                d->changed);
    else if (d->beyond > 0 && r->precision > 0.0)
        fprintf(
            stderr, "%" PRIu64 " of them are off by more than %.3g, %s: %s\n", d->beyond,
            r->precision,
            r->precision == 0.5 * r->step ? "half the input's own scale" : "the precision given",
            s->keeps_grid ? "a grid's samples lie too far apart for finer steps, also with "
                            "--precision exact"
            : 2 * d->beyond > d->points
                ? "that is so far below the distance between neighbours that a disc's size leaves "
                  "no bits for it"
                : "their neighbours are too far for a disc's size and finer steps; give "
                  "--precision exact, which makes such discs smaller, or --outliers drop");
    else if (d->beyond > 0)
        fprintf(stderr,
                "%" PRIu64
                " of them are off by more than 1/32 of the distance to their neighbours: "
                "the model is too wide for finer steps; split it, or give --outliers drop\n",
                d->beyond);
}

/* Prints the grid of normals, if they were rounded. */
static void print_normal_bits(const stp_prep_stats *s)
{
    const double error_deg = s->normals_wide.normal_error * 180.0 / M_PI;
    if (s->normal_bits == 0 || s->normal_bits >= STP_NORMAL_BITS)
        return;
    fprintf(stderr, "normals are rounded to 2 x %.3g bits, by at most %.2g degrees",
            STP_NORMAL_BITS - log2(s->normal_step),
            stp_normal_step_angle(s->normal_step) * 180.0 / M_PI);
    if (error_deg > 0.0)
        fprintf(stderr, "; noise makes half of them wrong by %.2g degrees or more", error_deg);
    fprintf(stderr, "\n");
}

/* Prints "3 of 90 edges are left out: 1 join a vertex with itself, 2 are there already". */
static void print_edges(const stp_edge_counts *e)
{
    const struct {
        uint64_t count;
        const char *what;
    } reasons[] = {{e->no_vertex, "name a vertex that does not exist"},
                   {e->no_length, "join a vertex with itself"},
                   {e->repeated, "are there already"},
                   {e->not_finite, "end where a coordinate is not finite"},
                   {e->of_faces, "are sides of faces"}};
    const uint64_t dropped =
        e->no_vertex + e->no_length + e->repeated + e->not_finite + e->of_faces;
    const char *separator = ": ";
    if (dropped == 0)
        return;
    fprintf(stderr, "%" PRIu64 " of %" PRIu64 " edges are left out", dropped, e->read);
    for (size_t i = 0; i < sizeof reasons / sizeof *reasons; i++) {
        if (reasons[i].count == 0)
            continue;
        fprintf(stderr, "%s%" PRIu64 " %s", separator, reasons[i].count, reasons[i].what);
        separator = ", ";
    }
    fprintf(stderr, "\n");
}

static void print_plant(const stp_plant_report *p)
{
    fprintf(stderr,
            "plants: %" PRIu64 " ribbons out of %" PRIu64 " triangles, %" PRIu64
            " tubes of %" PRIu64 " rings out of %" PRIu64 ", %" PRIu64 " triangles stay; %" PRIu64
            " vertices were %" PRIu64 "\n",
            p->ribbons, p->ribbon_triangles, p->tubes, p->rings, p->tube_triangles,
            p->kept_triangles, p->vertices_after, p->vertices_before);
}

static void print_shapes(const stp_prep_stats *s, const prep_inputs *inputs)
{
    const stp_line_counts *l = &s->lines;
    if (l->strips > 0)
        fprintf(stderr,
                "lines: %" PRIu64 " of %" PRIu64 " vertices and %" PRIu64 " segments are stored\n",
                l->strips, l->vertices, l->segments);
    if (l->rejected > 0)
        fprintf(stderr,
                "%" PRIu64 " vertices of lines are not finite: left out, the lines are cut there\n",
                l->rejected);
    print_edges(&inputs->edges);
    if (inputs->plants)
        print_plant(&inputs->plant);
    if (s->triangles.triangles > 0)
        fprintf(stderr, "%" PRIu64 " triangles are stored\n", s->triangles.triangles);
    if (s->triangles.rejected > 0)
        fprintf(stderr, "%" PRIu64 " triangles are left out: a corner is not finite\n",
                s->triangles.rejected);
}

static void print_row(const char *stage, const char *seconds, const char *rate, const char *memory)
{
    fprintf(stderr, "  %-12s %10s %12s %14s\n", stage, seconds, rate, memory);
}

static void print_stage(const char *name, double seconds, uint64_t points, uint64_t peak_bytes)
{
    char time[32], rate[32] = "-", memory[32];
    snprintf(time, sizeof time, "%.2f", seconds);
    if (seconds > 0.0)
        snprintf(rate, sizeof rate, "%.2f M", 1e-6 * (double)points / seconds);
    snprintf(memory, sizeof memory, "%.2f GiB", (double)peak_bytes / 0x1p30);
    print_row(name, time, rate, memory);
}

/* Prints what system the points were brought to. */
static void print_system(const prep_inputs *in)
{
    const stp_projection *way = NULL;
    size_t count = 0, scaled = 0, unknown = 0, guessed = 0;
    for (size_t i = 0; i < in->count; i++) {
        const prep_way *this = &in->facts[i].way;
        unknown += this->unknown && !in->facts[i].why;
        if (!this->projection || in->facts[i].why)
            continue;
        way = way ? way : this->projection;
        count++;
        scaled += stp_projection_height_unit(this->projection) != 1.0;
        guessed += this->guessed;
    }
    if (guessed > 0)
        fprintf(stderr,
                "%zu of %zu inputs name no coordinate system, and their x and y are degrees: taken "
                "for longitude and latitude of WGS 84 (a .prj file names another system; --columns "
                "lat,lon,z another order of text)\n",
                guessed, in->count);
    if (way)
        fprintf(stderr, "%zu of %zu inputs brought to %s; heights %s\n", count, in->count,
                stp_projection_name(way), scaled > 0 ? "to its unit" : "as they are");
    if (unknown > 0)
        fprintf(stderr,
                "%zu of %zu inputs name a system that PROJ does not know: taken for that of the "
                "others (--to names one)\n",
                unknown, in->count);
}

void prep_report_points(const stp_prep_stats *s, const prep_inputs *inputs)
{
    fprintf(stderr, "%" PRIu64 " points read, %" PRIu64 " stored, %" PRIu64 " rejected",
            s->points_in, s->points_out, s->points_in - s->points_out);
    print_rejects(s);
    print_system(inputs);
    print_shapes(s, inputs);
    print_outliers(s);
    if (s->points_uncoloured > 0)
        fprintf(stderr,
                "%" PRIu64 " points have no colour, though others do: they are black in the input, "
                "light grey here\n",
                s->points_uncoloured);
    if (s->normals_wide.averaged > 0)
        fprintf(stderr,
                "%" PRIu64
                " normals of the input are averaged with their neighbours': they are noisy, "
                "near points' differ as much as farther ones'\n",
                s->normals_wide.averaged);
    if (inputs->colours_missing[0] != '\0')
        fprintf(stderr, "a mesh lacks its colours: %s\n", inputs->colours_missing);
    if (inputs->coarse)
        fprintf(stderr, "%s has large faces: %s (--sample none: its vertices alone)\n",
                inputs->coarse,
                s->points_in > 0 ? "points are spread over them, and the largest stay triangles"
                                 : "they stay triangles");
    if (inputs->loose_left_out > 0)
        fprintf(stderr,
                "%" PRIu64 " vertices without a face are left out (--sample none keeps them)\n",
                inputs->loose_left_out);
    if (inputs->suspect)
        fprintf(
            stderr,
            "%s looks like a plant: --lines auto turns its leaves into ribbons and its branches "
            "into tubes\n",
            inputs->suspect);
    else if (s->normals_wide.averaged > 0 && !s->join_layers)
        fprintf(stderr,
                "if these are overlapping scans, --layers joined moves them onto one surface "
                "and sharpens the picture\n");
    if (s->join_layers)
        fprintf(stderr,
                "layers are joined: points were moved by at most %.3g, by %.3g on average\n",
                s->joined.greatest, s->joined.mean);
    if (s->images > 0 && s->pixels_loose > 0)
        fprintf(stderr,
                "%" PRIu64 " points lie off the rays of their images, or in none: they are points "
                "beside them\n",
                s->pixels_loose);
    prep_report_doubts(s, inputs);
    prep_maps_print(s);
    if (inputs->numbers.left_out[0] != '\0')
        fprintf(stderr, "not kept of the points: %s (--attributes all keeps them)\n",
                inputs->numbers.left_out);
    print_displacement(s);
    print_normal_bits(s);
}

/* Says why ranks did not share the points. */
static void print_whole(const stp_prep_stats *s)
{
    if (s->each_has_all)
        fprintf(stderr,
                "each of the %u ranks held all points: some part of the inputs could not be read "
                "by itself\n",
                s->rank_count);
}

void prep_report_stages(const stp_prep_stats *s)
{
    print_orientation(s);
    print_row("stage", "seconds", "points/s", "memory so far");
    for (int i = 0; i < STP_PREP_STAGE_COUNT; i++)
        if (s->stage_peak_bytes[i] > 0)
            print_stage(stp_prep_stage_names[i], s->stage_seconds[i], s->points_out,
                        s->stage_peak_bytes[i]);
    print_stage("all", s->seconds, s->points_out, stp_peak_rss_bytes());
    if (s->temporary_bytes > 0)
        fprintf(stderr, "temporary files: %.2f GB at most\n", 1e-9 * (double)s->temporary_bytes);
}

void prep_report_print(const stp_prep_stats *s, const prep_inputs *inputs)
{
    prep_report_points(s, inputs);
    fprintf(stderr, "%u chunks, %" PRIu64 " patches, %" PRIu64 " bytes (%.2f a point)\n",
            s->tree.chunk_count, s->tree.patch_count, s->tree.file_bytes,
            (double)s->tree.file_bytes / samples_of(s));
    print_whole(s);
    prep_report_stages(s);
}

/* Heights in many times the units of columns are depths, more often than not. */
#define TALL 4.0

/* Says which heights look like holes that nobody told of. */
static void print_odd_heights(const stp_prep_stats *s, const char *path)
{
    const char *separator = "";
    if (!(s->odd_shares[0] + s->odd_shares[1] > 0.0))
        return;
    fprintf(stderr, "%s: ", path);
    for (int i = 0; i < 2; i++) {
        if (!(s->odd_shares[i] > 0.0))
            continue;
        fprintf(stderr, "%s%.2g %% of its heights are exactly %.9g", separator,
                100.0 * s->odd_shares[i], s->odd_heights[i]);
        separator = ", ";
    }
    fprintf(stderr, ", far from all others: if that means no sample, give prep --invalid and the "
                    "file's number; if this is a depth camera's image, --pinhole fx,fy,cx,cy\n");
}

/* Says what a reader had to assume: las_notes.c, grid/depth_guess.h, grid/relief_guess.h. */
static void print_notes(const prep_inputs *inputs)
{
    static const char *const names[] = {"counts", "scales", "camera", "spacing", "order"};
    for (size_t i = 0; inputs->files && i < inputs->count; i++)
        for (uint32_t k = 0; k < inputs->files[i].note_count; k++)
            for (size_t n = 0; n < sizeof names / sizeof *names; n++)
                if (strcmp(inputs->files[i].notes[k].name, names[n]) == 0)
                    fprintf(stderr, "%s: %s\n", inputs->paths[i], inputs->files[i].notes[k].text);
}

void prep_report_doubts(const stp_prep_stats *s, const prep_inputs *inputs)
{
    print_notes(inputs);
    const stp_dvec3 size = stp_dvec3_sub(s->box.max, s->box.min);
    const double width = fmax(size.x, size.y);
    print_odd_heights(s, inputs->paths[0]);
    if (s->keeps_grid && s->first.why == STP_FIRST_WHOLE && size.z > TALL * width)
        fprintf(stderr,
                "%s: its heights differ by %.3g times its width: if they are depths of a camera, "
                "give prep --pinhole fx,fy,cx,cy (--disparity F,B for disparities), else "
                "--height-scale or --spacing\n",
                inputs->paths[0], size.z / width);
}

void prep_report_unreadable(const prep_inputs *inputs)
{
    for (size_t i = 0; inputs->facts && i < inputs->count; i++)
        if (inputs->facts[i].why)
            fprintf(stderr, "not read: %s\n", inputs->facts[i].why);
}

void prep_report_sweep(const char *output)
{
    uint64_t bytes = 0, count = stp_output_sweep(output, &bytes);
    if (count > 0)
        fprintf(stderr,
                "%s: an earlier run was stopped before its end: removed %.1f MB of its files\n",
                output, 1e-6 * (double)bytes);
}

void prep_report_plan(const stp_prep_plan *plan)
{
    if (plan->temporary_bytes > 0)
        fprintf(stderr,
                "temporary files: about %.1f GB, at most %.1f GB if hardly any surface is found, "
                "in %s (%.1f GB free)\n",
                1e-9 * (double)plan->temporary_bytes, 1e-9 * (double)plan->most_temporary_bytes,
                plan->folder, 1e-9 * (double)plan->free_bytes);
}
