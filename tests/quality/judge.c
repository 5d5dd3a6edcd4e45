/* Compares pictures with a true mesh. */
#include "tests/quality/judge.h"

#include "base/memory.h"
#include "tests/support/triangles.h"
#include "tools/compare/compare_metrics.h"
#include "tools/draw/draw_fine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Places inside a pixel along each side. */
#define PARTS 4
/* The smooth picture is drawn in parts of this size: a place takes 40 bytes. */
#define TILE_PX 256

/* Lambert shading of the grey of a sample without colour. */
static double shade(const triangles_pixel *p)
{
    double grey = 0.8 * (0.05 + 0.85 * fmax(0.0, p->normal.z));
    return p->layers > 0 ? grey : 0.0;
}

static void take_centres(quality_truth *t, const triangles_picture *picture, const stp_view *view)
{
    for (size_t i = 0; i < (size_t)t->width * (size_t)t->height; i++) {
        const triangles_pixel *p = &picture->pixels[i];
        uint8_t grey = (uint8_t)(255.0 * shade(p) + 0.5);
        memcpy(t->rgba + 4 * i, (uint8_t[4]){grey, grey, grey, p->layers > 0 ? 255 : 0}, 4);
        if (p->layers == 0)
            continue;
        stp_dvec3 n = stp_dvec3_add(stp_dvec3_scale(view->right, p->normal.x),
                                    stp_dvec3_add(stp_dvec3_scale(view->up, p->normal.y),
                                                  stp_dvec3_scale(view->back, p->normal.z)));
        t->normals[3 * i] = (float)n.x;
        t->normals[3 * i + 1] = (float)n.y;
        t->normals[3 * i + 2] = (float)n.z;
    }
}

/* Computes the pixel at (x, y) of a part; `picture` holds the part's places. */
static void take_mean(quality_truth *t, const triangles_picture *picture, int x, int y, size_t at)
{
    double sum = 0.0;
    int covered = 0;
    for (int k = 0; k < PARTS * PARTS; k++) {
        int place = (PARTS * y + k / PARTS) * picture->width + PARTS * x + k % PARTS;
        sum += shade(&picture->pixels[place]);
        covered += picture->pixels[place].layers > 0;
    }
    uint8_t grey = (uint8_t)(255.0 * sum / (PARTS * PARTS) + 0.5);
    uint8_t alpha = (uint8_t)(255.0 * covered / (PARTS * PARTS) + 0.5);
    memcpy(t->smooth_rgba + 4 * at, (uint8_t[4]){grey, grey, grey, alpha}, 4);
    t->silhouette[at] = covered > 0 && covered < PARTS * PARTS;
}

static stp_status draw_smooth(quality_truth *t, const triangles_mesh *mesh, const stp_view *view,
                              stp_error *err)
{
    stp_status status = STP_OK;
    triangles_picture picture = {0};
    stp_view all = stp_view_scaled(view, PARTS);
    for (int y0 = 0; y0 < t->height; y0 += TILE_PX)
        for (int x0 = 0; x0 < t->width; x0 += TILE_PX) {
            int width = t->width - x0 < TILE_PX ? t->width - x0 : TILE_PX;
            int height = t->height - y0 < TILE_PX ? t->height - y0 : TILE_PX;
            stp_view part =
                stp_view_part(&all, PARTS * x0, PARTS * y0, PARTS * width, PARTS * height);
            STP_TRY(triangles_draw(&picture, mesh, &part, err));
            for (int y = 0; y < height; y++)
                for (int x = 0; x < width; x++)
                    take_mean(t, &picture, x, y,
                              (size_t)(y0 + y) * (size_t)t->width + (size_t)(x0 + x));
            triangles_destroy(&picture);
        }
done:
    triangles_destroy(&picture);
    return status;
}

