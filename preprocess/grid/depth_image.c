/* Cuts images into patches and leaves. */
#include "preprocess/grid/depth_image.h"

#include "base/memory.h"
#include "formats/chunk/codec/square/square.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/grid/depth_share.h"
#include "preprocess/orient/pixel_share.h"
#include "preprocess/patch/patch_build.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Neighbours on one surface lie this near to each other's planes, in pixels' widths. */
#define STEP_WIDTHS 2.0
/* Images whose patches have fewer pixels in the mean, as they lie apart, become points. */
#define PATCH_LEAST 8u
/* Discs have sizes of so many steps an octave, lest noise makes each a size of its own. */
#define SIZE_STEPS 4.0
/* If more than one of so many points is in no image, all are points of none. */
#define LOOSE_PART 8u

/* ---- squares ---- */

/* The side of a point's pixel. */
static double pixel_side(const stp_depth_images *images, const stp_depth_rays *rays, uint64_t point)
{
    double seen[3];
    stp_depth_see(rays, images->cloud->points[point].position, seen);
    return stp_depth_pixel_side(rays, seen);
}

double stp_depth_spacing(const stp_depth_images *images, uint32_t rays, uint64_t point)
{
    const stp_cloud_point *p = &images->cloud->points[point];
    const stp_depth_rays *r = &images->pieces.rays[rays];
    const stp_dvec3 ray = stp_dvec3_normalize(stp_dvec3_sub(p->position, r->station));
    const double facing =
        stp_has_normal(p) ? fabs(stp_dvec3_dot(stp_dvec3_from_float(p->normal), ray)) : 1.0;
    const double side = nearbyint(SIZE_STEPS * log2(pixel_side(images, r, point)));
    return exp2(side / SIZE_STEPS) * sqrt(stp_stretch(facing));
}

stp_dvec3 stp_depth_view(const stp_depth_images *images, uint32_t rays, uint64_t point)
{
    double seen[3];
    stp_depth_see(&images->pieces.rays[rays], images->cloud->points[point].position, seen);
    return (stp_dvec3){seen[1] / seen[0], seen[2] / seen[0], log(fabs(seen[0]))};
}

/* A point without a normal says nothing of its plane: the other one must be near. */
static bool is_one_surface(const stp_depth_images *images, const stp_depth_square *square,
                           uint64_t a, uint64_t b)
{
    const stp_pixel_image *m = &images->pixels.list[square->image];
    const stp_cloud_point *p = &images->cloud->points[a], *q = &images->cloud->points[b];
    const stp_dvec3 ray = stp_dvec3_sub(p->position, m->station);
    const double squared = stp_dvec3_dot(ray, ray);
    const double widths =
        STEP_WIDTHS * pixel_side(images, &images->pieces.rays[square->rays], a) / squared;
    const double step = stp_has_normal(p) && stp_has_normal(q)
                            ? stp_pixel_step(images->cloud, m, a, b)
                            : stp_dvec3_length(stp_dvec3_sub(p->position, q->position)) / squared;
    return step <= fmax(widths, images->cameras[square->image].step_most);
}

static unsigned root_of(const uint8_t parent[STP_SQUARE_SAMPLES], unsigned i)
{
    while (parent[i] != i)
        i = parent[i];
    return i;
}

/* Joins a pixel of a square with those before it: to the left and in the row above. */
static void join_before(const stp_depth_images *images, const stp_depth_square *square,
                        const uint64_t points[STP_SQUARE_SIDE][STP_SQUARE_SIDE], unsigned column,
                        unsigned row, uint8_t parent[STP_SQUARE_SAMPLES])
{
    static const int before[4][2] = {{-1, 0}, {-1, -1}, {0, -1}, {1, -1}};
    for (int k = 0; k < 4; k++) {
        const unsigned c = column + (unsigned)before[k][0], r = row + (unsigned)before[k][1];
        if (c >= STP_SQUARE_SIDE || r >= STP_SQUARE_SIDE || points[r][c] == STP_PIXEL_NONE ||
            !is_one_surface(images, square, points[row][column], points[r][c]))
            continue;
        const unsigned a = root_of(parent, row * STP_SQUARE_SIDE + column);
        const unsigned b = root_of(parent, r * STP_SQUARE_SIDE + c);
        parent[a > b ? a : b] = (uint8_t)(a < b ? a : b);
    }
}

