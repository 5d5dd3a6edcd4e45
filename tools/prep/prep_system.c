/* Brings inputs to one coordinate system. */
#include "tools/prep/prep_system.h"

#include "base/file.h"
#include "base/memory.h"
#include "preprocess/grid/raster_frame.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PRJ_BYTES_MAX 65536u
/* The code of GeoTIFF for a system that the file defines itself. */
#define USER_DEFINED 32767L
/* Points looked at for a place. */
#define LOOK_POINTS 256u

/* What a file says about its system. */
typedef struct told {
    char *definition; /* for PROJ; NULL: nothing that it takes */
    bool angles;      /* longitude and latitude */
    bool guessed;     /* by its numbers or columns, for want of a system */
} told;

cli_option prep_system_option(const char **wanted)
{
    return (cli_option){
        "--to",
        0,
        CLI_STRING,
        (void *)wanted,
        "SYSTEM",
        "coordinate system to bring points to, like EPSG:25832 (that of the first input; degrees: "
        "UTM)",
        NULL};
}

static const char *note_of(const stp_scan_info *info, const char *name)
{
    for (uint32_t i = 0; i < info->note_count; i++)
        if (strcmp(info->notes[i].name, name) == 0)
            return info->notes[i].text;
    return "";
}

/* The number of a line "NAME=number" of GeoTIFF's keys; 0: there is none. */
static long key_of(const char *keys, const char *name)
{
    const size_t length = strlen(name);
    for (const char *at = keys; (at = strstr(at, name)) != NULL; at += length)
        if (at[length] == '=' && isdigit((unsigned char)at[length + 1]))
            return strtol(at + length + 1, NULL, 10);
    return 0;
}

static bool is_projected(const char *wkt)
{
    return strstr(wkt, "PROJCS") || strstr(wkt, "PROJCRS");
}

static stp_status take_wkt(told *out, const char *wkt, stp_error *err)
{
    const bool projected = is_projected(wkt);
    const bool angles = strstr(wkt, "GEOGCS") || strstr(wkt, "GEOGCRS") || strstr(wkt, "GEODCRS");
    if (!projected && !angles)
        return STP_OK;
    out->angles = !projected;
    return stp_text_copy(&out->definition, wkt, "a coordinate system", err);
}

static stp_status take_keys(told *out, const char *keys, stp_error *err)
{
    const long projected = key_of(keys, "ProjectedCSTypeGeoKey");
    const long angles = key_of(keys, "GeographicTypeGeoKey");
    const long code = projected > 0 ? projected : angles;
    const long vertical = key_of(keys, "VerticalCSTypeGeoKey");
    char text[64], *wkt = NULL;
    out->angles = key_of(keys, "GTModelTypeGeoKey") == 2;
    if (code <= 0 || code == USER_DEFINED)
        return STP_OK;
    snprintf(text, sizeof text, "EPSG:%ld+%ld", code, vertical);
    if (vertical <= 0 || vertical == USER_DEFINED || stp_system_wkt(&wkt, text, NULL) != STP_OK)
        snprintf(text, sizeof text, "EPSG:%ld", code); /* or no system of heights that PROJ knows */
    free(wkt);
    return stp_text_copy(&out->definition, text, "a coordinate system", err);
}

stp_status prep_system_prj(char **out, const char *path, stp_error *err)
{
    const char *slash = strrchr(path, '/'), *dot = strrchr(path, '.');
    const bool ends = dot != NULL && dot > (slash ? slash : path);
    const size_t stem = ends ? (size_t)(dot - path) : strlen(path);
    const stp_status status = stp_alloc(out, stem + sizeof ".prj", 1, "a path", err);
    if (status == STP_OK)
        snprintf(*out, stem + sizeof ".prj", "%.*s.prj", (int)stem, path);
    return status;
}

/* Reads F.prj beside F.asc. No such file is no error. */
static stp_status take_prj(told *out, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    char *beside = NULL, *text = NULL;
    int descriptor = -1;
    uint64_t size = 0;
    STP_TRY(prep_system_prj(&beside, path, err));
    if (stp_file_open(beside, &descriptor, &size, NULL) != STP_OK || size > PRJ_BYTES_MAX)
        goto done;
    STP_TRY(stp_alloc(&text, (size_t)size + 1, 1, "a coordinate system", err));
    STP_TRY(stp_file_read_at(descriptor, beside, 0, text, (size_t)size, err));
    STP_TRY(take_wkt(out, text, err));
done:
    if (descriptor >= 0)
        close(descriptor);
    free(beside);
    free(text);
    return status;
}

