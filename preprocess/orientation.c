/* Which way normals point. */
#include "preprocess/orientation.h"

#include "base/memory.h"

#include <stdlib.h>

#define EDGE_NEIGHBOURS 8u /* of each point, nearest first: enough to connect it */
#define BUCKETS 256u
#define SMOOTH_BUCKETS 200u /* edges inside a sheet; the others lead across creases */
#define SHEET_COSINE 0.7f
#define SHEET_OFFSET 0.5f /* spacings off each other's plane */
/* A piece whose summed area vectors are below this part of its area is closed. */
#define CLOSED_RATIO 0.25
#define CLOSED_POINTS 64u

typedef struct edge {
    uint32_t a, b;
} edge;

/* Union-find with the parity of a point's sign against its root's. */
typedef struct forest {
    uint32_t *parent;
    uint8_t *parity;
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
        float badness =
            (1.0f - cosine) / (1.0f - SHEET_COSINE) * 0.7f + offset / SHEET_OFFSET * 0.3f;
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
    f->parity[high] = pa ^ pb ^ flip;
}

/* Edges sorted by rank; begin[r] is the first of rank r. */
static stp_status collect(const stp_cloud *cloud, const stp_neighbours *neighbours, edge **edges,
                          size_t begin[BUCKETS + 1], stp_error *err)
{
    unsigned k = neighbours->k < EDGE_NEIGHBOURS ? neighbours->k : EDGE_NEIGHBOURS;
    size_t counts[BUCKETS + 1] = {0};
    edge *out = NULL;
    for (int pass = 0; pass < 2; pass++) {
        for (uint32_t a = 0; a < cloud->count; a++) {
            const uint32_t *list = neighbours->indices + (size_t)a * neighbours->k;
            for (unsigned i = 0; i < k && list[i] != STP_NEIGHBOUR_NONE; i++) {
                uint32_t r = rank(cloud, a, list[i]);
                if (r < BUCKETS && pass == 0)
                    counts[r]++;
                else if (r < BUCKETS)
                    out[counts[r]++] = (edge){a, list[i]};
            }
        }
        if (pass == 1)
            break;
        size_t sum = 0;
        for (uint32_t r = 0; r <= BUCKETS; r++) {
            size_t here = r < BUCKETS ? counts[r] : 0;
            begin[r] = sum;
            counts[r] = sum;
            sum += here;
        }
        stp_status status = stp_alloc(&out, sum, sizeof *out, "edges", err);
        if (status != STP_OK)
            return status;
    }
    *edges = out;
    return STP_OK;
}

typedef struct piece {
    stp_dvec3 area; /* sum of area vectors */
    stp_dvec3 first;
    double total, volume;
    uint32_t count;
} piece;

/* Marks closed pieces oriented and turns them outward; returns the number of oriented points. */
static stp_status turn_outward(stp_cloud *cloud, forest *f, uint32_t *oriented, stp_error *err)
{
    piece *pieces = NULL;
    stp_status status = stp_alloc(&pieces, cloud->count, sizeof *pieces, "pieces", err);
    if (status != STP_OK)
        return status;
    for (uint32_t i = 0; i < cloud->count; i++) {
        uint8_t parity = 0;
        stp_cloud_point *p = &cloud->points[i];
        uint32_t root = find(f, i, &parity);
        piece *c = &pieces[root];
        if (parity)
            p->normal = glms_vec3_negate(p->normal);
        if (c->count++ == 0)
            c->first = p->position;
        double area = (double)p->spacing * (double)p->spacing;
        stp_dvec3 vector = stp_dvec3_scale(stp_dvec3_from_float(p->normal), area);
        c->area = stp_dvec3_add(c->area, vector);
        c->total += area;
        c->volume += stp_dvec3_dot(stp_dvec3_sub(p->position, c->first), vector);
    }
    *oriented = 0;
    for (uint32_t i = 0; i < cloud->count; i++) {
        uint8_t parity = 0;
        stp_cloud_point *p = &cloud->points[i];
        const piece *c = &pieces[find(f, i, &parity)];
        if (c->count < CLOSED_POINTS || stp_dvec3_length(c->area) > CLOSED_RATIO * c->total ||
            !(p->flags & STP_SAMPLE_HAS_NORMAL))
            continue;
        if (c->volume < 0.0)
            p->normal = glms_vec3_negate(p->normal);
        p->flags |= STP_SAMPLE_ORIENTED;
        (*oriented)++;
    }
    free(pieces);
    return STP_OK;
}

