/* Puts the meshes of a glTF file together as its nodes place them. */
#include "formats/scan/gltf/gltf.h"

#include "base/json.h"
#include "base/memory.h"
#include "formats/scan/gltf/gltf_draco.h"
#include "formats/scan/gltf/gltf_file.h"
#include "formats/scan/gltf/gltf_material.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Vertices and primitives of all nodes, at most: a small file can name one mesh many times. */
#define WALK_LIMIT (UINT64_C(1) << 30)
/* Nodes below each other, at most. */
#define DEPTH_LIMIT 256

/* How a primitive's vertices are joined (glTF 2.0, 5.24). */
enum { POINTS, LINES, LINE_LOOP, LINE_STRIP, TRIANGLES, TRIANGLE_STRIP, TRIANGLE_FAN };

/* A node's place in the scene: p' = linear * p + offset; columns of `linear` follow each other. */
typedef struct placing {
    double linear[9], offset[3];
} placing;

typedef struct scene {
    stp_gltf_file file;
    stp_point_mesh *mesh;
    stp_gltf_place *places; /* by material */
    bool *visited;          /* by node */
    /* By number of a vertex in its accessor: the primitive that used it last, and its point then.
     */
    uint64_t *used;
    size_t used_capacity;
    uint32_t primitive;
    uint64_t walked; /* vertices and primitives, also those that add nothing */
    bool lacks_normals, has_colours, has_images;
} scene;

/* The numbers that a primitive's vertices have; count 0: none. */
typedef struct vertices {
    stp_gltf_numbers position, normal, colour, texture;
    placing at;
    double turned;    /* -1 if the place mirrors, else 1 */
    double factor[3]; /* of colours */
    uint32_t material;
} vertices;

/* ---- places ---- */

static placing combine(const placing *a, const placing *b)
{
    placing c;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++)
            c.linear[3 * k + i] = a->linear[i] * b->linear[3 * k] +
                                  a->linear[3 + i] * b->linear[3 * k + 1] +
                                  a->linear[6 + i] * b->linear[3 * k + 2];
        c.offset[i] = a->linear[i] * b->offset[0] + a->linear[3 + i] * b->offset[1] +
                      a->linear[6 + i] * b->offset[2] + a->offset[i];
    }
    return c;
}

static stp_status read_matrix(const stp_gltf_file *f, const cJSON *matrix, placing *out,
                              stp_error *err)
{
    const cJSON *item = matrix->child;
    double m[16];
    for (int i = 0; i < 16; i++, item = item->next) {
        if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble))
            return stp_gltf_corrupt(f, err, "a node's matrix is not 16 numbers");
        m[i] = item->valuedouble;
    }
    if (!cJSON_IsArray(matrix) || item != NULL)
        return stp_gltf_corrupt(f, err, "a node's matrix is not 16 numbers");
    for (int i = 0; i < 9; i++)
        out->linear[i] = m[4 * (i / 3) + i % 3];
    for (int i = 0; i < 3; i++)
        out->offset[i] = m[12 + i];
    return STP_OK;
}

static stp_status place_of(const stp_gltf_file *f, const cJSON *node, placing *out, stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *matrix = cJSON_GetObjectItemCaseSensitive(node, "matrix");
    double q[4] = {0.0, 0.0, 0.0, 1.0}, s[3] = {1.0, 1.0, 1.0};
    *out = (placing){.linear = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};
    if (matrix != NULL)
        return read_matrix(f, matrix, out, err);
    STP_TRY(stp_json_numbers(node, "translation", out->offset, 3, f->path, err));
    STP_TRY(stp_json_numbers(node, "rotation", q, 4, f->path, err));
    STP_TRY(stp_json_numbers(node, "scale", s, 3, f->path, err));
    const double norm = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int i = 0; i < 4; i++)
        q[i] = norm > 0.0 ? q[i] / norm : i == 3;
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double turn[9] = {
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w),       2.0 * (x * z - y * w),
        2.0 * (x * y - z * w),       1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + x * w),
        2.0 * (x * z + y * w),       2.0 * (y * z - x * w),       1.0 - 2.0 * (x * x + y * y)};
    for (int i = 0; i < 9; i++)
        out->linear[i] = turn[i] * s[i / 3];
