/* Keeps the ranges in use in a treap (a search tree by begin, a heap by random rank). Each node
 * knows the widest gap between ranges of its subtree, so a first fit takes one descent. */
#include "runtime/stream/cache/range_pool.h"

#include "base/memory.h"

#include <stdlib.h>

typedef struct stp_range_node {
    stp_range range;
    uint32_t left, right, rank;
    uint32_t begin, end; /* of the subtree */
    uint32_t gap;        /* the widest within the subtree */
} stp_range_node;

static uint32_t larger(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

/* Works out what a node knows of its subtree. */
static void sum_up(stp_range_node *nodes, uint32_t at)
{
    stp_range_node *n = &nodes[at];
    uint32_t end = n->range.begin + n->range.count;
    const stp_range_node *l = &nodes[n->left], *r = &nodes[n->right];
    n->begin = n->left != 0 ? l->begin : n->range.begin;
    n->end = n->right != 0 ? r->end : end;
    n->gap = n->left != 0 ? larger(l->gap, n->range.begin - l->end) : 0;
    if (n->right != 0)
        n->gap = larger(n->gap, larger(r->gap, r->begin - end));
}

/* Parts a subtree into ranges before `begin` and the others. */
static void split(stp_range_node *nodes, uint32_t at, uint32_t begin, uint32_t *before,
                  uint32_t *after)
{
    if (at == 0) {
        *before = *after = 0;
    } else if (nodes[at].range.begin < begin) {
        split(nodes, nodes[at].right, begin, &nodes[at].right, after);
        sum_up(nodes, at);
        *before = at;
    } else {
        split(nodes, nodes[at].left, begin, before, &nodes[at].left);
        sum_up(nodes, at);
        *after = at;
    }
}

/* Joins two subtrees; all ranges of `a` come before those of `b`. */
static uint32_t join(stp_range_node *nodes, uint32_t a, uint32_t b)
{
    if (a == 0 || b == 0)
        return a != 0 ? a : b;
    uint32_t top = nodes[a].rank > nodes[b].rank ? a : b;
    if (top == a)
        nodes[a].right = join(nodes, nodes[a].right, b);
    else
        nodes[b].left = join(nodes, a, nodes[b].left);
    sum_up(nodes, top);
    return top;
}

/* Where the first gap of at least `count` elements begins: between ranges, or after the last. */
static uint32_t find_gap(const stp_range_pool *pool, uint32_t count)
{
    const stp_range_node *nodes = pool->nodes;
    uint32_t low = 0, at = pool->root; /* low: the end of what lies before the subtree */
    while (at != 0) {
        const stp_range_node *n = &nodes[at], *l = &nodes[n->left];
        uint32_t end = n->left != 0 ? l->end : low;
        if (n->left != 0 && (l->begin - low >= count || l->gap >= count)) {
            at = n->left;
        } else if (n->range.begin - end >= count) {
            return end;
        } else {
            low = n->range.begin + n->range.count;
            at = n->right;
        }
    }
    return low;
}

/* A node to use, or 0. Ranks are random, but the same in every run. */
static uint32_t take_node(stp_range_pool *pool, stp_status *status, stp_error *err)
{
    uint32_t at = pool->unused;
    if (at != 0) {
        pool->unused = pool->nodes[at].right;
        return at;
    }
    at = (uint32_t)larger((uint32_t)pool->node_count, 1);
    *status = stp_grow(&pool->nodes, &pool->node_capacity, at + 1u, sizeof *pool->nodes,
                       "a list of ranges", err);
    if (*status != STP_OK)
        return 0;
    if (pool->node_count == 0)
        pool->nodes[0] = (stp_range_node){0};
    pool->node_count = at + 1u;
    pool->nodes[at].rank = at * UINT32_C(2654435769);
    pool->nodes[at].rank ^= pool->nodes[at].rank >> 15;
    pool->nodes[at].rank *= UINT32_C(2246822519);
    return at;
}

bool stp_range_pool_take(stp_range_pool *pool, uint32_t count, stp_range *out, stp_status *status,
                         stp_error *err)
{
    uint32_t before, after, begin = find_gap(pool, count);
    *status = STP_OK;
    if (count == 0) {
        *out = (stp_range){0, 0};
        return true;
    }
    if (pool->capacity - begin < count)
        return false;
    uint32_t at = take_node(pool, status, err);
    if (at == 0)
        return false;
    pool->nodes[at].range = *out = (stp_range){begin, count};
    pool->nodes[at].left = pool->nodes[at].right = 0;
    sum_up(pool->nodes, at);
    split(pool->nodes, pool->root, begin, &before, &after);
    pool->root = join(pool->nodes, join(pool->nodes, before, at), after);
    return true;
}

void stp_range_pool_give(stp_range_pool *pool, stp_range range)
{
    uint32_t before, at, after;
    if (range.count == 0)
        return;
    split(pool->nodes, pool->root, range.begin, &before, &at);
    split(pool->nodes, at, range.begin + 1, &at, &after);
    pool->root = join(pool->nodes, before, after);
    if (at == 0)
        return;
    pool->nodes[at].right = pool->unused;
    pool->unused = at;
}

void stp_range_pool_trim(stp_range_pool *pool, stp_range *range, uint32_t count)
{
    uint32_t before, at, after;
    split(pool->nodes, pool->root, range->begin, &before, &at);
    split(pool->nodes, at, range->begin + 1, &at, &after);
    pool->nodes[at].range.count = range->count = count;
    sum_up(pool->nodes, at);
    pool->root = join(pool->nodes, join(pool->nodes, before, at), after);
}

void stp_range_pool_destroy(stp_range_pool *pool)
{
    free(pool->nodes);
    *pool = (stp_range_pool){0};
}
