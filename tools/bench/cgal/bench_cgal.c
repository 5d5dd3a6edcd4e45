/* stipple-bench-cgal: measures how long CGAL takes for the normals of a scan's points. */
#include "base/clock.h"
#include "base/memory.h"
#include "formats/scan/scan.h"
#include "preprocess/prep.h"
#include "tools/bench/cgal/cgal_shim.h"
#include "tools/cli/cli.h"

#include <stdio.h>
#include <stdlib.h>

#define BLOCK 4096

static int run(int argc, char **argv);
static const cli_command bench = {
    .name = "bench-cgal",
    .program = "stipple-bench-cgal",
    .summary = "measure how long CGAL takes for normals alone",
    .usage = "stipple-bench-cgal SCAN",
    .details = "Reads a scan and prints the seconds that CGAL's pca_estimate_normals takes for its "
               "points\n"
               "with 16 neighbours. Reading is not counted.",
    .run = run,
};

static stp_status read_positions(const char *path, double (**out)[3], size_t *out_count,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    stp_scan *scan = NULL;
    double(*positions)[3] = NULL;
    stp_point *block = NULL;
    size_t count = 0, got = 0;
    STP_TRY(stp_scan_open(&scan, path, &(stp_scan_params){0}, err));
    const size_t capacity = stp_scan_get_info(scan)->point_count;
    STP_TRY(stp_alloc(&positions, capacity, sizeof *positions, "points", err));
    STP_TRY(stp_alloc(&block, BLOCK, sizeof *block, "points", err));
    do {
        STP_TRY(stp_scan_read(scan, block, BLOCK, &got, err));
        for (size_t i = 0; i < got && count < capacity; i++) {
            positions[count][0] = block[i].position.x;
            positions[count][1] = block[i].position.y;
            positions[count++][2] = block[i].position.z;
        }
    } while (got > 0);
    *out = positions;
    *out_count = count;
    positions = NULL;
done:
    free(positions);
    free(block);
    stp_scan_close(&scan);
    return status;
}

static stp_status time_normals(const char *path, double *seconds, stp_error *err)
{
    stp_status status = STP_OK;
    double(*positions)[3] = NULL, (*normals)[3] = NULL;
    size_t count = 0;
    STP_TRY(read_positions(path, &positions, &count, err));
    STP_TRY(stp_alloc(&normals, count, sizeof *normals, "normals", err));
    double began = stp_clock_seconds();
    if (cgal_pca_normals((const double(*)[3])positions, count, STP_PREP_NEIGHBOURS, normals) != 0)
        status = stp_error_set(err, STP_INTERNAL, "%s: CGAL failed", path);
    *seconds = stp_clock_seconds() - began;
done:
    free(normals);
    free(positions);
    return status;
}

static int run(int argc, char **argv)
{
    cli_common common = {0};
    const char *path = NULL;
    size_t count = 0;
    double seconds = 0.0;
    stp_error err = {0};
    int code = cli_parse(&bench, NULL, 0, argc, argv, &path, 1, 1, &count, &common);
    if (code != CLI_CONTINUE)
        return code;
    if (time_normals(path, &seconds, &err) != STP_OK)
        return cli_fail(&bench, &err);
    printf("%.3f\n", seconds);
    return CLI_DONE;
}

int main(int argc, char **argv)
{
    return bench.run(argc, argv);
}
