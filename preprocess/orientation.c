/* Which way normals point. */
#include "preprocess/orientation.h"

#include "base/memory.h"
#include "preprocess/layer.h"
#include "preprocess/visibility.h"

#include <stdlib.h>

#define EDGE_NEIGHBOURS 8u /* of each point, nearest first: enough to connect it */
#define BUCKETS 256u
#define SMOOTH_BUCKETS 200u /* edges inside a sheet; the others lead across creases */
#define SURE_BUCKETS 100u   /* a quarter of a spacing off, 31 degrees: joins sheets */
#define CRUMB_POINTS 64u    /* smaller pieces are no sheets but parts of one nearby */
#define SHEET_COSINE 0.7f
#define SHEET_OFFSET 0.5f /* spacings off each other's plane */
/* A piece whose summed area vectors are below this part of its area is closed. */
#define CLOSED_RATIO 0.25
#define CLOSED_POINTS 64u
/* Views flatter than this do not tell the sides of a noisy normal apart. */
#define GRAZING_COSINE 0.2

typedef struct edge {
    uint32_t a, b;
} edge;

/* Union-find with the parity of a point's sign against its root's. */
typedef struct forest {
    uint32_t *parent;
    uint8_t *parity;
    uint32_t *size; /* of a root's piece */
} forest;

static uint32_t find(forest *f, uint32_t i, uint8_t *parity)
{
    uint32_t root = i;
    uint8_t sum = 0;
    while (f->parent[root] != root) {
        sum ^= f->parity[root];
        root = f->parent[root];
    }
    *parity = sum;
    while (f->parent[i] != root) {
        uint32_t next = f->parent[i];
        uint8_t own = f->parity[i];
        f->parent[i] = root;
        f->parity[i] = sum;
        sum ^= own;
        i = next;
    }
    return root;
}

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

static void join(const stp_cloud *cloud, forest *f, edge e)
{
    uint8_t pa = 0, pb = 0;
    uint32_t ra = find(f, e.a, &pa);
    uint32_t rb = find(f, e.b, &pb);
    if (ra == rb)
        return;
    uint8_t flip = against(cloud, e.a, e.b) ? 1 : 0;
    uint32_t low = ra < rb ? ra : rb;
    uint32_t high = ra < rb ? rb : ra;
    f->parent[high] = low;
    f->size[low] += f->size[high];
    f->parity[high] = pa ^ pb ^ flip;
}

typedef struct ranked_edge {
    uint32_t a, b, rank;
} ranked_edge;

/* Edges that a cell cannot decide alone: to other cells, and unsure ones. */
typedef struct open_edges {
    ranked_edge *edges;
    size_t count, capacity;
} open_edges;

typedef struct connection {
    stp_cloud *cloud;
    const stp_neighbours *neighbours;
    forest forest;
    stp_layer *layers;   /* by point */
    open_edges *open;    /* by cell */
    unsigned edge_count; /* of each point */
} connection;

static stp_status find_layers(void *context, size_t index, unsigned worker, stp_error *err)
{
    connection *c = context;
    (void)worker;
    (void)err;
    const stp_cell *cell = &c->cloud->cells[index];
    for (uint32_t i = cell->begin; i < cell->end; i++)
        c->layers[i] =
            stp_layer_find(c->cloud, i, c->cloud->points[i].normal,
                           c->neighbours->indices + (size_t)i * c->neighbours->k, c->neighbours->k);
    return STP_OK;
}

static bool in_layer(const connection *c, uint32_t a, uint32_t b)
{
    float height = stp_layer_height(c->cloud, a, c->cloud->points[a].normal, b);
    return stp_layer_holds(c->layers[a], height);
}

/* Sure edges lie within the layers of both ends. */
static uint32_t rank_edge(const connection *c, uint32_t a, uint32_t b)
{
    uint32_t r = rank(c->cloud, a, b);
    return r < SURE_BUCKETS && !(in_layer(c, a, b) && in_layer(c, b, a)) ? SURE_BUCKETS : r;
}

