/* Writes the facts of a run as JSON. */
#include "preprocess/prep_metadata.h"

#include "base/json.h"
#include "formats/chunk/sample/normal_grid.h"

#include <cjson/cJSON.h>
#include <string.h>

/* Whether the first file has the same note. */
static bool is_repeated(const stp_prep_source *source, const stp_scan_note *note)
{
    const stp_prep_file *first = &source->files[0];
    for (uint32_t i = 0; i < first->note_count; i++)
        if (strcmp(first->notes[i].name, note->name) == 0)
            return strcmp(first->notes[i].text, note->text) == 0;
    return false;
}

static cJSON *source_json(const stp_prep_source *source, size_t i)
{
    const stp_prep_file *file = &source->files[i];
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "name", file->name);
    cJSON_AddNumberToObject(json, "points", (double)file->point_count);
    if (file->unreadable)
        cJSON_AddBoolToObject(json, "unreadable", true);
    for (uint32_t n = 0; n < file->note_count; n++)
        if (i == 0 || !is_repeated(source, &file->notes[n]))
            cJSON_AddStringToObject(json, file->notes[n].name, file->notes[n].text);
    return json;
}

static void add_displacement(cJSON *root, const stp_displacement *d, const stp_resolution *r)
{
    if (d->points == 0)
        return;
    cJSON *to = cJSON_AddObjectToObject(root, "displacement");
    cJSON_AddNumberToObject(to, "greatest", d->greatest);
    cJSON_AddNumberToObject(to, "mean", stp_displacement_mean(d));
    cJSON_AddNumberToObject(to, "beyond", (double)d->beyond);
    if (r->exact)
        cJSON_AddNumberToObject(to, "changed", (double)d->changed);
}

static void add_joined(cJSON *root, const stp_prep_stats *stats)
{
    if (!stats->join_layers)
        return;
    cJSON *joined = cJSON_AddObjectToObject(root, "joined");
    cJSON_AddNumberToObject(joined, "greatest", stats->joined.greatest);
    cJSON_AddNumberToObject(joined, "mean", stats->joined.mean);
}

/* What maps stand for, and how far points are from the stored surface. */
static void add_resampled(cJSON *root, const stp_prep_facts *f, const stp_tree_stats *tree)
{
    const stp_maps_counts *m = &f->stats->maps;
    if (!f->stats->makes_maps)
        return;
    cJSON *to = cJSON_AddObjectToObject(root, "resampled");
    cJSON_AddNumberToObject(to, "represented", (double)m->represented);
    cJSON_AddNumberToObject(to, "as_points", (double)m->as_points);
    cJSON_AddNumberToObject(to, "rejected",
                            (double)(f->stats->points_in - m->represented - m->as_points));
    cJSON_AddNumberToObject(to, "maps", (double)m->maps);
    cJSON_AddNumberToObject(to, "samples", (double)m->samples);
    cJSON_AddNumberToObject(to, "cone_deg", f->cone_deg);
    cJSON_AddNumberToObject(to, "greatest", stp_prep_maps_greatest(m, tree));
    cJSON_AddNumberToObject(to, "mean", stp_prep_maps_mean(m, tree));
    if (!f->stats->fills_gaps)
        return;
    cJSON_AddNumberToObject(to, "between", (double)m->between);
    cJSON_AddNumberToObject(to, "open_edges", (double)m->open_edges);
}

static void add_intensity(cJSON *root, const stp_prep_source *source, const stp_prep_stats *stats)
{
    if ((source->attributes & STP_POINT_HAS_INTENSITY) == 0)
        return;
    cJSON_AddNumberToObject(root, "intensity_max", stats->intensity_max);
    if (source->intensity_full > 0.0)
        stp_json_add_number(root, "intensity_full", source->intensity_full);
}

/* Adds the first view; nothing if the whole model is shown. */
static void add_first_view(cJSON *root, const stp_first_camera *first)
{
    static const char *const words[] = {
        [STP_FIRST_SCANNER] = "scanner", [STP_FIRST_INTERIOR] = "interior",
        [STP_FIRST_MAIN] = "main",       [STP_FIRST_PART] = "part",
        [STP_FIRST_SIDE] = "side",
    };
    if (first->why == STP_FIRST_WHOLE)
        return;
    cJSON *json = cJSON_AddObjectToObject(root, "first_view");
    stp_json_add_vector(json, "eye", first->eye);
    stp_json_add_vector(json, "look", first->look);
    stp_json_add_vector(json, "up", first->up);
    stp_json_add_number(json, "fovy_deg", first->fovy_deg);
    stp_json_add_number(json, "aspect", first->aspect);
    cJSON_AddStringToObject(json, "why", words[first->why]);
}

