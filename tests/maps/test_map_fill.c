/* Tests --gaps fill on the stored file: cells of maps, found by their rasters across chunks, and
 * the triangles between maps are one closed mesh of closed surfaces. Every edge has two triangles
 * that run along it in opposite directions, Euler's number is that of the surface, and so is the
 * area: nothing lies over anything else. An open surface keeps its border and its hole. */
#include "tests/fixtures/prep_fixture.h"

#include "base/memory.h"
#include "formats/chunk/codec/square/square.h"
#include "tests/support/check.h"

#include <inttypes.h>

#define FILE_NAME "test_map_fill.stipple"

/* ---- the stored mesh ---- */

typedef struct node {
    uint64_t grid; /* of its map, the same in all chunks */
    int64_t column, row;
    stp_dvec3 at;
} node;

typedef struct mesh {
    node *nodes; /* samples of maps */
    size_t node_count, node_capacity;
    stp_dvec3 (*triangles)[3];
    size_t count, capacity, between;
    uint64_t between_bytes; /* of the chunks of triangles */
} mesh;

static uint64_t mix(uint64_t hash, const void *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ ((const uint8_t *)bytes)[i]) * UINT64_C(0x100000001b3);
    return hash;
}

/* Columns and rows of a raster's grid at the world's axis of its heights, so they are the same for
 * all chunks. */
static void grid_at(const stp_raster *r, stp_dvec3 origin, stp_dvec3 world, double out[2])
{
    const double o[3] = {origin.x, origin.y, origin.z}, w[3] = {world.x, world.y, world.z};
    const double *a = r->across[0], *b = r->across[1];
    const double height = w[r->axis] - o[r->axis];
    const double x = w[(r->axis + 1) % 3] - o[(r->axis + 1) % 3] - a[0] - height * a[3];
    const double y = w[(r->axis + 2) % 3] - o[(r->axis + 2) % 3] - b[0] - height * b[3];
    const double turn = a[1] * b[2] - a[2] * b[1];
    out[0] = (b[2] * x - a[2] * y) / turn;
    out[1] = (a[1] * y - b[1] * x) / turn;
}

static void add_triangle(mesh *m, stp_dvec3 a, stp_dvec3 b, stp_dvec3 c)
{
    check_ok(
        stp_grow(&m->triangles, &m->capacity, m->count + 1, sizeof *m->triangles, "test", err));
    m->triangles[m->count][0] = a;
    m->triangles[m->count][1] = b;
    m->triangles[m->count++][2] = c;
}

static stp_dvec3 place(const stp_chunk_entry *e, const stp_patch *patch, const stp_sample *s)
{
    const double step = ldexp(1.0, patch->exponent);
    return (stp_dvec3){e->origin.x + step * ((double)patch->origin[0] + s->position[0]),
                       e->origin.y + step * ((double)patch->origin[1] + s->position[1]),
                       e->origin.z + step * ((double)patch->origin[2] + s->position[2])};
}

static void take_chunk(mesh *m, const stp_chunk_entry *e, const stp_chunk *chunk)
{
    if (chunk->patches[0].flags & STP_PATCH_TRIANGLES)
        m->between_bytes += stp_chunk_payload_bytes(e, 0);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        const stp_sample *s = &chunk->samples[0][chunk->level_begin[0][p]];
        if (patch->flags & STP_PATCH_TRIANGLES) {
            for (unsigned i = 0; i < patch->counts[0]; i += 3, m->between++)
                add_triangle(m, place(e, patch, &s[i]), place(e, patch, &s[i + 1]),
                             place(e, patch, &s[i + 2]));
            continue;
        }
        const stp_square *square = chunk->squares ? &chunk->squares[p] : NULL;
        if (!square || square->samples == 0)
            continue; /* points that stay */
        const stp_raster *raster = &chunk->rasters[square->raster];
        uint64_t grid = mix(UINT64_MAX, &raster->axis, sizeof raster->axis);
        double base[2];
        for (int k = 0; k < 2; k++)
            grid = mix(grid, raster->across[k] + 1, 3 * sizeof(double));
        grid_at(raster, e->origin, (stp_dvec3){0.0, 0.0, 0.0}, base);
        for (uint32_t k = 0, i = 0; k < STP_SQUARE_SAMPLES; k++) {
            if (!(square->samples >> k & 1))
                continue;
            check_ok(stp_grow(&m->nodes, &m->node_capacity, m->node_count + 1, sizeof *m->nodes,
                              "test", err));
            const double column = square->column * 8.0 + stp_square_column(k) - base[0];
            const double row = square->row * 8.0 + stp_square_row(k) - base[1];
            m->nodes[m->node_count++] =
                (node){grid, llround(4.0 * column), llround(4.0 * row), place(e, patch, &s[i++])};
        }
    }
}