done:
    return status;
}

static double cofactor(const placing *p, int row, int column)
{
    const int a = (row + 1) % 3, b = (row + 2) % 3, c = (column + 1) % 3, d = (column + 2) % 3;
    return p->linear[3 * c + a] * p->linear[3 * d + b] -
           p->linear[3 * d + a] * p->linear[3 * c + b];
}

static double determinant(const placing *p)
{
    return p->linear[0] * cofactor(p, 0, 0) + p->linear[1] * cofactor(p, 1, 0) +
           p->linear[2] * cofactor(p, 2, 0);
}

/* ---- vertices ---- */

static stp_point make_point(const vertices *v, size_t i)
{
    stp_point point = {0};
    double p[3], n[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3; k++) {
        p[k] = v->at.offset[k];
        for (unsigned c = 0; c < 3; c++)
            p[k] += v->at.linear[3 * c + (unsigned)k] * stp_gltf_number(&v->position, i, c);
    }
    point.position = (stp_dvec3){p[0], p[1], p[2]};
    for (int k = 0; k < 3 && i < v->normal.count; k++)
        for (int c = 0; c < 3; c++)
            n[k] +=
                v->turned * cofactor(&v->at, k, c) * stp_gltf_number(&v->normal, i, (unsigned)c);
    point.normal = stp_unit_normal((stp_dvec3){n[0], n[1], n[2]});
    for (unsigned k = 0; k < 3; k++) {
        const double shade = i < v->colour.count ? stp_gltf_number(&v->colour, i, k) : 1.0;
        point.rgb[k] = stp_gltf_srgb(v->factor[k] * shade);
    }
    return point;
}

/* The point of a vertex; the first time that the primitive uses it, it is added. */
static stp_status point_of(scene *s, const vertices *v, uint64_t vertex, uint32_t *out,
                           stp_error *err)
{
    stp_status status = STP_OK;
    if (vertex >= v->position.count)
        return stp_gltf_corrupt(&s->file, err, "an index names no vertex");
    if (s->used[vertex] >> 32 == s->primitive) {
        *out = (uint32_t)s->used[vertex];
        return STP_OK;
    }
    STP_TRY(stp_point_mesh_reserve(s->mesh, s->file.path, 1, err));
    *out = (uint32_t)s->mesh->point_count;
    s->mesh->points[s->mesh->point_count++] = make_point(v, (size_t)vertex);
    s->used[vertex] = (uint64_t)s->primitive << 32 | *out;
done:
    return status;
}

static void texture_place(const scene *s, const vertices *v, uint64_t vertex, float out[2])
{
    out[0] = out[1] = NAN;
    if (vertex >= v->texture.count)
        return;
    const stp_gltf_place *p = &s->places[v->material];
    const double x = p->scale[0] * stp_gltf_number(&v->texture, (size_t)vertex, 0);
    const double y = p->scale[1] * stp_gltf_number(&v->texture, (size_t)vertex, 1);
    const double c = cos(p->rotation), n = sin(p->rotation);
    out[0] = stp_texture_place(p->offset[0] + c * x + n * y);
    out[1] = stp_texture_place(1.0 - (p->offset[1] - n * x + c * y)); /* glTF's v goes down */
}

