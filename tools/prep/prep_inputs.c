/* Makes many scans one source. */
#include "tools/prep/prep_inputs.h"

#include "base/memory.h"
#include "formats/scan/coordinate_step.h"
#include "tools/prep/prep_grids.h"
#include "tools/prep/prep_plants.h"
#include "tools/prep/prep_series.h"
#include "tools/prep/prep_stations.h"
#include "tools/prep/prep_twice.h"
#include "tools/prep/prep_web.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* What the file system says about a file; zero if it is no regular file. */
static prep_input facts_of(const char *path)
{
    struct stat facts;
    if (stat(path, &facts) != 0 || !S_ISREG(facts.st_mode))
        return (prep_input){0};
    return (prep_input){.device = facts.st_dev,
                        .inode = facts.st_ino,
                        .size = facts.st_size,
                        .changed = facts.st_mtim};
}

static stp_status check_unchanged(const prep_inputs *in, stp_error *err)
{
    prep_input now = facts_of(in->paths[in->current]);
    const prep_input *then = &in->facts[in->current];
    if (now.size == then->size && now.changed.tv_sec == then->changed.tv_sec &&
        now.changed.tv_nsec == then->changed.tv_nsec)
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s changed while it was read: run again when nothing writes to it",
                         in->paths[in->current]);
}

stp_scan_params prep_inputs_params(const prep_inputs *in, size_t i)
{
    stp_scan_params params = in->params;
    params.grid = prep_series_grid(in, i);
    params.mirror = in->facts[i].mirror;
    params.web = prep_web_params();
    params.sample_coarse = !in->vertices && !in->plants && !in->params.numbers;
    return params;
}

static void clear_notes(stp_prep_file *file)
{
    for (uint32_t n = 0; n < file->note_count; n++) {
        free((void *)file->notes[n].name);
        free((void *)file->notes[n].text);
    }
    free(file->notes);
    file->notes = NULL;
    file->note_count = 0;
}

/* True if only this file is at fault and other files are left. */
static bool may_leave_out(const prep_inputs *in, stp_status status)
{
    const bool own = status == STP_NOT_FOUND || status == STP_IO || status == STP_FORMAT ||
                     status == STP_CORRUPT || status == STP_VERSION || status == STP_UNSUPPORTED ||
                     status == STP_EMPTY;
    return own && in->count > 1 && !in->strict;
}

/* Leaves a file out. Nothing of it is stored, because half a scan looks like a whole one. */
static bool leave_out(prep_inputs *in, size_t i, const stp_error *why)
{
    if (!may_leave_out(in, why->status) ||
        stp_text_copy(&in->facts[i].why, why->message, "a message", NULL) != STP_OK)
        return false;
    in->files[i].point_count = 0;
    in->files[i].unreadable = true;
    clear_notes(&in->files[i]);
    return true;
}

static stp_status end_scan(prep_inputs *in, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(check_unchanged(in, err));
    in->stations_before += stp_scan_get_info(in->scan)->station_count;
    stp_scan_close(&in->scan);
    in->current++;
done:
    return status;
}

/* Opens the current input. */
static stp_status open_current(prep_inputs *in, stp_error *err)
{
    const stp_scan_params params = prep_inputs_params(in, in->current);
    stp_status status = stp_scan_open(&in->scan, in->paths[in->current], &params, err);
    if (status == STP_OK)
        prep_where_open(&in->where, stp_scan_get_info(in->scan));
    if (status == STP_OK && in->part_skip > 0)
        status = stp_scan_seek(in->scan, in->part_skip, err);
    in->part_skip = 0;
    return status;
}

static stp_status read_inputs(void *context, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    prep_inputs *in = context;
    stp_status status = STP_OK;
    *count = 0;
    if (in->in_part && in->part_left < capacity)
        capacity = (size_t)in->part_left;
    while (*count == 0 && capacity > 0 && in->current < in->count) {
        if (in->facts[in->current].why) {
            in->current++;
            continue;
        }
        if (in->facts[in->current].plant) {
            STP_TRY(check_unchanged(in, err));
            in->current++;
            continue;
        }
        if (!in->scan)
            STP_TRY(open_current(in, err));
        STP_TRY(stp_scan_read(in->scan, points, capacity, count, err));
        if (in->numbers.joined.list.count > 0)
            STP_TRY(prep_numbers_take(&in->numbers, stp_scan_get_info(in->scan)->extra,
                                      stp_scan_numbers(in->scan), *count, err));
        if (in->facts[in->current].way.projection)
            prep_system_move(in->facts[in->current].way.projection, points, *count);
        prep_where_reject(&in->where, stp_scan_get_info(in->scan), stp_scan_numbers(in->scan),
                          points, *count);
        if (in->in_part)
            in->part_left -= *count;
        else
            in->files[in->current].point_count += *count;
        for (size_t i = 0; i < *count; i++)
            if (points[i].station > 0)
                points[i].station = (uint16_t)(points[i].station + in->stations_before);
        if (*count == 0)
            STP_TRY(end_scan(in, err));
    }
done:
    return status;
}

