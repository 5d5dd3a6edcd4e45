/* Grows a plant level by level from random numbers. */
#include "tools/gen/tree.h"

#include "base/memory.h"
#include "base/random.h"

#include <stdlib.h>

static const double two_pi = 6.28318530717958647692;
/* The angle around their bearer between successive children, radians. */
static const double golden_angle = 2.39996322972865332;

/* The shape of the tubes of a level. */
typedef struct habit {
    uint32_t sides, rings;
    double length_m;
    double radius;   /* at its begin, as a part of the bearer's radius there (the trunk: metres) */
    double taper;    /* radius at the last ring, as a part of `radius` */
    double angle;    /* to the bearer's axis, radians */
    double from, to; /* range of the bearer that has children */
    double bend, climb; /* how far the direction wanders and turns upwards per ring */
    vec3s bark;
} habit;

static const habit habits[GEN_TREE_LEVELS] = {
    {8, 14, 5.0, 0.24, 0.2, 0.0, 0.0, 0.0, 0.03, 0.05, {{0.33f, 0.25f, 0.19f}}},
    {8, 14, 2.4, 0.33, 0.35, 0.95, 0.35, 1.0, 0.05, 0.03, {{0.37f, 0.28f, 0.21f}}},
    {6, 12, 1.1, 0.5, 0.4, 0.85, 0.25, 1.0, 0.06, 0.02, {{0.41f, 0.31f, 0.23f}}},
    {5, 14, 0.55, 0.5, 0.4, 0.8, 0.2, 1.0, 0.05, 0.02, {{0.45f, 0.34f, 0.24f}}},
    {3, 3, 0.1, 0.6, 0.7, 0.7, 0.4, 0.9, 0.04, 0.02, {{0.46f, 0.38f, 0.22f}}},
};

enum { SPRIGS_PER_TWIG = 2, TWIG = 3, SPRIG = 4 };

static const double leaf_length_m = 0.13, leaf_width_m = 0.06;

/* The number of tubes of each level. */
typedef struct counts {
    uint64_t tubes[GEN_TREE_LEVELS];
    uint64_t leaves;
} counts;

typedef struct grower {
    gen_tree *tree;
    uint64_t key, counter;
} grower;

static double draw(grower *g)
{
    return stp_random_unit(g->key, g->counter++);
}

/* Draws a number around 0, at most `most` away from it. */
static double draw_about(grower *g, double most)
{
    return most * (2.0 * draw(g) - 1.0);
}

static counts counts_of(uint64_t twigs)
{
    const double side = cbrt((double)twigs);
    return (counts){.tubes = {1, (uint64_t)ceil(side), (uint64_t)ceil(side * side), twigs,
                              SPRIGS_PER_TWIG * twigs},
                    .leaves = (SPRIGS_PER_TWIG + 1) * twigs};
}

static uint64_t tube_vertices(const habit *h)
{
    return (uint64_t)h->sides * h->rings + 1;
}

static uint64_t tube_triangles(const habit *h)
{
    return (uint64_t)h->sides * (2 * (h->rings - 1) + 1);
}

static uint64_t vertices_of(const counts *c)
{
    uint64_t sum = GEN_LEAF_VERTICES * c->leaves;
    for (int level = 0; level < GEN_TREE_LEVELS; level++)
        sum += c->tubes[level] * tube_vertices(&habits[level]);
    return sum;
}

/* Plans the largest number of twigs, at least one, that needs at most vertex_count vertices. */
static counts plan(uint64_t vertex_count)
{
    uint64_t few = 1, many = GEN_TREE_VERTEX_LIMIT;
    while (few + 1 < many) {
        const uint64_t middle = few + (many - few) / 2;
        const counts c = counts_of(middle);
        if (vertices_of(&c) <= vertex_count)
            few = middle;
        else
            many = middle;
    }
    return counts_of(few);
}

