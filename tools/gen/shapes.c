/* The table of shapes. */
#include "tools/gen/surface.h"

#include <string.h>

gen_shape gen_shape_find(const char *name)
{
    static const char *const names[] = {
#define X(constant, text) #text,
        GEN_SHAPE_LIST(X)
#undef X
    };
    unsigned shape = 0;
    while (shape < GEN_SHAPE_COUNT && strcmp(names[shape], name) != 0)
        shape++;
    return (gen_shape)shape;
}

void gen_surface_init(gen_surface *surface, gen_shape shape, uint64_t point_count, uint64_t seed)
{
    *surface = (gen_surface){.shape = shape, .seed = seed};
    switch (shape) {
    case GEN_STATUE:
        gen_statue_init(surface, point_count);
        break;
    case GEN_BUMPY:
        gen_bumpy_init(surface);
        break;
    case GEN_TERRAIN:
        gen_terrain_init(surface);
        break;
    case GEN_SPHERE:
        gen_sphere_init(surface);
        break;
    case GEN_PLANE:
        gen_plane_init(surface);
        break;
    case GEN_TORUS:
        gen_torus_init(surface);
        break;
    case GEN_TREE:
        gen_tree_init(surface, point_count);
        break;
    case GEN_BUILDING:
        gen_building_init(surface);
        break;
    case GEN_SHEET:
    case GEN_SHAPE_COUNT:
        gen_sheet_init(surface, point_count);
        break;
    }
}
