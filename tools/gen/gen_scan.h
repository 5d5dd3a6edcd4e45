/* The file that `stipple gen` writes a scan to: LAS or LAZ if its name ends so, else PLY. */
#ifndef STP_TOOLS_GEN_GEN_SCAN_H
#define STP_TOOLS_GEN_GEN_SCAN_H

#include "formats/scan/las/las_write.h"
#include "formats/scan/ply/ply_write.h"
#include "tools/gen/sampler.h"

typedef struct gen_scan {
    stp_ply_writer *ply; /* exactly one of ply and las is set */
    stp_las_writer *las;
} gen_scan;

/* True if the name asks for LAS or LAZ. */
bool gen_scan_is_las(const char *path);
/* Starts the file of a sampler that was made with these params. PLY coordinates are floats. The
 * step of LAS is the coarsest power of ten below a hundredth of the sample spacing, if 32 bits
 * permit it. Errors: those of the writers. */
stp_status gen_scan_create(gen_scan *out, const char *path, bool force, uint32_t attributes,
                           const gen_sampler *sampler, const gen_sampler_params *params,
                           stp_error *err);
stp_status gen_scan_points(gen_scan *scan, const stp_point *points, size_t count, stp_error *err);
/* Makes the file appear. */
stp_status gen_scan_finish(gen_scan *scan, stp_error *err);
/* Abandons the file if not finished. */
void gen_scan_destroy(gen_scan *scan);

#endif