static stp_status make_room(gen_tree *tree, const counts *c, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t vertices = (size_t)vertices_of(c);
    size_t tubes = 0, rings = 0, triangles = GEN_LEAF_TRIANGLES * (size_t)c->leaves;
    for (int level = 0; level < GEN_TREE_LEVELS; level++) {
        const size_t count = (size_t)c->tubes[level];
        tubes += count;
        rings += count * habits[level].rings;
        triangles += count * (size_t)tube_triangles(&habits[level]);
    }
    gen_mesh *mesh = &tree->mesh;
    STP_TRY(stp_alloc(&mesh->positions, vertices, sizeof *mesh->positions, "the tree", err));
    STP_TRY(stp_alloc(&mesh->normals, vertices, sizeof *mesh->normals, "the tree", err));
    STP_TRY(stp_alloc(&mesh->colours, vertices, sizeof *mesh->colours, "the tree", err));
    STP_TRY(stp_alloc(&mesh->triangles, triangles, sizeof *mesh->triangles, "the tree", err));
    STP_TRY(stp_alloc(&tree->tubes, tubes, sizeof *tree->tubes, "the tree", err));
    STP_TRY(stp_alloc(&tree->rings, rings, sizeof *tree->rings, "the tree", err));
done:
    return status;
}

static stp_dvec3 mix(stp_dvec3 a, double s, stp_dvec3 b, double t)
{
    return stp_dvec3_add(stp_dvec3_scale(a, s), stp_dvec3_scale(b, t));
}

/* The part of a vector at right angles to a unit axis, as a unit vector. */
static stp_dvec3 across(stp_dvec3 v, stp_dvec3 axis)
{
    return stp_dvec3_normalize(mix(v, 1.0, axis, -stp_dvec3_dot(v, axis)));
}

static void add_vertex(gen_tree *tree, stp_dvec3 position, stp_dvec3 normal, vec3s colour)
{
    const size_t i = tree->mesh.vertex_count++;
    tree->mesh.positions[i] = stp_dvec3_to_float(position);
    tree->mesh.normals[i] = stp_dvec3_to_float(stp_dvec3_normalize(normal));
    tree->mesh.colours[i] = colour;
}

static void add_triangle(gen_tree *tree, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *corners = tree->mesh.triangles[tree->mesh.triangle_count++];
    corners[0] = a;
    corners[1] = b;
    corners[2] = c;
}

static vec3s shaded(vec3s colour, double shade)
{
    return glms_vec3_scale(colour, (float)shade);
}

/* Adds a ring. Its vertices go counter-clockwise around the axis, seen from where the axis points
 * to. */
static void add_ring(grower *g, const gen_tree_ring *ring, const habit *h)
{
    gen_tree *tree = g->tree;
    const stp_dvec3 up = stp_dvec3_cross(ring->axis, ring->side);
    for (uint32_t k = 0; k < h->sides; k++) {
        const double angle = two_pi * (double)k / (double)h->sides;
        const stp_dvec3 out = mix(ring->side, cos(angle), up, sin(angle));
        add_vertex(tree, mix(ring->centre, 1.0, out, ring->radius), out,
                   shaded(h->bark, 1.0 + draw_about(g, 0.12)));
    }
    tree->rings[tree->ring_count++] = *ring;
}

/* Adds two triangles between neighbours of two rings, and one between neighbours and the tip. */
static void join_rings(gen_tree *tree, const gen_tree_tube *tube)
{
    const uint32_t sides = tube->sides, tip = tube->first_vertex + tube->ring_count * sides;
    for (uint32_t r = 0; r < tube->ring_count; r++) {
        const uint32_t low = tube->first_vertex + r * sides, high = low + sides;
        for (uint32_t k = 0; k < sides; k++) {
            const uint32_t next = (k + 1) % sides;
            if (r + 1 == tube->ring_count) {
                add_triangle(tree, low + k, low + next, tip);
                continue;
            }
            add_triangle(tree, low + k, low + next, high + next);
            add_triangle(tree, low + k, high + next, high + k);
        }
    }
}