static const uint8_t *packed_numbers(void *context)
{
    return ((const prep_inputs *)context)->numbers.packed;
}

/* Leaves out the file that is being read and continues after it. */
static bool leave_out_current(void *context, const stp_error *why, size_t *file)
{
    prep_inputs *in = context;
    *file = in->current;
    if (in->current >= in->count || in->facts[in->current].plant ||
        !leave_out(in, in->current, why))
        return false;
    if (in->scan)
        in->stations_before += stp_scan_get_info(in->scan)->station_count;
    stp_scan_close(&in->scan);
    in->current++;
    return true;
}

static void add_edges(prep_inputs *in, const stp_edge_counts *edges)
{
    in->edges.read += edges->read;
    in->edges.no_vertex += edges->no_vertex;
    in->edges.no_length += edges->no_length;
    in->edges.repeated += edges->repeated;
    in->edges.not_finite += edges->not_finite;
    in->edges.of_faces += edges->of_faces;
}

/* Appends a set of lines and frees the set. */
static stp_status add_lines(prep_inputs *in, stp_line_set *set, stp_error *err)
{
    stp_status status = STP_OK;
    stp_line_set own = *set, *all = &in->lines;
    *set = (stp_line_set){0};
    STP_TRY(stp_grow(&all->vertices, &in->vertex_capacity, all->vertex_count + own.vertex_count,
                     sizeof *all->vertices, "lines", err));
    STP_TRY(stp_grow(&all->strips, &in->strip_capacity, all->strip_count + own.strip_count,
                     sizeof *all->strips, "lines", err));
    for (uint64_t s = 0; s < own.strip_count; s++) {
        own.strips[s].begin += all->vertex_count;
        all->strips[all->strip_count++] = own.strips[s];
    }
    for (uint64_t i = 0; i < own.vertex_count; i++)
        all->vertices[all->vertex_count++] = own.vertices[i];
done:
    stp_line_set_clear(&own);
    return status;
}

/* Appends a set of triangles and frees the set. */
static stp_status add_triangles(prep_inputs *in, stp_triangle_set *set, const char *path,
                                stp_error *err)
{
    stp_status status = STP_OK;
    stp_triangle_set own = *set, *all = &in->triangles;
    *set = (stp_triangle_set){0};
    const uint32_t before = (uint32_t)all->vertex_count;
    if (all->vertex_count + own.vertex_count > UINT32_MAX) {
        status = stp_error_set(err, STP_LIMIT,
                               "%s: with it the triangles have more than 2^32 vertices: give it to "
                               "another model",
                               path);
        goto done;
    }
    STP_TRY(stp_grow(&all->vertices, &in->corner_capacity, all->vertex_count + own.vertex_count,
                     sizeof *all->vertices, "triangles", err));
    STP_TRY(stp_grow(&all->triangles, &in->triangle_capacity,
                     all->triangle_count + own.triangle_count, sizeof *all->triangles, "triangles",
                     err));
    for (uint64_t t = 0; t < own.triangle_count; t++, all->triangle_count++)
        for (int k = 0; k < 3; k++)
            all->triangles[all->triangle_count][k] = before + own.triangles[t][k];
    for (uint64_t i = 0; i < own.vertex_count; i++)
        all->vertices[all->vertex_count++] = own.vertices[i];
done:
    stp_triangle_set_clear(&own);
    return status;
}

/* Copies the notes, because the scan is closed when the metadata is written. */
static stp_status copy_notes(stp_prep_file *file, const stp_scan_info *info, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&file->notes, info->note_count, sizeof *file->notes, "notes", err));
    for (uint32_t i = 0; i < info->note_count; i++) {
        const char *const from[2] = {info->notes[i].name, info->notes[i].text};
        char *to[2] = {NULL, NULL};
        for (int k = 0; k < 2; k++) {
            STP_TRY(stp_text_copy(&to[k], from[k], "notes", err));
            *(k == 0 ? &file->notes[i].name : &file->notes[i].text) = to[k];
        }
        file->note_count = i + 1;
    }