static stp_status add_triangle(scene *s, const vertices *v, const uint64_t corners[3],
                               stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t points[3] = {0};
    float places[3][2] = {{0.0f}};
    const int second = v->turned < 0.0 ? 2 : 1;
    const int order[3] = {0, second, 3 - second};
    for (int k = 0; k < 3; k++) {
        STP_TRY(point_of(s, v, corners[order[k]], &points[k], err));
        texture_place(s, v, corners[order[k]], places[k]);
    }
    STP_TRY(stp_point_mesh_add_triangle(s->mesh, points[0], points[1], points[2], err));
    s->mesh->face_count++;
    if (s->mesh->materials.count > 0)
        STP_TRY(stp_materials_add_triangle(&s->mesh->materials,
                                           v->material < s->mesh->materials.count ? v->material
                                                                                  : STP_NO_MATERIAL,
                                           (const float(*)[2])places, err));
done:
    return status;
}

static stp_status add_line(scene *s, const vertices *v, uint64_t from, uint64_t to, stp_error *err)
{
    stp_status status = STP_OK;
    stp_mesh_edge edge = {0};
    STP_TRY(point_of(s, v, from, &edge.vertices[0], err));
    STP_TRY(point_of(s, v, to, &edge.vertices[1], err));
    STP_TRY(stp_point_mesh_add_edge(s->mesh, &edge, err));
done:
    return status;
}

/* ---- primitives ---- */

/* The vertices of a primitive in their order. */
typedef struct order {
    stp_gltf_numbers indices;
    bool indexed;
    uint64_t count;
} order;

static uint64_t vertex_at(const order *o, uint64_t i)
{
    return o->indexed ? (uint64_t)stp_gltf_number(&o->indices, (size_t)i, 0) : i;
}

static stp_status add_faces(scene *s, const vertices *v, const order *o, uint64_t mode,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t step = mode == TRIANGLES ? 3 : 1;
    for (uint64_t i = 0; i + 2 < o->count; i += step) {
        const uint64_t odd = mode == TRIANGLE_STRIP ? i % 2 : 0; /* every second one is turned */
        const uint64_t corners[3] = {vertex_at(o, mode == TRIANGLE_FAN ? 0 : i),
                                     vertex_at(o, i + 1 + odd), vertex_at(o, i + 2 - odd)};
        STP_TRY(add_triangle(s, v, corners, err));
    }
done:
    return status;
}

static stp_status add_items(scene *s, const vertices *v, const order *o, uint64_t mode,
                            stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t point;
    if (mode >= TRIANGLES)
        return add_faces(s, v, o, mode, err);
    for (uint64_t i = 0; i < o->count; i++) {
        if (mode == POINTS)
            STP_TRY(point_of(s, v, vertex_at(o, i), &point, err));
        else if (mode == LINES ? i % 2 == 1 : i > 0)
            STP_TRY(add_line(s, v, vertex_at(o, i - 1), vertex_at(o, i), err));
    }
    if (mode == LINE_LOOP && o->count > 2)
        STP_TRY(add_line(s, v, vertex_at(o, o->count - 1), vertex_at(o, 0), err));
done:
    return status;
}

/* Reads an attribute if the primitive has it. */
static stp_status attribute(stp_gltf_draco *draco, const cJSON *attributes, const char *name,
                            unsigned components, stp_gltf_numbers *out, stp_error *err)
{
    uint32_t accessor;
    bool found = false;
    stp_status status = stp_gltf_index(draco->file, attributes, name, &accessor, err);
    if (status == STP_OK && accessor != STP_GLTF_NONE)
        status = stp_gltf_draco_numbers(draco, name, accessor, components, out, &found, err);
    if (status != STP_OK || accessor == STP_GLTF_NONE || found)
        return status;
    return stp_gltf_numbers_of(draco->file, accessor, components, out, err);
}