static int compare_nodes(const void *a, const void *b)
{
    const node *p = a, *q = b;
    if (p->grid != q->grid)
        return p->grid < q->grid ? -1 : 1;
    if (p->row != q->row)
        return p->row < q->row ? -1 : 1;
    return (p->column > q->column) - (p->column < q->column);
}

/* The sample some columns and rows on; columns are counted in quarters. */
static const node *beside(const mesh *m, const node *from, int column, int row)
{
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++) { /* rounding may differ from chunk to chunk */
            const node key = {from->grid,
                              from->column + 4 * column + i,
                              from->row + 4 * row + j,
                              {0.0, 0.0, 0.0}};
            const node *found = bsearch(&key, m->nodes, m->node_count, sizeof key, compare_nodes);
            if (found)
                return found;
        }
    return NULL;
}

static mesh read_mesh(void)
{
    mesh m = {0};
    stp_chunk_file *file = prep_open_verified(FILE_NAME);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        if (entry.child_count == 0)
            take_chunk(&m, &entry, chunk);
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    qsort(m.nodes, m.node_count, sizeof *m.nodes, compare_nodes);
    for (size_t i = 0; i < m.node_count; i++) {
        const node *a = &m.nodes[i], *b = beside(&m, a, 1, 0);
        const node *c = beside(&m, a, 0, 1), *d = beside(&m, a, 1, 1);
        if (!b || !c || !d)
            continue;
        add_triangle(&m, a->at, b->at, c->at);
        add_triangle(&m, b->at, d->at, c->at);
    }
    return m;
}

static void clear_mesh(mesh *m)
{
    free(m->nodes);
    free(m->triangles);
    *m = (mesh){0};
}

/* ---- what is counted ---- */

typedef struct edge {
    double at[6]; /* the lesser end first */
    int along;    /* 1 from the lesser end, else -1 */
} edge;

static int compare_edges(const void *a, const void *b)
{
    const edge *p = a, *q = b;
    for (int i = 0; i < 6; i++)
        if (p->at[i] != q->at[i])
            return p->at[i] < q->at[i] ? -1 : 1;
    return 0;
}

static int compare_places(const void *a, const void *b)
{
    const double *p = a, *q = b;
    for (int i = 0; i < 3; i++)
        if (p[i] != q[i])
            return p[i] < q[i] ? -1 : 1;
    return 0;
}

typedef struct count {
    size_t vertices, edges, triangles;
    size_t open; /* edges that do not have two triangles in opposite directions */
    double area;
} count;

static count measure(const mesh *m)
{
    count out = {.triangles = m->count};
    edge *edges = calloc(3 * m->count + 1, sizeof *edges);
    double(*places)[3] = calloc(3 * m->count + 1, sizeof *places);
    assert_true(edges && places);
    for (size_t t = 0; t < m->count; t++) {
        const stp_dvec3 *p = m->triangles[t];
        out.area += 0.5 * stp_dvec3_length(stp_dvec3_cross(stp_dvec3_sub(p[1], p[0]),
                                                           stp_dvec3_sub(p[2], p[0])));
        for (int k = 0; k < 3; k++) {
            const double a[3] = {p[k].x, p[k].y, p[k].z};
            const stp_dvec3 n = p[(k + 1) % 3];
            const double b[3] = {n.x, n.y, n.z};
            const bool up = compare_places(a, b) < 0;
            edge *e = &edges[3 * t + (size_t)k];
            assert_int_not_equal(compare_places(a, b), 0);
            memcpy(e->at, up ? a : b, sizeof a);
            memcpy(e->at + 3, up ? b : a, sizeof a);
            e->along = up ? 1 : -1;
            memcpy(places[3 * t + (size_t)k], a, sizeof a);
        }
    }
    qsort(edges, 3 * m->count, sizeof *edges, compare_edges);
    qsort(places, 3 * m->count, sizeof *places, compare_places);
    for (size_t i = 0, end = 0; i < 3 * m->count; i = end, out.edges++) {
        int sum = 0;
        for (end = i; end < 3 * m->count && compare_edges(&edges[i], &edges[end]) == 0; end++)
            sum += edges[end].along;
        out.open += end - i != 2 || sum != 0;
    }
    for (size_t i = 0; i < 3 * m->count; i++)
        out.vertices += i == 0 || compare_places(places[i - 1], places[i]) != 0;
    free(edges);
    free(places);
    return out;
}

