/* Draws a true mesh on the CPU. Coverage, normals and silhouettes are judged by it.
 *
 * A pixel is covered if its centre lies inside a triangle; the top-left rule gives a pixel on an
 * edge to one triangle. All in double; depth and normal are perspective-correct. Triangles are
 * clipped at the near plane and drawn from both sides. Pictures have their bottom row first.
 * Threads: any. */
#ifndef STP_TESTS_SUPPORT_TRIANGLES_H
#define STP_TESTS_SUPPORT_TRIANGLES_H

#include "base/error.h"
#include "base/vec.h"
#include "runtime/camera/camera.h"

#include <stddef.h>
#include <stdint.h>

/* Borrowed. normals may be NULL: then the faces' normals are used. */
typedef struct triangles_mesh {
    size_t vertex_count, triangle_count;
    const stp_dvec3 *positions; /* world */
    const stp_dvec3 *normals;   /* world, of the vertices */
    const uint32_t (*triangles)[3];
} triangles_mesh;

typedef struct triangles_pixel {
    double depth;     /* of the nearest triangle, at the pixel's centre */
    stp_dvec3 normal; /* eye space, unit, turned to the eye; zero if the triangle is degenerate */
    uint32_t triangle;
    uint32_t layers; /* the number of triangles that cover the pixel; 0: not covered */
} triangles_pixel;

typedef struct triangles_picture {
    int width, height;
    triangles_pixel *pixels;
} triangles_picture;

/* Draws a mesh. Errors: OUT_OF_MEMORY. */
stp_status triangles_draw(triangles_picture *out, const triangles_mesh *mesh, const stp_view *view,
                          stp_error *err);
void triangles_destroy(triangles_picture *picture);

/* Writes one byte per pixel, 1 if covered, into the caller's width * height bytes. */
void triangles_mask(const triangles_picture *picture, uint8_t *mask);

#endif