/* Patches of all images. */
typedef struct listing {
    stp_depth_square *squares;
    size_t count, capacity;
} listing;

/* The rays of a square of a chunk's grid. */
static uint32_t rays_of(const stp_depth_images *images, uint32_t image, uint32_t column,
                        uint32_t row)
{
    const stp_depth_camera *camera = &images->cameras[image];
    const uint32_t c = camera->turned ? row : column, r = camera->turned ? column : row;
    const uint32_t across = stp_depth_squares(images->pixels.list[image].columns);
    return images->pieces.of_square[camera->first_square + (size_t)r * across + c];
}

/* Cuts a square into the pieces that neighbours join. */
static stp_status cut_square(listing *l, const stp_depth_images *images, uint32_t image,
                             uint32_t column, uint32_t row, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t points[STP_SQUARE_SIDE][STP_SQUARE_SIDE];
    uint8_t parent[STP_SQUARE_SAMPLES];
    uint64_t pieces[STP_SQUARE_SAMPLES] = {0};
    const stp_depth_square whole = {
        .image = image, .column = column, .row = row, .rays = rays_of(images, image, column, row)};
    for (unsigned i = 0; i < STP_SQUARE_SAMPLES; i++) {
        const unsigned c = i % STP_SQUARE_SIDE, r = i / STP_SQUARE_SIDE;
        points[r][c] =
            stp_depth_point(images, image, column * STP_SQUARE_SIDE + c, row * STP_SQUARE_SIDE + r);
        parent[i] = (uint8_t)i;
        if (points[r][c] != STP_PIXEL_NONE)
            join_before(images, &whole, points, c, r, parent);
    }
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++) {
        const unsigned c = stp_square_column(k), r = stp_square_row(k);
        const unsigned root = root_of(parent, r * STP_SQUARE_SIDE + c);
        if (points[r][c] == STP_PIXEL_NONE)
            continue;
        pieces[root] |= UINT64_C(1) << k;
    }
    for (unsigned i = 0; i < STP_SQUARE_SAMPLES; i++) {
        if (pieces[i] == 0)
            continue;
        STP_TRY(
            stp_grow(&l->squares, &l->capacity, l->count + 1, sizeof *l->squares, "patches", err));
        l->squares[l->count] = whole;
        l->squares[l->count++].samples = pieces[i];
    }
done:
    return status;
}

/* Squares near each other follow each other: they stand in Morton order, in parts as long as the
 * image's shorter side. */
static stp_status cut_image(listing *l, const stp_depth_images *images, uint32_t image,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const stp_pixel_image *m = &images->pixels.list[image];
    const bool turned = images->cameras[image].turned;
    const uint32_t columns = ((turned ? m->rows : m->columns) - 1) / STP_SQUARE_SIDE + 1;
    const uint32_t rows = ((turned ? m->columns : m->rows) - 1) / STP_SQUARE_SIDE + 1;
    const bool wide = columns > rows;
    uint32_t side = 1;
    while (side < (wide ? rows : columns))
        side *= 2;
    for (uint64_t begin = 0; begin < (wide ? columns : rows); begin += side)
        for (uint64_t i = 0; i < (uint64_t)side * side; i++) {
            const uint64_t c = stp_square_column((uint32_t)i) + (wide ? begin : 0);
            const uint64_t r = stp_square_row((uint32_t)i) + (wide ? 0 : begin);
            stp_cloud_stride(images->cloud->spill, i * STP_SQUARE_SAMPLES, STP_SQUARE_SAMPLES);
            if (c < columns && r < rows)
                STP_TRY(cut_square(l, images, image, (uint32_t)c, (uint32_t)r, err));
        }
done:
    return status;
}

