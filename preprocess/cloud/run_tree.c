/* Boxes over runs of points. */
#include "preprocess/cloud/run_tree.h"

#include "base/memory.h"
#include "base/wide.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LANES STP_RUN_POINTS

static uint32_t parts(uint32_t count)
{
    return count / LANES + (count % LANES != 0);
}

/* The box of points [begin, end), at most one run. */
static void take_run(stp_run_node *node, unsigned lane, const float *const axes[3], uint32_t begin,
                     uint32_t end)
{
    for (int a = 0; a < 3; a++) {
        float low = INFINITY, high = -INFINITY;
        for (uint32_t i = begin; i < end; i++) {
            low = fminf(low, axes[a][i]);
            high = fmaxf(high, axes[a][i]);
        }
        node->low[a][lane] = low;
        node->high[a][lane] = high;
    }
}

/* The box of a node's boxes. */
static void take_node(stp_run_node *node, unsigned lane, const stp_run_node *below)
{
    for (int a = 0; a < 3; a++) {
        float low = INFINITY, high = -INFINITY;
        for (unsigned i = 0; i < LANES; i++) {
            low = fminf(low, below->low[a][i]);
            high = fmaxf(high, below->high[a][i]);
        }
        node->low[a][lane] = low;
        node->high[a][lane] = high;
    }
}

stp_status stp_run_tree_create(stp_run_tree *out, const float *const axes[3], uint32_t count,
                               stp_error *err)
{
    stp_run_tree tree = {0};
    const uint32_t run_count = parts(count);
    for (uint32_t below = run_count; below > 0; below = below > LANES ? parts(below) : 0) {
        const unsigned tier = tree.tier_count++;
        tree.begin[tier + 1] = tree.begin[tier] + parts(below);
    }
    const stp_status status =
        stp_alloc(&tree.nodes, tree.begin[tree.tier_count], sizeof *tree.nodes, "neighbours", err);
    if (status != STP_OK)
        return status;
    for (uint32_t r = 0; tree.tier_count > 0 && r < LANES * tree.begin[1]; r++) {
        const uint32_t begin = r < run_count ? LANES * r : count;
        const uint32_t end = count - begin < LANES ? count : begin + LANES;
        take_run(&tree.nodes[r / LANES], r % LANES, axes, begin, end);
    }
    for (unsigned tier = 1; tier < tree.tier_count; tier++) {
        const uint32_t begin = tree.begin[tier - 1], below = tree.begin[tier] - begin;
        for (uint32_t i = 0; i < LANES * (tree.begin[tier + 1] - tree.begin[tier]); i++) {
            stp_run_node *node = &tree.nodes[tree.begin[tier] + i / LANES];
            if (i < below)
                take_node(node, i % LANES, &tree.nodes[begin + i]);
            else
                take_run(node, i % LANES, axes, 0, 0);
        }
    }
    *out = tree;
    return STP_OK;
}

void stp_run_tree_clear(stp_run_tree *tree)
{
    free(tree->nodes);
    *tree = (stp_run_tree){0};
}

/* Distance along an axis from [low, high] to [from, to]; 0 if they meet. */
static inline float gap(float low, float high, float from, float to)
{
    const float under = low - to, over = from - high, most = under > over ? under : over;
    return most > 0.0f ? most : 0.0f;
}

/* Sets near[] to 1 for the boxes below a node that are near, else to 0. */
STP_WIDE
static void test_node(const stp_run_node *node, const float low[3], const float high[3],
                      float squared, uint32_t near[LANES])
{
    for (unsigned i = 0; i < LANES; i++) {
        const float x = gap(node->low[0][i], node->high[0][i], low[0], high[0]);
        const float y = gap(node->low[1][i], node->high[1][i], low[1], high[1]);
        const float z = gap(node->low[2][i], node->high[2][i], low[2], high[2]);
        near[i] = x * x + y * y + z * z <= squared;
    }
}

unsigned stp_run_tree_near(const stp_run_tree *tree, const float low[3], const float high[3],
                           float reach, uint32_t runs[STP_RUNS_NEAR])
{
    uint32_t at[STP_RUNS_NEAR + LANES] = {0}, below[STP_RUNS_NEAR + LANES];
    const float squared = reach * reach + FLT_MIN; /* no square below it is told apart */
    unsigned count = tree->tier_count > 0;
    for (unsigned tier = tree->tier_count; tier-- > 0;) {
        unsigned found = 0;
        for (unsigned n = 0; n < count; n++) {
            uint32_t near[LANES];
            test_node(&tree->nodes[tree->begin[tier] + at[n]], low, high, squared, near);
            for (unsigned i = 0; i < LANES; i++) {
                below[found] = LANES * at[n] + i;
                found += near[i];
            }
            if (found > STP_RUNS_NEAR)
                return STP_RUNS_NEAR + 1;
        }
        count = found;
        memcpy(at, below, count * sizeof *at);
    }
    for (unsigned i = 0; i < count; i++)
        runs[i] = at[i];
    return count;
}