static stp_status find_told(told *out, const char *path, const stp_scan_info *info, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(take_wkt(out, note_of(info, "wkt"), err));
    if (out->definition == NULL)
        STP_TRY(take_keys(out, note_of(info, "geokeys"), err));
    if (out->definition == NULL && !out->angles)
        STP_TRY(take_prj(out, path, err));
    if (out->definition == NULL && !out->angles && note_of(info, "degrees")[0] != '\0') {
        STP_TRY(stp_text_copy(&out->definition, "EPSG:4326", "a coordinate system", err));
        out->angles = out->guessed = true;
    }
done:
    return status;
}

/* A place of the scan: its first point that is one. */
static stp_status find_place(const char *path, const stp_scan_params *params, stp_dvec3 *out,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_scan *scan = NULL;
    stp_point *points = NULL;
    size_t count = 0;
    *out = (stp_dvec3){0.0, 0.0, 0.0};
    STP_TRY(stp_alloc(&points, LOOK_POINTS, sizeof *points, "points", err));
    STP_TRY(stp_scan_open(&scan, path, params, err));
    do {
        STP_TRY(stp_scan_read(scan, points, LOOK_POINTS, &count, err));
        for (size_t i = 0; i < count; i++)
            if (points[i].reject == STP_REJECT_NONE && stp_dvec3_finite(points[i].position)) {
                *out = points[i].position;
                goto done;
            }
    } while (count > 0);
done:
    stp_scan_close(&scan);
    free(points);
    return status;
}

static stp_status check_told(const prep_system *system, const told *t, const char *path,
                             const stp_scan_info *info, stp_error *err)
{
    if (t->definition == NULL && t->angles)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s is in degrees of longitude and latitude, of a system that it does "
                             "not name: project it first, for example with PDAL's "
                             "filters.reprojection",
                             path);
    if (t->definition == NULL)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s does not say its coordinate system, so it cannot be brought to "
                             "%s: put a .prj file beside it",
                             path, system->wanted);
    if (info->face_count > 0 || info->edges.read > 0)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s has lines or faces, and only points are projected: project it "
                             "first",
                             path);
    return STP_OK;
}

/* Whether an input is moved. One whose system PROJ does not know stays where it is. */
static bool moves(const prep_system *system, const told *t, const char *to, prep_way *way)
{
    bool same = false;
    if (t->angles || t->definition == NULL)
        return t->angles || system->wanted != NULL;
    if (to == NULL || strcmp(t->definition, to) == 0)
        return false;
    const bool known = stp_system_same(&same, t->definition, to, NULL) == STP_OK;
    way->unknown = !known && system->wanted == NULL;
    return !same && !way->unknown;
}

stp_status prep_system_choose(prep_system *system, const char *path, const stp_scan_params *params,
                              const stp_scan_info *info, prep_way *way, stp_error *err)
{
    stp_status status = STP_OK;
    told t = {0};
    stp_dvec3 at = {0.0, 0.0, 0.0};
    const char *to = system->wanted ? system->wanted : system->target;
    STP_TRY(find_told(&t, path, info, err));
    if (!moves(system, &t, to, way)) {
        if (system->target == NULL) {
            system->target = t.definition;
            t.definition = NULL;
        }
        goto done;
    }
    STP_TRY(check_told(system, &t, path, info, err));
    if (t.angles)
        STP_TRY(find_place(path, params, &at, err));
    STP_TRY(stp_projection_create(&way->projection, t.definition, to, at, err));
    way->guessed = t.guessed;
    if (!is_projected(stp_projection_wkt(way->projection))) {
        status = stp_error_set(err, STP_UNSUPPORTED,
                               "--to %s has angles, or x, y and z from the earth's middle: give a "
                               "projected system, or leave --to out for the zone of UTM at hand",
                               to);
        goto done;
    }
    if (system->target == NULL)
        STP_TRY(stp_text_copy(&system->target, stp_projection_wkt(way->projection),
                              "a coordinate system", err));
done:
    free(t.definition);
    return status;
}

stp_status prep_system_add_note(stp_prep_file *file, const char *name, const char *text,
                                stp_error *err)
{
    stp_status status = STP_OK;
    size_t capacity = file->note_count;
    char *own_name = NULL, *own_text = NULL;
    STP_TRY(stp_text_copy(&own_name, name, "notes", err));
    STP_TRY(stp_text_copy(&own_text, text, "notes", err));
    STP_TRY(stp_grow(&file->notes, &capacity, (size_t)file->note_count + 1, sizeof *file->notes,
                     "notes", err));
    file->notes[file->note_count++] = (stp_scan_note){own_name, own_text};
    own_name = own_text = NULL;
done:
    free(own_name);
    free(own_text);
    return status;
}

