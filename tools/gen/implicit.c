/* Marching tetrahedra on a body-centred cubic lattice, block by block; projection by Newton steps.
 */
#include "tools/gen/implicit.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* Number of cubes per block along each axis. */
enum { BLOCK = 4, CORNERS = BLOCK + 1, CENTRES = BLOCK + 1, LOCAL_HASH = 1u << 11 };

/* The key of a lattice edge is the sum of its ends' doubled coordinates (corners even, centres
 * odd), 21 bits per axis. All sums differ. */
typedef uint64_t edge_key;

typedef struct block {
    int x, y, z; /* first cube */
    size_t vertex_count, triangle_count;
    size_t vertex_capacity, triangle_capacity;
    edge_key *keys;
    vec3s *positions;
    uint32_t (*triangles)[3];
} block;

typedef struct mesher {
    gen_implicit *f;
    vec3s origin;
    float cell;
    block *blocks;
} mesher;

/* Values at a block's nodes. Centres reach one cube beyond the low sides. */
typedef struct block_work {
    float corners[CORNERS][CORNERS][CORNERS];
    float centres[CENTRES][CENTRES][CENTRES];
    edge_key hash_keys[LOCAL_HASH]; /* 0: empty; no edge has key 0 */
    uint32_t hash_values[LOCAL_HASH];
} block_work;

typedef struct node {
    int x, y, z; /* doubled lattice coordinates */
    float value;
} node;

static vec3s node_position(const mesher *m, int x, int y, int z)
{
    float half = 0.5f * m->cell;
    return (vec3s){{m->origin.x + half * (float)x, m->origin.y + half * (float)y,
                    m->origin.z + half * (float)z}};
}

/* Finds the root of f between two nodes of opposite sign: regula falsi, Illinois variant. */
static vec3s edge_root(const mesher *m, const node *a, const node *b)
{
    /* Takes the ends in a fixed order, whichever tetrahedron asks, so that neighbours agree to the
     * last bit. */
    bool swap = a->x != b->x ? a->x > b->x : a->y != b->y ? a->y > b->y : a->z > b->z;
    const node *low = swap ? b : a, *high = swap ? a : b;
    vec3s p = node_position(m, low->x, low->y, low->z);
    vec3s q = node_position(m, high->x, high->y, high->z);
    float s = 0.0f, t = 1.0f, fs = low->value, ft = high->value, u = 0.5f;
    vec3s r = p;
    for (int step = 0; step < 24; step++) {
        u = fs == ft ? 0.5f * (s + t) : (s * ft - t * fs) / (ft - fs);
        r = (vec3s){{p.x + (q.x - p.x) * u, p.y + (q.y - p.y) * u, p.z + (q.z - p.z) * u}};
        float value = m->f(r, NULL)[0];
        if (fabsf(value) < 1e-7f || t - s < 1e-6f)
            break;
        if ((value < 0.0f) == (ft < 0.0f)) {
            t = u;
            ft = value;
            fs *= 0.5f;
        } else {
            s = u;
            fs = value;
            ft *= 0.5f;
        }
    }
    return r;
}

static stp_status edge_vertex(const mesher *m, block *b, block_work *work, const node *p,
                              const node *q, uint32_t *index, stp_error *err)
{
    edge_key key =
        (edge_key)(p->x + q->x) | (edge_key)(p->y + q->y) << 21 | (edge_key)(p->z + q->z) << 42;
    size_t slot = (size_t)((key * 0x9e3779b97f4a7c15u) >> 53);
    while (work->hash_keys[slot] != 0 && work->hash_keys[slot] != key)
        slot = (slot + 1) % LOCAL_HASH;
    if (work->hash_keys[slot] == key) {
        *index = work->hash_values[slot];
        return STP_OK;
    }
    stp_status status = STP_OK;
    if (b->vertex_count >= LOCAL_HASH * 3 / 4)
        return stp_error_set(err, STP_LIMIT, "the surface is too dense for its mesh cell");
    if (b->vertex_count == b->vertex_capacity) {
        size_t capacity = b->vertex_capacity;
        STP_TRY(stp_grow(&b->keys, &capacity, b->vertex_count + 1, sizeof *b->keys, "mesh", err));
        capacity = b->vertex_capacity;
        STP_TRY(stp_grow(&b->positions, &capacity, b->vertex_count + 1, sizeof *b->positions,
                         "mesh", err));
        b->vertex_capacity = capacity;
    }
    *index = (uint32_t)b->vertex_count++;
    b->keys[*index] = key;
    b->positions[*index] = edge_root(m, p, q);
    work->hash_keys[slot] = key;
    work->hash_values[slot] = *index;
done:
    return status;
}

