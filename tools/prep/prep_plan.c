/* prep --plan. */
#include "tools/prep/prep_plan.h"

#include "preprocess/prep_forecast.h"

#include <inttypes.h>
#include <stdio.h>

/* Bytes a second of networks of 10 and 100 Gbit/s. */
#define SLOW_NETWORK 1.25e9
#define FAST_NETWORK 12.5e9

static void print_times(uint64_t points, unsigned threads)
{
    static const unsigned counts[] = {1, 2, 4, 8, 16, 64, 256, 1024};
    printf(
        "\nA model of the seconds, if every rank has a machine with %u threads and a network of\n"
        "10 or 100 Gbit/s (docs/mpi.md):\n\n%5s %10s %9s %9s %9s %9s %9s %9s %9s\n",
        threads, "ranks", "every rank", "shared", "sent: 10", "or 100", "written", "all: 10",
        "or 100", "GB sent");
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        const stp_prep_forecast slow =
            stp_prep_forecast_make(points, counts[i], threads, SLOW_NETWORK);
        const stp_prep_forecast fast =
            stp_prep_forecast_make(points, counts[i], threads, FAST_NETWORK);
        printf("%5u %10.1f %9.1f %9.1f %9.1f %9.1f %9.1f %9.1f %9.1f\n", counts[i], slow.lone_s,
               slow.shared_s, slow.sent_s, fast.sent_s, slow.written_s,
               stp_prep_forecast_seconds(&slow), stp_prep_forecast_seconds(&fast),
               1e-9 * slow.sent_bytes);
    }
}

stp_status prep_plan_print(const char *output, const stp_prep_source *source,
                           const stp_prep_params *params, unsigned threads, stp_error *err)
{
    stp_prep_plan plan = {0};
    const double points = (double)source->point_count;
    const stp_prep_size size = stp_prep_size_of(source, params);
    stp_status status = stp_prep_check_count(source, params, err);
    if (status == STP_OK)
        status = stp_prep_plan_make(&plan, output, &size, params, threads, err);
    if (status != STP_OK)
        return status;
    printf("points           %" PRIu64 "\nmemory           %.2f GB a rank\n", source->point_count,
           1e-9 * (double)plan.memory_bytes);
    if (plan.temporary_bytes > 0)
        printf("temporary files  about %.1f GB a rank, at most %.1f GB if hardly any surface is "
               "found, in %s (%.1f GB free)\n",
               1e-9 * (double)plan.temporary_bytes, 1e-9 * (double)plan.most_temporary_bytes,
               plan.folder, 1e-9 * (double)plan.free_bytes);
    else
        printf("temporary files  none: everything fits in memory\n");
    printf("file             about %.1f to %.1f MB (4 to 8 bytes a point, without attributes)\n",
           4e-6 * points, 8e-6 * points);
    if (size.grid)
        printf("\nA grid of heights takes a fraction of the time of points.\n");
    else
        print_times(source->point_count, threads);
    stp_prep_plan_clear(&plan);
    return STP_OK;
}
