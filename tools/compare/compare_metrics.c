/* Measures how far one picture is from another. */
#include "tools/compare/compare_metrics.h"

#include "base/memory.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { WINDOW = 11, RADIUS = WINDOW / 2 };

/* The five images from whose local means SSIM is computed. */
enum { MEAN_A, MEAN_B, MEAN_AA, MEAN_BB, MEAN_AB, MEAN_COUNT };

static const uint8_t *pixel(const stp_image *image, int x, int y)
{
    return image->rgba + 4 * ((size_t)y * (size_t)image->width + (size_t)x);
}

static bool covered(const stp_image *image, int x, int y)
{
    return pixel(image, x, y)[3] > 0;
}

/* A colour component over black. */
static int over_black(const uint8_t *p, int component)
{
    return (p[component] * p[3] + 127) / 255;
}

static int at_least(int value, int minimum)
{
    return value > minimum ? value : minimum;
}

static int at_most(int value, int maximum)
{
    return value < maximum ? value : maximum;
}

/* Returns how many of the up to 9 pixels around are covered; *total: how many exist. */
static int covered_around(const stp_image *image, int x, int y, int *total)
{
    int count = 0;
    *total = 0;
    for (int v = at_least(y - 1, 0); v <= at_most(y + 1, image->height - 1); v++) {
        for (int u = at_least(x - 1, 0); u <= at_most(x + 1, image->width - 1); u++) {
            count += covered(image, u, v);
            ++*total;
        }
    }
    return count;
}

/* Sums over the pixels; integers, so that they are exact. */
typedef struct pixel_sums {
    uint64_t either, both, covered_a, covered_b, holes, spill;
    uint64_t squares_either, squares_both; /* of RGB differences */
} pixel_sums;

static uint64_t squared_difference(const stp_image *a, const stp_image *b, int x, int y)
{
    const uint8_t *p = pixel(a, x, y), *q = pixel(b, x, y);
    uint64_t sum = 0;
    for (int k = 0; k < 3; k++) {
        const int d = over_black(p, k) - over_black(q, k);
        sum += (uint64_t)(d * d);
    }
    return sum;
}

static void add_pixel(pixel_sums *sums, const stp_image *a, const stp_image *b, int x, int y)
{
    const bool in_a = covered(a, x, y), in_b = covered(b, x, y);
    int total;
    if (!in_a && !in_b)
        return;
    const uint64_t squares = squared_difference(a, b, x, y);
    sums->either++;
    sums->squares_either += squares;
    sums->covered_a += in_a;
    sums->covered_b += in_b;
    if (in_a && in_b) {
        sums->both++;
        sums->squares_both += squares;
    } else if (in_b) {
        sums->holes += covered_around(b, x, y, &total) == total;
    } else {
        sums->spill += covered_around(b, x, y, &total) == 0;
    }
}

static double psnr(uint64_t squares, uint64_t pixels)
{
    if (pixels == 0)
        return 0.0;
    if (squares == 0)
        return COMPARE_PSNR_IDENTICAL;
    return 10.0 * log10(255.0 * 255.0 * 3.0 * (double)pixels / (double)squares);
}

/* Luminances and their products, filtered along rows. A ring holds the rows of the window, so that
 * memory does not grow with the height. */
typedef struct ssim_filter {
    const stp_image *a, *b;
    double weights[WINDOW];
    double *products; /* MEAN_COUNT planes of one row */
    double *rows;     /* WINDOW x MEAN_COUNT filtered rows; row y is at y % WINDOW */
    size_t width;
} ssim_filter;

static double luminance(const uint8_t *p)
{
    return 0.299 * over_black(p, 0) + 0.587 * over_black(p, 1) + 0.114 * over_black(p, 2);
}

static double *filtered_row(const ssim_filter *f, int y, int mean)
{
    return f->rows + ((size_t)(y % WINDOW) * MEAN_COUNT + (size_t)mean) * f->width;
}

/* The mean of the values around `at`, over the part of the window inside the row. */
static double windowed(const ssim_filter *f, const double *values, int at)
{
    double sum = 0.0, weight = 0.0;
    const int first = at_least(at - RADIUS, 0);
    const int last = at_most(at + RADIUS, (int)f->width - 1);
    for (int x = first; x <= last; x++) {
        const double w = f->weights[x - at + RADIUS];
        sum += w * values[x];
        weight += w;
    }
    return sum / weight;
}