/* Ranks of all edges of a cell's points, and how many have each. */
static void rank_cell(const connection *c, const stp_cell *cell, uint16_t *ranks,
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
static void join_cell(connection *c, const stp_cell *cell, const uint16_t *ranks, uint32_t *order,
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
        join(c->cloud, &c->forest, (edge){a, b});
    }
}

/* Keeps what joins more than the cell's own pieces. */
static stp_status keep_open(connection *c, const stp_cell *cell, const uint16_t *ranks,
                            open_edges *out, stp_error *err)
{
    uint32_t edges = (cell->end - cell->begin) * c->edge_count;
    for (uint32_t e = 0; e < edges; e++) {
        uint32_t a = cell->begin + e / c->edge_count;
        uint32_t b = c->neighbours->indices[(size_t)a * c->neighbours->k + e % c->edge_count];
        uint8_t pa = 0, pb = 0;
        if (ranks[e] >= BUCKETS)
            continue;
        if (b >= cell->begin && b < cell->end &&
            find(&c->forest, a, &pa) == find(&c->forest, b, &pb))
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
    connection *c = context;
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
static stp_status join_open(connection *c, uint32_t first, uint32_t end, stp_error *err)
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
        join(c->cloud, &c->forest, order[e]);
    free(order);
    return STP_OK;
}

typedef struct piece {
    stp_dvec3 area; /* sum of area vectors */
    stp_dvec3 first;
    double total, volume;
    uint32_t count;
} piece;

/* Points' pieces, numbered from 0 in the order of their roots; returns how many. */
static uint32_t number_pieces(forest *f, uint32_t count, uint32_t *numbers)
{
    uint32_t piece_count = 0;
    for (uint32_t i = 0; i < count; i++) { /* a root is its piece's first point */
        uint8_t parity = 0;
        uint32_t root = find(f, i, &parity);
        numbers[i] = root == i ? piece_count++ : numbers[root];
    }
    return piece_count;
}

/* Makes signs agree with the piece's first point and sums the pieces up. */
static void sum_pieces(stp_cloud *cloud, const forest *f, const uint32_t *numbers, piece *pieces)
{
    for (uint32_t i = 0; i < cloud->count; i++) {
        stp_cloud_point *p = &cloud->points[i];
        piece *c = &pieces[numbers[i]];
        if (f->parity[i])
            p->normal = glms_vec3_negate(p->normal);
        if (c->count++ == 0)
            c->first = p->position;
        double area = (double)p->spacing * (double)p->spacing;
        stp_dvec3 vector = stp_dvec3_scale(stp_dvec3_from_float(p->normal), area);
        c->area = stp_dvec3_add(c->area, vector);
        c->total += area;
        c->volume += stp_dvec3_dot(stp_dvec3_sub(p->position, c->first), vector);
    }
}

/* Marks closed pieces oriented and turns them outward; *oriented: how many points. */
static stp_status turn_outward(stp_cloud *cloud, forest *f, uint32_t *oriented, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *numbers = NULL;
    piece *pieces = NULL;
    STP_TRY(stp_alloc(&numbers, cloud->count, sizeof *numbers, "pieces", err));
    uint32_t piece_count = number_pieces(f, cloud->count, numbers);
    STP_TRY(stp_alloc(&pieces, piece_count, sizeof *pieces, "pieces", err));
    sum_pieces(cloud, f, numbers, pieces);
    *oriented = 0;
    for (uint32_t i = 0; i < cloud->count; i++) {
        stp_cloud_point *p = &cloud->points[i];
        const piece *c = &pieces[numbers[i]];
        if (c->count < CLOSED_POINTS || stp_dvec3_length(c->area) > CLOSED_RATIO * c->total ||
            !(p->flags & STP_SAMPLE_HAS_NORMAL)) {
            /* Either sign will do; octahedral codes are contiguous around +z, not around -z. */
            if (c->area.z < 0.0)
                p->normal = glms_vec3_negate(p->normal);
            continue;
        }
        if (c->volume < 0.0)
            p->normal = glms_vec3_negate(p->normal);
        p->flags |= STP_SAMPLE_ORIENTED;
        (*oriented)++;
    }
done:
    free(pieces);
    free(numbers);
    return status;
}

/* Which side of its piece a point's position says is seen; grazing views say nothing. */
static double facing(const stp_cloud_point *p, stp_dvec3 position)
{
    stp_dvec3 d = stp_dvec3_normalize(stp_dvec3_sub(position, p->position));
    return stp_dvec3_dot(d, stp_dvec3_from_float(p->normal));
}

/* Turns every point to the scanner's position, and those seen at a grazing angle with the piece
 * they are on. */
static stp_status turn_to(stp_cloud *cloud, forest *f, stp_dvec3 position, stp_error *err)
{
    double *votes = NULL;
    stp_status status = stp_alloc(&votes, cloud->count, sizeof *votes, "pieces", err);
    if (status != STP_OK)
        return status;
    for (uint32_t i = 0; i < cloud->count; i++) {
        uint8_t parity = 0;
        uint32_t root = find(f, i, &parity);
        stp_cloud_point *p = &cloud->points[i];
        if (parity)
            p->normal = glms_vec3_negate(p->normal);
        votes[root] += facing(p, position);
    }
    for (uint32_t i = 0; i < cloud->count; i++) {
        uint8_t parity = 0;
        stp_cloud_point *p = &cloud->points[i];
        double own = facing(p, position);
        if ((fabs(own) >= GRAZING_COSINE ? own : votes[find(f, i, &parity)]) < 0.0)
            p->normal = glms_vec3_negate(p->normal);
    }
    free(votes);
    return STP_OK;
}

/* The big sheet among a point's neighbours whose planes' mean it is nearest to; its own if there is
 * none. */
static uint32_t adopt(const connection *c, uint32_t self)
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
static void number_sheets(connection *c)
{
    stp_cloud *cloud = c->cloud;
    for (uint32_t i = 0; i < cloud->count; i++) { /* makes every parent a root */
        uint8_t parity = 0;
        (void)find(&c->forest, i, &parity);
    }
    for (uint32_t i = 0; i < cloud->count; i++) {
        stp_cloud_point *p = &cloud->points[i];
        uint32_t root = c->forest.parent[i];
        p->sheet = c->forest.size[root] <= CRUMB_POINTS ? adopt(c, i) : root;
        if (!(p->flags & STP_SAMPLE_HAS_NORMAL))
            p->sheet = STP_SHEET_NONE;
    }
}

/* Turns the sheets of closed pieces whose seen points say so: reflection across one crease may be
 * wrong, but what a closed surface shows to the outside is its outside. */
static stp_status turn_seen(stp_cloud *cloud, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    _Atomic int *votes = NULL;
    int64_t *sums = NULL;
    STP_TRY(stp_alloc(&votes, cloud->count, sizeof *votes, "votes", err));
    STP_TRY(stp_alloc(&sums, cloud->count, sizeof *sums, "votes", err));
    STP_TRY(stp_visibility_vote(votes, cloud, pool, err));
    for (uint32_t i = 0; i < cloud->count; i++)
        if (cloud->points[i].flags & STP_SAMPLE_ORIENTED)
            sums[cloud->points[i].sheet] += votes[i];
    for (uint32_t i = 0; i < cloud->count; i++) {
        stp_cloud_point *p = &cloud->points[i];
        if (p->flags & STP_SAMPLE_ORIENTED && sums[p->sheet] < 0)
            p->normal = glms_vec3_negate(p->normal);
    }
done:
    free(sums);
    free((void *)votes);
    return status;
}

static void mark_all(stp_cloud *cloud)
{
    for (uint32_t i = 0; i < cloud->count; i++)
        if (cloud->points[i].flags & STP_SAMPLE_HAS_NORMAL)
            cloud->points[i].flags |= STP_SAMPLE_ORIENTED;
}

/* Builds the sheets: in each cell, then between cells. Then goes on across creases and turns the
 * pieces. */
static stp_status connect(stp_cloud *cloud, const stp_neighbours *neighbours,
                          const stp_orient_params *params, stp_pool *pool, uint32_t *oriented,
                          stp_error *err)
{
    stp_status status = STP_OK;
    unsigned k = neighbours->k < EDGE_NEIGHBOURS ? neighbours->k : EDGE_NEIGHBOURS;
    connection c = {.cloud = cloud, .neighbours = neighbours, .edge_count = k};
    STP_TRY(stp_alloc(&c.forest.parent, cloud->count, sizeof *c.forest.parent, "pieces", err));
    STP_TRY(stp_alloc(&c.forest.parity, cloud->count, sizeof *c.forest.parity, "pieces", err));
    STP_TRY(stp_alloc(&c.forest.size, cloud->count, sizeof *c.forest.size, "pieces", err));
    STP_TRY(stp_alloc(&c.layers, cloud->count, sizeof *c.layers, "layers", err));
    STP_TRY(stp_alloc(&c.open, cloud->cell_count, sizeof *c.open, "edges", err));
    for (uint32_t i = 0; i < cloud->count; i++) {
        c.forest.parent[i] = i;
        c.forest.size[i] = 1;
    }
    STP_TRY(stp_pool_run(pool, cloud->cell_count, find_layers, &c, err));
    STP_TRY(stp_pool_run(pool, cloud->cell_count, connect_cell, &c, err));
    STP_TRY(join_open(&c, 0, SURE_BUCKETS, err));
    number_sheets(&c);
    if (params->mode != STP_ORIENT_NONE)
        STP_TRY(join_open(&c, SURE_BUCKETS, BUCKETS, err));
    if (params->mode == STP_ORIENT_POSITION)
        STP_TRY(turn_to(cloud, &c.forest, params->position, err));
    else if (params->mode != STP_ORIENT_NONE)
        STP_TRY(turn_outward(cloud, &c.forest, oriented, err));
    if (*oriented > 0)
        STP_TRY(turn_seen(cloud, pool, err));
done:
    for (uint32_t i = 0; c.open && i < cloud->cell_count; i++)
        free(c.open[i].edges);
    free(c.open);
    free(c.layers);
    free(c.forest.size);
    free(c.forest.parity);
    free(c.forest.parent);
    return status;
}

stp_status stp_orientation_find(stp_cloud *cloud, const stp_neighbours *neighbours,
                                const stp_orient_params *params, stp_pool *pool,
                                stp_orientation *found, stp_error *err)
{
    uint32_t oriented = 0;
    if (params->mode == STP_ORIENT_FILE && !params->from_file)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the input has no normals to orient by: use --orient propagate");
    if (params->from_file && (params->mode == STP_ORIENT_FILE || params->mode == STP_ORIENT_AUTO)) {
        mark_all(cloud); /* signs are known: opposed sheets part by their normals */
        *found = STP_ORIENTATION_FILE;
        return STP_OK;
    }
    stp_status status = connect(cloud, neighbours, params, pool, &oriented, err);
    if (status != STP_OK)
        return status;
    *found = STP_ORIENTATION_UNKNOWN;
    if (params->mode == STP_ORIENT_POSITION) {
        mark_all(cloud);
        *found = STP_ORIENTATION_POSITION;
    } else if (oriented > 0) {
        *found = oriented == cloud->count ? STP_ORIENTATION_PROPAGATED : STP_ORIENTATION_MIXED;
    }
    return STP_OK;
}