/* ---- leaves ---- */

/* The extent of a square's points. */
static stp_leaf_extent measure(const stp_depth_images *images, const stp_depth_square *square,
                               const stp_point_item_params *params)
{
    stp_leaf_extent out = {stp_dbox_empty(), INT_MAX, INT_MIN};
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++) {
        if (!(square->samples >> k & 1u))
            continue;
        const uint64_t point = stp_depth_square_point(images, square, k);
        const stp_dvec3 at = images->cloud->points[point].position;
        const int exponent =
            stp_point_exponent(at, stp_depth_spacing(images, square->rays, point), params);
        stp_dbox_add(&out.box, at);
        out.finest = exponent < out.finest ? exponent : out.finest;
        out.coarsest = exponent > out.coarsest ? exponent : out.coarsest;
    }
    return out;
}

static stp_leaf_extent extent_of(const void *context, uint32_t index)
{
    return ((const stp_leaf_extent *)context)[index];
}

/* Lists the squares of this rank's images. *extents: theirs. */
static stp_status list_squares(stp_depth_images *images, const stp_point_item_params *params,
                               stp_leaf_extent **extents, stp_error *err)
{
    stp_status status = STP_OK;
    listing l = {0};
    for (size_t i = 0; i < images->pixels.count; i++)
        if (images->pixels.list[i].has_points)
            STP_TRY(cut_image(&l, images, (uint32_t)i, err));
    STP_TRY(stp_depth_squares_check(l.count, err));
    images->squares = l.squares;
    images->square_count = (uint32_t)l.count;
    l.squares = NULL;
    STP_TRY(stp_alloc(extents, images->square_count, sizeof **extents, "patches", err));
    for (uint32_t i = 0; i < images->square_count; i++) {
        stp_cloud_stride(images->cloud->spill, (uint64_t)i * STP_SQUARE_SAMPLES,
                         STP_SQUARE_SAMPLES);
        (*extents)[i] = measure(images, &images->squares[i], params);
    }
done:
    free(l.squares);
    return status;
}

/* ---- images ---- */

/* Finds the rays of all images. Those that have none, or no points, lose their pixels. */
static stp_status add_cameras(stp_depth_images *made, const struct stp_prep_source *source,
                              stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_pixel_images_create(&made->pixels, made->cloud, source, err));
    STP_TRY(stp_alloc(&made->cameras, made->pixels.count, sizeof *made->cameras, "images", err));
    for (size_t i = 0; i < made->pixels.count; i++) {
        stp_pixel_image *image = &made->pixels.list[i];
        stp_depth_camera *camera = &made->cameras[i];
        camera->first_square = made->pieces.square_count;
        if (image->has_points)
            STP_TRY(stp_depth_pieces_add(&made->pieces, made->cloud, image, &image->has_points,
                                         &camera->turned, err));
        made->image_count += image->has_points;
    }
done:
    return status;
}

/* Counts the points of the images. */
static uint64_t count_points(const stp_depth_images *made)
{
    uint64_t count = 0;
    for (size_t i = 0; i < made->pixels.count; i++) {
        const stp_pixel_image *image = &made->pixels.list[i];
        for (uint64_t k = 0; image->has_points && k < stp_pixel_count(image); k++)
            count += stp_pixel_point(image, k) != STP_PIXEL_NONE;
    }
    return count;
}

