/* Gives the vertices of a mesh the colours of the faces around them. */
#include "formats/scan/mesh/mesh_colours.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Least difference of two channels of a colour that is no grey, of 65535. */
#define HUE_LEAST 4096

/* Whether a colour is none of the greys that programs write for no colour. */
static bool is_hue(const uint16_t rgb[3])
{
    uint16_t least = UINT16_MAX, most = 0;
    for (int c = 0; c < 3; c++) {
        least = rgb[c] < least ? rgb[c] : least;
        most = rgb[c] > most ? rgb[c] : most;
    }
    return most - least > HUE_LEAST;
}

/* Whether faces differ in colour, or have one that is no grey. */
static bool are_coloured(const stp_materials *m)
{
    const uint16_t *first = NULL;
    for (size_t t = 0; t < m->triangle_count; t++) {
        if (stp_materials_textured(m, t))
            return true;
        if (m->of_triangle[t] == STP_NO_MATERIAL)
            continue;
        const uint16_t *rgb = m->list[m->of_triangle[t]].rgb;
        if ((first && memcmp(first, rgb, 3 * sizeof *rgb) != 0) || is_hue(rgb))
            return true;
        first = rgb;
    }
    return false;
}

typedef struct colour_sum {
    float rgb[3];
    uint32_t count;
} colour_sum;

static void add_corners(const stp_point_mesh *mesh, size_t t, colour_sum *sums)
{
    const stp_materials *m = &mesh->materials;
    const double texels = 2.0 * stp_materials_texels(m, t); /* a vertex has two triangles */
    for (int k = 0; k < 3; k++) {
        double weights[3] = {0.0, 0.0, 0.0};
        uint16_t rgb[3];
        weights[k] = 1.0;
        if (!stp_materials_colour(m, t, weights, texels, rgb))
            continue;
        colour_sum *sum = &sums[mesh->triangles[t][k]];
        for (int c = 0; c < 3; c++)
            sum->rgb[c] += (float)rgb[c];
        sum->count++;
    }
}

static stp_status colour_vertices(stp_point_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    colour_sum *sums = NULL;
    STP_TRY(stp_alloc(&sums, mesh->point_count, sizeof *sums, "colours", err));
    for (size_t t = 0; t < mesh->triangle_count; t++)
        add_corners(mesh, t, sums);
    for (size_t i = 0; i < mesh->point_count; i++)
        for (int c = 0; c < 3; c++)
            mesh->points[i].rgb[c] = sums[i].count > 0
                                         ? (uint16_t)lrintf(sums[i].rgb[c] / (float)sums[i].count)
                                         : STP_POINT_GREY;
    mesh->attributes |= STP_POINT_HAS_COLOUR;
done:
    free(sums);
    return status;
}

/* Whether the vertices have one grey all: a program wrote it for want of colours. */
static bool are_plain(const stp_point_mesh *mesh)
{
    const stp_point *p = mesh->points;
    size_t i = 1;
    if (mesh->point_count > 0 && is_hue(p[0].rgb))
        return false;
    while (i < mesh->point_count && memcmp(p[0].rgb, p[i].rgb, sizeof p->rgb) == 0)
        i++;
    return i >= mesh->point_count;
}

stp_status stp_mesh_take_colours(stp_point_mesh *mesh, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_materials *m = &mesh->materials;
    /* If a face was left out, nothing says which triangle has which material. */
    bool usable = m->triangle_count > 0 && m->triangle_count == mesh->triangle_count &&
                  ((mesh->attributes & STP_POINT_HAS_COLOUR) == 0 || are_plain(mesh));
    if (usable) {
        STP_TRY(stp_materials_load_images(m, path, err));
        usable = are_coloured(m);
    }
    if (usable)
        STP_TRY(colour_vertices(mesh, err));
    else
        stp_materials_clear(m);
done:
    return status;
}