/* ---- surfaces ---- */

enum { POINTS = 30000, MANY = 100000 /* for several leaves */ };

typedef stp_dvec3 surface(size_t i);

static stp_dvec3 on_torus(size_t i)
{
    for (uint64_t k = 0;; k++) { /* as dense outside as inside */
        const double a = 2.0 * M_PI * stp_random_unit(3 + 3 * k, i);
        const double b = 2.0 * M_PI * stp_random_unit(4 + 3 * k, i);
        const double across = 1.0 + 0.4 * cos(b);
        if (1.4 * stp_random_unit(5 + 3 * k, i) < across)
            return (stp_dvec3){across * cos(a), across * sin(a), 0.4 * sin(b)};
    }
}

static stp_dvec3 on_ball(size_t i)
{
    const double z = 2.0 * stp_random_unit(1, i) - 1.0, a = 2.0 * M_PI * stp_random_unit(2, i);
    const double across = sqrt(1.0 - z * z);
    return (stp_dvec3){across * cos(a), across * sin(a), z};
}

static stp_dvec3 far_away(size_t i)
{
    return stp_dvec3_add(on_ball(i), (stp_dvec3){5e5, 4.8e6, 200.0});
}

/* With waves some 300 / often spacings long. */
static stp_dvec3 waves_over(stp_dvec3 p, double often)
{
    const double waves = sin(often * p.x) * sin(often * p.y + 1.0) * sin(often * p.z + 2.0);
    return stp_dvec3_scale(p, 1.0 + 0.05 * waves);
}

/* As steep as 45 degrees and more. */
static stp_dvec3 on_waves(size_t i)
{
    return waves_over(on_ball(i), 25.0);
}

/* So steep that maps lie over each other in folds. */
static stp_dvec3 on_short_waves(size_t i)
{
    return waves_over(on_ball(i), 30.0);
}

static stp_dvec3 ball_at(double z, double a)
{
    const double across = sqrt(1.0 - z * z);
    return (stp_dvec3){across * cos(a), across * sin(a), z};
}

/* The area of the waves: of small pieces, each the same part of the ball. */
static double waves_area(double often)
{
    enum { ROWS = 1000, COLUMNS = 2000 };
    double sum = 0.0;
    for (int i = 0; i < ROWS * COLUMNS; i++) {
        const double z = 2.0 * (i / COLUMNS + 0.5) / ROWS - 1.0, h = 1e-4 * (1.0 - fabs(z));
        const double a = 2.0 * M_PI * (i % COLUMNS + 0.5) / COLUMNS;
        const stp_dvec3 by_z = stp_dvec3_sub(waves_over(ball_at(z + h, a), often),
                                             waves_over(ball_at(z - h, a), often));
        const stp_dvec3 by_a = stp_dvec3_sub(waves_over(ball_at(z, a + 1e-4), often),
                                             waves_over(ball_at(z, a - 1e-4), often));
        sum += stp_dvec3_length(stp_dvec3_cross(by_z, by_a)) / (4.0 * h * 1e-4);
    }
    return sum * 4.0 * M_PI / (ROWS * COLUMNS);
}

/* A ball of half the points with a cap cut off. */
static stp_dvec3 on_bowl(size_t i)
{
    for (uint64_t k = 0;; k++) {
        const double z = 2.0 * stp_random_unit(1 + 2 * k, i) - 1.0;
        const double a = 2.0 * M_PI * stp_random_unit(2 + 2 * k, i), across = sqrt(1.0 - z * z);
        if (z < 0.8)
            return (stp_dvec3){across * cos(a), across * sin(a), z};
    }
}

static stp_prep_stats prepare(surface *at, size_t points, double cone_deg, unsigned threads,
                              uint64_t memory)
{
    stp_prep_stats stats;
    prep_cloud cloud = prep_cloud_make(points);
    for (size_t i = 0; i < points; i++)
        cloud.points[i].position = at(i);
    check_ok(prep_cloud_run(
        &cloud, FILE_NAME, threads,
        &(stp_prep_params){.codec = STP_CODEC_DRACO,
                           .memory_bytes = memory,
                           .maps = &(stp_maps_params){.cone_deg = cone_deg, .fill = true}},
        &stats, err));
    free(cloud.points);
    return stats;
}

