/* FLANN's exact single kd-tree over 3D float points, as C. */
#ifndef STP_PREPROCESS_FLANN_SHIM_H
#define STP_PREPROCESS_FLANN_SHIM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_kd_tree stp_kd_tree;

/* points: count * 3 floats, kept by the caller as long as the tree. NULL: out of memory. */
stp_kd_tree *stp_kd_tree_create(float *points, size_t count);
void stp_kd_tree_destroy(stp_kd_tree *tree);
/* The k nearest points of one query, nearest first, the query's own position included; fewer only
 * if the tree has fewer. Returns how many, or -1 on failure. Threads: any number of readers. */
int stp_kd_tree_nearest(const stp_kd_tree *tree, const float query[3], int k, int32_t *indices,
                        float *squared_distances);

#endif
