/* Reads a PLY file as a stream of points. */
#include "formats/scan/ply/ply.h"

#include "base/memory.h"
#include "formats/scan/ply/ply_grid.h"
#include "formats/scan/ply/ply_splats.h"
#include "formats/scan/value_range.h"

#include <stdlib.h>
#include <string.h>

static bool has_targets(const stp_ply *ply, stp_ply_target first, int count)
{
    for (int i = 0; i < count; i++)
        if (!stp_ply_target_property(ply, (stp_ply_target)(first + (stp_ply_target)i)))
            return false;
    return true;
}

static stp_status find_vertex_element(stp_ply *ply, stp_error *err)
{
    const char *path = ply->source.path;
    ply->vertex = stp_ply_header_find_vertices(&ply->header);
    if (!ply->vertex)
        return stp_error_set(
            err, STP_CORRUPT,
            "%s: the PLY header (%llu lines) has no element `vertex`: is it a scan?", path,
            (unsigned long long)ply->header.header_lines);
    static const char *const axes[] = {"x", "y", "z"};
    for (int i = stp_ply_splats_find(ply) && has_targets(ply, STP_PLY_X, 1) ? 3 : 0; i < 3; i++)
        if (!has_targets(ply, (stp_ply_target)i, 1))
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: the PLY element `vertex` has no number property `%s` (%llu "
                                 "header lines): export the file again with x, y and z",
                                 path, axes[i], (unsigned long long)ply->header.header_lines);
    if (has_targets(ply, STP_PLY_NX, 3))
        ply->attributes |= STP_POINT_HAS_NORMAL;
    const stp_ply_property *red = stp_ply_target_property(ply, STP_PLY_RED);
    if (has_targets(ply, STP_PLY_RED, 3) || (red && (ply->packed || stp_ply_is_packed(red))))
        ply->attributes |= STP_POINT_HAS_COLOUR;
    if (has_targets(ply, STP_PLY_INTENSITY, 1))
        ply->attributes |= STP_POINT_HAS_INTENSITY;
    if (has_targets(ply, STP_PLY_CLASS, 1))
        ply->attributes |= STP_POINT_HAS_CLASS;
    return STP_OK;
}

/* Stations in comments win over a camera. */
static void find_stations(stp_ply *ply)
{
    const bool named = has_targets(ply, STP_PLY_STATION, 1);
    ply->has_camera = ply->has_camera && !named && ply->header.stations.count == 0;
    ply->lone_station = ply->has_camera || (!named && ply->header.stations.count == 1);
    if (named || ply->lone_station)
        ply->attributes |= STP_POINT_HAS_STATION;
}

static void find_face_element(stp_ply *ply)
{
    static const char *const names[] = {"face", "tristrips"};
    for (size_t i = 0; i < sizeof names / sizeof *names && !ply->faces; i++) {
        const stp_ply_element *element = stp_ply_header_find(&ply->header, names[i]);
        if (element && element->count > 0 && stp_ply_index_list(&ply->header, element))
            ply->faces = element;
    }
}

static void find_edge_element(stp_ply *ply)
{
    const stp_ply_header *h = &ply->header;
    const stp_ply_element *element = stp_ply_header_find(h, "edge");
    if (element && element->count > 0 && stp_ply_number_property(h, element, "vertex1") &&
        stp_ply_number_property(h, element, "vertex2"))
        ply->edges = element;
}

/* Rejects a count that the file cannot hold, before anyone allocates by it. */
static stp_status check_vertex_count(stp_ply *ply, bool salvage, stp_error *err)
{
    stp_ply_element *vertex = &ply->header.elements[ply->vertex - ply->header.elements];
    const bool ascii = ply->header.encoding == STP_PLY_ASCII;
    const uint64_t left = ply->source.size - ply->source.offset;
    /* ASCII: a digit and a separator per value; the last separator may be missing. */
    const uint64_t record = ascii ? 2 * (uint64_t)vertex->property_count : vertex->stride;
    const uint64_t fit = (left + (ascii ? 1 : 0)) / record;
    if (vertex->count <= fit)
        return STP_OK;
    if (salvage && stp_salvage_count(&vertex->count, fit, &ply->lost_count)) {
        ply->faces = ply->edges = NULL;
        return STP_OK;
    }
    return stp_error_set(err, STP_CORRUPT,
                         "%s: the PLY header declares %llu vertices, but the %llu bytes from byte "
                         "%llu on hold %s%llu: the file was cut or its header is wrong; copy or "
                         "export it again",
                         ply->source.path, (unsigned long long)vertex->count,
                         (unsigned long long)left, (unsigned long long)ply->source.offset,
                         ascii || vertex->has_lists ? "at most " : "", (unsigned long long)fit);
}

