/* Makes elevation maps of a cloud's surface (after Ochotta and Saupe 2004, and Pauly and Gross
 * 2001, who part and merge surfaces likewise).
 *
 * First, each cell is cut into parts whose normals keep the cone (part_cut.h). Second, parts that
 * touch, of all cells, are merged as long as the cone holds (part_merge.h). Third, each merged part
 * is sampled on a grid over its plane (map_make.h). If it is no height field, or if more than
 * STP_MAP_OFF_MOST of its points lie off what was sampled, it is halved, and each half is tried
 * again.
 *
 * A map also stands for points of no part, and of parts of fewer than STP_MAP_POINTS_LEAST points,
 * that lie near enough to its surface. What is no surface stays points: points that lie farther off
 * their map than `error` or than the weights of the surface reach (map_points.h), and all points of
 * a map that has more points of no part around it, off its surface, than points of its own, as in
 * the crown of a tree.
 *
 * The cloud keeps what stays points and loses those that maps stand for; its tree no longer fits,
 * and its box may be too wide. Memory: 14 bytes a point and some 20 a sample in the cloud's spill,
 * and 450 bytes a part. Threads: those of the pool; the same maps for any number of threads and
 * ranks (maps_work.h), and for any memory. */
#ifndef STP_PREPROCESS_MAPS_MAPS_MAKE_H
#define STP_PREPROCESS_MAPS_MAPS_MAKE_H

#include "base/pool.h"
#include "base/progress.h"
#include "preprocess/maps/maps.h"

/* Makes the maps of a sorted cloud whose spacings, normals and marks are known. Errors:
 * OUT_OF_MEMORY, IO, CANCELLED. Free with stp_maps_clear. */
stp_status stp_maps_make(stp_maps *out, stp_cloud *cloud, const stp_maps_params *params,
                         stp_pool *pool, const stp_progress *progress, stp_error *err);
void stp_maps_clear(stp_maps *maps);

#endif
