/* Parses the values of prep's options. */
#ifndef STP_TOOLS_PREP_PREP_VALUES_H
#define STP_TOOLS_PREP_PREP_VALUES_H

#include "formats/scan/scan.h"
#include "preprocess/prep.h"
#include "tools/cli/cli.h"

/* Each returns INVALID_ARGUMENT with what to give instead. A NULL text keeps the default. */
stp_status prep_parse_orient(const char *text, stp_prep_params *params, stp_error *err);
/* A length, or "exact". */
stp_status prep_parse_precision(const char *text, stp_prep_params *params, stp_error *err);
/* A number, or "auto". */
stp_status prep_parse_normal_bits(const char *text, stp_prep_params *params, stp_error *err);
/* The number of points on a mesh's faces, or none. NULL: *count is 0. */
stp_status prep_parse_sample(const char *text, uint64_t *count, bool *none, stp_error *err);

/* Which part of scans is read. */
typedef struct prep_region {
    const char *bounds; /* x0,y0,x1,y1 or x0,y0,z0,x1,y1,z1; NULL: all of it */
    double resolution;  /* 0: all of it */
} prep_region;

#define PREP_REGION_OPTIONS 2

void prep_region_fill(prep_region *region, cli_option out[PREP_REGION_OPTIONS]);
/* *out: a scan is read whole, or as *region says. region must outlive the scans. */
stp_status prep_parse_region(const prep_region *given, stp_scan_region *region,
                             const stp_scan_region **out, stp_error *err);

/* How grids of heights or depths are read. */
typedef struct prep_grid {
    const char *colour, *mask, *invalid, *spacing, *scale, *pinhole,
        *disparity; /* NULL: not given */
    int depth;      /* 1: along the ray */
    int holes;      /* 1: they grow */
    bool keep;      /* say so if rows and columns are not kept; ask for those of PTX and E57 */
} prep_grid;

#define PREP_GRID_OPTIONS 10

void prep_grid_fill(prep_grid *grid, cli_option out[PREP_GRID_OPTIONS]);
bool prep_grid_is_given(const prep_grid *grid);
/* The strings must outlive *out. */
stp_status prep_parse_grid(const prep_grid *grid, stp_grid_params *out, stp_error *err);

#endif