static stp_status add_triangle(block *b, uint32_t i, uint32_t j, uint32_t k, stp_error *err)
{
    stp_status status = stp_grow(&b->triangles, &b->triangle_capacity, b->triangle_count + 1,
                                 sizeof *b->triangles, "mesh", err);
    if (status != STP_OK)
        return status;
    uint32_t *triangle = b->triangles[b->triangle_count++];
    triangle[0] = i;
    triangle[1] = j;
    triangle[2] = k;
    return STP_OK;
}

/* Even permutations of a tetrahedron's corners. First comes the inside corner (if one is inside),
 * the outside corner (if three are inside), or the two inside corners. */
static const uint8_t tet_order[16][4] = {{0, 1, 2, 3}, {0, 1, 2, 3}, {1, 0, 3, 2}, {0, 1, 2, 3},
                                         {2, 3, 0, 1}, {0, 2, 3, 1}, {1, 2, 0, 3}, {3, 2, 1, 0},
                                         {3, 2, 1, 0}, {0, 3, 1, 2}, {1, 3, 2, 0}, {2, 3, 0, 1},
                                         {2, 3, 0, 1}, {1, 0, 3, 2}, {0, 1, 2, 3}, {0, 1, 2, 3}};

/* Adds the surface inside one positively oriented tetrahedron. */
static stp_status march(const mesher *m, block *b, block_work *work, const node corners[4],
                        stp_error *err)
{
    unsigned mask = 0;
    for (unsigned i = 0; i < 4; i++)
        mask |= (corners[i].value < 0.0f ? 1u : 0u) << i;
    if (mask == 0 || mask == 15)
        return STP_OK;
    stp_status status = STP_OK;
    const node *p = &corners[tet_order[mask][0]], *q = &corners[tet_order[mask][1]];
    const node *r = &corners[tet_order[mask][2]], *s = &corners[tet_order[mask][3]];
    uint32_t v[4];
    int inside = __builtin_popcount(mask);
    if (inside == 2) {
        STP_TRY(edge_vertex(m, b, work, p, r, &v[0], err));
        STP_TRY(edge_vertex(m, b, work, p, s, &v[1], err));
        STP_TRY(edge_vertex(m, b, work, q, s, &v[2], err));
        STP_TRY(edge_vertex(m, b, work, q, r, &v[3], err));
        STP_TRY(add_triangle(b, v[0], v[1], v[2], err));
        STP_TRY(add_triangle(b, v[0], v[2], v[3], err));
    } else {
        STP_TRY(edge_vertex(m, b, work, p, q, &v[0], err));
        STP_TRY(edge_vertex(m, b, work, p, inside == 1 ? r : s, &v[1], err));
        STP_TRY(edge_vertex(m, b, work, p, inside == 1 ? s : r, &v[2], err));
        STP_TRY(add_triangle(b, v[0], v[1], v[2], err));
    }
done:
    return status;
}

static node corner_node(const block *b, const block_work *work, const int at[3])
{
    return (node){2 * (b->x + at[0]), 2 * (b->y + at[1]), 2 * (b->z + at[2]),
                  work->corners[at[2]][at[1]][at[0]]};
}

/* at is the cube; -1 is the neighbour on the low side. */
static node centre_node(const block *b, const block_work *work, const int at[3])
{
    return (node){2 * (b->x + at[0]) + 1, 2 * (b->y + at[1]) + 1, 2 * (b->z + at[2]) + 1,
                  work->centres[at[2] + 1][at[1] + 1][at[0] + 1]};
}

/* Marches the four tetrahedra around the low face of a cube across one axis. */
static stp_status march_face(const mesher *m, block *b, block_work *work, const int cube[3],
                             int axis, stp_error *err)
{
    static const int ring[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    int low[3] = {cube[0], cube[1], cube[2]};
    low[axis]--;
    node tet[4] = {centre_node(b, work, low), centre_node(b, work, cube)};
    int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int i = 0; i < 4; i++) {
        for (int end = 0; end < 2; end++) {
            int at[3] = {cube[0], cube[1], cube[2]};
            at[u] += ring[i + end][0];
            at[v] += ring[i + end][1];
            tet[2 + end] = corner_node(b, work, at);
        }
        stp_status status = march(m, b, work, tet, err);
        if (status != STP_OK)
            return status;
    }
    return STP_OK;
}

