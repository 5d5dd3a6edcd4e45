/* Computes CGAL's normals, to compare ours with: by principal components of the nearest points. */
#ifndef STP_TOOLS_BENCH_CGAL_CGAL_SHIM_H
#define STP_TOOLS_BENCH_CGAL_CGAL_SHIM_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/* normals[i]: unit, of either sign, from the k points nearest to positions[i]; x, y, z. Returns 0,
 * or -1 if CGAL failed. Uses all processors if CGAL was built with TBB, else one. */
int cgal_pca_normals(const double (*positions)[3], size_t count, unsigned k, double (*normals)[3]);

#ifdef __cplusplus
}
#endif

#endif
