/* Merges the parts of a cell. */
#include "preprocess/maps/parts/part_within.h"

#include "preprocess/maps/parts/part_merge.h"

#include <stdlib.h>

/* Drops the parts that became part of another. roots: by part; gets its new number. */
static void number_anew(stp_cell_parts *parts, uint32_t *roots)
{
    uint32_t kept = 0;
    for (uint32_t p = 0; p < parts->part_count; p++) {
        if (roots[p] == p) {
            parts->parts[kept] = parts->parts[p];
            roots[p] = kept++;
        } else {
            roots[p] = roots[roots[p]]; /* the part with the lowest number is the root */
        }
    }
    parts->part_count = kept;
    size_t pairs = 0;
    for (size_t i = 0; i < parts->pair_count; i++) {
        const uint32_t a = roots[parts->pairs[i].a], b = roots[parts->pairs[i].b];
        if (a != b)
            parts->pairs[pairs++] = stp_part_pair_of(a, b);
    }
    parts->pair_count = stp_part_pairs_sort(parts->pairs, pairs);
    for (size_t i = 0; i < parts->border_count; i++)
        parts->borders[i].part = roots[parts->borders[i].part];
}

stp_status stp_cell_parts_merge(stp_cell_parts *parts, const stp_cloud *cloud, uint32_t index,
                                double cone_rad, uint32_t *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cell *cell = &cloud->cells[index];
    stp_part_field field = {0};
    uint32_t *roots = NULL;
    STP_TRY(stp_part_field_create(&field, cloud, (stp_rank_part){cell->begin, cell->end}, numbers,
                                  parts->part_count, NULL, cone_rad, err));
    STP_TRY(stp_parts_merge(parts->parts, parts->part_count, parts->pairs, parts->pair_count,
                            cos(cone_rad), &field, &roots, err));
    number_anew(parts, roots);
    for (uint64_t i = cell->begin; i < cell->end; i++)
        if (numbers[i] != STP_PART_NONE)
            numbers[i] = roots[numbers[i]];
done:
    stp_part_field_clear(&field);
    free(roots);
    return status;
}
