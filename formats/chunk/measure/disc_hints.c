/* A table of one disc a cell. */
#include "formats/chunk/measure/disc_hints.h"

#include "base/memory.h"
#include "base/wide.h"
#include "formats/chunk/measure/disc_cells.h"

#include <stdlib.h>

/* Width of a cell, in radii. */
#define CELL_RADII 1.2
/* A disc is entered in the cells this many widths over and under its centre: two cells, or one. */
#define THICKNESS 0.5f
/* A slot holds the disc in its low STP_DISC_HINTS_BITS bits. The bits above score how near the
 * disc's centre is to the cell's middle: greater is nearer. The score falls by SCORE_UNIT for each
 * squared cell width. */
#define SCORE_MAX 16383.0f
#define SCORE_UNIT 1024.0f
/* Discs a block of 64 cells: about a tenth of the cells is then used. */
#define DISCS_A_BLOCK 16

static inline uint32_t slot_of(uint32_t mask, int i, int j, int k)
{
    return stp_cell_bucket(mask, stp_cell_part_of(0, i), stp_cell_part_of(1, j),
                           stp_cell_part_of(2, k));
}

/* Enters a disc in the cell `up` widths along the normal from its centre. */
static void enter(stp_disc_hints *h, uint32_t disc, float up)
{
    const float *d = h->discs[disc].numbers;
    const float x = d[0] * h->scale, y = d[1] * h->scale, z = d[2] * h->scale;
    const int i = stp_cell_floor(x + d[3] * up), j = stp_cell_floor(y + d[4] * up),
              k = stp_cell_floor(z + d[5] * up);
    const float a = (float)i + 0.5f - x, b = (float)j + 0.5f - y, c = (float)k + 0.5f - z;
    float score = SCORE_MAX - (a * a + b * b + c * c) * SCORE_UNIT;
    uint32_t *slot = &h->slots[slot_of(h->mask, i, j, k)];
    uint32_t key = (uint32_t)(int)(score > 0.0f ? score : 0.0f) << STP_DISC_HINTS_BITS | disc;
    *slot = *slot > key ? *slot : key;
}

stp_status stp_disc_hints_create(stp_disc_hints *out, const stp_lane_disc *discs, uint32_t count,
                                 double radius, stp_error *err)
{
    stp_status status = STP_OK;
    stp_disc_hints h = {.discs = discs, .scale = (float)(1.0 / (CELL_RADII * radius))};
    uint32_t blocks = 1;
    while (DISCS_A_BLOCK * blocks < count)
        blocks *= 2;
    h.mask = blocks - 1;
    STP_TRY(stp_alloc(&h.slots, (size_t)blocks * 64, sizeof *h.slots, "discs", err));
    for (uint32_t d = 0; d < count; d++) {
        enter(&h, d, THICKNESS);
        enter(&h, d, -THICKNESS);
    }
done:
    *out = h;
    return status;
}

void stp_disc_hints_clear(stp_disc_hints *h)
{
    free(h->slots);
    *h = (stp_disc_hints){0};
}

STP_WIDE
void stp_disc_hints_pair(const stp_disc_hints *h, stp_paired_lanes *lanes)
{
    const float scale = h->scale;
    const uint32_t mask = h->mask;
    uint32_t slot[STP_DISC_LANES];
    for (unsigned i = 0; i < STP_DISC_LANES; i++)
        slot[i] = slot_of(mask, stp_cell_floor(lanes->point[0][i] * scale),
                          stp_cell_floor(lanes->point[1][i] * scale),
                          stp_cell_floor(lanes->point[2][i] * scale));
    for (unsigned i = 0; i < STP_DISC_LANES; i++)
        lanes->index[i] = h->slots[slot[i]] & (STP_DISC_HINTS_LIMIT - 1);
    stp_paired_lanes_take(lanes, h->discs);
    for (unsigned i = 0; i < STP_DISC_LANES; i++)
        for (int c = STP_LANE_CARRIED; c < STP_LANE_NUMBERS; c++)
            lanes->disc[c][i] = h->discs[lanes->index[i]].numbers[c];
}

void stp_disc_hints_about(const stp_disc_hints *h, const float point[3],
                          uint32_t disc[STP_LANE_STEP])
{
    int low[3];
    for (int a = 0; a < 3; a++)
        low[a] = stp_cell_floor(point[a] * h->scale - 0.5f);
    for (int i = 0; i < (int)STP_LANE_STEP; i++)
        disc[i] =
            h->slots[slot_of(h->mask, low[0] + (i >> 2), low[1] + (i >> 1 & 1), low[2] + (i & 1))] &
            (STP_DISC_HINTS_LIMIT - 1);
}