done:
    return status;
}

/* Notes which part of the file is read. */
static stp_status note_part(prep_inputs *in, size_t i, stp_error *err)
{
    const stp_scan_region *r = in->params.region;
    char text[200] = "";
    size_t at = 0;
    if (!r)
        return STP_OK;
    if (r->bounded && isinf(r->min[2]))
        at += (size_t)snprintf(text, sizeof text, "bounds %.15g,%.15g,%.15g,%.15g", r->min[0],
                               r->min[1], r->max[0], r->max[1]);
    else if (r->bounded)
        at += (size_t)snprintf(text, sizeof text, "bounds %.15g,%.15g,%.15g,%.15g,%.15g,%.15g",
                               r->min[0], r->min[1], r->min[2], r->max[0], r->max[1], r->max[2]);
    if (r->resolution > 0.0)
        (void)snprintf(text + at, sizeof text - at, "%sresolution %.15g", at > 0 ? " " : "",
                       r->resolution);
    return prep_system_add_note(&in->files[i], "part", text, err);
}

/* Notes which points of the file are stored. */
static stp_status note_where(prep_inputs *in, size_t i, stp_error *err)
{
    return in->where.text ? prep_system_add_note(&in->files[i], "where", in->where.text, err)
                          : STP_OK;
}

/* Copies the grid and the images for the same reason. */
static stp_status copy_grids(stp_prep_file *file, const stp_scan_info *info, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t cells = info->grid.cell_count, images = info->image_count;
    stp_grid_cell *copy = NULL;
    STP_TRY(stp_alloc(&copy, cells, sizeof *copy, "a grid", err));
    file->grid = info->grid;
    file->grid.cells = copy;
    STP_TRY(stp_alloc(&file->images, images, sizeof *file->images, "images", err));
    if (copy)
        memcpy(copy, info->grid.cells, cells * sizeof *copy);
    if (file->images)
        memcpy(file->images, info->images, images * sizeof *file->images);
    file->image_count = info->image_count;
    file->pixels_told = info->pixels_told;
done:
    return status;
}

/* Decides whether the input's positions are moved, and says so in its notes. */
static stp_status choose_system(prep_inputs *in, size_t i, const stp_scan_info *info,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const stp_scan_params params = prep_inputs_params(in, i);
    if (info->raster.columns > 0 && params.grid && params.grid->dx > 0.0)
        return STP_OK; /* --spacing: columns and rows have no place in the world */
    STP_TRY(prep_system_choose(&in->system, in->paths[i], &params, info, &in->facts[i].way, err));
    const bool turned = info->raster.skew[0] != 0.0 || info->raster.skew[1] != 0.0;
    if (in->facts[i].way.projection || turned)
        STP_TRY(prep_system_move_raster(&in->files[i], in->facts[i].way.projection, err));
    if (in->facts[i].way.projection == NULL)
        return prep_system_tell(&in->files[i], in->paths[i], info, err);
    STP_TRY(prep_system_note(&in->files[i], in->facts[i].way.projection, err));
done:
    return status;
}

/* The state before an input adds to it. */
typedef struct survey_mark {
    size_t station_count;
    uint64_t line_vertices, strips, corners, triangles, points;
    stp_edge_counts edges;
    stp_plant_report plant;
    uint32_t all, any;
    double step, intensity_full;
    bool floats;
} survey_mark;

static survey_mark mark_of(const prep_inputs *in, const stp_prep_source *source, uint32_t all,
                           uint32_t any)
{
    return (survey_mark){in->station_count,
                         in->lines.vertex_count,
                         in->lines.strip_count,
                         in->triangles.vertex_count,
                         in->triangles.triangle_count,
                         source->point_count,
                         in->edges,
                         in->plant,
                         all,
                         any,
                         source->coordinate_step,
                         source->intensity_full,
                         source->floats};
}

static void go_back(prep_inputs *in, stp_prep_source *source, uint32_t *all, uint32_t *any,
                    const survey_mark *m)
{
    in->station_count = m->station_count;
    in->lines.vertex_count = m->line_vertices;
    in->lines.strip_count = m->strips;
    in->triangles.vertex_count = m->corners;
    in->triangles.triangle_count = m->triangles;
    in->edges = m->edges;
    in->plant = m->plant;
    source->point_count = m->points;
    source->coordinate_step = m->step;
    source->intensity_full = m->intensity_full;
    source->floats = m->floats;
    *all = m->all;
    *any = m->any;
}

