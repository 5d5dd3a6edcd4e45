/* Known surfaces: what `stipple gen` samples, meshes and draws as the truth.
 *
 * A surface is a triangle mesh near it (the proxy, which only says where there is how much area)
 * and a projection of any point near the surface onto it, which is the truth: the exact position,
 * the exact normal, the colour. The tree alone is its mesh: flat triangles, whose vertices have the
 * normals and colours. No surface has state beyond this struct, so nothing is destroyed.
 * Units: the model's own, right-handed; +y up, the terrain +z up. Threads: any, once made. */
#ifndef STP_TOOLS_GEN_SURFACE_H
#define STP_TOOLS_GEN_SURFACE_H

#include "base/error.h"
#include "base/pool.h"
#include "base/vec.h"
#include "formats/scan/scan.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* name, what --help says */
#define GEN_SHAPE_LIST(X)                                                                          \
    X(STATUE, statue)                                                                              \
    X(BUMPY, bumpy)                                                                                \
    X(TERRAIN, terrain)                                                                            \
    X(SPHERE, sphere)                                                                              \
    X(PLANE, plane)                                                                                \
    X(TORUS, torus)                                                                                \
    X(SHEET, sheet)                                                                                \
    X(TREE, tree)

typedef enum gen_shape {
#define X(constant, name) GEN_##constant,
    GEN_SHAPE_LIST(X)
#undef X
        GEN_SHAPE_COUNT
} gen_shape;

/* A point of the true surface. */
typedef struct gen_hit {
    stp_dvec3 position;
    vec3s normal; /* unit, outward */
    vec3s colour; /* 0..1 */
    uint8_t class_id;
} gen_hit;

/* Counter-clockwise triangles seen from outside; every vertex lies on the surface to within float
 * rounding. Owned by whoever built it; gen_mesh_clear frees. */
typedef struct gen_mesh {
    size_t vertex_count;
    size_t triangle_count;
    vec3s *positions;
    uint32_t (*triangles)[3];
    vec3s *normals, *colours; /* of a surface that is its mesh; else NULL: project says them */
} gen_mesh;

typedef struct gen_surface gen_surface;
struct gen_surface {
    gen_shape shape;
    uint64_t seed;          /* of the terrain's relief; the other shapes are always the same */
    double separation;      /* of the sheet's two sides */
    uint64_t mesh_vertices; /* of the tree, about */
    bool closed;
    bool has_class;
    uint64_t proxy_triangles; /* enough for sampling */
    uint64_t mesh_triangles;  /* the default of --mesh */
    stp_dvec3 centre;         /* of a ball that holds the surface */
    double radius;
    /* About so many triangles; the tree has one mesh. Errors: OUT_OF_MEMORY, LIMIT. */
    stp_status (*mesh)(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                       gen_mesh *out, stp_error *err);
    /* The point of the surface that belongs to a point of a proxy triangle; NULL: the mesh is the
     * surface. */
    void (*project)(const gen_surface *surface, stp_dvec3 start, gen_hit *hit);
};

/* The shape's index or GEN_SHAPE_COUNT. */
gen_shape gen_shape_find(const char *name);
/* point_count matters to the statue, whose proxy gets finer with it, to the sheet, whose sides are
 * one sample spacing apart, and to the tree, which has about as many vertices. */
void gen_surface_init(gen_surface *surface, gen_shape shape, uint64_t point_count, uint64_t seed);
void gen_mesh_clear(gen_mesh *mesh);
/* The surface's point at a vertex of its mesh. */
void gen_surface_vertex(const gen_surface *surface, const gen_mesh *mesh, size_t vertex,
                        gen_hit *hit);
/* The point of a triangle at these weights of its corners, which sum to 1; the mesh has normals. */
void gen_mesh_point(const gen_mesh *mesh, size_t triangle, const float weights[3], gen_hit *hit);
/* The scan point of a point of the surface; colours get the eight bits a channel of the files. */
stp_point gen_hit_point(const gen_hit *hit);

/* One file each; called by gen_surface_init on a struct with shape and seed set. */
void gen_statue_init(gen_surface *surface, uint64_t point_count);
void gen_bumpy_init(gen_surface *surface);
void gen_terrain_init(gen_surface *surface);
void gen_sphere_init(gen_surface *surface);
void gen_plane_init(gen_surface *surface);
void gen_torus_init(gen_surface *surface);
void gen_sheet_init(gen_surface *surface, uint64_t point_count);
void gen_tree_init(gen_surface *surface, uint64_t point_count);

#endif
