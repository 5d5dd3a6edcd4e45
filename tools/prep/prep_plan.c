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

/* Whether all points are pixels of heights or depths, which take fewer bytes. */
static bool all_pixels(const stp_prep_source *source)
{
    bool all = source->point_count > 0;
    for (size_t f = 0; f < source->file_count && all; f++) {
        const stp_prep_file *file = &source->files[f];
        all = file->unreadable || file->raster.columns > 0 || file->grid.columns > 0 ||
              file->image_count > 0;
    }
    return all;
}

/* Real scans of all kinds take 4.2 to 8.2 bytes a point, images 0.3 to 4.2; a tree 14 a vertex. */
static void print_file(const stp_prep_source *source)
{
    const bool pixels = all_pixels(source);
    const double points = (double)source->point_count, mega = points > 1e9 ? 1e-9 : 1e-6;
    const double least = pixels ? 0.3 : 4.0, most = pixels ? 5.0 : 9.0;
    const uint64_t vertices = (source->lines ? source->lines->vertex_count : 0) +
                              (source->triangles ? source->triangles->vertex_count : 0);
    if (vertices > 0)
        printf("lines, triangles %" PRIu64 " vertices, 5 to 25 bytes each\n", vertices);
    printf("file             about %.2f to %.2f %s (%g to %g bytes a %s, without attributes)\n",
           mega * (least * points + 5.0 * (double)vertices),
           mega * (most * points + 25.0 * (double)vertices), points > 1e9 ? "GB" : "MB", least,
           most, pixels ? "pixel" : "point");
}

stp_status prep_plan_print(const char *output, const stp_prep_source *source,
                           const stp_prep_params *params, unsigned threads, stp_error *err)
{
    stp_prep_plan plan = {0};
    const stp_prep_size size = stp_prep_size_of(source, params);
    stp_status status = stp_prep_check_count(source, params, err);
    if (status == STP_OK)
        status = stp_prep_plan_make(&plan, output, &size, params, threads, err);
    if (status != STP_OK)
        return status;
    printf("points           %" PRIu64 "\nmemory           at most %.2f GB a rank\n",
           source->point_count, 1e-9 * (double)plan.memory_bytes);
    if (plan.temporary_bytes > 0)
        printf("temporary files  about %.1f GB a rank, at most %.1f GB if hardly any surface is "
               "found, in %s (%.1f GB free)\n",
               1e-9 * (double)plan.temporary_bytes, 1e-9 * (double)plan.most_temporary_bytes,
               plan.folder, 1e-9 * (double)plan.free_bytes);
    else
        printf("temporary files  none: everything fits in memory\n");
    print_file(source);
    if (size.grid)
        printf("\nA grid of heights takes a fraction of the time of points.\n");
    else
        print_times(source->point_count, threads);
    status = stp_prep_plan_check(&plan, err);
    stp_prep_plan_clear(&plan);
    return status;
}