/* Goes to the next ring: a step along the axis, which then wanders and turns upwards. */
static void advance(grower *g, gen_tree_ring *ring, const habit *h)
{
    ring->centre = mix(ring->centre, 1.0, ring->axis, h->length_m / (double)h->rings);
    stp_dvec3 turn = {draw_about(g, h->bend), draw_about(g, h->bend) + h->climb,
                      draw_about(g, h->bend)};
    ring->axis = stp_dvec3_normalize(stp_dvec3_add(ring->axis, turn));
    ring->side = across(ring->side, ring->axis);
}

static void grow_tube(grower *g, gen_tree_ring ring, uint32_t level)
{
    gen_tree *tree = g->tree;
    const habit *h = &habits[level];
    gen_tree_tube *tube = &tree->tubes[tree->tube_count++];
    *tube = (gen_tree_tube){.first_ring = (uint32_t)tree->ring_count,
                            .ring_count = h->rings,
                            .sides = h->sides,
                            .level = level,
                            .first_vertex = (uint32_t)tree->mesh.vertex_count,
                            .first_triangle = (uint32_t)tree->mesh.triangle_count};
    const double radius = ring.radius;
    for (uint32_t r = 0; r < h->rings; r++) {
        ring.radius = radius * (1.0 - (1.0 - h->taper) * (double)r / (double)(h->rings - 1));
        add_ring(g, &ring, h);
        advance(g, &ring, h);
    }
    add_vertex(tree, ring.centre, ring.axis, h->bark);
    join_rings(tree, tube);
}

/* Makes the first ring of a tube's index-th of count children. A child begins in the middle of a
 * ring of its bearer. */
static gen_tree_ring bud(grower *g, const gen_tree_tube *bearer, uint64_t index, uint64_t count)
{
    const habit *h = &habits[bearer->level + 1];
    const double part = h->from + (h->to - h->from) * ((double)index + draw(g)) / (double)count;
    const gen_tree_ring *at =
        &g->tree->rings[bearer->first_ring + (uint32_t)(part * (bearer->ring_count - 1))];
    const double around = golden_angle * (double)index + draw_about(g, 0.5);
    const double angle = h->angle * (1.0 + draw_about(g, 0.25));
    const stp_dvec3 out =
        mix(at->side, cos(around), stp_dvec3_cross(at->axis, at->side), sin(around));
    gen_tree_ring ring = {.centre = at->centre, .radius = h->radius * at->radius};
    ring.axis = stp_dvec3_normalize(mix(at->axis, cos(angle), out, sin(angle)));
    ring.side = across(at->axis, ring.axis);
    return ring;
}

/* Grows a level: shares its tubes among the bearers as evenly as whole numbers allow. */
static void grow_level(grower *g, uint32_t level, uint64_t first_bearer, const counts *c)
{
    const uint64_t bearers = c->tubes[level - 1], children = c->tubes[level];
    for (uint64_t i = 0; i < bearers; i++) {
        const uint64_t begin = children * i / bearers, end = children * (i + 1) / bearers;
        const gen_tree_tube bearer = g->tree->tubes[first_bearer + i];
        for (uint64_t k = begin; k < end; k++)
            grow_tube(g, bud(g, &bearer, k - begin, end - begin), level);
    }
}

/* Grows a leaf at the tip of a tube, along the tube's last direction and hanging a little. Both
 * pairs are symmetric about the line between the ends, so half their distance is the leaf's
 * half-width. */