static void evaluate_block(const mesher *m, const block *b, block_work *work)
{
    for (int z = 0; z < CORNERS; z++)
        for (int y = 0; y < CORNERS; y++)
            for (int x = 0; x < CORNERS; x++) {
                int u = 2 * (b->x + x), v = 2 * (b->y + y), w = 2 * (b->z + z);
                work->corners[z][y][x] = m->f(node_position(m, u, v, w), NULL)[0];
                work->centres[z][y][x] = m->f(node_position(m, u - 1, v - 1, w - 1), NULL)[0];
            }
    memset(work->hash_keys, 0, sizeof work->hash_keys);
}

static stp_status mesh_block(void *context, size_t index, unsigned worker, stp_error *err)
{
    (void)worker;
    const mesher *m = context;
    block *b = &m->blocks[index];
    block_work *work = NULL;
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&work, 1, sizeof *work, "mesh block", err));
    evaluate_block(m, b, work);
    for (int z = 0; z < BLOCK; z++)
        for (int y = 0; y < BLOCK; y++)
            for (int x = 0; x < BLOCK; x++)
                for (int axis = 0; axis < 3; axis++)
                    STP_TRY(march_face(m, b, work, (int[3]){x, y, z}, axis, err));
done:
    free(work);
    return status;
}

/* Finds the blocks that the surface may pass through: their middle is near enough to it. */
static stp_status find_blocks(mesher *m, const gen_implicit_box *box, size_t *block_count,
                              stp_error *err)
{
    size_t capacity = 0;
    float side = m->cell * (float)BLOCK;
    int count[3];
    for (int axis = 0; axis < 3; axis++)
        count[axis] = (int)ceilf((box->max.raw[axis] - box->min.raw[axis]) / side) + 1;
    /* Half the diagonal of a block with its low neighbours. */
    float reach = box->lipschitz * 0.8660254f * (side + m->cell);
    *block_count = 0;
    for (int z = 0; z < count[2]; z++)
        for (int y = 0; y < count[1]; y++)
            for (int x = 0; x < count[0]; x++) {
                int at[3] = {x * BLOCK + 1, y * BLOCK + 1, z * BLOCK + 1};
                vec3s middle = node_position(m, 2 * at[0] + BLOCK - 1, 2 * at[1] + BLOCK - 1,
                                             2 * at[2] + BLOCK - 1);
                if (fabsf(m->f(middle, NULL)[0]) > reach)
                    continue;
                stp_status status = stp_grow(&m->blocks, &capacity, *block_count + 1,
                                             sizeof *m->blocks, "mesh blocks", err);
                if (status != STP_OK)
                    return status;
                m->blocks[(*block_count)++] = (block){.x = at[0], .y = at[1], .z = at[2]};
            }
    return STP_OK;
}

/* Gives equal keys of different blocks one vertex, and fills out. */
static stp_status join_blocks(const mesher *m, size_t block_count, gen_mesh *out, stp_error *err)
{
    stp_status status = STP_OK;
    size_t vertex_limit = 0, triangle_count = 0, table_bits = 10;
    edge_key *table = NULL;
    uint32_t *values = NULL, *map = NULL;
    gen_mesh mesh = {0};
    for (size_t i = 0; i < block_count; i++) {
        vertex_limit += m->blocks[i].vertex_count;
        triangle_count += m->blocks[i].triangle_count;
    }
    while (((size_t)1 << table_bits) < 2 * vertex_limit)
        table_bits++;
    size_t mask = ((size_t)1 << table_bits) - 1;
    if (vertex_limit > UINT32_MAX) {
        status =
            stp_error_set(err, STP_LIMIT, "the mesh has more than 2^32 vertices; ask for fewer");
        goto done;
    }
    STP_TRY(stp_alloc(&table, mask + 1, sizeof *table, "mesh vertex table", err));
    STP_TRY(stp_alloc(&values, mask + 1, sizeof *values, "mesh vertex table", err));
    STP_TRY(stp_alloc(&map, LOCAL_HASH, sizeof *map, "mesh vertex table", err));
    STP_TRY(stp_alloc(&mesh.positions, vertex_limit, sizeof *mesh.positions, "mesh", err));
    STP_TRY(stp_alloc(&mesh.triangles, triangle_count, sizeof *mesh.triangles, "mesh", err));
    for (size_t i = 0; i < block_count; i++) {
        const block *b = &m->blocks[i];
        for (size_t j = 0; j < b->vertex_count; j++) {
            size_t slot = (size_t)((b->keys[j] * 0x9e3779b97f4a7c15u) >> (64 - table_bits));
            while (table[slot] != 0 && table[slot] != b->keys[j])
                slot = (slot + 1) & mask;
            if (table[slot] == 0) {
                table[slot] = b->keys[j];
                values[slot] = (uint32_t)mesh.vertex_count;
                mesh.positions[mesh.vertex_count++] = b->positions[j];
            }
            map[j] = values[slot];
        }
        for (size_t j = 0; j < b->triangle_count; j++, mesh.triangle_count++)
            for (int k = 0; k < 3; k++)
                mesh.triangles[mesh.triangle_count][k] = map[b->triangles[j][k]];
    }
    *out = mesh;
    mesh = (gen_mesh){0};
done:
    free(table);
    free(values);
    free(map);
    gen_mesh_clear(&mesh);
    return status;
}

