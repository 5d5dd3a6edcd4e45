/* Depth cameras' and scanners' images that stay grids of pixels, and the leaves that they become:
 * patches are squares of 8 x 8 pixels, cut where the depth jumps.
 *
 * The points lie on rays (depth_rays.h). A few that do not, and points of other scans if they are
 * few, are loose: they stay in their cells of the cloud, beside the images. If they are many, the
 * images become points as any other scan.
 *
 * Neighbouring pixels lie on one surface if each is near the other's plane: two pixels' width, and
 * what the image's noise allows (pixel_image.h). A patch has the pixels of a square that such
 * neighbours join. A sample's disc is as wide as the surface behind its pixel. Threads: one maker;
 * leaves may be built on any. */
#ifndef STP_PREPROCESS_GRID_DEPTH_IMAGE_H
#define STP_PREPROCESS_GRID_DEPTH_IMAGE_H

#include "formats/chunk/codec/square/square.h"
#include "preprocess/grid/depth_rays.h"
#include "preprocess/tree/chunk_build.h"
#include "preprocess/tree/leaf_cut.h"

typedef struct stp_depth_camera {
    size_t first_square; /* of its image, among those of the pieces */
    bool turned; /* a chunk's columns are the image's rows, so that its normals face the camera */
    double step_most; /* of pixel_image.h; 0: the image has no noise */
} stp_depth_camera;

/* The pixels of a square that become a patch, as a chunk has them. */
typedef struct stp_depth_square {
    uint64_t samples;
    uint32_t image, column, row; /* of the square, in squares */
    uint32_t rays;               /* of its piece */
} stp_depth_square;

typedef struct stp_depth_images {
    const stp_cloud *cloud; /* borrowed */
    stp_pixel_images pixels;
    stp_depth_camera *cameras; /* by image */
    stp_depth_pieces pieces;
    uint64_t *loose; /* by point of the cloud, from its first on, a bit each: it is in no image */
    stp_depth_square *squares; /* leaf by leaf */
    stp_leaf_run *leaves;      /* of squares */
    uint32_t square_count, leaf_count;
    uint32_t image_count; /* of those that have pixels */
    uint64_t loose_count;
    unsigned least_bits; /* where normals are rough, they may be rounded to this grid */
    stp_holes *holes;    /* of image i at i + 1 (depth_holes.h); NULL: discs may cover them */
    struct stp_depth_open *open; /* what they know of their images */
} stp_depth_images;

/* Cuts the images of a cloud, whose normals are known, into leaves. No leaves: many points belong
 * to no image or are on no ray, or pixels lie apart. noisy: normals come from images. params: what
 * samples will be stored with. Ranks that share the cloud cut an image each, and all know all
 * leaves in the end. Errors: OUT_OF_MEMORY, IO, CANCELLED. Free with stp_depth_images_clear. */
stp_status stp_depth_images_create(stp_depth_images *out, const stp_cloud *cloud,
                                   const struct stp_prep_source *source, bool noisy,
                                   const stp_point_item_params *params, stp_error *err);
/* Asks for the points of a leaf (cloud_blocks.h). */
void stp_depth_leaf_ask(const stp_depth_images *images, uint32_t leaf);
/* Builds one leaf, without tangential errors. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status stp_depth_leaf_build(const stp_depth_images *images, uint32_t leaf,
                                const stp_point_item_params *params, stp_built_chunk *out,
                                stp_error *err);
void stp_depth_images_clear(stp_depth_images *images);

/* How many of the points [begin, end) of the cloud are in no image. */
uint64_t stp_depth_loose(const stp_depth_images *images, uint64_t begin, uint64_t end);
static inline bool stp_depth_is_loose(const stp_depth_images *images, uint64_t point)
{
    const uint64_t at = point - images->cloud->first;
    return images->loose[at / 64] >> at % 64 & 1u;
}

/* The point of a place in a chunk's grid, of an image; STP_PIXEL_NONE: none. */
static inline uint64_t stp_depth_point(const stp_depth_images *images, uint32_t image,
                                       uint32_t column, uint32_t row)
{
    const stp_pixel_image *m = &images->pixels.list[image];
    const bool turned = images->cameras[image].turned;
    const uint32_t c = turned ? row : column, r = turned ? column : row;
    return c < m->columns && r < m->rows ? stp_pixel_point(m, (uint64_t)r * m->columns + c)
                                         : STP_PIXEL_NONE;
}

/* The point of a sample of a square, in Morton order. */
static inline uint64_t stp_depth_square_point(const stp_depth_images *images,
                                              const stp_depth_square *square, unsigned sample)
{
    return stp_depth_point(images, square->image,
                           square->column * STP_SQUARE_SIDE + stp_square_column(sample),
                           square->row * STP_SQUARE_SIDE + stp_square_row(sample));
}

/* A point as its camera sees it: two tangents and the logarithm of its depth. So lengths are in
 * parts of the depth, along all three. */
stp_dvec3 stp_depth_view(const stp_depth_images *images, uint32_t rays, uint64_t point);
/* The spacing of a point's disc. */
double stp_depth_spacing(const stp_depth_images *images, uint32_t rays, uint64_t point);

#endif
