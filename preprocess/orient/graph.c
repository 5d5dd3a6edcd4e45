/* Joins a cell's points into pieces. */
#include "preprocess/orient/graph.h"

#include "base/ahead.h"
#include "base/memory.h"
#include "base/prefix_sum.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/cloud/place_list.h"
#include "preprocess/orient/facing.h"
#include "preprocess/orient/forest.h"
#include "preprocess/surface/layer.h"

#include <stdlib.h>
#include <string.h>

#define EDGE_NEIGHBOURS 8u /* of each point, nearest first: enough to connect the surface */

/* An edge between two points of the cell, numbered in the cell. */
typedef struct cell_edge {
    uint32_t a, b;
    uint16_t rank;
    bool turned;
} cell_edge;

typedef struct connection {
    const stp_unit *unit;
    const stp_dvec3 *stations;
    uint32_t begin, count; /* the cell's points in the unit */
    unsigned edge_count;   /* of each point */
    stp_forest forest;     /* over the cell's points */
    stp_graph *out;
    cell_edge *sure, *order; /* sure edges inside the cell that are not plain */
    uint32_t sure_count;
    size_t counts[STP_RANK_SURE]; /* of sure edges, by rank */
} connection;

static const uint32_t *edges_of(const connection *c, uint32_t a)
{
    return c->unit->neighbours.indices + (size_t)a * c->unit->neighbours.k;
}

/* Whether a point at this height over a's plane lies on a's own sheet. Within one gap it does,
 * whatever else is near. */
static bool in_layer(const connection *c, uint32_t a, float height)
{
    const stp_cloud *cloud = &c->unit->cloud;
    const float gap = STP_LAYER_GAP * cloud->points[a].spacing;
    if (fabsf(height) <= gap)
        return true;
    stp_layer layer = stp_layer_find(cloud, a, cloud->points[a].normal, edges_of(c, a),
                                     c->unit->neighbours.k, gap);
    return stp_layer_holds(layer, height);
}

/* Relates two points. An edge is sure only if it lies within the layers of both ends. */
static stp_relation relate_layers(const connection *c, uint32_t a, uint32_t b)
{
    stp_relation r = stp_relate(&c->unit->cloud.points[a], &c->unit->cloud.points[b]);
    if (r.rank < STP_RANK_SURE && !(in_layer(c, a, r.height_p) && in_layer(c, b, r.height_q)))
        r.rank = STP_RANK_SURE;
    return r;
}

/* Whether the edge from a to b is also b's edge to a and b, the earlier point, handles it. */
static bool is_repeated(const connection *c, uint32_t a, uint32_t b)
{
    bool found = false;
    if (c->unit->places[b] > c->unit->places[a])
        return false;
    for (unsigned i = 0; i < c->edge_count; i++)
        found |= edges_of(c, b)[i] == a;
    return found;
}

/* A cell has at most half a million edges. */
static stp_status add_open(stp_graph *graph, stp_edge edge, stp_error *err)
{
    stp_status status = stp_grow(&graph->edges, &graph->edge_capacity, graph->edge_count + 1,
                                 sizeof *graph->edges, "edges", err);
    if (status == STP_OK)
        graph->edges[graph->edge_count++] = edge;
    return status;
}

/* Whether a point of the cell is already in one piece with another point. */
static bool is_joined(connection *c, uint32_t a, uint32_t b)
{
    uint8_t parity;
    if (b - c->begin >= c->count)
        return false;
    a -= c->begin;
    b -= c->begin;
    return c->forest.parent[a] == c->forest.parent[b] ||
           stp_forest_find(&c->forest, a, &parity) == stp_forest_find(&c->forest, b, &parity);
}

/* Looks at the edges of the cell's points that may still join pieces. Plain ones inside the cell
 * join at once, so most edges of a smooth surface need no look. */
static stp_status relate_cell(connection *c, stp_error *err)
{
    for (uint32_t a = c->begin; a < c->begin + c->count; a++) {
        stp_ask_ahead(c->unit->cloud.points, sizeof *c->unit->cloud.points, a);
        stp_ask_ahead(c->unit->neighbours.indices, c->unit->neighbours.k * sizeof(uint32_t), a);
        for (unsigned i = 0; i < c->edge_count; i++) {
            uint32_t b = edges_of(c, a)[i];
            if (b == STP_NEIGHBOUR_NONE || is_joined(c, a, b) || is_repeated(c, a, b))
                continue;
            stp_relation r = relate_layers(c, a, b);
            const bool inside = b - c->begin < c->count;
            if (r.rank < STP_RANK_PLAIN && inside) {
                stp_forest_join(&c->forest, a - c->begin, b - c->begin, r.turned);
                continue;
            }
            if (r.rank < STP_RANK_SURE && inside) {
                c->sure[c->sure_count++] =
                    (cell_edge){a - c->begin, b - c->begin, r.rank, r.turned};
                c->counts[r.rank]++;
                continue;
            }
            if (r.rank >= STP_RANK_NONE)
                continue;
            stp_edge edge = {.other = c->unit->places[b] & STP_PLACE_MASK,
                             .own = (uint16_t)(a - c->begin),
                             .rank = r.rank & 0xffu,
                             .turned = r.turned,
                             .narrow = r.narrow};
            stp_status status = add_open(c->out, edge, err);
            if (status != STP_OK)
                return status;
        }
    }
    return STP_OK;
}

