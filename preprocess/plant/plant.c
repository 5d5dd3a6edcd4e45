/* Turns a plant's mesh into lines. */
#include "preprocess/plant/plant.h"

#include "base/memory.h"
#include "preprocess/plant/plant_leaf.h"
#include "preprocess/plant/plant_tube.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double default_leaf_size = 0.1;
static const double default_trunk_radius = 1.0 / 128.0;
/* Smaller or larger models stay triangles: squares of their lengths must fit in floats. */
static const double size_range[2] = {1e-18, 1e18};

typedef struct conversion {
    const stp_mesh *mesh;
    double leaf_size, trunk_radius; /* the model's unit */
    stp_mesh_parts parts;
    stp_plant_piece piece;
    stp_plant_tubes tubes;
    stp_plant_lines lines;
    uint8_t *fates; /* by triangle: the stp_line_kind that replaces it; 0: kept */
} conversion;

static stp_status check_params(const stp_plant_params *params, stp_error *err)
{
    const double values[] = {params->leaf_size, params->trunk_radius};
    static const char *const names[] = {"leaf_size", "trunk_radius"};
    for (int i = 0; i < 2; i++)
        if (!(values[i] >= 0.0) || !isfinite(values[i]))
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "%s is %g: give a part of the model's size, 0 for the default",
                                 names[i], values[i]);
    return STP_OK;
}

/* The diagonal of the box around the triangles; 0 without triangles. */
static double diagonal(const stp_mesh *mesh)
{
    stp_dbox box = stp_dbox_empty();
    for (uint64_t i = 0; i < mesh->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            const stp_dvec3 p = mesh->positions[mesh->triangles[i][k]];
            if (stp_dvec3_finite(p))
                stp_dbox_add(&box, p);
        }
    return stp_dbox_is_empty(&box) ? 0.0 : stp_dvec3_length(stp_dvec3_sub(box.max, box.min));
}

static stp_status convert_part(conversion *c, uint32_t part, stp_error *err)
{
    stp_line_vertex ribbon[STP_PLANT_RIBBON_VERTICES];
    stp_plant_piece_set(&c->piece, part);
    const uint32_t count = stp_plant_leaf_read(&c->piece, c->leaf_size, ribbon);
    if (count == 0)
        return stp_plant_tubes_find(&c->tubes, &c->piece, c->trunk_radius, &c->lines, c->fates,
                                    err);
    for (uint32_t i = 0; i < c->piece.triangle_count; i++)
        c->fates[c->piece.triangles[i]] = STP_LINE_RIBBON;
    return stp_plant_lines_add(&c->lines, STP_LINE_RIBBON, ribbon, count, err);
}

static stp_status convert_parts(conversion *c, const stp_plant_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    const double size = diagonal(c->mesh);
    const double leaf = params->leaf_size, trunk = params->trunk_radius;
    c->leaf_size = size * (leaf > 0.0 ? leaf : default_leaf_size);
    c->trunk_radius = size * (trunk > 0.0 ? trunk : default_trunk_radius);
    STP_TRY(stp_mesh_parts_find(&c->parts, c->mesh, err));
    STP_TRY(stp_plant_piece_create(&c->piece, c->mesh, &c->parts, err));
    STP_TRY(stp_plant_tubes_create(&c->tubes, c->parts.most_triangles, err));
    const bool is_measurable = size > size_range[0] && size < size_range[1];
    for (uint32_t i = 0; is_measurable && i < c->parts.part_count; i++)
        STP_TRY(convert_part(c, i, err));
    for (uint64_t i = 0; i < c->mesh->triangle_count; i++)
        c->fates[i] = c->fates[c->parts.first_same[i]];
done:
    return status;
}

static stp_status alloc_mesh(stp_mesh **out, const stp_mesh *like, uint64_t vertices,
                             uint64_t triangles, stp_error *err)
{
    stp_status status = STP_OK;
    stp_mesh *m = NULL;
    const size_t v = (size_t)vertices, t = (size_t)triangles;
    STP_TRY(stp_alloc(&m, 1, sizeof *m, "mesh", err));
    STP_TRY(stp_alloc(&m->positions, v, sizeof *m->positions, "positions", err));
    if (like->normals != NULL)
        STP_TRY(stp_alloc(&m->normals, v, sizeof *m->normals, "normals", err));
    if (like->rgb != NULL)
        STP_TRY(stp_alloc(&m->rgb, v, sizeof *m->rgb, "colours", err));
    STP_TRY(stp_alloc(&m->triangles, t, sizeof *m->triangles, "triangles", err));
    *out = m;
    m = NULL;
done:
    stp_mesh_destroy(&m);
    return status;
}

