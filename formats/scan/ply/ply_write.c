/* Writes points, faces and edges as binary little-endian PLY. */
#include "formats/scan/ply/ply_write.h"

#include "base/file.h"
#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* x y z double, nx ny nz float, rgb, intensity, class, station, outlier, radius */
#define STP_PLY_RECORD_BYTES_MAX (24 + 12 + 3 + 2 + 1 + 2 + 1 + 4)
/* More stations than this need two bytes per number. The greatest value of either type means
 * unknown. */
#define STP_PLY_BYTE_STATIONS 255u
/* Bytes are collected in blocks, so that stp_output is called once per block, not per property. */
#define STP_PLY_BLOCK_RECORDS 1024u

struct stp_ply_writer {
    stp_output *output;
    char *path;
    stp_ply_writer_params params;
    uint64_t vertices_written;
    uint64_t triangles_written;
    uint64_t edges_written;
    unsigned char *block;
};

static unsigned char *put_u32(unsigned char *at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (unsigned char)(value >> (8 * i));
    return at + 4;
}

static unsigned char *put_float(unsigned char *at, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return put_u32(at, bits);
}

static unsigned char *put_double(unsigned char *at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return put_u32(put_u32(at, (uint32_t)bits), (uint32_t)(bits >> 32));
}

/* PLY has integers of at most 32 bits, and no scales. */
static bool is_double(const stp_attribute *a)
{
    return a->scale != 1.0 || a->offset != 0.0 || a->type == STP_ATTRIBUTE_U64 ||
           a->type == STP_ATTRIBUTE_I64;
}

static unsigned char *put_numbers(unsigned char *at, const uint8_t *packed,
                                  const stp_attribute_list *list)
{
    for (uint32_t a = 0; a < list->count; a++) {
        const stp_attribute *attribute = &list->items[a];
        const size_t bytes = stp_attribute_bytes(attribute->type);
        if (is_double(attribute)) {
            at = put_double(
                at, stp_attribute_value(attribute, stp_attribute_get(attribute->type, packed)));
        } else {
            memcpy(at, packed, bytes);
            at += bytes;
        }
        packed += bytes;
    }
    return at;
}

static unsigned char *put_point(unsigned char *at, const stp_point *p, float radius,
                                const uint8_t *packed, const stp_ply_writer_params *params)
{
    const double xyz[3] = {p->position.x, p->position.y, p->position.z};
    for (int i = 0; i < 3; i++)
        at = params->double_coordinates ? put_double(at, xyz[i]) : put_float(at, (float)xyz[i]);
    if (params->attributes & STP_POINT_HAS_NORMAL)
        for (int i = 0; i < 3; i++)
            at = put_float(at, p->normal.raw[i]);
    if (params->attributes & STP_POINT_HAS_COLOUR)
        for (int i = 0; i < 3; i++)
            *at++ = (unsigned char)((p->rgb[i] + 128u) / 257u);
    if (params->attributes & STP_POINT_HAS_INTENSITY) {
        *at++ = (unsigned char)(p->intensity & 0xff);
        *at++ = (unsigned char)(p->intensity >> 8);
    }
    if (params->attributes & STP_POINT_HAS_CLASS)
        *at++ = p->class_id;
    if (params->attributes & STP_POINT_HAS_STATION) {
        const unsigned number = p->station - 1u; /* all bits set if unknown */
        *at++ = (unsigned char)(number & 0xff);
        if (params->station_count > STP_PLY_BYTE_STATIONS)
            *at++ = (unsigned char)(number >> 8 & 0xff);
    }
    if (params->attributes & STP_POINT_HAS_OUTLIER)
        *at++ = p->outlier;
    if (params->edge_count > 0)
        at = put_float(at, radius);
    return params->numbers && packed ? put_numbers(at, packed, params->numbers) : at;
}

static stp_status put_text(stp_ply_writer *w, const char *text, stp_error *err)
{
    return stp_output_write(w->output, text, strlen(text), err);
}

static stp_status put_count(stp_ply_writer *w, const char *element, uint64_t count, stp_error *err)
{
    char line[64];
    snprintf(line, sizeof line, "element %s %llu\n", element, (unsigned long long)count);
    return put_text(w, line, err);
}

