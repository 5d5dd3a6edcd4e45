/* One part of a plant's mesh with its own numbering. */
#include "preprocess/plant/plant_piece.h"

#include "base/memory.h"
#include "formats/scan/scan.h"

#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX

stp_status stp_plant_piece_create(stp_plant_piece *out, const stp_mesh *mesh,
                                  const stp_mesh_parts *parts, stp_error *err)
{
    stp_status status = STP_OK;
    stp_plant_piece p = {.mesh = mesh, .parts = parts};
    const size_t triangles = parts->most_triangles, corners = 3 * triangles;
    STP_TRY(stp_alloc(&p.corners, triangles, sizeof *p.corners, "a plant's part", err));
    STP_TRY(stp_alloc(&p.vertices, corners, sizeof *p.vertices, "a plant's part", err));
    STP_TRY(stp_alloc(&p.star_begins, corners + 2, sizeof *p.star_begins, "a plant's part", err));
    STP_TRY(stp_alloc(&p.stars, corners, sizeof *p.stars, "a plant's part", err));
    STP_TRY(
        stp_alloc(&p.local, (size_t)mesh->vertex_count, sizeof *p.local, "a plant's part", err));
    if (p.local != NULL)
        memset(p.local, 0xff, (size_t)mesh->vertex_count * sizeof *p.local);
    *out = p;
    p = (stp_plant_piece){0};
done:
    stp_plant_piece_clear(&p);
    return status;
}

void stp_plant_piece_clear(stp_plant_piece *piece)
{
    free(piece->corners);
    free(piece->vertices);
    free(piece->star_begins);
    free(piece->stars);
    free(piece->local);
    *piece = (stp_plant_piece){0};
}

static void add_corner(stp_plant_piece *p, uint32_t triangle, int k)
{
    const uint32_t vertex = p->mesh->triangles[p->triangles[triangle]][k];
    const uint32_t first = p->parts->first_at[vertex];
    if (p->local[first] == NONE) {
        p->local[first] = p->vertex_count;
        p->vertices[p->vertex_count++] = (stp_plant_vertex){.position = p->mesh->positions[first]};
    }
    p->corners[triangle][k] = p->local[first];
    stp_plant_vertex *v = &p->vertices[p->local[first]];
    v->corner_count++;
    if (p->mesh->normals != NULL)
        v->normal = stp_dvec3_add(v->normal, stp_dvec3_from_float(p->mesh->normals[vertex]));
    for (int c = 0; c < 3 && p->mesh->rgb != NULL; c++)
        v->rgb[c] += (double)p->mesh->rgb[vertex][c];
}

/* Lists each vertex's triangles by a counting sort. */
static void list_stars(stp_plant_piece *p)
{
    uint32_t *ends = p->star_begins + 1;
    memset(p->star_begins, 0, ((size_t)p->vertex_count + 2) * sizeof *p->star_begins);
    for (uint32_t v = 0; v < p->vertex_count; v++)
        ends[v + 1] = ends[v] + p->vertices[v].corner_count;
    for (uint32_t i = 0; i < p->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            p->stars[ends[p->corners[i][k]]++] = i;
}

void stp_plant_piece_set(stp_plant_piece *p, uint32_t part)
{
    const uint32_t begin = p->parts->begins[part];
    p->triangles = p->parts->order + begin;
    p->triangle_count = p->parts->begins[part + 1] - begin;
    p->vertex_count = 0;
    for (uint32_t i = 0; i < p->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            add_corner(p, i, k);
    for (uint32_t i = 0; i < p->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            p->local[p->parts->first_at[p->mesh->triangles[p->triangles[i]][k]]] = NONE;
    for (uint32_t i = 0; i < p->vertex_count; i++) {
        stp_plant_vertex *v = &p->vertices[i];
        v->normal = stp_dvec3_scale(v->normal, 1.0 / (double)v->corner_count);
        for (int c = 0; c < 3; c++)
            v->rgb[c] /= (double)v->corner_count;
    }
    list_stars(p);
}

stp_dvec3 stp_plant_triangle_area(const stp_plant_piece *piece, uint32_t triangle)
{
    const uint32_t *c = piece->corners[triangle];
    const stp_dvec3 a = piece->vertices[c[0]].position;
    const stp_dvec3 ab = stp_dvec3_sub(piece->vertices[c[1]].position, a);
    const stp_dvec3 ac = stp_dvec3_sub(piece->vertices[c[2]].position, a);
    return stp_dvec3_scale(stp_dvec3_cross(ab, ac), 0.5);
}

stp_line_vertex stp_plant_line_vertex(const stp_plant_piece *piece, const uint32_t *vertices,
                                      uint32_t count)
{
    stp_line_vertex out = {.rgb = {STP_POINT_GREY, STP_POINT_GREY, STP_POINT_GREY}};
    for (int c = 0; c < 3 && piece->mesh->rgb != NULL; c++) {
        double sum = 0.0;
        for (uint32_t i = 0; i < count; i++)
            sum += piece->vertices[vertices[i]].rgb[c];
        out.rgb[c] = (uint16_t)(sum / (double)count + 0.5);
    }
    return out;
}