stp_status quality_truth_draw(quality_truth *out, const stp_mesh *mesh, const stp_view *view,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const size_t count = (size_t)view->width * (size_t)view->height;
    quality_truth t = {.width = view->width, .height = view->height};
    triangles_picture picture = {0};
    stp_dvec3 *normals = NULL;
    STP_TRY(stp_alloc(&t.rgba, count, 4, "a picture", err));
    STP_TRY(stp_alloc(&t.smooth_rgba, count, 4, "a picture", err));
    STP_TRY(stp_alloc(&t.normals, count, 3 * sizeof *t.normals, "normals", err));
    STP_TRY(stp_alloc(&t.silhouette, count, 1, "a silhouette", err));
    if (mesh->normals != NULL)
        STP_TRY(stp_alloc(&normals, mesh->vertex_count, sizeof *normals, "normals", err));
    for (size_t i = 0; i < mesh->vertex_count && normals != NULL; i++)
        normals[i] = stp_dvec3_from_float(mesh->normals[i]);
    const triangles_mesh triangles = {.vertex_count = mesh->vertex_count,
                                      .triangle_count = mesh->triangle_count,
                                      .positions = mesh->positions,
                                      .normals = normals,
                                      .triangles = (const uint32_t(*)[3])mesh->triangles};
    STP_TRY(triangles_draw(&picture, &triangles, view, err));
    take_centres(&t, &picture, view);
    STP_TRY(draw_smooth(&t, &triangles, view, err));
    *out = t;
    t = (quality_truth){0};
done:
    triangles_destroy(&picture);
    quality_truth_clear(&t);
    free(normals);
    return status;
}

void quality_truth_clear(quality_truth *t)
{
    free(t->rgba);
    free(t->smooth_rgba);
    free(t->normals);
    free(t->silhouette);
    *t = (quality_truth){0};
}

/* The squared difference of two pixels over black, components in 0..1. */
static double difference(const uint8_t *a, const uint8_t *b)
{
    double sum = 0.0;
    for (int c = 0; c < 3; c++) {
        double d = (a[c] - b[c]) / 255.0;
        sum += d * d;
    }
    return sum;
}

static double angle_deg(const float *a, const float *b)
{
    double cosine =
        (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
    return acos(fmin(1.0, fmax(-1.0, cosine))) * (180.0 / M_PI);
}

static void add_pixels(quality_sums *sums, const quality_truth *t, const uint8_t *rgba,
                       const float *normals)
{
    for (size_t i = 0; i < (size_t)t->width * (size_t)t->height; i++) {
        bool is = rgba[4 * i + 3] > 127, truly = t->rgba[4 * i + 3] > 0;
        sums->covered += is;
        sums->true_covered += truly;
        if (t->silhouette[i]) {
            sums->silhouette++;
            sums->smooth_error += difference(rgba + 4 * i, t->smooth_rgba + 4 * i);
        }
        if (truly && !t->silhouette[i]) {
            sums->inside++;
            sums->inside_error += difference(rgba + 4 * i, t->rgba + 4 * i);
        }
        if (is || truly) {
            sums->either++;
            sums->error += difference(rgba + 4 * i, t->rgba + 4 * i);
        }
        if (is && truly) {
            sums->both++;
            sums->angle_deg += angle_deg(normals + 3 * i, t->normals + 3 * i);
        }
    }
}

stp_status quality_add(quality_sums *sums, const quality_truth *t, uint8_t *rgba,
                       const float *normals, stp_error *err)
{
    compare_metrics metrics;
    stp_image a = {t->width, t->height, rgba};
    const stp_image b = {t->width, t->height, t->rgba};
    add_pixels(sums, t, rgba, normals);
    draw_straighten(&a);
    stp_status status = compare_metrics_compute(&a, &b, &metrics, err);
    if (status != STP_OK)
        return status;
    sums->ssim += metrics.ssim;
    sums->holes += metrics.holes;
    sums->spill += metrics.spill;
    sums->views++;
    return STP_OK;
}

double quality_psnr_db(double error, uint64_t components)
{
    return error > 0.0 ? -10.0 * log10(error / (double)components) : COMPARE_PSNR_IDENTICAL;
}