static stp_status put_stations(stp_ply_writer *w, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t i = 0; i < w->params.station_count; i++) {
        char line[128];
        const stp_dvec3 p = w->params.stations[i];
        snprintf(line, sizeof line, "comment station %u %.17g %.17g %.17g\n", i, p.x, p.y, p.z);
        STP_TRY(put_text(w, line, err));
    }
done:
    return status;
}

/* Names that points have without attributes. */
static bool is_taken(const char *name)
{
    static const char *const taken[] = {"x",
                                        "y",
                                        "z",
                                        "nx",
                                        "ny",
                                        "nz",
                                        "red",
                                        "green",
                                        "blue",
                                        "intensity",
                                        "classification",
                                        "station",
                                        "outlier",
                                        "radius"};
    for (size_t i = 0; i < sizeof taken / sizeof *taken; i++)
        if (strcmp(taken[i], name) == 0)
            return true;
    return false;
}

static stp_status put_number_properties(stp_ply_writer *w, stp_error *err)
{
    stp_status status = STP_OK;
    static const char *const types[STP_ATTRIBUTE_TYPE_COUNT] = {
        [STP_ATTRIBUTE_U8] = "uchar",   [STP_ATTRIBUTE_I8] = "char",
        [STP_ATTRIBUTE_U16] = "ushort", [STP_ATTRIBUTE_I16] = "short",
        [STP_ATTRIBUTE_U32] = "uint",   [STP_ATTRIBUTE_I32] = "int",
        [STP_ATTRIBUTE_U64] = "double", [STP_ATTRIBUTE_I64] = "double",
        [STP_ATTRIBUTE_F32] = "float",  [STP_ATTRIBUTE_F64] = "double"};
    const stp_attribute_list *list = w->params.numbers;
    for (uint32_t a = 0; list && a < list->count; a++) {
        const stp_attribute *attribute = &list->items[a];
        char line[STP_ATTRIBUTE_NAME_BYTES + 32];
        const int length = snprintf(line, sizeof line, "property %s ",
                                    is_double(attribute) ? "double" : types[attribute->type]);
        snprintf(line + length, sizeof line - (size_t)length, "%s%s\n", attribute->name,
                 is_taken(attribute->name) ? "_full" : "");
        for (char *c = line + length; *c != '\0'; c++)
            *c = *c == ' ' ? '_' : *c;
        STP_TRY(put_text(w, line, err));
    }
done:
    return status;
}

static stp_status put_properties(stp_ply_writer *w, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_ply_writer_params *p = &w->params;
    STP_TRY(put_text(w,
                     p->double_coordinates
                         ? "property double x\nproperty double y\nproperty double z\n"
                         : "property float x\nproperty float y\nproperty float z\n",
                     err));
    if (p->attributes & STP_POINT_HAS_NORMAL)
        STP_TRY(put_text(w, "property float nx\nproperty float ny\nproperty float nz\n", err));
    if (p->attributes & STP_POINT_HAS_COLOUR)
        STP_TRY(
            put_text(w, "property uchar red\nproperty uchar green\nproperty uchar blue\n", err));
    if (p->attributes & STP_POINT_HAS_INTENSITY)
        STP_TRY(put_text(w, "property ushort intensity\n", err));
    if (p->attributes & STP_POINT_HAS_CLASS)
        STP_TRY(put_text(w, "property uchar classification\n", err));
    if (p->attributes & STP_POINT_HAS_STATION)
        STP_TRY(put_text(w,
                         p->station_count > STP_PLY_BYTE_STATIONS ? "property ushort station\n"
                                                                  : "property uchar station\n",
                         err));
    if (p->attributes & STP_POINT_HAS_OUTLIER)
        STP_TRY(put_text(w, "property uchar outlier\n", err));
    if (p->edge_count > 0)
        STP_TRY(put_text(w, "property float radius\n", err));
    STP_TRY(put_number_properties(w, err));
done:
    return status;
}