/* Joins by the cell's other sure edges, surest first. */
static void join_cell(connection *c)
{
    size_t sum = stp_prefix_sum(c->counts, STP_RANK_SURE);
    for (size_t e = 0; e < sum; e++)
        c->order[c->counts[c->sure[e].rank]++] = c->sure[e];
    for (size_t e = 0; e < sum; e++)
        stp_forest_join(&c->forest, c->order[e].a, c->order[e].b, c->order[e].turned);
}

/* Numbers the pieces in the order of their roots, which are their first points. */
static stp_status number_pieces(connection *c, stp_error *err)
{
    stp_status status = STP_OK;
    stp_graph *graph = c->out;
    uint32_t *sheets = c->unit->whole->sheets + c->unit->places[c->begin];
    uint8_t *marks = c->unit->whole->marks + c->unit->places[c->begin];
    for (uint32_t i = 0; i < c->count; i++)
        graph->piece_count += c->forest.parent[i] == i;
    STP_TRY(stp_alloc(&graph->sizes, graph->piece_count, sizeof *graph->sizes, "pieces", err));
    uint32_t number = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        uint8_t parity = 0;
        uint32_t root = stp_forest_find(&c->forest, i, &parity);
        if (root == i)
            graph->sizes[number] = c->forest.size[i];
        sheets[i] = root == i ? number++ : sheets[root];
        marks[i] = (uint8_t)((marks[i] & STP_MARK_OUTLIER) | (parity ? STP_MARK_TURNED : 0u));
    }
done:
    return status;
}

/* Drops open edges whose ends are in one piece of the cell. */
static void drop_joined(connection *c)
{
    stp_graph *graph = c->out;
    const uint32_t *sheets = c->unit->whole->sheets;
    const uint64_t first = c->unit->places[c->begin];
    size_t kept = 0;
    for (size_t e = 0; e < graph->edge_count; e++) {
        stp_edge edge = graph->edges[e];
        if (edge.other - first >= c->count || sheets[first + edge.own] != sheets[edge.other])
            graph->edges[kept++] = edge;
    }
    graph->edge_count = kept;
}

static bool is_kept(const connection *c, uint32_t i)
{
    uint32_t at = c->begin + i;
    uint32_t piece = c->unit->whole->sheets[c->unit->places[at]];
    return c->out->sizes[piece] <= STP_CRUMB_POINTS ||
           (c->stations && !stp_facing_plainly(&c->unit->cloud.points[at], c->stations));
}

static stp_status keep_lists(connection *c, stp_error *err)
{
    stp_status status = STP_OK;
    stp_graph *graph = c->out;
    unsigned k = c->unit->neighbours.k;
    for (uint32_t i = 0; i < c->count; i++)
        graph->kept_count += is_kept(c, i);
    STP_TRY(stp_alloc(&graph->kept, graph->kept_count, sizeof *graph->kept, "neighbours", err));
    STP_TRY(stp_alloc(&graph->lists, (size_t)graph->kept_count * k, STP_PLACE_BYTES, "neighbours",
                      err));
    uint8_t *end = graph->lists;
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        if (!is_kept(c, i))
            continue;
        const uint64_t self = c->unit->places[c->begin + i];
        graph->kept[count++] = (uint16_t)i;
        for (unsigned n = 0; n < k; n++) {
            uint32_t other = edges_of(c, c->begin + i)[n];
            end = stp_place_list_write(
                end, self, other == STP_NEIGHBOUR_NONE ? STP_PLACE_NONE : c->unit->places[other]);
        }
    }
    graph->list_bytes = (size_t)(end - graph->lists);
done:
    return status;
}

stp_status stp_graph_stow(stp_graph *graph, stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_spill_move(spill, &graph->edges, graph->edge_count, sizeof *graph->edges, "edges",
                           err));
    STP_TRY(stp_spill_move(spill, &graph->sizes, graph->piece_count, sizeof *graph->sizes, "pieces",
                           err));
    STP_TRY(stp_spill_move(spill, &graph->kept, graph->kept_count, sizeof *graph->kept,
                           "neighbours", err));
    STP_TRY(stp_spill_move(spill, &graph->lists, graph->list_bytes, 1, "neighbours", err));
