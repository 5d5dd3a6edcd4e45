/* Looks for neighbourhoods that are lines. */
#include "preprocess/cloud/scan_lines.h"

#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/nearest_list.h"

/* About so many points of so many cells are looked at; how far neighbours may be in the order. */
#define CELLS 64u
#define PLACES 512u
#define REACH 2048u
/* Fewer looks say nothing. */
#define LOOKS_LEAST 32u
/* With eigenvalues a >= b >= c, a line has (ab + bc + ca) / (a + b + c)^2 below this: its length is
 * four times its width. It is 0.25 for a round neighbourhood on a plane. */
#define LINE_MOST 0.06

/* The `count` points nearest to a point, among those of its run at other places. */
static void find_near(stp_nearest_list *list, const stp_cloud *cloud, const stp_cell *cell,
                      uint64_t self)
{
    const uint64_t begin = self - cell->begin > REACH ? self - REACH : cell->begin;
    const uint64_t end = cell->end - self > REACH ? self + REACH : cell->end;
    const stp_dvec3 middle = cloud->points[self].position;
    for (uint64_t i = begin; i < end; i++) {
        const stp_dvec3 d = stp_dvec3_sub(cloud->points[i].position, middle);
        const double squared = stp_dvec3_dot(d, d);
        if (squared > 0.0 && squared < stp_nearest_list_reach(list))
            stp_nearest_list_insert(list, squared, i, cloud->points[i].source);
    }
}

/* Whether the first `count` of the list lie on a line. */
static bool is_line(const stp_nearest_list *list, const stp_cloud *cloud, uint64_t self,
                    unsigned count)
{
    stp_dvec3 sum = {0.0, 0.0, 0.0}, squares = sum, mixed = sum;
    for (unsigned i = 0; i < count; i++) {
        const stp_dvec3 d =
            stp_dvec3_sub(cloud->points[list->place[i]].position, cloud->points[self].position);
        sum = stp_dvec3_add(sum, d);
        squares = stp_dvec3_add(squares, (stp_dvec3){d.x * d.x, d.y * d.y, d.z * d.z});
        mixed = stp_dvec3_add(mixed, (stp_dvec3){d.y * d.z, d.z * d.x, d.x * d.y});
    }
    const double n = count + 1.0; /* the point itself, too */
    const double xx = squares.x - sum.x * sum.x / n, yz = mixed.x - sum.y * sum.z / n;
    const double yy = squares.y - sum.y * sum.y / n, zx = mixed.y - sum.z * sum.x / n;
    const double zz = squares.z - sum.z * sum.z / n, xy = mixed.z - sum.x * sum.y / n;
    const double minors = xx * yy + yy * zz + zz * xx - xy * xy - yz * yz - zx * zx;
    const double trace = xx + yy + zz;
    return minors < LINE_MOST * trace * trace;
}

stp_status stp_scan_lines_choose(unsigned *k, unsigned few, const stp_cloud *cloud, stp_error *err)
{
    stp_status status = STP_OK;
    enum { LOOKS, LINES, LEFT, COUNTS };
    uint64_t counts[COUNTS] = {0};
    const stp_rank_part own = stp_cloud_own_cells(cloud);
    const uint32_t step = cloud->cell_count / CELLS + 1;
    const uint32_t places = PLACES / (cloud->cell_count / step + 1);
    for (uint64_t c = (own.begin + step - 1) / step * step; c < own.end; c += step) {
        const stp_cell *cell = &cloud->cells[c];
        for (uint32_t i = 0; i < places; i++) {
            const uint64_t part = (cell->end - cell->begin) * (2 * i + 1);
            const uint64_t self = cell->begin + part / (2 * places);
            stp_nearest_list list = {.capacity = STP_SCAN_LINE_NEIGHBOURS};
            find_near(&list, cloud, cell, self);
            if (!stp_nearest_list_full(&list))
                continue;
            counts[LOOKS]++;
            if (!is_line(&list, cloud, self, few))
                continue;
            counts[LINES]++;
            counts[LEFT] += is_line(&list, cloud, self, STP_SCAN_LINE_NEIGHBOURS);
        }
        stp_spill_relieve(cloud->spill);
    }
    STP_TRY(stp_cloud_sum(cloud, counts, COUNTS, err));
    const bool lines = counts[LOOKS] >= LOOKS_LEAST && 5 * counts[LINES] > counts[LOOKS];
    *k = lines && 2 * counts[LEFT] < counts[LINES] ? STP_SCAN_LINE_NEIGHBOURS : few;
done:
    return status;
}