static void grow_leaf(grower *g, const gen_tree_tube *tube)
{
    gen_tree *tree = g->tree;
    const uint32_t first = (uint32_t)tree->mesh.vertex_count;
    const gen_tree_ring *last = &tree->rings[tube->first_ring + tube->ring_count - 1];
    const stp_dvec3 base =
        stp_dvec3_from_float(tree->mesh.positions[tube->first_vertex + tube->ring_count * //
                                                                           tube->sides]);
    const stp_dvec3 along = stp_dvec3_normalize(
        mix(last->axis, 1.0, (stp_dvec3){draw_about(g, 1.0), -0.4, draw_about(g, 1.0)}, 0.6));
    const stp_dvec3 lean = {draw_about(g, 0.6), 1.0, draw_about(g, 0.6)};
    const stp_dvec3 normal = across(lean, along), side = stp_dvec3_cross(along, normal);
    const double length = leaf_length_m * (1.0 + draw_about(g, 0.25));
    const double half = 0.5 * leaf_width_m * (1.0 + draw_about(g, 0.25));
    const double places[4] = {0.0, 0.35, 0.7, 1.0}, widths[4] = {0.0, 1.0, 0.75, 0.0};
    const double arch[4] = {0.0, 0.08, 0.07, -0.02}, tilts[4] = {-0.3, -0.1, 0.15, 0.3};
    const vec3s green = {{(float)(0.18 + 0.22 * draw(g)), (float)(0.42 + 0.22 * draw(g)), //
                          (float)(0.08 + 0.1 * draw(g))}};
    for (int row = 0; row < 4; row++) {
        const stp_dvec3 middle =
            stp_dvec3_add(base, mix(along, length * places[row], normal, length * arch[row]));
        const stp_dvec3 up = mix(normal, 1.0, along, tilts[row]);
        const double reach = half * widths[row];
        add_vertex(tree, mix(middle, 1.0, side, reach), up, shaded(green, 0.9 + 0.05 * row));
        if (reach > 0.0)
            add_vertex(tree, mix(middle, 1.0, side, -reach), up, shaded(green, 0.9 + 0.05 * row));
    }
    add_triangle(tree, first, first + 1, first + 2);
    add_triangle(tree, first + 1, first + 3, first + 2);
    add_triangle(tree, first + 2, first + 3, first + 4);
    add_triangle(tree, first + 3, first + 5, first + 4);
    tree->leaf_count++;
}

stp_status gen_tree_grow(gen_tree *out, uint64_t vertex_count, uint64_t seed, stp_error *err)
{
    stp_status status = STP_OK;
    gen_tree tree = {0};
    grower g = {.tree = &tree, .key = stp_random_u64(seed, 11)};
    const counts c =
        plan(vertex_count < GEN_TREE_VERTEX_LIMIT ? vertex_count : GEN_TREE_VERTEX_LIMIT);
    STP_TRY(make_room(&tree, &c, err));
    const gen_tree_ring root = {
        {0.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {1.0, 0.0, 0.0}, habits[0].radius};
    grow_tube(&g, root, 0);
    uint64_t first = 0;
    for (uint32_t level = 1; level < GEN_TREE_LEVELS; level++) {
        grow_level(&g, level, first, &c);
        first += c.tubes[level - 1];
    }
    tree.first_leaf_vertex = (uint32_t)tree.mesh.vertex_count;
    tree.first_leaf_triangle = (uint32_t)tree.mesh.triangle_count;
    for (size_t i = 0; i < tree.tube_count; i++)
        if (tree.tubes[i].level == TWIG || tree.tubes[i].level == SPRIG)
            grow_leaf(&g, &tree.tubes[i]);
    *out = tree;
    tree = (gen_tree){0};
done:
    gen_tree_clear(&tree);
    return status;
}

void gen_tree_clear(gen_tree *tree)
{
    gen_mesh_clear(&tree->mesh);
    free(tree->tubes);
    free(tree->rings);
    *tree = (gen_tree){0};
}

static stp_status tree_mesh(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                            gen_mesh *out, stp_error *err)
{
    (void)triangle_count;
    (void)pool;
    gen_tree tree = {0};
    stp_status status = gen_tree_grow(&tree, surface->mesh_vertices, surface->seed, err);
    if (status != STP_OK)
        return status;
    *out = tree.mesh;
    tree.mesh = (gen_mesh){0};
    gen_tree_clear(&tree);
    return STP_OK;
}

void gen_tree_init(gen_surface *surface, uint64_t point_count)
{
    const uint64_t default_vertices = 20000;
    surface->mesh_vertices = point_count > 0 ? point_count : default_vertices;
    /* A ball that no path along the tubes, from where the trunk bears on, can leave. */
    surface->centre = (stp_dvec3){0.0, 3.5, 0.0};
    surface->radius = 7.0;
    surface->mesh = tree_mesh;
}
