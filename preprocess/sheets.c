/* Sheets out of the neighbour graph. */
#include "preprocess/sheets.h"

#include "base/memory.h"
#include "base/prefix_sum.h"
#include "formats/chunk/sample.h"

#include <stdlib.h>

#define EDGE_NEIGHBOURS 8u /* of each point, nearest first: enough to connect it */

typedef struct ranked_edge {
    uint32_t a, b;
    stp_relation relation;
} ranked_edge;

/* Edges that a cell cannot decide alone: to other cells, and unsure ones. */
struct stp_open_edges {
    ranked_edge *edges;
    size_t count, capacity;
};

static const uint32_t *edges_of(const stp_sheets *c, uint32_t a)
{
    return c->neighbours->indices + (size_t)a * c->neighbours->k;
}

/* Whether b lies on a's own sheet. Within one gap of a's height it does, whatever else is near. */
static bool in_layer(const stp_sheets *c, uint32_t a, uint32_t b)
{
    vec3s normal = c->cloud->points[a].normal;
    float height = stp_layer_height(c->cloud, a, normal, b);
    if (fabsf(height) <= STP_LAYER_GAP * c->cloud->points[a].spacing)
        return true;
    stp_layer layer = stp_layer_find(c->cloud, a, normal, edges_of(c, a), c->neighbours->k);
    return stp_layer_holds(layer, height);
}

/* Sure edges lie within the layers of both ends. */
static stp_relation relate_layers(const stp_sheets *c, uint32_t a, uint32_t b)
{
    stp_relation r = stp_relate(c->cloud, a, b);
    if (r.rank < STP_RANK_SURE && !(in_layer(c, a, b) && in_layer(c, b, a)))
        r.rank = STP_RANK_SURE;
    return r;
}

/* Whether the edge from a to b is b's edge to a, too, and is left to b: the earlier one. */
static bool is_repeated(const stp_sheets *c, uint32_t a, uint32_t b)
{
    bool found = false;
    for (unsigned i = 0; b < a && i < c->edge_count; i++)
        found |= edges_of(c, b)[i] == a;
    return found;
}

/* One of a cell's edges, between points that belong to it. */
typedef struct cell_edge {
    uint32_t a, b;
    uint16_t rank;
    bool turned;
} cell_edge;

/* Looks at all edges of a cell's points: the sure ones inside it to `sure`, how many have each rank
 * to counts, and what else may join pieces to `out`. */
static stp_status relate_cell(const stp_sheets *c, const stp_cell *cell, cell_edge *sure,
                              size_t counts[STP_RANK_SURE], stp_open_edges *out, stp_error *err)
{
    uint32_t sure_count = 0;
    for (uint32_t a = cell->begin; a < cell->end; a++) {
        for (unsigned i = 0; i < c->edge_count; i++) {
            uint32_t b = edges_of(c, a)[i];
            if (b == STP_NEIGHBOUR_NONE || is_repeated(c, a, b))
                continue;
            stp_relation r = relate_layers(c, a, b);
            if (r.rank < STP_RANK_SURE && b >= cell->begin && b < cell->end) {
                sure[sure_count++] = (cell_edge){a, b, r.rank, r.turned};
                counts[r.rank]++;
                continue;
            }
            if (r.rank >= STP_RANK_NONE)
                continue;
            stp_status status = stp_grow(&out->edges, &out->capacity, out->count + 1,
                                         sizeof *out->edges, "edges", err);
            if (status != STP_OK)
                return status;
            out->edges[out->count++] = (ranked_edge){a, b, r};
        }
    }
    return STP_OK;
}

/* Joins the cell's own sure edges, surest first. */
static void join_cell(stp_sheets *c, const cell_edge *sure, cell_edge *order,
                      size_t counts[STP_RANK_SURE])
{
    size_t sum = stp_prefix_sum(counts, STP_RANK_SURE);
    for (size_t e = 0; e < sum; e++)
        order[counts[sure[e].rank]++] = sure[e];
    for (size_t e = 0; e < sum; e++)
        stp_forest_join(&c->forest, order[e].a, order[e].b, order[e].turned);
}

/* Drops open edges inside a piece of the cell's. */
static void drop_joined(stp_sheets *c, const stp_cell *cell, stp_open_edges *open)
{
    size_t kept = 0;
    uint8_t parity = 0;
    for (size_t e = 0; e < open->count; e++) {
        ranked_edge edge = open->edges[e];
        if (edge.b < cell->begin || edge.b >= cell->end ||
            stp_forest_find(&c->forest, edge.a, &parity) !=
                stp_forest_find(&c->forest, edge.b, &parity))
            open->edges[kept++] = edge;
    }
    open->count = kept;
}