/* Marks the points that are in no image. */
static stp_status mark_loose(stp_depth_images *made, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud *cloud = made->cloud;
    STP_TRY(stp_alloc(&made->loose, cloud->count / 64 + 1, sizeof *made->loose, "marks", err));
    for (uint64_t i = 0; i < cloud->count; i++)
        made->loose[i / 64] |= UINT64_C(1) << i % 64;
    for (size_t i = 0; i < made->pixels.count; i++) {
        const stp_pixel_image *image = &made->pixels.list[i];
        for (uint64_t k = 0; image->has_points && k < stp_pixel_count(image); k++) {
            const uint64_t point = stp_pixel_point(image, k), at = point - cloud->first;
            stp_cloud_stride(cloud->spill, k, 1);
            if (point != STP_PIXEL_NONE)
                made->loose[at / 64] &= ~(UINT64_C(1) << at % 64);
        }
    }
done:
    return status;
}

uint64_t stp_depth_loose(const stp_depth_images *images, uint64_t begin, uint64_t end)
{
    uint64_t count = 0;
    for (uint64_t i = begin; images->loose_count > 0 && i < end; i++)
        count += stp_depth_is_loose(images, i);
    return count;
}

/* Measures the steps between pixels and cuts the images into leaves, all ranks' in the end. */
static stp_status make_leaves(stp_depth_images *made, const stp_cloud *cloud,
                              const stp_pixel_share *share, bool noisy,
                              const stp_point_item_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_leaf_extent *extents = NULL;
    for (size_t i = 0; noisy && i < made->pixels.count; i++)
        if (made->pixels.list[i].has_points)
            STP_TRY(stp_pixel_step_most(&made->cameras[i].step_most, made->cloud,
                                        &made->pixels.list[i], err));
    STP_TRY(list_squares(made, params, &extents, err));
    if (cloud->blocks)
        STP_TRY(stp_depth_images_share(made, &extents, share, cloud, err));
    made->cloud = cloud;
    STP_TRY(stp_leaf_cut(&made->leaves, &made->leaf_count, made->square_count, extent_of, extents,
                         err));
    STP_TRY(mark_loose(made, err));
done:
    free(extents);
    return status;
}

stp_status stp_depth_images_create(stp_depth_images *out, const stp_cloud *cloud,
                                   const struct stp_prep_source *source, bool noisy,
                                   const stp_point_item_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_pixel_share share = {0};
    stp_depth_images made = {.cloud = cloud};
    STP_TRY(stp_pixel_share_create(&share, cloud, source, err));
    made.cloud = share.seen;
    STP_TRY(add_cameras(&made, source, err));
    uint64_t counts[2] = {made.image_count, count_points(&made)};
    STP_TRY(stp_cloud_sum(cloud, counts, 2, err));
    made.image_count = (uint32_t)counts[0];
    made.loose_count = cloud->count - counts[1];
    if (made.image_count > 0 && made.loose_count <= cloud->count / LOOSE_PART)
        STP_TRY(make_leaves(&made, cloud, &share, noisy, params, err));
    if (made.leaf_count > 0 &&
        made.square_count <= (cloud->count - made.loose_count) / PATCH_LEAST) {
        *out = made;
        made = (stp_depth_images){.cloud = cloud};
    }
done:
    stp_depth_images_clear(&made);
    stp_pixel_share_clear(&share);
    return status;
}

void stp_depth_leaf_ask(const stp_depth_images *images, uint32_t leaf)
{
    const stp_leaf_run *run = &images->leaves[leaf];
    for (uint32_t i = run->begin; i < run->end; i++)
        for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++)
            if (images->squares[i].samples >> k & 1u)
                (void)stp_cloud_has(images->cloud,
                                    stp_depth_square_point(images, &images->squares[i], k));
}

void stp_depth_images_clear(stp_depth_images *images)
{
    for (size_t i = 0; images->holes && i <= images->pixels.count; i++)
        stp_holes_clear(&images->holes[i]);
    free(images->holes);
    free(images->open);
    if (images->cloud)
        stp_pixel_images_clear(&images->pixels, images->cloud);
    free(images->cameras);
    free(images->loose);
    stp_depth_pieces_clear(&images->pieces);
    free(images->squares);
    free(images->leaves);
    *images = (stp_depth_images){0};
}