static void filter_row(ssim_filter *f, int y)
{
    for (size_t x = 0; x < f->width; x++) {
        const double la = luminance(pixel(f->a, (int)x, y));
        const double lb = luminance(pixel(f->b, (int)x, y));
        const double values[MEAN_COUNT] = {la, lb, la * la, lb * lb, la * lb};
        for (int mean = 0; mean < MEAN_COUNT; mean++)
            f->products[(size_t)mean * f->width + x] = values[mean];
    }
    for (int mean = 0; mean < MEAN_COUNT; mean++) {
        double *out = filtered_row(f, y, mean);
        for (int x = 0; x < (int)f->width; x++)
            out[x] = windowed(f, f->products + (size_t)mean * f->width, x);
    }
}

static double ssim_at(const ssim_filter *f, int x, int y)
{
    const double c1 = (0.01 * 255.0) * (0.01 * 255.0), c2 = (0.03 * 255.0) * (0.03 * 255.0);
    double m[MEAN_COUNT] = {0.0}, weight = 0.0;
    const int first = at_least(y - RADIUS, 0);
    const int last = at_most(y + RADIUS, f->a->height - 1);
    for (int v = first; v <= last; v++) {
        const double w = f->weights[v - y + RADIUS];
        for (int mean = 0; mean < MEAN_COUNT; mean++)
            m[mean] += w * filtered_row(f, v, mean)[x];
        weight += w;
    }
    for (int mean = 0; mean < MEAN_COUNT; mean++)
        m[mean] /= weight;
    const double variance_a = m[MEAN_AA] - m[MEAN_A] * m[MEAN_A];
    const double variance_b = m[MEAN_BB] - m[MEAN_B] * m[MEAN_B];
    const double covariance = m[MEAN_AB] - m[MEAN_A] * m[MEAN_B];
    return (2.0 * m[MEAN_A] * m[MEAN_B] + c1) * (2.0 * covariance + c2) /
           ((m[MEAN_A] * m[MEAN_A] + m[MEAN_B] * m[MEAN_B] + c1) * (variance_a + variance_b + c2));
}

/* Sum of SSIM over the pixels covered in either. */
static stp_status sum_ssim(const stp_image *a, const stp_image *b, double *sum, stp_error *err)
{
    stp_status status = STP_OK;
    ssim_filter f = {.a = a, .b = b, .width = (size_t)a->width};
    double total = 0.0;
    int filtered = 0;
    for (int k = 0; k < WINDOW; k++)
        f.weights[k] = exp(-0.5 * (k - RADIUS) * (k - RADIUS) / (1.5 * 1.5));
    STP_TRY(stp_alloc(&f.products, f.width, MEAN_COUNT * sizeof *f.products, "image rows", err));
    STP_TRY(stp_alloc(&f.rows, f.width, WINDOW * MEAN_COUNT * sizeof *f.rows, "image rows", err));
    for (int y = 0; y < a->height; y++) {
        for (; filtered <= at_most(y + RADIUS, a->height - 1); filtered++)
            filter_row(&f, filtered);
        for (int x = 0; x < a->width; x++)
            if (covered(a, x, y) || covered(b, x, y))
                total += ssim_at(&f, x, y);
    }
    *sum = total;
done:
    free(f.products);
    free(f.rows);
    return status;
}

stp_status compare_metrics_compute(const stp_image *a, const stp_image *b, compare_metrics *out,
                                   stp_error *err)
{
    stp_status status = STP_OK;
    pixel_sums sums = {0};
    double ssim;
    if (a->width != b->width || a->height != b->height)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the pictures have different sizes, %dx%d and %dx%d: draw both with "
                             "the same --size",
                             a->width, a->height, b->width, b->height);
    for (int y = 0; y < a->height; y++)
        for (int x = 0; x < a->width; x++)
            add_pixel(&sums, a, b, x, y);
    if (sums.either == 0)
        return stp_error_set(err, STP_EMPTY,
                             "neither picture covers a pixel (alpha is 0 everywhere): check the "
                             "cameras they were drawn with");
    STP_TRY(sum_ssim(a, b, &ssim, err));
    const double pixels = (double)a->width * (double)a->height;
    *out = (compare_metrics){.psnr_db = psnr(sums.squares_either, sums.either),
                             .psnr_inside_db = psnr(sums.squares_both, sums.both),
                             .ssim = ssim / (double)sums.either,
                             .coverage_a = (double)sums.covered_a / pixels,
                             .coverage_b = (double)sums.covered_b / pixels,
                             .either = sums.either,
                             .holes = sums.holes,
                             .spill = sums.spill};
done:
    return status;
}
