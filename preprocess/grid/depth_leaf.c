/* Makes leaf chunks of depth images. */
#include "base/memory.h"
#include "base/sort.h"
#include "formats/chunk/block/block_cut.h"
#include "formats/chunk/codec/square/square.h"
#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/grid/depth_holes.h"
#include "preprocess/grid/depth_normals.h"
#include "preprocess/patch/partition.h"
#include "preprocess/surface/normal_error.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

/* Of noise with deviation 1: the mean of how far four pixels are off a plane. */
#define MEAN_OFF 1.596

/* A block has the patches of so many times so many squares, and of as many beside them if it has so
 * many patches: what is common to it, such as its rasters and its ladder, and what its odds must
 * learn takes as much as hundreds of samples. They stand in Morton order, so those of larger blocks
 * could be too far apart (square_map.c). */
#define BLOCK_SIDE 16u
#define BLOCK_WIDTH 32u
#define PATCHES_TO_WIDEN 64u

typedef struct making {
    const stp_depth_images *images;
    const stp_point_item_params *params;
    const stp_depth_square *squares; /* of the leaf */
    stp_item *items;
    uint64_t *points;      /* by item */
    uint32_t *order;       /* of squares: those that lie together follow each other */
    uint32_t *ends;        /* of the squares' items */
    uint32_t *together;    /* ends, among the squares, of those that lie together */
    uint32_t *blocks;      /* ends, among the samples, of blocks */
    stp_patch_grid *grids; /* by square, in order */
    stp_dvec3 *merged;     /* by square, in order: room for merged normals */
    double *angles;        /* room for those between neighbouring normals */
    uint32_t square_count, count, together_count, block_count;
} making;

/* The middle of a patch, as its camera sees it, and its mean normal. */
static stp_place place_of(const making *m, const stp_depth_square *square)
{
    const stp_depth_images *images = m->images;
    stp_dvec3 middle = {0.0, 0.0, 0.0}, normal = {0.0, 0.0, 0.0};
    double area = 0.0, count = 0.0;
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++) {
        if (!(square->samples >> k & 1u))
            continue;
        const uint64_t point = stp_depth_square_point(images, square, k);
        const stp_dvec3 at = stp_depth_view(images, square->rays, point);
        const double spacing = stp_depth_spacing(images, square->rays, point) / exp(at.z);
        middle = stp_dvec3_add(middle, at);
        normal =
            stp_dvec3_add(normal, stp_dvec3_from_float(stp_cloud_normal(images->cloud, point)));
        area += spacing * spacing;
        count += 1.0;
    }
    middle = stp_dvec3_scale(middle, 1.0 / count);
    normal = stp_dvec3_normalize(normal);
    const double key[6] = {middle.x, middle.y, middle.z, normal.x, normal.y, normal.z};
    stp_place out = {.spacing = (float)sqrt(area)};
    for (int i = 0; i < 6; i++)
        out.key[i] = (float)key[i];
    return out;
}

/* Whether two squares are in the same so many times so many squares of an image. */
static bool is_near(const stp_depth_square *a, const stp_depth_square *b, uint32_t columns,
                    uint32_t rows)
{
    return a->image == b->image && a->column / columns == b->column / columns &&
           a->row / rows == b->row / rows;
}

/* Finds which patches lie together: in 8 x 8 squares, which blocks need, and on one surface. */
static stp_status order_squares(making *m, stp_error *err)
{
    stp_status status = STP_OK;
    stp_place *places = NULL;
    uint64_t *scratch = NULL;
    STP_TRY(stp_alloc(&places, m->square_count, sizeof *places, "patches", err));
    STP_TRY(stp_alloc(&scratch, m->square_count, sizeof *scratch, "patches", err));
    for (uint32_t begin = 0, end = 0; begin < m->square_count; begin = end) {
        for (; end < m->square_count &&
               is_near(&m->squares[begin], &m->squares[end], STP_SQUARE_SIDE, STP_SQUARE_SIDE);
             end++)
            places[end - begin] = place_of(m, &m->squares[end]);
        uint32_t *order = m->order + begin, *together = m->together + m->together_count;
        const uint32_t runs =
            stp_partition(places, end - begin, STP_PATCH_SAMPLES, order, scratch, together);
        for (uint32_t i = begin; i < end; i++)
            m->order[i] += begin;
        for (uint32_t i = 0; i < runs; i++)
            together[i] += begin;
        m->together_count += runs;
    }
done:
    free(places);
    free(scratch);
    return status;
}