static stp_status write_header(stp_ply_writer *w, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_ply_writer_params *p = &w->params;
    STP_TRY(put_text(w, "ply\nformat binary_little_endian 1.0\n", err));
    STP_TRY(put_stations(w, err));
    STP_TRY(put_count(w, "vertex", p->vertex_count, err));
    STP_TRY(put_properties(w, err));
    if (p->triangle_count > 0) {
        STP_TRY(put_count(w, "face", p->triangle_count, err));
        STP_TRY(put_text(w,
                         p->vertex_count > INT32_MAX ? "property list uchar uint vertex_indices\n"
                                                     : "property list uchar int vertex_indices\n",
                         err));
    }
    if (p->edge_count > 0) {
        STP_TRY(put_count(w, "edge", p->edge_count, err));
        STP_TRY(put_text(w,
                         p->vertex_count > INT32_MAX
                             ? "property uint vertex1\nproperty uint vertex2\n"
                             : "property int vertex1\nproperty int vertex2\n",
                         err));
    }
    STP_TRY(put_text(w, "end_header\n", err));
done:
    return status;
}

static stp_status check_params(const char *path, const stp_ply_writer_params *p, stp_error *err)
{
    if (p->attributes & STP_POINT_HAS_STATION && p->station_count == 0)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: points of stations need the stations' positions: give them",
                             path);
    if (p->station_count > STP_STATION_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: %u stations are more than the %u that a scan may have: write "
                             "several scans",
                             path, p->station_count, STP_STATION_LIMIT);
    if ((p->triangle_count > 0 || p->edge_count > 0) &&
        (p->vertex_count == 0 || p->vertex_count > (uint64_t)1 << 32))
        return stp_error_set(
            err, STP_INVALID_ARGUMENT,
            "%s: triangles or edges over %llu vertices cannot be written to PLY: write the "
            "points alone",
            path, (unsigned long long)p->vertex_count);
    return STP_OK;
}

stp_status stp_ply_writer_create(stp_ply_writer **out, const char *path,
                                 const stp_ply_writer_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ply_writer *w = NULL;
    STP_TRY(check_params(path, params, err));
    STP_TRY(stp_alloc(&w, 1, sizeof *w, "PLY writer", err));
    w->params = *params;
    const size_t attributes = params->numbers ? 8 * (size_t)params->numbers->count : 0;
    STP_TRY(stp_alloc(&w->block, STP_PLY_BLOCK_RECORDS, STP_PLY_RECORD_BYTES_MAX + attributes,
                      "PLY writer", err));
    STP_TRY(stp_text_copy(&w->path, path, "path", err));
    STP_TRY(stp_output_create(&w->output, path, params->force, err));
    STP_TRY(write_header(w, err));
    w->params.stations = NULL; /* borrowed for the header only */
    *out = w;
    w = NULL;
done:
    stp_ply_writer_destroy(&w);
    return status;
}

stp_status stp_ply_writer_points(stp_ply_writer *writer, const stp_point *points, size_t count,
                                 stp_error *err)
{
    return stp_ply_writer_wide_points(writer, points, NULL, NULL, count, err);
}

stp_status stp_ply_writer_wide_points(stp_ply_writer *writer, const stp_point *points,
                                      const float *radii, const uint8_t *packed, size_t count,
                                      stp_error *err)
{
    stp_status status = STP_OK;
    const size_t stride =
        writer->params.numbers ? stp_attribute_list_bytes(writer->params.numbers) : 0;
    const stp_ply_writer_params *p = &writer->params;
    if (p->numbers && !packed && count > 0)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%s: points without their attributes",
                             writer->path);
    if (count > p->vertex_count - writer->vertices_written)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: more than the %llu announced points: announce them all",
                             writer->path, (unsigned long long)p->vertex_count);
    while (count > 0) {
        size_t part = count < STP_PLY_BLOCK_RECORDS ? count : STP_PLY_BLOCK_RECORDS;
        unsigned char *end = writer->block;
        for (size_t i = 0; i < part; i++)
            end = put_point(end, &points[i], radii ? radii[i] : 0.0f,
                            packed ? packed + i * stride : NULL, p);
        STP_TRY(
            stp_output_write(writer->output, writer->block, (size_t)(end - writer->block), err));
        writer->vertices_written += part;
        points += part;
        radii = radii ? radii + part : NULL;
        packed = packed ? packed + part * stride : NULL;
        count -= part;
    }
done:
    return status;
}

