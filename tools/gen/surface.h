/* Known surfaces that `stipple gen` samples, meshes and draws as the truth.
 *
 * A surface is a proxy and a projection. The proxy is a triangle mesh near the surface; it only
 * says where there is how much area. The projection takes any point near the surface onto it and
 * gives the truth: the exact position, the exact normal, the colour. The tree and the building
 * are their own meshes: flat triangles, whose vertices have the normals and colours. No surface has
 * state beyond this struct, so nothing is destroyed. Units: the model's own, right-handed; +y up,
 * terrain and building +z up. Threads: any, once made. */
#ifndef STP_TOOLS_GEN_SURFACE_H
#define STP_TOOLS_GEN_SURFACE_H

#include "base/error.h"
#include "base/pool.h"
#include "base/vec.h"
#include "formats/scan/scan.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* X(constant, name in --help) */
#define GEN_SHAPE_LIST(X)                                                                          \
    X(STATUE, statue)                                                                              \
    X(BUMPY, bumpy)                                                                                \
    X(TERRAIN, terrain)                                                                            \
    X(SPHERE, sphere)                                                                              \
    X(PLANE, plane)                                                                                \
    X(TORUS, torus)                                                                                \
    X(SHEET, sheet)                                                                                \
    X(TREE, tree)                                                                                  \
    X(BUILDING, building)

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

/* Triangles, counter-clockwise seen from outside. Every vertex lies on the surface to within float
 * rounding. Owned by its maker; gen_mesh_clear frees it. */
typedef struct gen_mesh {
    size_t vertex_count;
    size_t triangle_count;
    vec3s *positions;
    uint32_t (*triangles)[3];
    vec3s *normals, *colours; /* if the surface is its own mesh; else NULL: project computes them */
} gen_mesh;

typedef struct gen_surface gen_surface;
struct gen_surface {
    gen_shape shape;
    uint64_t seed;          /* seed of the terrain's relief; other shapes never change */
    double separation;      /* distance between the sheet's two sides */
    uint64_t mesh_vertices; /* approximate number of vertices of the tree */
    bool closed;
    bool has_class;
    uint64_t proxy_triangles; /* number of triangles that is enough for sampling */
    uint64_t mesh_triangles;  /* the default of --mesh */
    stp_dvec3 centre;         /* centre of a ball around the surface */
    double radius;
    /* Makes a mesh of about triangle_count triangles; tree and building have only one mesh. Errors:
     * OUT_OF_MEMORY, LIMIT. */
    stp_status (*mesh)(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                       gen_mesh *out, stp_error *err);
    /* Gets the point of the surface for a point of a proxy triangle. NULL: the mesh is the surface.
     */
    void (*project)(const gen_surface *surface, stp_dvec3 start, gen_hit *hit);
};

/* Returns the shape, GEN_SHAPE_COUNT if there is none of this name. */
gen_shape gen_shape_find(const char *name);
/* Three shapes depend on point_count: the statue's proxy gets finer with it, the sheet's sides are
 * one sample spacing apart, and the tree has about as many vertices. */
void gen_surface_init(gen_surface *surface, gen_shape shape, uint64_t point_count, uint64_t seed);
void gen_mesh_clear(gen_mesh *mesh);
/* Gets the surface's point at a vertex of its mesh. */
void gen_surface_vertex(const gen_surface *surface, const gen_mesh *mesh, size_t vertex,
                        gen_hit *hit);
/* Gets the point of a triangle at these weights of its corners, whose sum is 1. The mesh must have
 * normals. */
void gen_mesh_point(const gen_mesh *mesh, size_t triangle, const float weights[3], gen_hit *hit);
/* Converts a point of the surface to a scan point. Colours get 8 bits per channel, as in files. */
stp_point gen_hit_point(const gen_hit *hit);

/* Each has a file of its own. gen_surface_init calls them on a struct with shape and seed set. */
void gen_statue_init(gen_surface *surface, uint64_t point_count);
void gen_bumpy_init(gen_surface *surface);
void gen_terrain_init(gen_surface *surface);
void gen_sphere_init(gen_surface *surface);
void gen_plane_init(gen_surface *surface);
void gen_torus_init(gen_surface *surface);
void gen_sheet_init(gen_surface *surface, uint64_t point_count);
void gen_tree_init(gen_surface *surface, uint64_t point_count);
void gen_building_init(gen_surface *surface);

#endif
