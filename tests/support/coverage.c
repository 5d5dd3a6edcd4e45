/* Finds holes, and what the picture and the truth have far from each other. */
#include "tests/support/coverage.h"

#include "base/memory.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* ---- distance ---- */

/* The lower envelope of the parabolas f[i] + (x - i)^2 at every x: the squared distances along one
 * line. place and from are scratch memory of n and n + 1 values. */
static void envelope(const double *f, double *out, int n, int *place, double *from)
{
    int last = -1;
    for (int i = 0; i < n; i++) {
        double start = -INFINITY;
        if (isinf(f[i]))
            continue;
        while (last >= 0) {
            int j = place[last];
            start = ((f[i] + (double)i * i) - (f[j] + (double)j * j)) / (2.0 * (i - j));
            if (start > from[last])
                break;
            last--;
        }
        place[++last] = i;
        from[last] = last == 0 ? -INFINITY : start;
    }
    for (int x = 0, k = 0; x < n; x++) {
        if (last < 0) {
            out[x] = INFINITY;
            continue;
        }
        while (k < last && from[k + 1] < x)
            k++;
        out[x] = f[place[k]] + (double)(x - place[k]) * (x - place[k]);
    }
}

stp_status coverage_distance(const uint8_t *mask, int width, int height, double *distance,
                             stp_error *err)
{
    stp_status status = STP_OK;
    double *line = NULL, *result = NULL, *from = NULL;
    int *place = NULL;
    int longest = width > height ? width : height;
    STP_TRY(stp_alloc(&line, (size_t)longest, sizeof *line, "a row", err));
    STP_TRY(stp_alloc(&result, (size_t)longest, sizeof *result, "a row", err));
    STP_TRY(stp_alloc(&from, (size_t)longest + 1, sizeof *from, "a row", err));
    STP_TRY(stp_alloc(&place, (size_t)longest, sizeof *place, "a row", err));
    for (int x = 0; x < width; x++) {
        for (int y = 0; y < height; y++)
            line[y] = mask[y * width + x] ? 0.0 : INFINITY;
        envelope(line, result, height, place, from);
        for (int y = 0; y < height; y++)
            distance[y * width + x] = result[y];
    }
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++)
            line[x] = distance[y * width + x];
        envelope(line, result, width, place, from);
        for (int x = 0; x < width; x++)
            distance[y * width + x] = sqrt(result[x]);
    }
done:
    free(line);
    free(result);
    free(from);
    free(place);
    return status;
}

/* ---- holes ---- */

typedef struct judge {
    const uint8_t *picture, *silhouette;
    int width, height;
    uint8_t *work; /* marks of the floods */
    size_t *stack; /* one place per pixel */
    double *distance;
} judge;

static size_t pixel_count(const judge *j)
{
    return (size_t)j->width * (size_t)j->height;
}

/* Floods from a pixel over pixels marked `from` and marks them `to`; corners: also across corners.
 * Returns how many pixels it marked. */
static size_t flood(const judge *j, size_t start, uint8_t from, uint8_t to, bool corners)
{
    size_t depth = 0, count = 0;
    j->work[start] = to;
    j->stack[depth++] = start;
    while (depth > 0) {
        size_t at = j->stack[--depth];
        int x = (int)(at % (size_t)j->width), y = (int)(at / (size_t)j->width);
        count++;
        for (int k = 0; k < 9; k++) {
            int dx = k % 3 - 1, dy = k / 3 - 1, u = x + dx, v = y + dy;
            if ((dx != 0 && dy != 0 && !corners) || u < 0 || v < 0 || u >= j->width ||
                v >= j->height)
                continue;
            size_t next = (size_t)v * (size_t)j->width + (size_t)u;
            if (j->work[next] != from)
                continue;
            j->work[next] = to;
            j->stack[depth++] = next;
        }
    }
    return count;
}

/* Whether the mask contains the pixel and its eight neighbours; pixels beyond the picture count as
 * contained. */
static bool holds_neighbours(const judge *j, const uint8_t *mask, size_t at)
{
    int x = (int)(at % (size_t)j->width), y = (int)(at / (size_t)j->width);
    for (int v = y - 1; v <= y + 1; v++)
        for (int u = x - 1; u <= x + 1; u++)
            if (u >= 0 && v >= 0 && u < j->width && v < j->height && !mask[v * j->width + u])
                return false;
    return true;
}

enum { COVERED, MISSING, OUTSIDE, HOLE, COUNTED };