/* Pieces inside one cell: its points alone are touched. */
static stp_status connect_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    stp_sheets *c = context;
    const stp_cell *cell = &c->cloud->cells[index];
    size_t edges = (size_t)(cell->end - cell->begin) * c->edge_count;
    size_t counts[STP_RANK_SURE] = {0};
    cell_edge *sure = NULL;
    cell_edge *order = NULL;
    (void)worker;
    STP_TRY(stp_alloc(&sure, edges, sizeof *sure, "edges", err));
    STP_TRY(stp_alloc(&order, edges, sizeof *order, "edges", err));
    STP_TRY(relate_cell(c, cell, sure, counts, &c->open[index], err));
    join_cell(c, sure, order, counts);
    drop_joined(c, cell, &c->open[index]);
    STP_TRY(stp_spill_move(c->cloud->spill, &c->open[index].edges, c->open[index].count,
                           sizeof *c->open[index].edges, "edges", err));
done:
    free(order);
    free(sure);
    return status;
}

static bool is_crumb(stp_sheets *c, uint32_t point)
{
    uint8_t parity = 0;
    return c->forest.size[stp_forest_find(&c->forest, point, &parity)] <= STP_CRUMB_POINTS;
}

/* Joins the open edges of all cells with ranks below `end`, surest first; crumbs_only: no two
 * pieces greater than crumbs, for which narrow edges will do. */
static stp_status join_open(stp_sheets *c, uint32_t end, bool crumbs_only, stp_error *err)
{
    size_t counts[STP_RANK_NONE] = {0};
    ranked_edge *order = NULL;
    for (uint32_t cell = 0; cell < c->cloud->cell_count; cell++)
        for (size_t e = 0; e < c->open[cell].count; e++)
            counts[c->open[cell].edges[e].relation.rank]++;
    size_t sum = stp_prefix_sum(counts, end);
    stp_spill *spill = c->cloud->spill;
    stp_status status = stp_spill_alloc(spill, &order, sum, sizeof *order, "edges", err);
    if (status != STP_OK)
        return status;
    for (uint32_t cell = 0; cell < c->cloud->cell_count; cell++)
        for (size_t e = 0; e < c->open[cell].count; e++)
            if (c->open[cell].edges[e].relation.rank < end)
                order[counts[c->open[cell].edges[e].relation.rank]++] = c->open[cell].edges[e];
    for (size_t e = 0; e < sum; e++) {
        ranked_edge edge = order[e];
        if (crumbs_only ? is_crumb(c, edge.a) || is_crumb(c, edge.b) : !edge.relation.narrow)
            stp_forest_join(&c->forest, edge.a, edge.b, edge.relation.turned);
    }
    stp_spill_free(spill, order);
    return STP_OK;
}

stp_status stp_sheets_create(stp_sheets *out, stp_cloud *cloud, const stp_neighbours *neighbours,
                             stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    unsigned k = neighbours->k < EDGE_NEIGHBOURS ? neighbours->k : EDGE_NEIGHBOURS;
    stp_sheets s = {.cloud = cloud, .neighbours = neighbours, .edge_count = k};
    STP_TRY(stp_forest_create(&s.forest, cloud->count, cloud->spill, err));
    STP_TRY(stp_alloc(&s.open, cloud->cell_count, sizeof *s.open, "edges", err));
    STP_TRY(stp_cloud_run(cloud, pool, cloud->cell_count, connect_cell, &s, err));
    STP_TRY(join_open(&s, STP_RANK_SURE, false, err));
    STP_TRY(stp_crumbs_find(&s.crumbs, cloud, neighbours, &s.forest, err));
    *out = s;
    s = (stp_sheets){0};
done:
    stp_sheets_clear(&s);
    return status;
}

stp_status stp_sheets_cross(stp_sheets *s, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t parity = 0;
    STP_TRY(stp_spill_alloc(s->cloud->spill, &s->parts, s->cloud->count, sizeof *s->parts, "pieces",
                            err));
    STP_TRY(join_open(s, STP_RANK_NONE, true, err));
    for (uint32_t i = 0; i < s->cloud->count; i++, stp_cloud_step(s->cloud->spill, i))
        s->parts[i] = stp_forest_find(&s->forest, i, &parity);
    STP_TRY(join_open(s, STP_RANK_NONE, false, err));
done:
    return status;
}

void stp_sheets_clear(stp_sheets *sheets)
{
    if (sheets->cloud)
        stp_spill_free(sheets->cloud->spill, sheets->parts);
    for (uint32_t i = 0; sheets->open && i < sheets->cloud->cell_count; i++)
        stp_spill_free(sheets->cloud->spill, sheets->open[i].edges);
    free(sheets->open);
    stp_crumbs_clear(&sheets->crumbs);
    stp_forest_clear(&sheets->forest);
    *sheets = (stp_sheets){0};
}
