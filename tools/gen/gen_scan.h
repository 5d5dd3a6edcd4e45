/* The file that `stipple gen` writes a scan to: LAS where its name ends so, else PLY. */
#ifndef STP_TOOLS_GEN_GEN_SCAN_H
#define STP_TOOLS_GEN_GEN_SCAN_H

#include "formats/scan/las/las_write.h"
#include "formats/scan/ply/ply_write.h"
#include "tools/gen/sampler.h"

typedef struct gen_scan {
    stp_ply_writer *ply; /* one of the two */
    stp_las_writer *las;
} gen_scan;

/* Does the name ask for LAS, or for LAZ, which is not written? */
bool gen_scan_is_las(const char *path);
bool gen_scan_is_laz(const char *path);
/* Starts the file of a sampler made by these params, in floats (PLY) or in the coarsest power of
 * ten below a hundredth of the sample spacing (LAS: 32 bits permitting). Errors: as the writers'.
 */
stp_status gen_scan_create(gen_scan *out, const char *path, bool force, uint32_t attributes,
                           const gen_sampler *sampler, const gen_sampler_params *params,
                           stp_error *err);
stp_status gen_scan_points(gen_scan *scan, const stp_point *points, size_t count, stp_error *err);
/* Makes the file appear. */
stp_status gen_scan_finish(gen_scan *scan, stp_error *err);
/* Abandons the file if not finished. */
void gen_scan_destroy(gen_scan *scan);

#endif
