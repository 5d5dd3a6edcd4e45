/* Reads the faces of meshes for maps. */
#include "tools/prep/prep_meshes.h"

#include "base/memory.h"

#include <string.h>

typedef struct joining {
    stp_mesh *all;
    size_t vertex_capacity, triangle_capacity;
} joining;

/* Appends the positions and triangles of a mesh. */
static stp_status append(joining *j, const stp_mesh *mesh, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_mesh *all = j->all;
    const uint32_t before = (uint32_t)all->vertex_count;
    if (all->vertex_count + mesh->vertex_count > UINT32_MAX)
        return stp_error_set(err, STP_LIMIT,
                             "%s: with it the meshes have more than 2^32 vertices: give it to "
                             "another model",
                             path);
    STP_TRY(stp_grow(&all->positions, &j->vertex_capacity, all->vertex_count + mesh->vertex_count,
                     sizeof *all->positions, "positions", err));
    STP_TRY(stp_grow(&all->triangles, &j->triangle_capacity,
                     all->triangle_count + mesh->triangle_count, sizeof *all->triangles,
                     "triangles", err));
    if (mesh->vertex_count > 0)
        memcpy(all->positions + before, mesh->positions,
               mesh->vertex_count * sizeof *mesh->positions);
    for (uint64_t t = 0; t < mesh->triangle_count; t++, all->triangle_count++)
        for (int k = 0; k < 3; k++)
            all->triangles[all->triangle_count][k] = before + mesh->triangles[t][k];
    all->vertex_count += mesh->vertex_count;
done:
    return status;
}

stp_status prep_meshes_read(const prep_inputs *in, stp_mesh **out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_mesh *mesh = NULL;
    joining j = {0};
    for (size_t i = 0; i < in->count; i++) {
        const prep_input *facts = &in->facts[i];
        if (!facts->mesh || facts->why || facts->way.projection || facts->mirror)
            continue;
        STP_TRY(stp_mesh_load(&mesh, in->paths[i], err));
        if (!j.all)
            STP_TRY(stp_alloc(&j.all, 1, sizeof *j.all, "mesh", err));
        STP_TRY(append(&j, mesh, in->paths[i], err));
        stp_mesh_destroy(&mesh);
    }
    *out = j.all;
    j.all = NULL;
done:
    stp_mesh_destroy(&mesh);
    stp_mesh_destroy(&j.all);
    return status;
}
