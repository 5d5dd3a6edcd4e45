/* Sheets out of the neighbour graph. */
#include "preprocess/sheets.h"

#include "base/memory.h"
#include "formats/chunk/sample.h"

#include <stdlib.h>

#define EDGE_NEIGHBOURS 8u /* of each point, nearest first: enough to connect it */
#define BUCKETS 256u
#define SMOOTH_BUCKETS 200u /* edges inside a sheet; the others lead across creases */
#define SURE_BUCKETS 100u   /* a quarter of a spacing off, 31 degrees: joins sheets */
#define CRUMB_POINTS 64u    /* smaller pieces are no sheets but parts of one nearby */
#define SHEET_COSINE 0.7f
#define SHEET_OFFSET 0.5f /* spacings off each other's plane */

/* Sign by which b's normal continues a's: plain on a smooth piece, reflected in the plane between
 * the two points across a crease. */
static bool against(const stp_cloud *cloud, uint32_t a, uint32_t b)
{
    vec3s n = cloud->points[a].normal;
    vec3s m = cloud->points[b].normal;
    vec3s d = glms_vec3_normalize(
        stp_dvec3_to_float(stp_dvec3_sub(cloud->points[b].position, cloud->points[a].position)));
    if (fabsf(glms_vec3_dot(n, m)) > SHEET_COSINE)
        return glms_vec3_dot(n, m) < 0.0f;
    vec3s reflected = glms_vec3_sub(m, glms_vec3_scale(d, 2.0f * glms_vec3_dot(m, d)));
    return glms_vec3_dot(n, reflected) < 0.0f;
}

/* Rank of an edge, smaller is surer; BUCKETS where nothing can be said across it. */
static uint32_t rank(const stp_cloud *cloud, uint32_t a, uint32_t b)
{
    const stp_cloud_point *p = &cloud->points[a];
    const stp_cloud_point *q = &cloud->points[b];
    if (!(p->flags & q->flags & STP_SAMPLE_HAS_NORMAL))
        return BUCKETS;
    vec3s d = stp_dvec3_to_float(stp_dvec3_sub(q->position, p->position));
    float cosine = fabsf(glms_vec3_dot(p->normal, q->normal));
    float scale = fmaxf(p->spacing, q->spacing);
    float offset =
        fmaxf(fabsf(glms_vec3_dot(p->normal, d)), fabsf(glms_vec3_dot(q->normal, d))) / scale;
    if (cosine > SHEET_COSINE && offset <= SHEET_OFFSET) {
        float badness = fmaxf((1.0f - cosine) / (1.0f - SHEET_COSINE), offset / SHEET_OFFSET);
        return (uint32_t)(badness * (float)(SMOOTH_BUCKETS - 1));
    }
    if (cosine > SHEET_COSINE) /* parallel sheets: neither side knows of the other */
        return BUCKETS;
    float badness = fminf(1.0f, offset / 2.0f);
    return SMOOTH_BUCKETS + (uint32_t)(badness * (float)(BUCKETS - SMOOTH_BUCKETS - 1));
}

static void join(stp_sheets *c, uint32_t a, uint32_t b)
{
    stp_forest_join(&c->forest, a, b, against(c->cloud, a, b) ? 1 : 0);
}

typedef struct edge {
    uint32_t a, b;
} edge;

typedef struct ranked_edge {
    uint32_t a, b, rank;
} ranked_edge;

/* Edges that a cell cannot decide alone: to other cells, and unsure ones. */
struct stp_open_edges {
    ranked_edge *edges;
    size_t count, capacity;
};

static stp_status find_layers(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_sheets *c = context;
    (void)worker;
    (void)err;
    const stp_cell *cell = &c->cloud->cells[index];
    for (uint32_t i = cell->begin; i < cell->end; i++)
        c->layers[i] =
            stp_layer_find(c->cloud, i, c->cloud->points[i].normal,
                           c->neighbours->indices + (size_t)i * c->neighbours->k, c->neighbours->k);
    return STP_OK;
}

static bool in_layer(const stp_sheets *c, uint32_t a, uint32_t b)
{
    float height = stp_layer_height(c->cloud, a, c->cloud->points[a].normal, b);
    return stp_layer_holds(c->layers[a], height);
}

/* Sure edges lie within the layers of both ends. */
static uint32_t rank_edge(const stp_sheets *c, uint32_t a, uint32_t b)
{
    uint32_t r = rank(c->cloud, a, b);
    return r < SURE_BUCKETS && !(in_layer(c, a, b) && in_layer(c, b, a)) ? SURE_BUCKETS : r;
}

