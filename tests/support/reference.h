/* Implements the reconstruction on the CPU, written from shaders/README.md: slow, plain, in double.
 *
 * The shaders are judged by it. It has one function each for projection, pull, push and shading. It
 * does not choose levels and reads no files: the caller gives the discs to draw.
 * Axes: eye space (x right, y up, z towards the viewer); pictures have their bottom row first.
 * Threads: any (no state but the caller's). */
#ifndef STP_TESTS_SUPPORT_REFERENCE_H
#define STP_TESTS_SUPPORT_REFERENCE_H

#include "base/error.h"
#include "base/vec.h"
#include "runtime/camera/camera.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define REFERENCE_LEVELS_LIMIT 16

/* Whether a pixel of a segment or a triangle is drawn. Rasterisers round vertices, and they may
 * differ at the ends of segments. */
typedef enum reference_presence {
    REFERENCE_SURE = 0,
    REFERENCE_THERE,  /* drawn, but may be missing */
    REFERENCE_MISSING /* not drawn, but may be there */
} reference_presence;

/* A hidden back is not drawn from this cosine to the ray on. */
#define REFERENCE_CULL_COSINE 0.1

/* A sample as it is drawn. */
typedef struct reference_disc {
    stp_dvec3 position; /* eye space */
    stp_dvec3 normal;   /* eye space, unit; meaningless without has_normal */
    double radius;      /* world units */
    double rgb[3];      /* 0..1 */
    unsigned kind;
    bool has_normal, oriented;
    bool culled;       /* not drawn from behind, */
    bool seen_through; /* except through an opening */
    reference_presence presence;
    bool wide;    /* one pixel's part of a segment; its centre may be anywhere in the picture */
    int pixel[2]; /* that pixel */
} reference_disc;

/* A zeroed list is empty. */
typedef struct reference_disc_list {
    reference_disc *items;
    size_t count, capacity;
} reference_disc_list;

/* "A pixel of the pyramid"; all zero where tag is 0. */
typedef struct reference_pixel {
    stp_dvec3 normal;
    double radius;
    double z_min, z_max;
    double dx, dy;
    double rgb[3];
    int tag;
} reference_pixel;

typedef struct reference_level {
    int width, height;
    reference_pixel *pulled, *finished;
} reference_level;

/* How level 0 is finished. The value of a template is the side of its window. */
typedef enum reference_filter {
    REFERENCE_GAUSS = 0, /* MKC08 */
    REFERENCE_BOX = 1,   /* MKC07 */
    REFERENCE_SPLAT = 2, /* without levels: reference_splat */
    REFERENCE_TEMPLATE3 = 3,
    REFERENCE_TEMPLATE5 = 5,
    REFERENCE_TEMPLATE7 = 7
} reference_filter;

/* Levels 0..level_count; the finished pixels of the last one are its pulled pixels. */
typedef struct reference_pyramid {
    stp_view view;
    reference_filter filter;
    bool grid; /* "Grids"; set after reference_create */
    int level_count;
    reference_level levels[REFERENCE_LEVELS_LIMIT + 1];
} reference_pyramid;

typedef enum reference_shade {
    REFERENCE_PHONG,
    REFERENCE_LAMBERT,
    REFERENCE_UNLIT,
    REFERENCE_NORMAL,
    REFERENCE_DEPTH
} reference_shade;

/* L of README for a greatest projected radius in pixels (may be infinite). */
int reference_level_count(double radius_px, int width, int height);

/* Turns a position or a direction of the world into eye space. */
stp_dvec3 reference_to_eye(const stp_view *view, stp_dvec3 p);
stp_dvec3 reference_turn_to_eye(const stp_view *view, stp_dvec3 d);

/* Appends a disc. Errors: OUT_OF_MEMORY. */
stp_status reference_append(reference_disc_list *list, const reference_disc *disc, stp_error *err);
void reference_disc_list_clear(reference_disc_list *list);
/* Appends a disc for each pixel of a segment or of a triangle; each disc falls into its pixel.
 * Errors: OUT_OF_MEMORY. */