/* Keeps the number for full intensity as long as all files with intensities have the same one. */
static void note_intensity(stp_prep_source *source, const stp_scan_info *info, bool first)
{
    const double full = info->intensity_full;
    if (info->attributes & STP_POINT_HAS_INTENSITY)
        source->intensity_full = first || source->intensity_full == full ? full : 0.0;
}

/* Notes what the report says of meshes. */
static void note_mesh(prep_inputs *in, size_t i, const stp_scan_info *info)
{
    in->facts[i].mesh = info->face_count > 0;
    if (info->colours_missing && in->colours_missing[0] == '\0')
        snprintf(in->colours_missing, sizeof in->colours_missing, "%s", info->colours_missing);
    if (info->coarse_samples > 0 && !in->coarse)
        in->coarse = in->paths[i];
    in->loose_left_out += info->loose_left_out;
    if (info->face_count > 0 && !in->suspect && prep_plants_suspect(in->paths[i], info))
        in->suspect = in->paths[i];
}

/* Notes the step of an input's coordinates. */
static stp_status note_step(const prep_inputs *in, size_t i, stp_scan *scan,
                            stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_scan_info *info = stp_scan_get_info(scan);
    const stp_projection *way = in->facts[i].way.projection;
    double step = 0.0;
    if (info->edges.read == 0) /* points that remain beside lines say nothing about the digits */
        STP_TRY(stp_scan_find_step(scan, in->exact, &step, err));
    if (way)
        step *=
            info->raster.columns > 0 ? stp_projection_height_unit(way) : stp_projection_unit(way);
    source->floats = source->floats || (step == 0.0 && info->point_count > 0);
    if (step > 0.0 && (source->coordinate_step == 0.0 || step < source->coordinate_step))
        source->coordinate_step = step;
done:
    return status;
}

static stp_status survey_one(prep_inputs *in, size_t i, stp_prep_source *source, uint32_t *all,
                             uint32_t *any, stp_error *err)
{
    stp_status status = STP_OK;
    stp_scan *scan = NULL;
    stp_line_set lines = {0};
    stp_triangle_set triangles = {0};
    in->facts[i] = facts_of(in->paths[i]);
    STP_TRY(prep_web_name(&in->facts[i].name, in->paths[i], err));
    in->files[i].name = in->facts[i].name;
    STP_TRY(prep_web_open(&in->facts[i].mirror, in->paths[i], in->temp, err));
    const stp_scan_params params = prep_inputs_params(in, i);
    STP_TRY(stp_scan_open(&scan, in->paths[i], &params, err));
    const stp_scan_info *info = stp_scan_get_info(scan);
    STP_TRY(prep_stations_add(in, i, info, err));
    STP_TRY(copy_grids(&in->files[i], info, err));
    in->files[i].raster = info->raster;
    STP_TRY(copy_notes(&in->files[i], info, err));
    STP_TRY(note_part(in, i, err));
    STP_TRY(note_where(in, i, err));
    if (info->point_count > 0 || info->face_count > 0)
        STP_TRY(choose_system(in, i, info, err));
    if (info->point_count > 0) {
        STP_TRY(prep_where_add(&in->where, info, in->paths[i], err));
        if (prep_numbers_wanted(&in->numbers))
            STP_TRY(prep_numbers_add(&in->numbers, info->extra, in->paths[i], err));
        else
            prep_numbers_leave_out(&in->numbers, info->extra);
    }
    prep_stations_move(in, i);
    add_edges(in, &info->edges);
    stp_scan_take_lines(scan, &lines);
    STP_TRY(add_lines(in, &lines, err));
    in->facts[i].plant = in->plants && info->face_count > 0;
    if (in->facts[i].plant) {
        STP_TRY(prep_plants_read(in->paths[i], &lines, &triangles, &in->plant, err));
        STP_TRY(add_lines(in, &lines, err));
    } else {
        stp_scan_take_triangles(scan, &triangles);
        in->facts[i].points = info->point_count;
        in->facts[i].seek_points = info->seek_points;
        source->point_count += info->point_count;
        note_mesh(in, i, info);
    }
    STP_TRY(add_triangles(in, &triangles, in->paths[i], err));
    note_intensity(source, info, (*any & STP_POINT_HAS_INTENSITY) == 0);
    const uint32_t lost = in->facts[i].way.projection ? STP_POINT_HAS_NORMAL : 0u;
    *all &= info->attributes & ~lost;
    *any |= info->attributes & ~lost;
    source->heights = source->heights || info->heights;
    source->y_up = source->y_up || info->y_up;
    source->y_down = source->y_down || info->y_down;
    source->y_likely_down = source->y_likely_down || info->y_likely_down;
    STP_TRY(note_step(in, i, scan, source, err));
done:
    stp_line_set_clear(&lines);
    stp_triangle_set_clear(&triangles);
    stp_scan_close(&scan);
    return status;
}