static stp_status rename_note(stp_prep_file *file, const char *name, const char *as, stp_error *err)
{
    for (uint32_t i = 0; i < file->note_count; i++) {
        char *copy = NULL;
        if (strcmp(file->notes[i].name, name) != 0)
            continue;
        if (stp_text_copy(&copy, as, "notes", err) != STP_OK)
            return STP_OUT_OF_MEMORY;
        free((void *)file->notes[i].name);
        file->notes[i].name = copy;
    }
    return STP_OK;
}

stp_status prep_system_note(stp_prep_file *file, const stp_projection *way, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(rename_note(file, "wkt", "projected_from_wkt", err));
    STP_TRY(rename_note(file, "geokeys", "projected_from_geokeys", err));
    STP_TRY(prep_system_add_note(file, "wkt", stp_projection_wkt(way), err));
done:
    return status;
}

stp_status prep_system_tell(stp_prep_file *file, const char *path, const stp_scan_info *info,
                            stp_error *err)
{
    stp_status status = STP_OK;
    told t = {0};
    char *wkt = NULL;
    if (note_of(info, "wkt")[0] != '\0')
        return STP_OK;
    STP_TRY(find_told(&t, path, info, err));
    if (t.definition == NULL || stp_system_wkt(&wkt, t.definition, NULL) != STP_OK)
        goto done; /* without PROJ, the keys stay as they are */
    STP_TRY(prep_system_add_note(file, "wkt", wkt, err));
done:
    free(t.definition);
    free(wkt);
    return status;
}

void prep_system_move(stp_projection *way, stp_point *points, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (points[i].reject == STP_REJECT_NONE)
            points[i].position = stp_projection_apply(way, points[i].position);
        points[i].normal = (vec3s){{0.0f, 0.0f, 0.0f}};
    }
}

/* Whether nodes tell where the samples between them lie: whether the middle of these is moved to
 * the middle of the frame. Where a map is torn, it is not. */
static bool nodes_tell(const stp_prep_file *file, stp_projection *way, uint32_t i, uint32_t j)
{
    const stp_scan_raster *r = &file->raster;
    const uint32_t begin[2] = {stp_raster_node_column(i, r->columns),
                               stp_raster_node_column(j, r->rows)};
    const double c = 0.5 * (begin[0] + stp_raster_node_column(i + 1, r->columns));
    const double d = 0.5 * (begin[1] + stp_raster_node_column(j + 1, r->rows));
    const stp_raster_frame frame = stp_raster_frame_at(r, file->raster_nodes, begin[0], begin[1]);
    const stp_dvec3 middle = stp_raster_frame_place(&frame, c, d);
    const stp_dvec3 moved = stp_projection_apply(way, stp_scan_raster_at(r, c, d, 0.0));
    return hypot(moved.x - middle.x, moved.y - middle.y) <=
           frame.wide; /* false if a place is NaN */
}

stp_status prep_system_move_raster(stp_prep_file *file, stp_projection *way, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_scan_raster raster = file->raster;
    if (raster.columns == 0)
        return STP_OK;
    const uint32_t across = stp_raster_node_count(raster.columns);
    const uint32_t down = stp_raster_node_count(raster.rows);
    STP_TRY(stp_alloc(&file->raster_nodes, (size_t)across * down, sizeof *file->raster_nodes,
                      "a grid", err));
    for (uint32_t j = 0; j < down; j++)
        for (uint32_t i = 0; i < across; i++) {
            const stp_dvec3 from =
                stp_scan_raster_at(&raster, stp_raster_node_column(i, raster.columns),
                                   stp_raster_node_column(j, raster.rows), 0.0);
            file->raster_nodes[(size_t)j * across + i] =
                way ? stp_projection_apply(way, from) : from;
        }
    bool tell = true;
    for (uint32_t j = 0; way && tell && j + 1 < down; j++)
        for (uint32_t i = 0; tell && i + 1 < across; i++)
            tell = nodes_tell(file, way, i, j);
    if (!tell)
        file->raster = (stp_scan_raster){0};
done:
    return status;
}

void prep_system_clear(prep_system *system)
{
    free(system->target);
    *system = (prep_system){0};
}