static stp_status read_vertices(scene *s, const cJSON *primitive, stp_gltf_draco *draco,
                                vertices *v, stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *attributes = cJSON_GetObjectItemCaseSensitive(primitive, "attributes");
    const stp_materials *materials = &s->mesh->materials;
    char name[24];
    STP_TRY(attribute(draco, attributes, "POSITION", 1u << 3, &v->position, err));
    STP_TRY(attribute(draco, attributes, "NORMAL", 1u << 3, &v->normal, err));
    STP_TRY(attribute(draco, attributes, "COLOR_0", 1u << 3 | 1u << 4, &v->colour, err));
    STP_TRY(stp_gltf_index(&s->file, primitive, "material", &v->material, err));
    for (int k = 0; k < 3; k++)
        v->factor[k] = 1.0;
    if (v->material < materials->count) {
        snprintf(name, sizeof name, "TEXCOORD_%u", s->places[v->material].set);
        STP_TRY(attribute(draco, attributes, name, 1u << 2, &v->texture, err));
        memcpy(v->factor, s->places[v->material].factor, sizeof v->factor);
    }
    s->lacks_normals |= v->position.count > 0 && v->normal.count < v->position.count;
    s->has_colours |= v->colour.count > 0;
    s->has_images |= v->texture.count > 0 && v->material < materials->count &&
                     materials->list[v->material].image != STP_NO_MATERIAL;
done:
    return status;
}

static stp_status read_order(const scene *s, const cJSON *primitive, stp_gltf_draco *draco,
                             const vertices *v, order *o, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t indices;
    STP_TRY(stp_gltf_index(&s->file, primitive, "indices", &indices, err));
    if (draco->mesh != NULL)
        STP_TRY(stp_gltf_draco_indices(draco, &o->indices, err));
    else if (indices != STP_GLTF_NONE)
        STP_TRY(stp_gltf_numbers_of(&s->file, indices, 1u << 1, &o->indices, err));
    o->indexed = draco->mesh != NULL || indices != STP_GLTF_NONE;
    if (o->indexed &&
        (o->indices.normalized ||
         (o->indices.type != 5121 && o->indices.type != 5123 && o->indices.type != 5125)))
        return stp_gltf_corrupt(&s->file, err, "accessor %u has no indices", indices);
    o->count = o->indexed ? o->indices.count : v->position.count;
done:
    return status;
}

/* Makes room for what the primitive's vertices become. */
static stp_status begin_primitive(scene *s, const vertices *v, const order *o, stp_error *err)
{
    stp_status status = STP_OK;
    s->walked += o->count + 1;
    if (s->walked > WALK_LIMIT)
        return stp_error_set(
            err, STP_LIMIT,
            "%s: its nodes name more than %llu vertices: export it without copies of meshes",
            s->file.path, (unsigned long long)WALK_LIMIT);
    size_t had = s->used_capacity;
    STP_TRY(stp_grow(&s->used, &s->used_capacity, v->position.count + 1, sizeof *s->used,
                     "vertices", err));
    memset(s->used + had, 0, (s->used_capacity - had) * sizeof *s->used);
    if (++s->primitive == 0)
        return stp_error_set(err, STP_LIMIT, "%s: more than %u primitives", s->file.path,
                             UINT32_MAX);
done:
    return status;
}

static stp_status add_primitive(scene *s, const cJSON *primitive, const placing *at, stp_error *err)
{
    stp_status status = STP_OK;
    vertices v = {.at = *at, .turned = determinant(at) < 0.0 ? -1.0 : 1.0};
    stp_gltf_draco draco;
    order o = {0};
    uint64_t mode = TRIANGLES;
    STP_TRY(stp_gltf_draco_open(&draco, &s->file, primitive, err));
    if (draco.mesh == NULL) /* else a list of triangles, also in place of a strip */
        STP_TRY(stp_gltf_whole(&s->file, primitive, "mode", TRIANGLES, &mode, err));
    STP_TRY(read_vertices(s, primitive, &draco, &v, err));
    if (mode > TRIANGLE_FAN)
        STP_TRY(stp_gltf_corrupt(&s->file, err, "a primitive has an unknown mode"));
    STP_TRY(read_order(s, primitive, &draco, &v, &o, err));
    STP_TRY(begin_primitive(s, &v, &o, err));
    STP_TRY(add_items(s, &v, &o, mode, err));
done:
    stp_gltf_draco_close(&draco);
    return status;
}

/* ---- nodes ---- */

