/* Points and vertices of a surface. */
#include "tools/gen/surface.h"

#include <stdlib.h>

void gen_mesh_clear(gen_mesh *mesh)
{
    free(mesh->positions);
    free(mesh->triangles);
    free(mesh->normals);
    free(mesh->colours);
    *mesh = (gen_mesh){0};
}

void gen_surface_vertex(const gen_surface *surface, const gen_mesh *mesh, size_t vertex,
                        gen_hit *hit)
{
    const stp_dvec3 position = stp_dvec3_from_float(mesh->positions[vertex]);
    if (surface->project != NULL)
        surface->project(surface, position, hit);
    else
        *hit = (gen_hit){
            .position = position, .normal = mesh->normals[vertex], .colour = mesh->colours[vertex]};
}

static vec3s weighted(const vec3s *values, const uint32_t corners[3], const float weights[3])
{
    vec3s sum = {{0.0f, 0.0f, 0.0f}};
    for (int k = 0; k < 3; k++)
        sum = glms_vec3_add(sum, glms_vec3_scale(values[corners[k]], weights[k]));
    return sum;
}

void gen_mesh_point(const gen_mesh *mesh, size_t triangle, const float weights[3], gen_hit *hit)
{
    const uint32_t *corners = mesh->triangles[triangle];
    *hit = (gen_hit){.position = stp_dvec3_from_float(weighted(mesh->positions, corners, weights)),
                     .normal = glms_vec3_normalize(weighted(mesh->normals, corners, weights)),
                     .colour = weighted(mesh->colours, corners, weights)};
}

static uint16_t quantise(float colour)
{
    float level = fminf(fmaxf(colour, 0.0f), 1.0f) * 255.0f + 0.5f;
    return (uint16_t)((unsigned)level * 257u);
}

stp_point gen_hit_point(const gen_hit *hit)
{
    return (stp_point){
        .position = hit->position,
        .normal = hit->normal,
        .rgb = {quantise(hit->colour.x), quantise(hit->colour.y), quantise(hit->colour.z)},
        .class_id = hit->class_id};
}