size_t prep_inputs_unreadable(const prep_inputs *in)
{
    size_t count = 0;
    for (size_t i = 0; in->facts && i < in->count; i++)
        count += in->facts[i].why != NULL;
    return count;
}

stp_status prep_inputs_survey(prep_inputs *in, stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t all = UINT32_MAX, any = 0;
    STP_TRY(stp_alloc(&in->facts, in->count, sizeof *in->facts, "inputs", err));
    STP_TRY(stp_alloc(&in->files, in->count, sizeof *in->files, "inputs", err));
    STP_TRY(prep_series_decide(in, err));
    for (size_t i = 0; i < in->count; i++) {
        const survey_mark mark = mark_of(in, source, all, any);
        stp_error why = {0};
        status = survey_one(in, i, source, &all, &any, &why);
        if (status != STP_OK && !leave_out(in, i, &why))
            return stp_error_set(err, status, "%s", why.message);
        if (status != STP_OK)
            go_back(in, source, &all, &any, &mark);
    }
    STP_TRY(prep_inputs_check_twice(in, err));
    if (prep_inputs_unreadable(in) == in->count)
        return stp_error_set(err, STP_FORMAT,
                             "none of the %zu inputs can be read: nothing is written", in->count);
    if (in->plants && in->plant.triangles == 0)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s has no faces%s: --lines auto makes lines of a plant's mesh; edges "
                             "are lines without it",
                             in->paths[0], in->count > 1 ? ", nor have the other inputs" : "");
    if (source->point_count == 0 && in->lines.strip_count == 0 && in->triangles.triangle_count == 0)
        return stp_error_set(err, STP_EMPTY, "%s has no points%s: there is nothing to write",
                             in->paths[0], in->count > 1 ? ", nor have the other inputs" : "");
    if (in->where.text && (in->lines.strip_count > 0 || in->triangles.triangle_count > 0))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "the inputs have lines or triangles: --where chooses among points "
                             "alone");
    STP_TRY(prep_where_check(&in->where, err));
    STP_TRY(prep_numbers_check(&in->numbers, err));
    if (in->lines.strip_count > 0 || in->triangles.triangle_count > 0)
        stp_attribute_union_lack(&in->numbers.joined);
    source->context = in;
    source->read = read_inputs;
    source->kept = &in->numbers.joined.list;
    source->numbers = packed_numbers;
    source->leaves_out = leave_out_current;
    source->file = &in->current;
    source->part_begin = prep_inputs_part_begin;
    source->read_part = prep_inputs_read_part;
    source->rejected = prep_inputs_reject;
    source->files = in->files;
    source->file_count = in->count;
    source->lines = &in->lines;
    source->triangles = &in->triangles;
    source->stations = in->stations;
    source->station_ups = in->station_ups;
    source->station_count = (uint32_t)in->station_count;
    source->some_normals = any & STP_POINT_HAS_NORMAL;
    source->attributes = (any & ~(uint32_t)STP_POINT_HAS_NORMAL) | (all & STP_POINT_HAS_NORMAL);
    STP_TRY(prep_grids_find(in, source, err));
done:
    return status;
}

void prep_inputs_clear(prep_inputs *in)
{
    stp_scan_close(&in->scan);
    stp_output_destroy(&in->rejects);
    for (size_t i = 0; in->files && i < in->count; i++) {
        clear_notes(&in->files[i]);
        free((void *)in->files[i].grid.cells);
        free(in->files[i].images);
        free(in->files[i].raster_nodes);
    }
    for (size_t i = 0; in->facts && i < in->count; i++) {
        free(in->facts[i].why);
        free(in->facts[i].name);
        stp_mirror_close(&in->facts[i].mirror);
        stp_projection_destroy(&in->facts[i].way.projection);
    }
    prep_system_clear(&in->system);
    prep_numbers_clear(&in->numbers);
    free(in->raster_nodes);
    free(in->files);
    free(in->grids);
    free(in->facts);
    free(in->stations);
    free(in->station_ups);
    stp_line_set_clear(&in->lines);
    stp_triangle_set_clear(&in->triangles);
    *in = (prep_inputs){0};
}