static stp_status check_triangles(const stp_ply_writer *w, const uint32_t (*triangles)[3],
                                  size_t count, stp_error *err)
{
    if (w->vertices_written < w->params.vertex_count)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: triangles after %llu of %llu points: write all points first",
                             w->path, (unsigned long long)w->vertices_written,
                             (unsigned long long)w->params.vertex_count);
    if (count > w->params.triangle_count - w->triangles_written)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: more than the %llu announced triangles: announce them all",
                             w->path, (unsigned long long)w->params.triangle_count);
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            if (triangles[i][k] >= w->params.vertex_count)
                return stp_error_set(err, STP_INVALID_ARGUMENT,
                                     "%s: triangle %llu names vertex %u of %llu: mend the mesh",
                                     w->path, (unsigned long long)w->triangles_written + i,
                                     triangles[i][k], (unsigned long long)w->params.vertex_count);
    return STP_OK;
}

stp_status stp_ply_writer_triangles(stp_ply_writer *writer, const uint32_t (*triangles)[3],
                                    size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(check_triangles(writer, triangles, count, err));
    while (count > 0) {
        size_t part = count < STP_PLY_BLOCK_RECORDS ? count : STP_PLY_BLOCK_RECORDS;
        unsigned char *end = writer->block;
        for (size_t i = 0; i < part; i++) {
            *end++ = 3;
            for (int k = 0; k < 3; k++)
                end = put_u32(end, triangles[i][k]);
        }
        STP_TRY(
            stp_output_write(writer->output, writer->block, (size_t)(end - writer->block), err));
        writer->triangles_written += part;
        triangles += part;
        count -= part;
    }
done:
    return status;
}

static stp_status check_edges(const stp_ply_writer *w, const uint32_t (*edges)[2], size_t count,
                              stp_error *err)
{
    const stp_ply_writer_params *p = &w->params;
    if (w->vertices_written < p->vertex_count || w->triangles_written < p->triangle_count)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: edges before all points and triangles: write these first",
                             w->path);
    if (count > p->edge_count - w->edges_written)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: more than the %llu announced edges: announce them all", w->path,
                             (unsigned long long)p->edge_count);
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 2; k++)
            if (edges[i][k] >= p->vertex_count)
                return stp_error_set(err, STP_INVALID_ARGUMENT,
                                     "%s: edge %llu names vertex %u of %llu: mend the lines",
                                     w->path, (unsigned long long)w->edges_written + i, edges[i][k],
                                     (unsigned long long)p->vertex_count);
    return STP_OK;
}

stp_status stp_ply_writer_edges(stp_ply_writer *writer, const uint32_t (*edges)[2], size_t count,
                                stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(check_edges(writer, edges, count, err));
    while (count > 0) {
        size_t part = count < STP_PLY_BLOCK_RECORDS ? count : STP_PLY_BLOCK_RECORDS;
        unsigned char *end = writer->block;
        for (size_t i = 0; i < part; i++)
            for (int k = 0; k < 2; k++)
                end = put_u32(end, edges[i][k]);
        STP_TRY(
            stp_output_write(writer->output, writer->block, (size_t)(end - writer->block), err));
        writer->edges_written += part;
        edges += part;
        count -= part;
    }
done:
    return status;
}

stp_status stp_ply_writer_finish(stp_ply_writer **writer, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ply_writer *w = *writer;
    const stp_ply_writer_params *p = &w->params;
    if (w->vertices_written != p->vertex_count || w->triangles_written != p->triangle_count ||
        w->edges_written != p->edge_count) {
        status = stp_error_set(
            err, STP_INVALID_ARGUMENT,
            "%s: %llu of %llu points, %llu of %llu triangles and %llu of %llu edges were written: "
            "write the rest first",
            w->path, (unsigned long long)w->vertices_written, (unsigned long long)p->vertex_count,
            (unsigned long long)w->triangles_written, (unsigned long long)p->triangle_count,
            (unsigned long long)w->edges_written, (unsigned long long)p->edge_count);
        goto done;
    }
    STP_TRY(stp_output_commit(&w->output, err));
done:
    stp_ply_writer_destroy(writer);
    return status;
}

void stp_ply_writer_destroy(stp_ply_writer **writer)
{
    stp_ply_writer *w = *writer;
    if (!w)
        return;
    stp_output_destroy(&w->output);
    free(w->block);
    free(w->path);
    free(w);
    *writer = NULL;
}