stp_status reference_segment(const stp_view *view, const reference_disc *a, const reference_disc *b,
                             reference_disc_list *out, stp_error *err);
/* For splats, which draw a segment in its full width: appends a disc for each pixel that the
 * segment may cover. */
stp_status reference_segment_wide(const stp_view *view, const reference_disc *a,
                                  const reference_disc *b, reference_disc_list *out,
                                  stp_error *err);
stp_status reference_triangle(const stp_view *view, const reference_disc corners[3],
                              reference_disc_list *out, stp_error *err);

/* Whether a segment is drawn as a flat piece of a ribbon; and the discs for the pixels of the piece
 * from vertex i of a line to the next. Errors: OUT_OF_MEMORY. */
bool reference_ribbon_is_flat(const stp_view *view, const reference_disc *a,
                              const reference_disc *b);
stp_status reference_ribbon(const stp_view *view, const reference_disc *vertices, unsigned count,
                            unsigned i, reference_disc_list *out, stp_error *err);

/* Makes an empty pyramid. Errors: OUT_OF_MEMORY, INVALID_ARGUMENT (level_count). */
stp_status reference_create(reference_pyramid *out, const stp_view *view, reference_filter filter,
                            int level_count, stp_error *err);
void reference_destroy(reference_pyramid *pyramid);

/* Projects discs[0..count) in this order over the existing pixels: one pixel each, the nearest
 * wins. */
void reference_project(reference_pyramid *pyramid, const reference_disc *discs, size_t count);
/* Pulls levels 1..level_count. */
void reference_pull(reference_pyramid *pyramid);
/* Finishes levels level_count..0; templates finish level 0 alone. */
void reference_push(reference_pyramid *pyramid);
/* Writes finished level 0 as width * height RGBA, 0..1, into the caller's memory. */
void reference_shade_picture(const reference_pyramid *pyramid, reference_shade shade, double *rgba);

/* Projects discs[0..count) as splats, adds them up, and so finishes level 0. Needs no other level.
 * Errors: OUT_OF_MEMORY. */
stp_status reference_splat(reference_pyramid *pyramid, const reference_disc *discs, size_t count,
                           stp_error *err);

/* Turns a disc into a pixel of level 0; (dx, dy) are the window coordinates of its centre. Returns
 * false if the disc is not drawn. */
bool reference_sample(const reference_pyramid *pyramid, const reference_disc *disc,
                      reference_pixel *out);
/* Returns q at the point where the ray through window (u, v) meets the disc of p, whose ellipse has
 * its centre at (cx, cy); *depth is the depth there. */
double reference_meet(const reference_pyramid *pyramid, const reference_pixel *p, double cx,
                      double cy, double u, double v, double *depth);
/* The weighted mean of count pixels whose (dx, dy) start at one place. The tag and the side of
 * normals are the front's. */
reference_pixel reference_mean(const reference_pixel *pixels, const double *weights, int count,
                               const reference_pixel *front);
/* The projected radius, at least the floor. */
double reference_radius_px(const reference_pyramid *pyramid, const reference_pixel *p);

/* The ellipse's quadratic form, 1 at the rim: for p's ellipse with its centre at window (cx, cy),
 * at the offset (x, y) from there. */
double reference_ellipse(const reference_pyramid *pyramid, const reference_pixel *p, double cx,
                         double cy, double x, double y);

/* The input of smooth edges: a picture without them, premultiplied, and its pixels. */
typedef struct reference_rough {
    stp_view view;
    const uint8_t *rgba;
    const float *depth;             /* 0: nothing there */
    const reference_pixel *level_0; /* pulled */
    const reference_pixel *level_1; /* finished; NULL: no level 1 */
} reference_rough;

/* Writes the picture with smooth edges, 0..255, into the caller's width * height * 4 values. */
void reference_edges(const reference_rough *rough, double *rgba);

#endif