static void add_grids(cJSON *root, const stp_prep_stats *stats)
{
    if (stats->keeps_grid)
        cJSON_AddBoolToObject(root, "grid", true);
    if (stats->holes_grow)
        cJSON_AddStringToObject(root, "holes", "grow");
    if (stats->images > 0 && stats->images_turned % stats->images == 0)
        cJSON_AddBoolToObject(root, "turned", stats->images_turned > 0);
}

static void add_resolution(cJSON *root, const stp_resolution *resolution)
{
    cJSON_AddNumberToObject(root, "precision", resolution->precision);
    if (resolution->exact)
        cJSON_AddBoolToObject(root, "exact", true);
}

static void add_normal_grid(cJSON *root, const stp_prep_stats *stats)
{
    if (stats->normal_bits == 0)
        return;
    cJSON_AddNumberToObject(root, "normal_bits", stats->normal_bits);
    if (stats->normal_step != stp_normal_bits_step(stats->normal_bits))
        cJSON_AddNumberToObject(root, "normal_step", stats->normal_step);
}

char *stp_prep_metadata(void *context, const stp_tree_stats *tree)
{
    const stp_prep_facts *f = context;
    const stp_prep_source *source = f->source;
    const stp_prep_stats *stats = f->stats;
    const stp_dvec3 *stations = f->stations;
    cJSON *root = cJSON_CreateObject();
    cJSON *sources = cJSON_AddArrayToObject(root, "sources");
    for (size_t i = 0; i < source->file_count; i++)
        cJSON_AddItemToArray(sources, source_json(source, i));
    cJSON *rejected = cJSON_AddObjectToObject(root, "rejected");
    for (int r = STP_REJECT_NOT_FINITE; r < STP_REJECT_COUNT; r++)
        if (stats->rejected[r] > 0 || r == STP_REJECT_NOT_FINITE)
            cJSON_AddNumberToObject(rejected, stp_reject_name((stp_reject)r),
                                    (double)stats->rejected[r]);
    if (stats->outliers != STP_OUTLIERS_KEEP) {
        cJSON *outliers = cJSON_AddObjectToObject(root, "outliers");
        cJSON_AddNumberToObject(outliers, "distance", stats->outlier_distance);
        cJSON_AddNumberToObject(outliers,
                                stats->outliers == STP_OUTLIERS_MARK ? "marked" : "dropped",
                                (double)stats->outlier_count);
    }
    if (stats->lines.strips > 0) {
        cJSON *lines = cJSON_AddObjectToObject(root, "lines");
        cJSON_AddNumberToObject(lines, "strips", (double)stats->lines.strips);
        cJSON_AddNumberToObject(lines, "vertices", (double)stats->lines.vertices);
        cJSON_AddNumberToObject(lines, "segments", (double)stats->lines.segments);
        cJSON_AddNumberToObject(lines, "samples", (double)stats->lines.samples);
    }
    if (stats->triangles.triangles > 0)
        cJSON_AddNumberToObject(root, "triangles", (double)stats->triangles.triangles);
    cJSON_AddNumberToObject(root, "neighbours", f->k);
    cJSON_AddNumberToObject(root, "lambda", f->lambda);
    add_resolution(root, &stats->resolution);
    add_grids(root, stats);
    add_normal_grid(root, stats);
    add_joined(root, stats);
    add_resampled(root, f, tree);
    add_displacement(root, &tree->displacement, &stats->resolution);
    add_intensity(root, source, stats);
    cJSON_AddStringToObject(root, "orientation", stp_orientation_name(stats->orientation));
    cJSON *list = stats->station_count ? cJSON_AddArrayToObject(root, "stations") : NULL;
    for (uint32_t i = 0; i < stats->station_count; i++) {
        const double xyz[3] = {stations[i].x, stations[i].y, stations[i].z};
        cJSON_AddItemToArray(list, cJSON_CreateDoubleArray(xyz, 3));
    }
    if (f->unlit)
        cJSON_AddStringToObject(root, "shade", "unlit");
    if (f->outside->point_count > 0)
        cJSON_AddItemToObject(root, "closed", stp_outside_to_json(f->outside));
    const stp_dvec3 told = stp_prep_told_up(source);
    const stp_dvec3 found = stats->first.model_up;
    const stp_dvec3 up = stp_dvec3_length(found) > 0.0 ? found : told;
    if (stp_dvec3_length(up) > 0.0)
        stp_json_add_vector(root, "up", up);
    add_first_view(root, &stats->first);
    char *text = cJSON_PrintUnformatted(root);
    cJSON_Delete(root);
    return text;
}