static stp_status open_file(stp_ply *ply, const char *path, bool salvage, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_source_open(&ply->source, path, err));
    STP_TRY(stp_ply_header_read(&ply->header, &ply->source, err));
    STP_TRY(find_vertex_element(ply, err));
    stp_ply_numbers_find(ply);
    find_face_element(ply);
    find_edge_element(ply);
    ply->cursor = (stp_ply_cursor){.source = &ply->source, .encoding = ply->header.encoding};
    for (const stp_ply_element *e = ply->header.elements; e != ply->vertex; e++)
        STP_TRY(e->count == 1 && strcmp(e->name, "camera") == 0 ? stp_ply_camera_read(ply, e, err)
                : ply->packed && !ply->splats && strcmp(e->name, "chunk") == 0
                    ? stp_ply_splats_read(ply, e, err)
                    : stp_ply_skip_element(&ply->cursor, &ply->header, e, err));
    find_stations(ply);
    STP_TRY(check_vertex_count(ply, salvage, err));
    STP_TRY(stp_ply_splats_check(ply, err));
    ply->vertex_offset = ply->source.offset;
    ply->vertex_line = ply->source.line;
    ply->cursor.element = ply->vertex;
    ply->cursor.index = 0;
    STP_TRY(stp_ply_find_depths(ply, err));
    STP_TRY(stp_ply_grid_read(ply, err));
done:
    return status;
}

stp_status stp_ply_open(stp_ply **out, const char *path, bool salvage, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ply *ply = NULL;
    STP_TRY(stp_alloc(&ply, 1, sizeof *ply, "PLY reader", err));
    ply->source.descriptor = -1;
    STP_TRY(open_file(ply, path, salvage, err));
    *out = ply;
    ply = NULL;
done:
    stp_ply_close(&ply);
    return status;
}

void stp_ply_close(stp_ply **ply)
{
    if (!*ply)
        return;
    stp_source_close(&(*ply)->source);
    stp_ply_header_free(&(*ply)->header);
    free((*ply)->cells);
    free((*ply)->splats);
    stp_ply_numbers_clear(&(*ply)->numbers);
    free(*ply);
    *ply = NULL;
}

void stp_ply_seek(stp_ply *ply, uint64_t vertex)
{
    stp_source_seek(&ply->source, ply->vertex_offset + vertex * ply->vertex->stride, 0);
    ply->source.narrow = true;
    ply->cursor.index = vertex;
}

static void set_stations(const stp_ply *ply, stp_point *points, size_t count)
{
    const double *numbers = ply->columns[STP_PLY_STATION];
    for (size_t i = 0; i < count; i++)
        points[i].station =
            ply->lone_station ? 1 : stp_ply_stations_find(&ply->header.stations, numbers[i]);
}

static void columns_to_points(const stp_ply *ply, stp_point *points, size_t count)
{
    const double(*c)[STP_PLY_BLOCK_POINTS] = ply->columns;
    for (size_t i = 0; i < count; i++)
        points[i] = (stp_point){.position = {c[STP_PLY_X][i], c[STP_PLY_Y][i], c[STP_PLY_Z][i]}};
    if (ply->attributes & STP_POINT_HAS_NORMAL)
        for (size_t i = 0; i < count; i++)
            points[i].normal =
                stp_unit_normal((stp_dvec3){c[STP_PLY_NX][i], c[STP_PLY_NY][i], c[STP_PLY_NZ][i]});
    if (ply->attributes & STP_POINT_HAS_COLOUR)
        for (size_t i = 0; i < count; i++)
            for (int k = 0; k < 3; k++)
                points[i].rgb[k] =
                    stp_value_range_map(c[STP_PLY_RED + k][i], ply->colour_low, ply->colour_scale);
    if (ply->attributes & STP_POINT_HAS_INTENSITY)
        for (size_t i = 0; i < count; i++)
            points[i].intensity = stp_value_range_map(c[STP_PLY_INTENSITY][i], ply->intensity_low,
                                                      ply->intensity_scale);
    if (ply->attributes & STP_POINT_HAS_CLASS)
        for (size_t i = 0; i < count; i++)
            points[i].class_id = stp_class_of(c[STP_PLY_CLASS][i]);
    if (ply->attributes & STP_POINT_HAS_STATION)
        set_stations(ply, points, count);
}

stp_status stp_ply_read(stp_ply *ply, stp_point *points, size_t capacity, size_t *count,
                        stp_error *err)
{
    stp_status status = STP_OK;
    size_t done_count = 0;
    STP_TRY(stp_ply_numbers_reserve(ply, capacity, err));
    while (done_count < capacity && ply->cursor.index < ply->vertex->count) {
        size_t part = capacity - done_count;
        const uint64_t left = ply->vertex->count - ply->cursor.index;
        part = part < STP_PLY_BLOCK_POINTS ? part : STP_PLY_BLOCK_POINTS;
        part = part < left ? part : (size_t)left;
        STP_TRY(stp_ply_read_columns(ply, part, err));
        columns_to_points(ply, points + done_count, part);
        if (ply->numbers.columns)
            stp_ply_numbers_pack(ply, done_count, part);
        done_count += part;
    }
    *count = done_count;
done:
    return status;
}