static void turn_to(stp_cloud *cloud, stp_dvec3 position)
{
    for (uint32_t i = 0; i < cloud->count; i++) {
        stp_cloud_point *p = &cloud->points[i];
        vec3s d = stp_dvec3_to_float(stp_dvec3_sub(position, p->position));
        if (glms_vec3_dot(d, p->normal) < 0.0f)
            p->normal = glms_vec3_negate(p->normal);
    }
}

static void mark_all(stp_cloud *cloud)
{
    for (uint32_t i = 0; i < cloud->count; i++)
        if (cloud->points[i].flags & STP_SAMPLE_HAS_NORMAL)
            cloud->points[i].flags |= STP_SAMPLE_ORIENTED;
}

/* Builds the sheets; goes on across creases and turns pieces outward if propagate. */
static stp_status connect(stp_cloud *cloud, const stp_neighbours *neighbours, bool propagate,
                          uint32_t *oriented, stp_error *err)
{
    stp_status status = STP_OK;
    forest f = {0};
    edge *edges = NULL;
    size_t begin[BUCKETS + 1];
    STP_TRY(stp_alloc(&f.parent, cloud->count, sizeof *f.parent, "pieces", err));
    STP_TRY(stp_alloc(&f.parity, cloud->count, sizeof *f.parity, "pieces", err));
    for (uint32_t i = 0; i < cloud->count; i++)
        f.parent[i] = i;
    STP_TRY(collect(cloud, neighbours, &edges, begin, err));
    for (size_t e = 0; e < begin[SMOOTH_BUCKETS]; e++)
        join(cloud, &f, edges[e]);
    for (uint32_t i = 0; i < cloud->count; i++) {
        uint8_t parity = 0;
        cloud->points[i].sheet = find(&f, i, &parity);
    }
    if (propagate) {
        for (size_t e = begin[SMOOTH_BUCKETS]; e < begin[BUCKETS]; e++)
            join(cloud, &f, edges[e]);
        STP_TRY(turn_outward(cloud, &f, oriented, err));
    }
done:
    free(edges);
    free(f.parity);
    free(f.parent);
    return status;
}

stp_status stp_orientation_find(stp_cloud *cloud, const stp_neighbours *neighbours,
                                const stp_orient_params *params, stp_orientation *found,
                                stp_error *err)
{
    bool file =
        params->mode == STP_ORIENT_FILE || (params->mode == STP_ORIENT_AUTO && params->from_file);
    bool propagate =
        !file && (params->mode == STP_ORIENT_AUTO || params->mode == STP_ORIENT_PROPAGATE);
    uint32_t oriented = 0;
    if (params->mode == STP_ORIENT_FILE && !params->from_file)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the input has no normals to orient by: use --orient propagate");
    if (file) { /* signs are known: opposed sheets part by their normals */
        mark_all(cloud);
        *found = STP_ORIENTATION_FILE;
        return STP_OK;
    }
    stp_status status = connect(cloud, neighbours, propagate, &oriented, err);
    if (status != STP_OK)
        return status;
    *found = STP_ORIENTATION_UNKNOWN;
    if (params->mode == STP_ORIENT_POSITION) {
        turn_to(cloud, params->position);
        mark_all(cloud);
        *found = STP_ORIENTATION_POSITION;
    } else if (propagate && oriented > 0) {
        *found = oriented == cloud->count ? STP_ORIENTATION_PROPAGATED : STP_ORIENTATION_MIXED;
    }
    return STP_OK;
}