/* Moves a sample to where its ray has a depth that its patch's lattice has, which a chunk need not
 * store, if it is then as near to the point as it must be. */
static void move_to_ray(const making *m, const stp_depth_square *square, unsigned sample,
                        int exponent, stp_item *item)
{
    const stp_depth_rays *rays = &m->images->pieces.rays[square->rays];
    const bool turned = m->images->cameras[square->image].turned;
    const stp_resolution *resolution = &m->params->resolution;
    const double column = square->column * STP_SQUARE_SIDE + stp_square_column(sample);
    const double row = square->row * STP_SQUARE_SIDE + stp_square_row(sample);
    const double step = ldexp(1.0, exponent);
    const stp_dvec3 s = rays->station, p = item->disc.centre;
    const double station[3] = {s.x, s.y, s.z}, read[3] = {p.x, p.y, p.z};
    const double limit =
        resolution->precision > 0.0 ? resolution->precision : sqrt(item->area) / STP_SPACING_PARTS;
    double at[3], squared = 0.0;
    at[rays->axis] = nearbyint(read[rays->axis] / step) * step;
    for (unsigned k = 0; k < 2; k++) {
        const unsigned i = (rays->axis + 1 + k) % 3;
        const double *t = rays->tilt[k];
        const double tangent =
            t[0] + (turned ? row * t[1] + column * t[2] : column * t[1] + row * t[2]);
        at[i] = station[i] + (at[rays->axis] - station[rays->axis]) * tangent;
    }
    for (int i = 0; i < 3; i++) {
        const double off = nearbyint(at[i] / step) * step - read[i];
        squared += off * off;
    }
    if (!resolution->exact && squared <= limit * limit)
        item->disc.centre = (stp_dvec3){at[0], at[1], at[2]};
}

/* What the pixels of squares tell of their noise. */
typedef struct pixel_noise {
    unsigned normal_bits;
    double depth; /* standard deviation */
} pixel_noise;

/* The angle between the normals of neighbours in a square's patch, right and below. Returns how
 * many were added. */
static uint32_t add_angles(const making *m, const stp_depth_square *square, double *out)
{
    const stp_cloud *cloud = m->images->cloud;
    uint32_t count = 0;
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++) {
        const uint32_t c = stp_square_column(k), r = stp_square_row(k);
        for (unsigned i = 0; i < 2; i++) {
            const unsigned next = stp_square_morton(c + 1 - i, r + i);
            if (c + 1 - i == STP_SQUARE_SIDE || r + i == STP_SQUARE_SIDE ||
                !(square->samples >> k & square->samples >> next & 1u))
                continue;
            const vec3s a = stp_cloud_normal(cloud, stp_depth_square_point(m->images, square, k));
            const vec3s b =
                stp_cloud_normal(cloud, stp_depth_square_point(m->images, square, next));
            out[count++] = (double)glms_vec3_norm(glms_vec3_sub(a, b));
        }
    }
    return count;
}

/* Adds up how far four pixels are off a plane in inverse depth, as depths. */
static double off_planes(const making *m, const stp_depth_square *square, uint32_t *count)
{
    double sum = 0.0;
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k += 4) {
        double inverse[4], mean = 0.0;
        if ((square->samples >> k & 15u) != 15u)
            continue;
        for (unsigned i = 0; i < 4; i++) {
            double seen[3];
            const uint64_t point = stp_depth_square_point(m->images, square, k + i);
            stp_depth_see(&m->images->pieces.rays[square->rays],
                          m->images->cloud->points[point].position, seen);
            inverse[i] = 1.0 / seen[0];
            mean += 0.25 * inverse[i];
        }
        sum += fabs(inverse[0] - inverse[1] - inverse[2] + inverse[3]) / (mean * mean);
        (*count)++;
    }
    return sum;
}