done:
    return status;
}

stp_status stp_graph_create(stp_graph *out, const stp_unit *unit, const stp_cell *cell,
                            const stp_dvec3 *stations, stp_error *err)
{
    stp_status status = STP_OK;
    stp_graph graph = {0};
    connection c = {.unit = unit,
                    .stations = stations,
                    .begin = (uint32_t)(cell->begin - unit->places[0]),
                    .count = (uint32_t)(cell->end - cell->begin),
                    .edge_count =
                        unit->neighbours.k < EDGE_NEIGHBOURS ? unit->neighbours.k : EDGE_NEIGHBOURS,
                    .out = &graph};
    size_t edges = (size_t)c.count * c.edge_count;
    STP_TRY(stp_forest_create(&c.forest, c.count, NULL, err));
    STP_TRY(stp_alloc_unset(&c.sure, edges, sizeof *c.sure, "edges", err));
    STP_TRY(stp_alloc_unset(&c.order, edges, sizeof *c.order, "edges", err));
    STP_TRY(relate_cell(&c, err));
    join_cell(&c);
    STP_TRY(number_pieces(&c, err));
    drop_joined(&c);
    STP_TRY(keep_lists(&c, err));
    STP_TRY(stp_graph_stow(&graph, unit->whole->spill, err));
    *out = graph;
    graph = (stp_graph){0};
done:
    stp_graph_clear(&graph, unit->whole->spill);
    stp_forest_clear(&c.forest);
    free(c.order);
    free(c.sure);
    return status;
}

/* An edge during sorting. */
typedef struct joint {
    uint32_t a, b;   /* its pieces, the lower number first */
    uint32_t number; /* in the order of the cell's points */
    stp_edge edge;
} joint;

static int compare_ranks(const void *a, const void *b)
{
    const joint *p = a, *q = b;
    if (p->edge.rank != q->edge.rank)
        return p->edge.rank < q->edge.rank ? -1 : 1;
    return p->number < q->number ? -1 : p->number > q->number;
}

/* By pieces, then narrow edges last, then by rank, then by number. */
static int compare_pieces(const void *a, const void *b)
{
    const joint *p = a, *q = b;
    if (p->a != q->a)
        return p->a < q->a ? -1 : 1;
    if (p->b != q->b)
        return p->b < q->b ? -1 : 1;
    if (p->edge.narrow != q->edge.narrow)
        return p->edge.narrow ? 1 : -1;
    return compare_ranks(a, b);
}

static bool same_pieces(const joint *p, const joint *q)
{
    return p->a == q->a && p->b == q->b && p->edge.narrow == q->edge.narrow;
}

static joint joint_of(const stp_cloud *cloud, const stp_cell *cell, uint32_t piece_begin,
                      stp_edge edge, uint32_t number)
{
    const uint64_t point = cell->begin + edge.own;
    uint32_t a = cloud->sheets[point], b = cloud->sheets[edge.other];
    edge.turned ^= ((cloud->marks[point] ^ cloud->marks[edge.other]) & STP_MARK_TURNED) != 0;
    edge.own = (uint16_t)(a - piece_begin);
    edge.other = b;
    return (joint){a < b ? a : b, a < b ? b : a, number, edge};
}

stp_status stp_graph_resolve(stp_graph *graph, const stp_cloud *cloud, const stp_cell *cell,
                             uint32_t piece_begin, stp_error *err)
{
    stp_status status = STP_OK;
    joint *joints = NULL;
    size_t kept = 0;
    if (graph->edge_count == 0)
        return STP_OK;
    STP_TRY(stp_alloc(&joints, graph->edge_count, sizeof *joints, "edges", err));
    for (size_t e = 0; e < graph->edge_count; e++)
        joints[e] = joint_of(cloud, cell, piece_begin, graph->edges[e], (uint32_t)e);
    qsort(joints, graph->edge_count, sizeof *joints, compare_pieces);
    for (size_t e = 0; e < graph->edge_count; e++)
        if (kept == 0 || !same_pieces(&joints[kept - 1], &joints[e]))
            joints[kept++] = joints[e];
    qsort(joints, kept, sizeof *joints, compare_ranks);
    for (size_t e = 0; e < kept; e++)
        graph->edges[e] = joints[e].edge;
    graph->edge_count = kept;
done:
    free(joints);
    return status;
}

void stp_graph_clear(stp_graph *graph, stp_spill *spill)
{
    stp_spill_free(spill, graph->sizes);
    stp_spill_free(spill, graph->edges);
    stp_spill_free(spill, graph->kept);
    stp_spill_free(spill, graph->lists);
    *graph = (stp_graph){0};
}
