/* Measures how near pictures are to a true mesh drawn as triangles with the same camera.
 *
 * Pictures are lambert of one grey (shaders/README.md), so only normals and coverage matter.
 * Threads: any, one judge each. */
#ifndef STP_TESTS_QUALITY_JUDGE_H
#define STP_TESTS_QUALITY_JUDGE_H

#include "base/error.h"
#include "formats/scan/mesh/mesh.h"
#include "runtime/camera/camera.h"

#include <stdint.h>

/* The mesh seen from one place. */
typedef struct quality_truth {
    int width, height;
    uint8_t *rgba;        /* at the pixels' centres, bottom row first */
    uint8_t *smooth_rgba; /* the mean of 4 x 4 places per pixel: the ideal silhouette */
    float *normals;       /* world, unit, turned to the eye; zero where not covered */
    uint8_t *silhouette;  /* 1 if some of a pixel's 4 x 4 places are covered, but not all */
} quality_truth;

/* Sums over views. */
typedef struct quality_sums {
    double error;        /* squared, over pixels covered in either, components of 0..1 */
    double inside_error; /* over pixels that the mesh covers wholly */
    double smooth_error; /* to the smooth picture, over the silhouette */
    double angle_deg;    /* between normals, over pixels covered in both */
    double ssim;         /* of views */
    uint64_t either, inside, silhouette, both, covered, true_covered, holes, spill, views;
} quality_sums;

/* Draws the mesh in a view. Errors: OUT_OF_MEMORY. */
stp_status quality_truth_draw(quality_truth *out, const stp_mesh *mesh, const stp_view *view,
                              stp_error *err);
void quality_truth_clear(quality_truth *truth);
/* Adds a picture of the same size, bottom row first, premultiplied, with its normals. Makes the
 * picture's alpha straight. Errors: OUT_OF_MEMORY, EMPTY. */
stp_status quality_add(quality_sums *sums, const quality_truth *truth, uint8_t *rgba,
                       const float *normals, stp_error *err);
/* The ratio in dB for a sum of squared errors of components in 0..1. */
double quality_psnr_db(double error, uint64_t components);

#endif