static pixel_noise measure_noise(const making *m, uint32_t begin, uint32_t end)
{
    uint32_t angles = 0, planes = 0;
    double off = 0.0;
    pixel_noise out = {.normal_bits = m->params->normal_bits};
    for (uint32_t i = begin; i < end; i++) {
        const stp_depth_square *square = &m->squares[m->order[i]];
        off += off_planes(m, square, &planes);
        angles += add_angles(m, square, m->angles + angles);
    }
    out.depth = planes > 0 ? off / (MEAN_OFF * planes) : 0.0;
    if (angles == 0)
        return out;
    stp_sort_doubles(m->angles, angles);
    const unsigned bits = stp_normal_bits_for(m->angles[angles / 2], false);
    if (bits < out.normal_bits)
        out.normal_bits = bits > m->images->least_bits ? bits : m->images->least_bits;
    return out;
}

/* Whether the leaf is the whole model, which is one block. */
static bool is_alone(const making *m)
{
    return m->images->leaf_count == 1 && m->images->loose_count == 0;
}

/* The last of the runs of squares, from one on, that become a block, unless they have few samples.
 * There normals have one grid. */
static uint32_t block_end(const making *m, uint32_t run, uint32_t begin)
{
    const uint32_t least = stp_block_samples_least(STP_CODEC_DRACO);
    const stp_depth_square *first = &m->squares[m->order[begin]];
    uint32_t samples = 0;
    if (is_alone(m))
        return m->together_count - 1;
    for (uint32_t i = begin;; i++) {
        samples += (uint32_t)__builtin_popcountll(m->squares[m->order[i]].samples);
        if (i + 1 < m->together[run])
            continue;
        if (run + 1 == m->together_count)
            return run;
        const stp_depth_square *next = &m->squares[m->order[i + 1]];
        const uint32_t width = i + 1 - begin < PATCHES_TO_WIDEN ? BLOCK_SIDE : BLOCK_WIDTH;
        if (samples >= least && !is_near(first, next, width, BLOCK_SIDE))
            return run;
        run++;
    }
}

static void add_square(making *m, uint32_t index, const pixel_noise *noise)
{
    stp_point_item_params params = *m->params;
    const stp_depth_square *square = &m->squares[m->order[index]];
    const uint32_t first = m->count;
    int finest = INT_MAX;
    params.normal_bits = noise->normal_bits;
    params.normal_step = stp_normal_bits_step(noise->normal_bits);
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++) {
        if (!(square->samples >> k & 1u))
            continue;
        const uint64_t point = stp_depth_square_point(m->images, square, k);
        stp_item *item = &m->items[m->count];
        m->points[m->count++] = point;
        *item = stp_point_item_of(m->images->cloud, point,
                                  stp_depth_spacing(m->images, square->rays, point), &params);
        stp_normal_code_side(item->normal, m->images->cloud->points[point].given == STP_GIVEN_INPUT
                                               ? params.given_bits
                                               : params.normal_bits);
        finest = item->exponent < finest ? item->exponent : finest;
    }
    m->ends[index] = m->count;
    const stp_depth_rays *rays = &m->images->pieces.rays[square->rays];
    m->grids[index] = (stp_patch_grid){.along = {rays->axis == 0, rays->axis == 1, rays->axis == 2},
                                       .merged_bits = stp_merged_bits(noise->normal_bits),
                                       .noise = noise->depth,
                                       .spreads = true,
                                       .station = rays->station};
    for (unsigned k = 0, i = first; k < STP_SQUARE_SAMPLES; k++)
        if (square->samples >> k & 1u)
            move_to_ray(m, square, k, finest, &m->items[i++]);
}

static stp_status cut_blocks(const making *m, stp_chunk *chunk, stp_error *err)
{
    if (is_alone(m))
        return STP_OK;
    const stp_status status =
        stp_alloc(&chunk->block_ends, m->block_count, sizeof *chunk->block_ends, "blocks", err);
    for (uint32_t p = 1; status == STP_OK && p <= chunk->patch_count; p++)
        if (chunk->level_begin[0][p] == m->blocks[chunk->block_count])
            chunk->block_ends[chunk->block_count++] = p;
    return status;
}

/* Lets the normals of a block follow from merged ones, if they are so noisy that those are told as
 * finely, and the file does not bring them. */
