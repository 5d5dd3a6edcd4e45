/* Joins the pieces of all cells into sheets. */
#include "preprocess/orient/sheets.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/orient/kept_walk.h"

#include <stdlib.h>

/* Numbers a cell's pieces after those of the cells before. */
static stp_status number_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    const stp_sheets *s = context;
    const stp_cell *cell = &s->cloud->cells[index];
    (void)worker;
    (void)err;
    for (uint64_t i = cell->begin; i < cell->end; i++)
        s->cloud->sheets[i] += s->piece_begin[index];
    return STP_OK;
}

static stp_status resolve_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_sheets *s = context;
    (void)worker;
    return stp_graph_resolve(&s->graphs[index], s->cloud, &s->cloud->cells[index],
                             s->piece_begin[index], err);
}

/* Asks for the points at the ends of edges, and for the neighbours of kept points. */
static void ask_for_ends(const stp_sheets *s)
{
    for (uint32_t c = 0; s->cloud->blocks && c < s->cloud->cell_count; c++) {
        const stp_graph *graph = &s->graphs[c];
        for (size_t e = 0; e < graph->edge_count; e++)
            (void)stp_cloud_has(s->cloud, graph->edges[e].other);
        for (stp_kept_walk kept = stp_kept_begin(s, c); stp_kept_next(&kept);)
            for (unsigned n = 0; n < s->k && kept.neighbours[n] != STP_PLACE_NONE; n++)
                (void)stp_cloud_has(s->cloud, kept.neighbours[n]);
    }
}

/* Gives each rank's edges, which are between pieces now, to all. */
static stp_status share_edges(stp_sheets *s, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud_blocks *b = s->cloud->blocks;
    stp_bytes packet = {0};
    for (unsigned rank = 0; b && rank < b->ranks->count; rank++) {
        const stp_rank_part cells = stp_cloud_cells(s->cloud, b->ranks, rank);
        for (uint64_t c = cells.begin; c < cells.end; c++) {
            stp_graph *graph = &s->graphs[c];
            packet.size = 0;
            if (rank == b->ranks->self)
                STP_TRY(stp_bytes_append(&packet, graph->edges,
                                         graph->edge_count * sizeof *graph->edges, err));
            STP_TRY(stp_ranks_broadcast_bytes(b->ranks, rank, &packet, err));
            if (rank == b->ranks->self || packet.size == 0)
                continue;
            stp_cursor from = {packet.data, packet.size};
            graph->edge_count = packet.size / sizeof *graph->edges;
            STP_TRY(stp_packet_take_array(&from, &graph->edges, graph->edge_count,
                                          sizeof *graph->edges, err));
            STP_TRY(stp_spill_move(s->cloud->spill, &graph->edges, graph->edge_count,
                                   sizeof *graph->edges, "edges", err));
        }
        stp_spill_relieve(s->cloud->spill);
    }
done:
    free(packet.data);
    return status;
}

/* Makes a forest of the pieces of all cells, and edges between the pieces. */
static stp_status gather_pieces(stp_sheets *s, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t cell_count = s->cloud->cell_count;
    STP_TRY(stp_alloc(&s->piece_begin, cell_count, sizeof *s->piece_begin, "pieces", err));
    STP_TRY(
        stp_alloc(&s->kept_begin, (size_t)cell_count + 1, sizeof *s->kept_begin, "pieces", err));
    for (uint32_t c = 0; c < cell_count; c++) { /* kept points are known of own cells only */
        if (s->graphs[c].piece_count >= STP_SHEET_NONE - s->piece_count)
            return stp_error_set(err, STP_LIMIT,
                                 "the points are in more than %u pieces of smooth surface: split "
                                 "the input into several models",
                                 STP_SHEET_NONE - 1);
        s->piece_begin[c] = s->piece_count;
        s->piece_count += s->graphs[c].piece_count;
        s->kept_begin[c + 1] = s->kept_begin[c] + s->graphs[c].kept_count;
    }
    STP_TRY(stp_cloud_run_own(s->cloud, pool, number_cell, s, err));
    ask_for_ends(s);
    STP_TRY(stp_cloud_fetch(s->cloud, err));
    STP_TRY(stp_cloud_run_own(s->cloud, pool, resolve_cell, s, err));
    STP_TRY(share_edges(s, err));
    STP_TRY(stp_forest_create(&s->forest, s->piece_count, s->cloud->spill, err));
    for (uint32_t c = 0; c < cell_count; c++) {
        stp_spill_relieve(s->cloud->spill);
        for (uint32_t i = 0; i < s->graphs[c].piece_count; i++)
            s->forest.size[s->piece_begin[c] + i] = s->graphs[c].sizes[i];
    }
done:
    return status;
}