/* Ranks of all edges of a cell's points, and how many have each. */
static void rank_cell(const stp_sheets *c, const stp_cell *cell, uint16_t *ranks,
                      uint32_t counts[BUCKETS + 1])
{
    for (uint32_t a = cell->begin; a < cell->end; a++) {
        const uint32_t *list = c->neighbours->indices + (size_t)a * c->neighbours->k;
        for (unsigned i = 0; i < c->edge_count; i++) {
            uint32_t r = list[i] == STP_NEIGHBOUR_NONE ? BUCKETS : rank_edge(c, a, list[i]);
            bool inside = r < SURE_BUCKETS && list[i] >= cell->begin && list[i] < cell->end;
            ranks[(size_t)(a - cell->begin) * c->edge_count + i] = (uint16_t)r;
            counts[inside ? r : BUCKETS]++;
        }
    }
}

/* Joins the cell's own sure edges, surest first. */
static void join_cell(stp_sheets *c, const stp_cell *cell, const uint16_t *ranks, uint32_t *order,
                      uint32_t counts[BUCKETS + 1])
{
    uint32_t edges = (cell->end - cell->begin) * c->edge_count;
    uint32_t sum = 0;
    for (uint32_t r = 0; r < SURE_BUCKETS; r++) {
        uint32_t here = counts[r];
        counts[r] = sum;
        sum += here;
    }
    for (uint32_t e = 0; e < edges; e++) {
        uint32_t a = cell->begin + e / c->edge_count;
        uint32_t b = c->neighbours->indices[(size_t)a * c->neighbours->k + e % c->edge_count];
        if (ranks[e] < SURE_BUCKETS && b >= cell->begin && b < cell->end)
            order[counts[ranks[e]]++] = e;
    }
    for (uint32_t i = 0; i < sum; i++) {
        uint32_t a = cell->begin + order[i] / c->edge_count;
        uint32_t b =
            c->neighbours->indices[(size_t)a * c->neighbours->k + order[i] % c->edge_count];
        join(c, a, b);
    }
}

/* Keeps what joins more than the cell's own pieces. */
static stp_status keep_open(stp_sheets *c, const stp_cell *cell, const uint16_t *ranks,
                            stp_open_edges *out, stp_error *err)
{
    uint32_t edges = (cell->end - cell->begin) * c->edge_count;
    for (uint32_t e = 0; e < edges; e++) {
        uint32_t a = cell->begin + e / c->edge_count;
        uint32_t b = c->neighbours->indices[(size_t)a * c->neighbours->k + e % c->edge_count];
        uint8_t pa = 0, pb = 0;
        if (ranks[e] >= BUCKETS)
            continue;
        if (b >= cell->begin && b < cell->end &&
            stp_forest_find(&c->forest, a, &pa) == stp_forest_find(&c->forest, b, &pb))
            continue;
        stp_status status =
            stp_grow(&out->edges, &out->capacity, out->count + 1, sizeof *out->edges, "edges", err);
        if (status != STP_OK)
            return status;
        out->edges[out->count++] = (ranked_edge){a, b, ranks[e]};
    }
    return STP_OK;
}

/* Pieces inside one cell: its points alone are touched. */
static stp_status connect_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    stp_sheets *c = context;
    const stp_cell *cell = &c->cloud->cells[index];
    size_t edges = (size_t)(cell->end - cell->begin) * c->edge_count;
    uint32_t counts[BUCKETS + 1] = {0};
    uint16_t *ranks = NULL;
    uint32_t *order = NULL;
    (void)worker;
    STP_TRY(stp_alloc(&ranks, edges, sizeof *ranks, "edges", err));
    STP_TRY(stp_alloc(&order, edges, sizeof *order, "edges", err));
    rank_cell(c, cell, ranks, counts);
    join_cell(c, cell, ranks, order, counts);
    STP_TRY(keep_open(c, cell, ranks, &c->open[index], err));
done:
    free(order);
    free(ranks);
    return status;
}

/* Joins the open edges of all cells with ranks in [first, end), surest first. */
static stp_status join_open(stp_sheets *c, uint32_t first, uint32_t end, stp_error *err)
{
    size_t counts[BUCKETS + 1] = {0};
    size_t sum = 0;
    edge *order = NULL;
    for (uint32_t cell = 0; cell < c->cloud->cell_count; cell++)
        for (size_t e = 0; e < c->open[cell].count; e++)
            counts[c->open[cell].edges[e].rank]++;
    for (uint32_t r = first; r < end; r++) {
        size_t here = counts[r];
        counts[r] = sum;
        sum += here;
    }
    stp_status status = stp_alloc(&order, sum, sizeof *order, "edges", err);
    if (status != STP_OK)
        return status;
    for (uint32_t cell = 0; cell < c->cloud->cell_count; cell++) {
        for (size_t e = 0; e < c->open[cell].count; e++) {
            ranked_edge r = c->open[cell].edges[e];
            if (r.rank >= first && r.rank < end)
                order[counts[r.rank]++] = (edge){r.a, r.b};
        }
    }
    for (size_t e = 0; e < sum; e++)
        join(c, order[e].a, order[e].b);
    free(order);
    return STP_OK;
}