static stp_status derive_normals(const making *m, uint32_t begin, uint32_t end,
                                 const pixel_noise *noise, stp_error *err)
{
    const stp_depth_block block = {.cloud = m->images->cloud,
                                   .squares = m->squares,
                                   .order = m->order,
                                   .begin = begin,
                                   .end = end,
                                   .ends = m->ends,
                                   .points = m->points,
                                   .items = m->items,
                                   .grids = m->grids,
                                   .merged = m->merged,
                                   .bits = noise->normal_bits,
                                   .merged_bits = stp_merged_bits(noise->normal_bits)};
    if (m->images->least_bits >= m->params->normal_bits || block.merged_bits <= block.bits)
        return STP_OK;
    for (uint32_t i = begin > 0 ? m->ends[begin - 1] : 0; i < m->count; i++) {
        const stp_cloud_point *point = &m->images->cloud->points[m->points[i]];
        if (point->given == STP_GIVEN_INPUT || !stp_has_normal(point))
            return STP_OK;
    }
    return stp_depth_normals_derive(&block, err);
}

/* Makes discs of a square as wide as their stored normals ask for, which the codec expects. */
static void fit_radii(const making *m, uint32_t index)
{
    const stp_cloud *cloud = m->images->cloud;
    const stp_depth_square *square = &m->squares[m->order[index]];
    const stp_dvec3 station = m->images->pieces.rays[square->rays].station;
    for (uint32_t i = index > 0 ? m->ends[index - 1] : 0; i < m->ends[index]; i++) {
        stp_item *item = &m->items[i];
        const uint64_t point = m->points[i];
        if (!stp_has_normal(&cloud->points[point]) || m->params->resolution.exact)
            continue;
        const stp_dvec3 ray =
            stp_dvec3_normalize(stp_dvec3_sub(cloud->points[point].position, station));
        const stp_dvec3 own = stp_dvec3_from_float(stp_cloud_normal(cloud, point));
        const stp_dvec3 stored = stp_dvec3_from_float(stp_normal_decode(item->normal));
        const double was = stp_stretch(stp_dvec3_dot(own, ray));
        item->disc.radius *= sqrt(stp_stretch(stp_dvec3_dot(stored, ray)) / was);
        item->disc.reach = item->disc.bound = item->disc.radius;
    }
}

/* The raster of a piece in a chunk. All follow from floats, as those of a camera do in a file. */
static stp_raster raster_of(const stp_depth_rays *rays, bool turned, stp_dvec3 origin)
{
    const stp_dvec3 way = stp_dvec3_sub(rays->station, origin);
    const double from[3] = {way.x, way.y, way.z};
    stp_raster out = {.stops = true,
                      .axis = rays->axis,
                      .first = {rays->first[turned ? 1 : 0], rays->first[turned ? 0 : 1]},
                      .side = rays->side};
    for (unsigned k = 0; k < 2; k++) {
        const double *t = rays->tilt[k];
        const float tilt[3] = {(float)t[0], (float)t[turned ? 2 : 1], (float)t[turned ? 1 : 2]};
        for (int i = 0; i < 3; i++) {
            out.across[k][i] = (double)(float)(0.0 - from[rays->axis] * (double)tilt[i]);
            out.across[k][3 + i] = (double)tilt[i];
        }
        out.across[k][0] = from[(rays->axis + 1 + k) % 3] - from[rays->axis] * (double)tilt[0];
    }
    return out;
}

/* Adds the rasters of the leaf's pieces. Squares of a piece do not always follow each other. */
static stp_status add_rasters(const making *m, stp_built_chunk *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = out->chunk;
    const size_t bits = m->images->pieces.count / 64 + 1;
    uint64_t *listed = NULL;
    STP_TRY(stp_alloc(&listed, bits, sizeof *listed, "rasters", err));
    STP_TRY(stp_alloc(&chunk->rasters, m->square_count, sizeof *chunk->rasters, "rasters", err));
    for (uint32_t i = 0; i < m->square_count; i++) {
        const stp_depth_square *square = &m->squares[i];
        const uint32_t rays = square->rays;
        if (listed[rays / 64] >> rays % 64 & 1u)
            continue;
        listed[rays / 64] |= UINT64_C(1) << rays % 64;
        chunk->rasters[chunk->raster_count++] = raster_of(
            &m->images->pieces.rays[rays], m->images->cameras[square->image].turned, out->origin);
    }
    chunk->reach = 1;
done:
    free(listed);
    return status;
}

