/* `stipple compare`: measures how far a picture is from its reference. */
#include "tools/cli/cli.h"

#include "formats/image/image.h"
#include "tools/compare/compare_metrics.h"

#include <inttypes.h>
#include <stdio.h>

static int run(int argc, char **argv);

const cli_command cli_compare = {
    .name = "compare",
    .summary = "measure how far a picture is from its reference",
    .usage = "stipple compare A.png B.png [--json]",
    .details =
        "A is judged, B is the reference. A pixel is covered if its alpha is above 0. Colours are\n"
        "compared over black. All figures are over the pixels that A or B covers:\n"
        "  psnr_db         of RGB; 999 if there is no difference\n"
        "  psnr_inside_db  the same over the pixels that A and B cover\n"
        "  ssim            of the luminance, 11x11 Gaussian window\n"
        "  coverage_a, coverage_b  covered fractions of the picture\n"
        "  holes           pixels that A lacks and that B covers together with their 8 neighbours\n"
        "  spill           pixels of A that are more than one pixel outside B",
    .run = run,
};

static void print_text(const compare_metrics *m)
{
    printf("psnr_db %.4f\n", m->psnr_db);
    printf("psnr_inside_db %.4f\n", m->psnr_inside_db);
    printf("ssim %.6f\n", m->ssim);
    printf("coverage_a %.6f\n", m->coverage_a);
    printf("coverage_b %.6f\n", m->coverage_b);
    printf("holes %" PRIu64 "\n", m->holes);
    printf("spill %" PRIu64 "\n", m->spill);
}

static void print_json(const compare_metrics *m)
{
    printf("{\"psnr_db\": %.4f, \"psnr_inside_db\": %.4f, \"ssim\": %.6f, \"coverage_a\": %.6f, "
           "\"coverage_b\": %.6f, \"holes\": %" PRIu64 ", \"spill\": %" PRIu64 "}\n",
           m->psnr_db, m->psnr_inside_db, m->ssim, m->coverage_a, m->coverage_b, m->holes,
           m->spill);
}

static int run(int argc, char **argv)
{
    bool json = false;
    const cli_option options[] = {
        {"--json", 0, CLI_FLAG, &json, NULL, "print one JSON object", NULL},
    };
    const char *paths[2];
    size_t path_count;
    cli_common common = {0};
    const int code = cli_parse(&cli_compare, options, sizeof options / sizeof *options, argc, argv,
                               paths, 2, 2, &path_count, &common);
    if (code != CLI_CONTINUE)
        return code;
    stp_error err;
    stp_status status = STP_OK;
    stp_image a = {0}, b = {0};
    compare_metrics metrics;
    STP_TRY(stp_image_load(&a, paths[0], &err));
    STP_TRY(stp_image_load(&b, paths[1], &err));
    STP_TRY(compare_metrics_compute(&a, &b, &metrics, &err));
    if (json)
        print_json(&metrics);
    else
        print_text(&metrics);
done:
    stp_image_destroy(&a);
    stp_image_destroy(&b);
    return status == STP_OK ? CLI_DONE : cli_fail(&cli_compare, &err);
}