stp_status gen_implicit_mesh(gen_implicit *f, const gen_implicit_box *box, float cell,
                             stp_pool *pool, gen_mesh *out, stp_error *err)
{
    mesher m = {.f = f, .origin = box->min, .cell = cell};
    size_t block_count = 0;
    stp_status status = STP_OK;
    /* The keys' space: 21 bits for twice the doubled coordinate. */
    for (int axis = 0; axis < 3; axis++)
        if ((box->max.raw[axis] - box->min.raw[axis]) / cell > 500000.0f) {
            status = stp_error_set(err, STP_LIMIT, "the mesh would be too fine; ask for less");
            goto done;
        }
    STP_TRY(find_blocks(&m, box, &block_count, err));
    STP_TRY(stp_pool_run(pool, block_count, mesh_block, &m, err));
    STP_TRY(join_blocks(&m, block_count, out, err));
done:
    for (size_t i = 0; i < block_count; i++) {
        free(m.blocks[i].keys);
        free(m.blocks[i].positions);
        free(m.blocks[i].triangles);
    }
    free(m.blocks);
    return status;
}

/* Returns f at p, and the unit normal if there is a gradient. */
static float value_at(gen_implicit *f, vec3s p, vec3s *normal, unsigned *part, float *slope)
{
    gen_dual value = f(p, part);
    float length = sqrtf(value[1] * value[1] + value[2] * value[2] + value[3] * value[3]);
    *slope = length;
    if (length > 1e-6f) {
        float inverse = 1.0f / length;
        *normal = (vec3s){{value[1] * inverse, value[2] * inverse, value[3] * inverse}};
    }
    return value[0];
}

static vec3s between(vec3s a, vec3s b, float t)
{
    return (vec3s){{a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, a.z + (b.z - a.z) * t}};
}

/* Halves the segment from a (f below 0) to b until no float lies between. */
static vec3s bisect(gen_implicit *f, vec3s a, vec3s b, vec3s *normal, unsigned *part)
{
    vec3s middle = a;
    for (int step = 0; step < 32; step++) {
        float slope;
        middle = between(a, b, 0.5f);
        if (value_at(f, middle, normal, part, &slope) < 0.0f)
            a = middle;
        else
            b = middle;
    }
    return middle;
}

/* Used if Newton's steps do not settle: searches along a line, ever further, for a change of sign.
 */
static vec3s search(gen_implicit *f, vec3s start, float reach, vec3s *normal, unsigned *part)
{
    float slope;
    vec3s along = *normal;
    bool inside = value_at(f, start, normal, part, &slope) < 0.0f;
    if (slope > 1e-6f)
        along = *normal;
    for (float away = 0.002f * reach; away < 2.0f * reach; away *= 1.25f)
        for (int side = -1; side < 2; side += 2) {
            float t = away * (float)side;
            vec3s p = {{start.x + along.x * t, start.y + along.y * t, start.z + along.z * t}};
            vec3s unused;
            if ((value_at(f, p, &unused, NULL, &slope) < 0.0f) != inside)
                return inside ? bisect(f, start, p, normal, part)
                              : bisect(f, p, start, normal, part);
        }
    return start;
}

vec3s gen_implicit_project(gen_implicit *f, vec3s start, float reach, vec3s *normal, unsigned *part)
{
    vec3s p = start, *seen[2] = {NULL, NULL}, ends[2];
    *normal = (vec3s){{0.0f, 1.0f, 0.0f}};
    for (int step = 0; step < 10; step++) {
        float slope, value = value_at(f, p, normal, part, &slope);
        if (!(slope > 1e-6f))
            break;
        float move = -value / slope;
        /* The remaining distance. In this short step the normal turns by less than curvature times
         * the step. */
        bool done = fabsf(move) < 4e-6f;
        int side = value < 0.0f ? 0 : 1;
        ends[side] = p;
        seen[side] = &ends[side];
        move = fminf(fmaxf(move, -0.5f * reach), 0.5f * reach);
        p = (vec3s){{p.x + move * normal->x, p.y + move * normal->y, p.z + move * normal->z}};
        if (done)
            return p;
    }
    if (seen[0] != NULL && seen[1] != NULL)
        return bisect(f, ends[0], ends[1], normal, part);
    return search(f, start, reach, normal, part);
}