static void copy_vertex(stp_mesh *to, const stp_mesh *from, uint32_t vertex)
{
    const size_t i = (size_t)to->vertex_count++;
    to->positions[i] = from->positions[vertex];
    if (from->normals != NULL)
        to->normals[i] = from->normals[vertex];
    if (from->rgb != NULL)
        memcpy(to->rgb[i], from->rgb[vertex], sizeof to->rgb[i]);
}

/* Makes a mesh of the kept triangles and their vertices, in the mesh's order. */
static stp_status make_rest(stp_mesh **out, const stp_mesh *mesh, const uint8_t *fates,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_mesh *rest = NULL;
    uint32_t *places = NULL; /* by vertex: its place from 1; 0: unused */
    uint64_t vertex_count = 0, triangle_count = 0;
    STP_TRY(stp_alloc(&places, (size_t)mesh->vertex_count, sizeof *places, "vertices", err));
    for (uint64_t i = 0; i < mesh->triangle_count; i++) {
        for (int k = 0; k < 3 && !fates[i]; k++) {
            uint32_t *place = &places[mesh->triangles[i][k]];
            vertex_count += *place == 0;
            *place = 1;
        }
        triangle_count += !fates[i];
    }
    STP_TRY(alloc_mesh(&rest, mesh, vertex_count, triangle_count, err));
    for (uint32_t v = 0; v < mesh->vertex_count; v++)
        if (places[v] != 0) {
            copy_vertex(rest, mesh, v);
            places[v] = (uint32_t)rest->vertex_count;
        }
    for (uint64_t i = 0; i < mesh->triangle_count; i++) {
        if (fates[i])
            continue;
        for (int k = 0; k < 3; k++)
            rest->triangles[rest->triangle_count][k] = places[mesh->triangles[i][k]] - 1;
        rest->triangle_count++;
    }
    *out = rest;
done:
    free(places);
    return status;
}

static stp_plant_report make_report(const conversion *c, const stp_mesh *rest)
{
    const stp_line_set *lines = &c->lines.set;
    stp_plant_report report = {.vertices_before = c->mesh->vertex_count,
                               .positions_before = c->parts.position_count,
                               .vertices_after = lines->vertex_count + rest->vertex_count,
                               .triangles = c->mesh->triangle_count};
    for (uint64_t i = 0; i < c->mesh->triangle_count; i++) {
        report.ribbon_triangles += c->fates[i] == STP_LINE_RIBBON;
        report.tube_triangles += c->fates[i] == STP_LINE_TUBE;
        report.kept_triangles += c->fates[i] == 0;
    }
    for (uint64_t i = 0; i < lines->strip_count; i++) {
        const stp_line_strip *strip = &lines->strips[i];
        report.ribbons += strip->kind == STP_LINE_RIBBON;
        report.tubes += strip->kind == STP_LINE_TUBE;
        report.rings += strip->kind == STP_LINE_TUBE ? strip->count : 0;
    }
    return report;
}

stp_status stp_plant_convert(stp_plant *out, const stp_mesh *mesh, const stp_plant_params *params,
                             stp_error *err)
{
    stp_status status = STP_OK;
    conversion c = {.mesh = mesh};
    stp_plant plant = {0};
    const stp_plant_params chosen = params != NULL ? *params : (stp_plant_params){0};
    STP_TRY(check_params(&chosen, err));
    STP_TRY(stp_alloc(&c.fates, (size_t)mesh->triangle_count, sizeof *c.fates, "triangles", err));
    STP_TRY(convert_parts(&c, &chosen, err));
    STP_TRY(make_rest(&plant.rest, mesh, c.fates, err));
    plant.report = make_report(&c, plant.rest);
    plant.lines = c.lines.set;
    c.lines.set = (stp_line_set){0};
    *out = plant;
done:
    stp_line_set_clear(&c.lines.set);
    stp_plant_tubes_clear(&c.tubes);
    stp_plant_piece_clear(&c.piece);
    stp_mesh_parts_clear(&c.parts);
    free(c.fates);
    return status;
}

void stp_plant_clear(stp_plant *plant)
{
    stp_line_set_clear(&plant->lines);
    stp_mesh_destroy(&plant->rest);
    plant->report = (stp_plant_report){0};
}