static bool is_crumb(stp_sheets *s, uint32_t piece)
{
    uint8_t parity = 0;
    return s->forest.size[stp_forest_find(&s->forest, piece, &parity)] <= STP_CRUMB_POINTS;
}

/* Joins across the open edges of all cells with ranks below `end`, surest first; equals go by cell.
 * crumbs_only: only pairs with a crumb are joined, also across narrow edges. Otherwise narrow edges
 * are skipped. */
static stp_status join_open(stp_sheets *s, uint32_t end, bool crumbs_only, stp_error *err)
{
    const uint32_t cell_count = s->cloud->cell_count;
    const bool again = end > STP_RANK_SURE; /* sure edges that are not narrow are joined already */
    size_t *next = NULL;                    /* edge, by cell */
    stp_status status = stp_alloc(&next, cell_count, sizeof *next, "edges", err);
    if (status != STP_OK)
        return status;
    for (uint32_t rank = 0; rank < end; rank++) {
        for (uint32_t c = 0; c < cell_count; c++) {
            const stp_graph *graph = &s->graphs[c];
            for (; next[c] < graph->edge_count; next[c]++) {
                stp_edge edge = graph->edges[next[c]];
                const uint32_t own = s->piece_begin[c] + edge.own, other = (uint32_t)edge.other;
                if (edge.rank != rank)
                    break;
                if (again && rank < STP_RANK_SURE && !edge.narrow)
                    continue;
                if (crumbs_only ? is_crumb(s, own) || is_crumb(s, other) : !edge.narrow)
                    stp_forest_join(&s->forest, own, other, edge.turned);
            }
        }
        stp_spill_relieve(s->cloud->spill);
    }
    free(next);
    return STP_OK;
}

stp_status stp_sheets_create(stp_sheets *out, stp_cloud *cloud, unsigned k, stp_graph **graphs,
                             stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t parity = 0;
    stp_sheets s = {.cloud = cloud, .k = k, .graphs = *graphs};
    *graphs = NULL;
    STP_TRY(gather_pieces(&s, pool, err));
    STP_TRY(join_open(&s, STP_RANK_SURE, false, err));
    STP_TRY(stp_spill_alloc(cloud->spill, &s.roots, s.piece_count, sizeof *s.roots, "pieces", err));
    STP_TRY(
        stp_spill_alloc(cloud->spill, &s.crumbs, s.piece_count, sizeof *s.crumbs, "pieces", err));
    for (uint32_t i = 0; i < s.piece_count; i++, stp_cloud_step(cloud->spill, i)) {
        s.roots[i] = stp_forest_find(&s.forest, i, &parity);
        s.crumbs[i] = s.forest.size[s.roots[i]] <= STP_CRUMB_POINTS;
    }
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
    stp_spill *spill = s->cloud->spill;
    STP_TRY(stp_spill_alloc(spill, &s->parts, s->piece_count, sizeof *s->parts, "pieces", err));
    STP_TRY(join_open(s, STP_RANK_NONE, true, err));
    for (uint32_t i = 0; i < s->piece_count; i++, stp_cloud_step(spill, i))
        s->parts[i] = stp_forest_find(&s->forest, i, &parity);
    STP_TRY(join_open(s, STP_RANK_NONE, false, err));
done:
    return status;
}

/* The sheet, among those of a point's neighbours, whose planes have the least mean distance from
 * the point; its own sheet if there is none. */