static stp_status judge_holes(const judge *j, double tolerance, coverage_verdict *out,
                              stp_error *err)
{
    size_t count = pixel_count(j);
    for (size_t i = 0; i < count; i++)
        j->work[i] = !j->silhouette[i];
    stp_status status = coverage_distance(j->work, j->width, j->height, j->distance, err);
    if (status != STP_OK)
        return status;
    for (size_t i = 0; i < count; i++)
        j->work[i] = j->picture[i] ? COVERED : MISSING;
    for (size_t i = 0; i < count; i++)
        if (!j->silhouette[i] && j->work[i] == MISSING)
            flood(j, i, MISSING, OUTSIDE, false);
    for (size_t i = 0; i < count; i++) {
        bool shut_in = j->work[i] == MISSING;
        bool deep = j->work[i] == OUTSIDE && j->distance[i] > tolerance;
        if (j->silhouette[i] && (shut_in || deep) && holds_neighbours(j, j->silhouette, i))
            j->work[i] = HOLE;
    }
    for (size_t i = 0; i < count; i++) {
        if (j->work[i] != HOLE)
            continue;
        size_t size = flood(j, i, HOLE, COUNTED, true);
        out->hole_count++;
        out->hole_pixels += size;
        out->largest_hole = size > out->largest_hole ? size : out->largest_hole;
    }
    return STP_OK;
}

/* ---- distances ---- */

/* Counts the pixels that the picture covers farther than the tolerance from all of the truth. */
static stp_status judge_spill(const judge *j, const uint8_t *truth, int scale, double tolerance,
                              coverage_verdict *out, stp_error *err)
{
    const int wide = j->width * scale;
    stp_status status = coverage_distance(truth, wide, j->height * scale, j->distance, err);
    if (status != STP_OK)
        return status;
    for (int y = 0; y < j->height; y++)
        for (int x = 0; x < j->width; x++) {
            const size_t centre =
                (size_t)(scale * y + scale / 2) * (size_t)wide + (size_t)(scale * x + scale / 2);
            const double distance = j->distance[centre] / scale;
            if (!j->picture[y * j->width + x])
                continue;
            out->spill += distance > tolerance;
            out->spill_max_px = fmax(out->spill_max_px, distance);
        }
    return STP_OK;
}

/* Counts the pixels of the silhouette that are farther than the tolerance from all of the
 * picture. */
static stp_status judge_lost(const judge *j, double tolerance, coverage_verdict *out,
                             stp_error *err)
{
    stp_status status = coverage_distance(j->picture, j->width, j->height, j->distance, err);
    if (status != STP_OK)
        return status;
    for (size_t i = 0; i < pixel_count(j); i++) {
        if (!j->silhouette[i])
            continue;
        out->lost += j->distance[i] > tolerance;
        out->lost_max_px = fmax(out->lost_max_px, j->distance[i]);
    }
    return STP_OK;
}

static bool on_outline(const judge *j, const uint8_t *mask, size_t at)
{
    int x = (int)(at % (size_t)j->width), y = (int)(at / (size_t)j->width);
    if (!mask[at])
        return false;
    return x == 0 || y == 0 || x == j->width - 1 || y == j->height - 1 || !mask[at - 1] ||
           !mask[at + 1] || !mask[at - (size_t)j->width] || !mask[at + (size_t)j->width];
}

/* ---- the verdict ---- */

/* The silhouette: the truth at the pixels' centres. */
static void sample_truth(const judge *j, const uint8_t *truth, int scale, uint8_t *silhouette)
{
    for (int y = 0; y < j->height; y++)
        for (int x = 0; x < j->width; x++)
            silhouette[y * j->width + x] =
                truth[(size_t)(scale * y + scale / 2) * (size_t)(j->width * scale) +
                      (size_t)(scale * x + scale / 2)];
}

stp_status coverage_judge(const uint8_t *picture, int width, int height, const uint8_t *truth,
                          int scale, double tolerance_px, coverage_verdict *out, stp_error *err)
{
    stp_status status = STP_OK;
    judge j = {.picture = picture, .width = width, .height = height};
    uint8_t *silhouette = NULL;
    coverage_verdict verdict = {0};
    STP_TRY(stp_alloc(&silhouette, pixel_count(&j), 1, "a mask", err));
    STP_TRY(stp_alloc(&j.work, pixel_count(&j), 1, "a mask", err));
    STP_TRY(stp_alloc(&j.stack, pixel_count(&j), sizeof *j.stack, "a mask", err));
    STP_TRY(stp_alloc(&j.distance, pixel_count(&j) * (size_t)scale * (size_t)scale,
                      sizeof *j.distance, "distances", err));
    sample_truth(&j, truth, scale, silhouette);
    j.silhouette = silhouette;
    STP_TRY(judge_holes(&j, tolerance_px, &verdict, err));
    STP_TRY(judge_spill(&j, truth, scale, tolerance_px, &verdict, err));
    STP_TRY(judge_lost(&j, tolerance_px, &verdict, err));
    for (size_t i = 0; i < pixel_count(&j); i++) {
        verdict.silhouette += silhouette[i] != 0;
        verdict.outline += on_outline(&j, silhouette, i);
        verdict.outline += on_outline(&j, picture, i);
    }
    *out = verdict;
done:
    free(silhouette);
    free(j.work);
    free(j.stack);
    free(j.distance);
    return status;
}