static void closed_surfaces_are_closed(void **state)
{
    (void)state;
    const struct {
        const char *name;
        surface *at;
        size_t points;
        double cone_deg, area, off; /* off: how much less may be found, as a part */
        long euler;
    } shapes[] = {{"torus", on_torus, MANY, 60.0, 4.0 * M_PI * M_PI * 0.4, 0.02, 0},
                  {"torus", on_torus, POINTS, 30.0, 4.0 * M_PI * M_PI * 0.4, 0.02, 0},
                  {"ball", on_ball, MANY, 60.0, 4.0 * M_PI, 0.02, 2},
                  {"ball", on_ball, POINTS, 40.0, 4.0 * M_PI, 0.02, 2},
                  {"ball far away", far_away, MANY, 60.0, 4.0 * M_PI, 0.02, 2},
                  {"waves", on_waves, POINTS, 60.0, waves_area(25.0), 0.02, 2},
                  {"short waves", on_short_waves, POINTS, 60.0, waves_area(30.0), 0.05, 2}};
    uint64_t bytes = 0, between = 0;
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        const stp_prep_stats stats =
            prepare(shapes[i].at, shapes[i].points, shapes[i].cone_deg, 2, 0);
        mesh m = read_mesh();
        const count c = measure(&m);
        print_message("%s, %g degrees: %zu triangles, %zu of them between %" PRIu64
                      " maps, %.1f bytes each, in %u chunks; %zu of %zu edges open; area %g of "
                      "%g\n",
                      shapes[i].name, shapes[i].cone_deg, c.triangles, m.between, stats.maps.maps,
                      (double)m.between_bytes / (double)m.between, stats.tree.chunk_count, c.open,
                      c.edges, c.area, shapes[i].area);
        assert_true(stats.maps.maps > 5);
        assert_int_equal(stats.maps.between, m.between);
        assert_int_equal(stats.maps.open_edges, 0);
        assert_int_equal(c.open, 0);
        assert_int_equal((long)c.vertices - (long)c.edges + (long)c.triangles, shapes[i].euler);
        assert_true(fabs(c.area / shapes[i].area - 1.0) < shapes[i].off);
        assert_int_equal(stats.maps.represented + stats.maps.as_points, shapes[i].points);
        assert_true(stats.maps.as_points < shapes[i].points / 1000);
        bytes += m.between_bytes;
        between += m.between;
        clear_mesh(&m);
    }
    print_message("%.2f bytes a triangle\n", (double)bytes / (double)between);
    assert_true((double)bytes <= 15.0 * (double)between);
}

/* The rim of the bowl stays open, and nothing lies over it. */
static void open_surfaces_stay_open(void **state)
{
    (void)state;
    const stp_prep_stats stats = prepare(on_bowl, POINTS, 60.0, 2, 0);
    mesh m = read_mesh();
    const count c = measure(&m);
    const double area = 2.0 * M_PI * 1.8, spacing = sqrt(area / POINTS);
    print_message("bowl: %zu of %zu edges open, %" PRIu64 " told; area %g of %g\n", c.open, c.edges,
                  stats.maps.open_edges, c.area, area);
    assert_int_equal(c.open, stats.maps.open_edges);
    assert_true((double)c.open > 0.5 * 2.0 * M_PI * 0.6 / spacing);
    assert_true((double)c.open < 2.5 * 2.0 * M_PI * 0.6 / spacing);
    assert_int_equal((long)c.vertices - (long)c.edges + (long)c.triangles, 1);
    assert_true(fabs(c.area / area - 1.0) < 0.01);
    clear_mesh(&m);
}

/* The points are of several cells. */
static void threads_and_memory_change_no_byte(void **state)
{
    (void)state;
    static const unsigned threads[] = {1, 3, 2};
    static const uint64_t memory[] = {0, 0, 180u << 20};
    size_t size[3];
    uint8_t *bytes[3];
    for (unsigned i = 0; i < 3; i++) {
        const stp_prep_stats stats = prepare(on_torus, MANY, 45.0, threads[i], memory[i]);
        assert_true((memory[i] > 0) == (stats.temporary_bytes > 0));
        bytes[i] = prep_file_bytes(FILE_NAME, &size[i]);
        assert_int_equal(size[i], size[0]);
        assert_memory_equal(bytes[i], bytes[0], size[0]);
    }
    for (unsigned i = 0; i < 3; i++)
        free(bytes[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closed_surfaces_are_closed),
        cmocka_unit_test(open_surfaces_stay_open),
        cmocka_unit_test(threads_and_memory_change_no_byte),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