/* How far stored samples are from the points: items were moved. Samples stand in their order. */
static void measure_displacement(const making *m, stp_built_chunk *out)
{
    const stp_cloud *cloud = m->images->cloud;
    const stp_chunk *chunk = out->chunk;
    uint32_t i = 0;
    out->displacement = (stp_displacement){0};
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (; i < chunk->level_begin[0][p + 1]; i++) {
            stp_item item = m->items[i];
            item.disc.centre = cloud->points[m->points[i]].position;
            stp_displacement_add(
                &out->displacement, &item,
                stp_dvec3_add(out->origin,
                              stp_sample_position(&chunk->samples[0][i], &chunk->patches[p])),
                &m->params->resolution);
        }
}

stp_status stp_depth_leaf_build(const stp_depth_images *images, uint32_t leaf,
                                const stp_point_item_params *params, stp_built_chunk *out,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const stp_leaf_run *run = &images->leaves[leaf];
    making m = {.images = images,
                .params = params,
                .squares = images->squares + run->begin,
                .square_count = run->end - run->begin};
    STP_TRY(stp_alloc(&m.items, (size_t)m.square_count * STP_SQUARE_SAMPLES, sizeof *m.items,
                      "samples", err));
    STP_TRY(stp_alloc(&m.points, (size_t)m.square_count * STP_SQUARE_SAMPLES, sizeof *m.points,
                      "samples", err));
    STP_TRY(stp_alloc(&m.order, m.square_count, sizeof *m.order, "patches", err));
    STP_TRY(stp_alloc(&m.ends, m.square_count, sizeof *m.ends, "patches", err));
    STP_TRY(stp_alloc(&m.together, m.square_count, sizeof *m.together, "patches", err));
    STP_TRY(stp_alloc(&m.blocks, m.square_count, sizeof *m.blocks, "blocks", err));
    STP_TRY(stp_alloc(&m.grids, m.square_count, sizeof *m.grids, "patches", err));
    STP_TRY(stp_alloc(&m.merged, (size_t)m.square_count * STP_DEPTH_MERGED, sizeof *m.merged,
                      "normals", err));
    STP_TRY(stp_alloc(&m.angles, (size_t)2 * m.square_count * STP_SQUARE_SAMPLES, sizeof *m.angles,
                      "samples", err));
    STP_TRY(order_squares(&m, err));
    for (uint32_t r = 0, begin = 0; begin < m.square_count; begin = m.together[r++]) {
        r = block_end(&m, r, begin);
        const pixel_noise noise = measure_noise(&m, begin, m.together[r]);
        for (uint32_t i = begin; i < m.together[r]; i++)
            add_square(&m, i, &noise);
        STP_TRY(derive_normals(&m, begin, m.together[r], &noise, err));
        for (uint32_t i = begin; i < m.together[r]; i++)
            fit_radii(&m, i);
        m.blocks[m.block_count++] = m.count;
    }
    for (uint32_t i = 0, begin = 0; i < m.square_count; begin = m.ends[i++])
        stp_depth_keep_open(images, m.squares[m.order[i]].image, m.items + begin,
                            m.ends[i] - begin);
    const stp_item_group group = {.items = m.items,
                                  .run_ends = m.ends,
                                  .together_ends = m.together,
                                  .run_grids = m.grids,
                                  .holes = images->holes,
                                  .count = m.count,
                                  .run_count = m.square_count,
                                  .together_count = m.together_count};
    STP_TRY(stp_chunk_build_leaf(out, &group, params, err));
    STP_TRY(cut_blocks(&m, out->chunk, err));
    measure_displacement(&m, out);
    STP_TRY(add_rasters(&m, out, err));
done:
    free(m.items);
    free(m.points);
    free(m.order);
    free(m.ends);
    free(m.together);
    free(m.blocks);
    free(m.grids);
    free(m.merged);
    free(m.angles);
    return status;
}
