/* FLANN's exact single kd-tree over 3D float points, as C.
 *
 * Distances are FLANN's own, in floats. Threads: any number of readers of one tree. */
#ifndef STP_PREPROCESS_CLOUD_FLANN_SHIM_H
#define STP_PREPROCESS_CLOUD_FLANN_SHIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_KD_TREE_NONE UINT32_MAX

typedef struct stp_kd_tree stp_kd_tree;

/* points: count * 3 floats; the caller keeps them as long as the tree. Returns NULL if out of
 * memory. */
stp_kd_tree *stp_kd_tree_create(float *points, size_t count);
void stp_kd_tree_destroy(stp_kd_tree *tree);
/* Finds the k nearest points, the query's own position included: k indices and squared distances,
 * nearest first. If the tree has fewer points, the rest are NONE and infinity. False: out of
 * memory. */
bool stp_kd_tree_nearest(const stp_kd_tree *tree, const float query[3], size_t k, uint32_t *indices,
                         float *squared);
/* Finds all points whose squared distance is below `squared`, in any order. indices has room for
 * all points of the tree. False: out of memory. */
bool stp_kd_tree_within(const stp_kd_tree *tree, const float query[3], float squared,
                        uint32_t *indices, size_t *count);

#endif