static stp_status add_mesh(scene *s, uint32_t index, const placing *at, stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *mesh = stp_gltf_item(&s->file, STP_GLTF_MESHES, index), *primitive;
    if (mesh == NULL)
        return stp_gltf_corrupt(&s->file, err, "a node names no mesh");
    cJSON_ArrayForEach(primitive, cJSON_GetObjectItemCaseSensitive(mesh, "primitives"))
        STP_TRY(add_primitive(s, primitive, at, err));
done:
    return status;
}

static stp_status add_node(scene *s, uint32_t index, const placing *above, int depth,
                           stp_error *err);

// NOLINTNEXTLINE(misc-no-recursion): DEPTH_LIMIT
static stp_status add_nodes(scene *s, const cJSON *list, const placing *above, int depth,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *item;
    cJSON_ArrayForEach(item, list)
    {
        const double number = cJSON_IsNumber(item) ? item->valuedouble : -1.0;
        if (!(number >= 0.0 && number < UINT32_MAX) || (double)(uint32_t)number != number)
            return stp_gltf_corrupt(&s->file, err, "a list of nodes holds no number of a node");
        STP_TRY(add_node(s, (uint32_t)number, above, depth, err));
    }
done:
    return status;
}

/* A node is reached once, since nodes form trees. */
// NOLINTNEXTLINE(misc-no-recursion): DEPTH_LIMIT
static stp_status add_node(scene *s, uint32_t index, const placing *above, int depth,
                           stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *node = stp_gltf_item(&s->file, STP_GLTF_NODES, index);
    placing own;
    uint32_t mesh;
    if (node == NULL || s->visited[index] || depth > DEPTH_LIMIT)
        return stp_gltf_corrupt(&s->file, err, "its nodes are no tree");
    s->visited[index] = true;
    STP_TRY(place_of(&s->file, node, &own, err));
    const placing at = combine(above, &own);
    STP_TRY(stp_gltf_index(&s->file, node, "mesh", &mesh, err));
    if (mesh != STP_GLTF_NONE)
        STP_TRY(add_mesh(s, mesh, &at, err));
    STP_TRY(add_nodes(s, cJSON_GetObjectItemCaseSensitive(node, "children"), &at, depth + 1, err));
done:
    return status;
}

/* Adds the default scene; without scenes, every mesh as it is. */
static stp_status add_scene(scene *s, stp_error *err)
{
    stp_status status = STP_OK;
    const placing origin = {.linear = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};
    uint64_t number;
    STP_TRY(stp_gltf_whole(&s->file, s->file.json, "scene", 0, &number, err));
    const cJSON *first =
        stp_gltf_item(&s->file, STP_GLTF_SCENES, number < STP_GLTF_NONE ? (uint32_t)number : 0);
    if (first != NULL)
        return add_nodes(s, cJSON_GetObjectItemCaseSensitive(first, "nodes"), &origin, 0, err);
    for (uint32_t i = 0; i < s->file.counts[STP_GLTF_MESHES]; i++)
        STP_TRY(add_mesh(s, i, &origin, err));
done:
    return status;
}

stp_status stp_gltf_read(stp_point_mesh *mesh, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    scene s = {.mesh = mesh};
    STP_TRY(stp_gltf_file_open(&s.file, path, err));
    STP_TRY(stp_alloc(&s.visited, (size_t)s.file.counts[STP_GLTF_NODES] + 1, sizeof *s.visited,
                      "nodes", err));
    STP_TRY(stp_gltf_materials(&s.file, &mesh->materials, &s.places, err));
    STP_TRY(add_scene(&s, err));
    if (!s.lacks_normals && mesh->point_count > 0)
        mesh->attributes |= STP_POINT_HAS_NORMAL;
    if (s.has_colours && !s.has_images) /* a mesh has either */
        mesh->attributes |= STP_POINT_HAS_COLOUR;
done:
    stp_gltf_file_close(&s.file);
    free(s.visited);
    free(s.places);
    free(s.used);
    return status;
}
