/* Finds holes and compares outlines. */
#include "tests/support/coverage.h"

#include "base/memory.h"
#include "base/sort.h"

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
    uint8_t *work; /* marks of the floods, later outlines */
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

/* ---- outlines ---- */

static bool on_outline(const judge *j, const uint8_t *mask, size_t at)
{
    int x = (int)(at % (size_t)j->width), y = (int)(at / (size_t)j->width);
    if (!mask[at])
        return false;
    return x == 0 || y == 0 || x == j->width - 1 || y == j->height - 1 || !mask[at - 1] ||
           !mask[at + 1] || !mask[at - (size_t)j->width] || !mask[at + (size_t)j->width];
}

/* Appends the distances from a's outline pixels to b's outline to list. */
static stp_status outline_distances(const judge *j, const uint8_t *a, const uint8_t *b,
                                    double *list, size_t *list_count, stp_error *err)
{
    for (size_t i = 0; i < pixel_count(j); i++)
        j->work[i] = on_outline(j, b, i);
    stp_status status = coverage_distance(j->work, j->width, j->height, j->distance, err);
    if (status != STP_OK)
        return status;
    for (size_t i = 0; i < pixel_count(j); i++)
        if (on_outline(j, a, i))
            list[(*list_count)++] = j->distance[i];
    return STP_OK;
}

static stp_status judge_outline(const judge *j, double tolerance, coverage_verdict *out,
                                stp_error *err)
{
    stp_status status = STP_OK;
    double *list = NULL;
    size_t count = 0;
    STP_TRY(stp_alloc(&list, 2 * pixel_count(j), sizeof *list, "outlines", err));
    STP_TRY(outline_distances(j, j->picture, j->silhouette, list, &count, err));
    STP_TRY(outline_distances(j, j->silhouette, j->picture, list, &count, err));
    stp_sort_doubles(list, count);
    out->outline = count;
    for (size_t i = 0; i < count; i++)
        out->outline_far += list[i] > tolerance;
    if (count > 0) {
        out->outline_p99_px = list[(size_t)ceil(0.99 * (double)count) - 1];
        out->outline_max_px = list[count - 1];
    }
done:
    free(list);
    return status;
}

/* ---- the verdict ---- */

static void judge_spill(const judge *j, coverage_verdict *out)
{
    for (size_t i = 0; i < pixel_count(j); i++) {
        int x = (int)(i % (size_t)j->width), y = (int)(i / (size_t)j->width);
        bool reached = false;
        for (int v = y - 1; v <= y + 1; v++)
            for (int u = x - 1; u <= x + 1; u++)
                reached |= u >= 0 && v >= 0 && u < j->width && v < j->height &&
                           j->silhouette[v * j->width + u];
        out->spill += j->picture[i] && !reached;
        out->silhouette += j->silhouette[i] != 0;
    }
}

stp_status coverage_judge(const uint8_t *picture, const uint8_t *silhouette, int width, int height,
                          double outline_tolerance_px, coverage_verdict *out, stp_error *err)
{
    stp_status status = STP_OK;
    judge j = {.picture = picture, .silhouette = silhouette, .width = width, .height = height};
    coverage_verdict verdict = {0};
    STP_TRY(stp_alloc(&j.work, pixel_count(&j), 1, "a mask", err));
    STP_TRY(stp_alloc(&j.stack, pixel_count(&j), sizeof *j.stack, "a mask", err));
    STP_TRY(stp_alloc(&j.distance, pixel_count(&j), sizeof *j.distance, "distances", err));
    STP_TRY(judge_holes(&j, outline_tolerance_px, &verdict, err));
    STP_TRY(judge_outline(&j, outline_tolerance_px, &verdict, err));
    judge_spill(&j, &verdict);
    *out = verdict;
done:
    free(j.work);
    free(j.stack);
    free(j.distance);
    return status;
}
