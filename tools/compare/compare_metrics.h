/* Measures how far one picture is from another, over the pixels that either covers.
 *
 * A is judged, B is the reference. A pixel is covered if its alpha is above 0. Colours are compared
 * over black. Neighbours beyond the edge of the picture do not count. Does not align, scale or
 * change colours. Threads: any. */
#ifndef STP_TOOLS_COMPARE_COMPARE_METRICS_H
#define STP_TOOLS_COMPARE_COMPARE_METRICS_H

#include "base/error.h"
#include "formats/image/image.h"

#include <stdint.h>

/* PSNR of equal pictures, which has no finite value; above all others. */
#define COMPARE_PSNR_IDENTICAL 999.0

typedef struct compare_metrics {
    double psnr_db;        /* RGB, over pixels covered in either */
    double psnr_inside_db; /* RGB, over pixels covered in both; 0 if there are none */
    /* Structural similarity of the luminance (0.299 R + 0.587 G + 0.114 B), Wang et al. 2004 eq.
     * 13: window of 11x11, Gaussian with sigma 1.5, renormalised at the edges, K1 0.01, K2 0.03;
     * the mean over pixels covered in either. */
    double ssim;
    double coverage_a, coverage_b; /* fractions of all pixels */
    uint64_t either;               /* pixels covered in either */
    uint64_t holes; /* pixels that A lacks and that B covers with their whole 3x3 neighbourhood */
    uint64_t
        spill; /* pixels that A covers without any covered pixel of B in their 3x3 neighbourhood */
} compare_metrics;

/* Errors: INVALID_ARGUMENT (sizes differ), EMPTY (no pixel is covered in either), OUT_OF_MEMORY. */
stp_status compare_metrics_compute(const stp_image *a, const stp_image *b, compare_metrics *out,
                                   stp_error *err);

#endif
