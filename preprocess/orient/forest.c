/* Union-find with signs. */
#include "preprocess/orient/forest.h"

#include "preprocess/cloud/cloud.h"

stp_status stp_forest_create(stp_forest *out, uint32_t count, stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    stp_forest f = {.spill = spill};
    STP_TRY(stp_spill_alloc(spill, &f.parent, count, sizeof *f.parent, "pieces", err));
    STP_TRY(stp_spill_alloc(spill, &f.parity, count, sizeof *f.parity, "pieces", err));
    STP_TRY(stp_spill_alloc(spill, &f.size, count, sizeof *f.size, "pieces", err));
    for (uint32_t i = 0; i < count; i++, stp_cloud_step(spill, i)) {
        f.parent[i] = i;
        f.size[i] = 1;
    }
    *out = f;
    f = (stp_forest){0};
done:
    stp_forest_clear(&f);
    return status;
}

void stp_forest_clear(stp_forest *forest)
{
    stp_spill_free(forest->spill, forest->parent);
    stp_spill_free(forest->spill, forest->parity);
    stp_spill_free(forest->spill, forest->size);
    *forest = (stp_forest){0};
}

uint32_t stp_forest_find(stp_forest *forest, uint32_t point, uint8_t *parity)
{
    uint32_t root = point;
    uint8_t sum = 0;
    while (forest->parent[root] != root) {
        sum ^= forest->parity[root];
        root = forest->parent[root];
    }
    *parity = sum;
    while (forest->parent[point] != root) {
        uint32_t next = forest->parent[point];
        uint8_t own = forest->parity[point];
        forest->parent[point] = root;
        forest->parity[point] = sum;
        sum ^= own;
        point = next;
    }
    return root;
}

void stp_forest_join(stp_forest *forest, uint32_t a, uint32_t b, bool turned)
{
    uint8_t pa = 0, pb = 0;
    if (forest->parent[a] == forest->parent[b]) /* as for most edges: trees are flat */
        return;
    uint32_t ra = stp_forest_find(forest, a, &pa);
    uint32_t rb = stp_forest_find(forest, b, &pb);
    if (ra == rb)
        return;
    uint32_t low = ra < rb ? ra : rb;
    uint32_t high = ra < rb ? rb : ra;
    forest->parent[high] = low;
    const uint64_t size = (uint64_t)forest->size[low] + forest->size[high];
    forest->size[low] = size < UINT32_MAX ? (uint32_t)size : UINT32_MAX;
    forest->parity[high] = (uint8_t)(pa ^ pb ^ turned);
}