static uint32_t adopt(const stp_sheets *s, uint64_t self, const uint64_t *list)
{
    struct {
        uint32_t root;
        float offset, count;
    } candidates[STP_NEIGHBOURS_LIMIT];
    const stp_cloud_point *p = &s->cloud->points[self];
    unsigned count = 0, best = 0;
    for (unsigned i = 0; i < s->k && list[i] != STP_PLACE_NONE; i++) {
        const stp_cloud_point *q = &s->cloud->points[list[i]];
        vec3s d = stp_dvec3_to_float(stp_dvec3_sub(p->position, q->position));
        if (stp_sheets_on_crumb(s, list[i]))
            continue;
        unsigned at = 0;
        while (at < count && candidates[at].root != stp_sheets_root(s, list[i]))
            at++;
        if (at == count) {
            candidates[at].root = stp_sheets_root(s, list[i]);
            candidates[at].offset = candidates[at].count = 0.0f;
            count++;
        }
        candidates[at].offset += fabsf(glms_vec3_dot(q->normal, d));
        candidates[at].count += 1.0f;
    }
    for (unsigned i = 1; i < count; i++)
        if (candidates[i].offset * candidates[best].count <
            candidates[best].offset * candidates[i].count)
            best = i;
    return count ? candidates[best].root : stp_sheets_root(s, self);
}

typedef struct adoption {
    const stp_sheets *sheets;
    uint32_t *sheets_of; /* by kept point */
} adoption;

/* A point that noise moved off its surface joins the sheet nearest to it. Edges would lead through
 * such points from one side of a thin plate to the other. */
static stp_status adopt_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    const adoption *adopted = context;
    const stp_sheets *s = adopted->sheets;
    (void)worker;
    (void)err;
    for (stp_kept_walk kept = stp_kept_begin(s, index); stp_kept_next(&kept);)
        adopted->sheets_of[kept.number] = stp_sheets_on_crumb(s, kept.self)
                                              ? adopt(s, kept.self, kept.neighbours)
                                              : stp_sheets_root(s, kept.self);
    return STP_OK;
}

static stp_status take_adopted(void *context, size_t index, unsigned worker, stp_error *err)
{
    const adoption *adopted = context;
    const stp_sheets *s = adopted->sheets;
    const stp_graph *graph = &s->graphs[index];
    const stp_cell *cell = &s->cloud->cells[index];
    (void)worker;
    (void)err;
    for (uint64_t i = cell->begin; i < cell->end; i++)
        s->cloud->sheets[i] = stp_sheets_root(s, i);
    for (uint32_t i = 0; i < graph->kept_count; i++)
        s->cloud->sheets[cell->begin + graph->kept[i]] =
            adopted->sheets_of[s->kept_begin[index] + i];
    for (uint64_t i = cell->begin; i < cell->end; i++)
        if (!stp_has_normal(&s->cloud->points[i]))
            s->cloud->sheets[i] = STP_SHEET_NONE;
    return STP_OK;
}

stp_status stp_sheets_adopt(stp_sheets *s, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    adoption adopted = {.sheets = s};
    STP_TRY(stp_spill_alloc(s->cloud->spill, &adopted.sheets_of,
                            s->kept_begin[s->cloud->cell_count], sizeof *adopted.sheets_of,
                            "sheets", err));
    STP_TRY(stp_cloud_run_own(s->cloud, pool, adopt_cell, &adopted, err));
    STP_TRY(stp_cloud_run_own(s->cloud, pool, take_adopted, &adopted, err));
done:
    stp_spill_free(s->cloud->spill, adopted.sheets_of);
    return status;
}

void stp_sheets_clear(stp_sheets *s)
{
    const stp_cloud *cloud = s->cloud; /* NULL: nothing was made */
    stp_spill *spill = cloud ? cloud->spill : NULL;
    for (uint32_t i = 0; cloud && s->graphs && i < cloud->cell_count; i++)
        stp_graph_clear(&s->graphs[i], spill);
    free(s->graphs);
    free(s->piece_begin);
    free(s->kept_begin);
    stp_spill_free(spill, s->roots);
    stp_spill_free(spill, s->crumbs);
    stp_spill_free(spill, s->parts);
    stp_forest_clear(&s->forest);
    *s = (stp_sheets){0};
}