/* The big sheet among a point's neighbours whose planes' mean it is nearest to; its own if there is
 * none. */
static uint32_t adopt(const stp_sheets *c, uint32_t self)
{
    struct {
        uint32_t root;
        float offset, count;
    } candidates[STP_NEIGHBOURS_LIMIT];
    const stp_cloud_point *p = &c->cloud->points[self];
    const uint32_t *list = c->neighbours->indices + (size_t)self * c->neighbours->k;
    unsigned count = 0, best = 0;
    for (unsigned i = 0; i < c->neighbours->k && list[i] != STP_NEIGHBOUR_NONE; i++) {
        const stp_cloud_point *q = &c->cloud->points[list[i]];
        uint32_t root = c->forest.parent[list[i]];
        vec3s d = stp_dvec3_to_float(stp_dvec3_sub(p->position, q->position));
        if (c->forest.size[root] <= CRUMB_POINTS)
            continue;
        unsigned at = 0;
        while (at < count && candidates[at].root != root)
            at++;
        if (at == count) {
            candidates[at].root = root;
            candidates[at].offset = candidates[at].count = 0.0f;
            count++;
        }
        float height = glms_vec3_dot(q->normal, d);
        candidates[at].offset += glms_vec3_dot(q->normal, p->normal) < 0.0f ? -height : height;
        candidates[at].count += 1.0f;
    }
    for (unsigned i = 1; i < count; i++)
        if (fabsf(candidates[i].offset) * candidates[best].count <
            fabsf(candidates[best].offset) * candidates[i].count)
            best = i;
    return count ? candidates[best].root : c->forest.parent[self];
}

/* Every point's sheet. What noise has put off its surface goes with the sheet it lies nearest to:
 * edges would lead from one side of a thin plate to the other through such points. */
static void number_sheets(stp_sheets *c)
{
    stp_cloud *cloud = c->cloud;
    for (uint32_t i = 0; i < cloud->count; i++) { /* makes every parent a root */
        uint8_t parity = 0;
        (void)stp_forest_find(&c->forest, i, &parity);
    }
    for (uint32_t i = 0; i < cloud->count; i++) {
        stp_cloud_point *p = &cloud->points[i];
        uint32_t root = c->forest.parent[i];
        p->sheet = c->forest.size[root] <= CRUMB_POINTS ? adopt(c, i) : root;
        if (!(p->flags & STP_SAMPLE_HAS_NORMAL))
            p->sheet = STP_SHEET_NONE;
    }
}

stp_status stp_sheets_create(stp_sheets *out, stp_cloud *cloud, const stp_neighbours *neighbours,
                             stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    unsigned k = neighbours->k < EDGE_NEIGHBOURS ? neighbours->k : EDGE_NEIGHBOURS;
    stp_sheets s = {.cloud = cloud, .neighbours = neighbours, .edge_count = k};
    STP_TRY(stp_forest_create(&s.forest, cloud->count, err));
    STP_TRY(stp_alloc(&s.layers, cloud->count, sizeof *s.layers, "layers", err));
    STP_TRY(stp_alloc(&s.open, cloud->cell_count, sizeof *s.open, "edges", err));
    STP_TRY(stp_pool_run(pool, cloud->cell_count, find_layers, &s, err));
    STP_TRY(stp_pool_run(pool, cloud->cell_count, connect_cell, &s, err));
    STP_TRY(join_open(&s, 0, SURE_BUCKETS, err));
    number_sheets(&s);
    *out = s;
    s = (stp_sheets){0};
done:
    stp_sheets_clear(&s);
    return status;
}

stp_status stp_sheets_cross(stp_sheets *sheets, stp_error *err)
{
    return join_open(sheets, SURE_BUCKETS, BUCKETS, err);
}

void stp_sheets_clear(stp_sheets *sheets)
{
    for (uint32_t i = 0; sheets->open && i < sheets->cloud->cell_count; i++)
        free(sheets->open[i].edges);
    free(sheets->open);
    free(sheets->layers);
    stp_forest_clear(&sheets->forest);
    *sheets = (stp_sheets){0};
}
