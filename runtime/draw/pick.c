/* Picking: from a pixel of level 0 to a place in the world and the sample drawn there. */
#include "runtime/draw/pick.h"

#include "base/memory.h"
#include "runtime/colour_range.h"
#include "runtime/draw/pixel_read.h"
#include "runtime/gl/gl_context.h"

#include <stdlib.h>
#include <string.h>

/* Samples are searched at most so many pixels around. */
#define REACH_LIMIT_PX 64
/* If a disc is seen more edge-on than this, the ray does not meet it. */
#define LEAST_COSINE 1e-3
/* Relative error of a depth in floats. */
#define DEPTH_TOLERANCE 1e-5

/* A pixel's two texels, as in shaders/reconstruct/pixel.glsl. */
typedef struct texels {
    GLuint shape[4], paint[4];
} texels;

/* A pixel as in shaders/reconstruct/pixel.glsl, in eye space. */
typedef struct pixel {
    stp_dvec3 normal, centre; /* of its disc */
    double radius, z_min, z_max;
    double rgb[3];
    int tag;
} pixel;

/* ---- a pixel ---- */

static double float_of(GLuint bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

/* The point that is seen at window coordinates and a depth. */
static stp_dvec3 place(const stp_gpu_frame *frame, double u, double v, double depth)
{
    double scale = (frame->modes[0] != 0 ? 1.0 : depth) / (double)frame->viewport[2];
    return (stp_dvec3){(u - (double)frame->centre[0]) * scale,
                       (v - (double)frame->centre[1]) * scale, -depth};
}

/* Unpacks the pixel at (x, y) of level 0. */
static pixel unpack(const stp_gpu_frame *frame, const texels *t, int x, int y)
{
    pixel p = {.normal = stp_direction_unpack(t->paint[0]),
               .radius = float_of(t->shape[2]),
               .z_min = float_of(t->paint[1]),
               .z_max = float_of(t->shape[3]),
               .rgb = {(t->paint[2] & 0xffffu) / 65535.0, (t->paint[2] >> 16) / 65535.0,
                       (t->paint[3] & 0xffffu) / 65535.0},
               .tag = (int)(t->paint[3] >> 16 & 511)}; /* without the mark */
    p.centre =
        place(frame, x + 0.5 + float_of(t->shape[0]), y + 0.5 + float_of(t->shape[1]), p.z_min);
    return p;
}

/* Where the ray through the centre of pixel (x, y) meets the disc's plane. Along the camera's axis,
 * no farther from the disc's centre than the interval is deep. */
static stp_dvec3 meet(const stp_gpu_frame *frame, const pixel *p, int x, int y)
{
    double extent = p->z_max - p->z_min, depth = p->z_min;
    stp_dvec3 near_point = place(frame, x + 0.5, y + 0.5, depth);
    stp_dvec3 way = frame->modes[0] != 0 ? (stp_dvec3){0.0, 0.0, -1.0}
                                         : stp_dvec3_scale(near_point, 1.0 / depth);
    double cosine = stp_dvec3_dot(p->normal, way);
    if (!stp_tag_is_tube(p->tag) && fabs(cosine) > LEAST_COSINE * stp_dvec3_length(way)) {
        double on = stp_dvec3_dot(p->normal, stp_dvec3_sub(p->centre, near_point)) / cosine;
        depth += fmin(fmax(on, -extent), extent);
    }
    return place(frame, x + 0.5, y + 0.5, depth);
}

static void read_texels(const GLuint textures[STP_TARGET_COUNT], int x, int y, texels *out)
{
    glGetTextureSubImage(textures[STP_TARGET_SHAPE], 0, x, y, 0, 1, 1, 1, GL_RGBA_INTEGER,
                         GL_UNSIGNED_INT, sizeof out->shape, out->shape);
    glGetTextureSubImage(textures[STP_TARGET_PAINT], 0, x, y, 0, 1, 1, 1, GL_RGBA_INTEGER,
                         GL_UNSIGNED_INT, sizeof out->paint, out->paint);
}

/* ---- the sample ---- */

/* The pixels around a picked pixel. */
typedef struct surrounding {
    int x, y, width, height;
    GLuint (*shape)[4], (*paint)[4];
    GLuint *sample;
} surrounding;

/* The pixels from which a pixel of this pyramid level may have its values. */
static surrounding around(const stp_pick_params *params, int source)
{
    int reach = source == 0 ? 0 : source < 5 ? 2 << source : REACH_LIMIT_PX;
    int x0 = params->x - reach, y0 = params->y - reach;
    int x1 = params->x + reach, y1 = params->y + reach;
    x0 = x0 < 0 ? 0 : x0;
    y0 = y0 < 0 ? 0 : y0;
    x1 = x1 < params->pyramid->width ? x1 : params->pyramid->width - 1;
    y1 = y1 < params->pyramid->height ? y1 : params->pyramid->height - 1;
    return (surrounding){.x = x0, .y = y0, .width = x1 - x0 + 1, .height = y1 - y0 + 1};
}

static stp_status read_surrounding(const stp_pick_params *params, surrounding *s, stp_error *err)
{
    const stp_pyramid_level *level = &params->pyramid->levels[0];
    size_t count = (size_t)s->width * (size_t)s->height;
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&s->shape, count, sizeof *s->shape, "pixels", err));
    STP_TRY(stp_alloc(&s->paint, count, sizeof *s->paint, "pixels", err));
    STP_TRY(stp_alloc(&s->sample, count, sizeof *s->sample, "pixels", err));
    glGetTextureSubImage(level->pulled[STP_TARGET_SHAPE], 0, s->x, s->y, 0, s->width, s->height, 1,
                         GL_RGBA_INTEGER, GL_UNSIGNED_INT, (GLsizei)(count * sizeof *s->shape),
                         s->shape);
    glGetTextureSubImage(level->pulled[STP_TARGET_PAINT], 0, s->x, s->y, 0, s->width, s->height, 1,
                         GL_RGBA_INTEGER, GL_UNSIGNED_INT, (GLsizei)(count * sizeof *s->paint),
                         s->paint);
    glGetTextureSubImage(params->pyramid->nearest, 0, s->x, s->y, 0, s->width, s->height, 1,
                         GL_RED_INTEGER, GL_UNSIGNED_INT, (GLsizei)(count * sizeof *s->sample),
                         s->sample);
done:
    return status;
}

static void free_surrounding(surrounding *s)
{
    free(s->shape);
    free(s->paint);
    free(s->sample);
}

/* A sample drawn, as level 0 has it: its name (UINT32_MAX: not known), and whether a segment or a
 * triangle begins with it (runtime/gl/gpu_layout.h). */
typedef struct drawn_sample {
    GLuint name;
    stp_dvec3 centre; /* eye space */
    double radius;    /* 0 if there is no sample at all */
} drawn_sample;

/* The drawn sample whose centre is nearest to a place. */
static drawn_sample nearest_sample(const stp_pick_params *params, const surrounding *s,
                                   stp_dvec3 at)
{
    double least = INFINITY;
    drawn_sample found = {.name = UINT32_MAX};
    for (int i = 0; i < s->width * s->height; i++) {
        texels t;
        memcpy(t.shape, s->shape[i], sizeof t.shape);
        memcpy(t.paint, s->paint[i], sizeof t.paint);
        pixel p = unpack(params->frame, &t, s->x + i % s->width, s->y + i / s->width);
        double distance = stp_dvec3_length(stp_dvec3_sub(p.centre, at));
        if (p.tag == 0 || !(distance < least))
            continue;
        least = distance;
        found = (drawn_sample){s->sample[i], p.centre, p.radius};
    }
    return found;
}

/* Reads item `index` of a buffer of `count` items; false if there is no such item. */
static bool read_item(const stp_lazy_buffer *buffer, GLuint index, GLuint count, void *out,
                      size_t bytes)
{
    if (index >= count)
        return false;
    stp_lazy_buffer_read(buffer, index * (uint64_t)bytes, bytes, out);
    return true;
}

/* A sample of the Object Texture, with its patch and chunk. */
typedef struct stored_sample {
    stp_sample sample;
    stp_gpu_patch patch;
    stp_gpu_chunk chunk;
} stored_sample;

static uint32_t slot_of(const stp_gpu_patch *patch)
{
    return patch->slot[0] | (uint32_t)patch->slot[1] << 8 | (uint32_t)patch->slot[2] << 16;
}

/* The step of a patch's lattice. */
static double step_of(const stp_gpu_patch *patch)
{
    return float_of((GLuint)patch->step << 23);
}

/* The number of a sample in its patch (stp_level_number). */
static uint32_t number_of(GLuint name, const stp_gpu_patch *patch)
{
    const int level = stp_name_level(name);
    return stp_level_number(stp_gpu_patch_count(patch), level) + name -
           stp_name_of(name >> STP_NAME_PATCH_SHIFT, level, 0);
}

/* Reads a sample of a patch that has been read. */
static bool read_packed(const stp_object_texture *texture, uint32_t number, stored_sample *out)
{
    uint64_t packed[STP_TEXELS_OF_PATCH + STP_TEXELS_SPARE] = {0};
    const uint64_t first = out->patch.first;
    const uint64_t end = texture->sample_ranges.capacity + UINT64_C(1) * STP_TEXELS_SPARE;
    const uint64_t most = sizeof packed / sizeof *packed;
    if (first >= texture->sample_ranges.capacity)
        return false;
    stp_lazy_buffer_read(&texture->samples, first * sizeof *packed,
                         (end - first < most ? end - first : most) * sizeof *packed, packed);
    return stp_texels_read(packed, &out->patch, number, &out->sample);
}

static bool read_sample(const stp_object_texture *texture, GLuint name, stored_sample *out)
{
    return read_item(&texture->patches, name >> STP_NAME_PATCH_SHIFT,
                     texture->patch_ranges.capacity, &out->patch, sizeof out->patch) &&
           read_item(&texture->chunks, slot_of(&out->patch), texture->slot_capacity, &out->chunk,
                     sizeof out->chunk) &&
           read_packed(texture, number_of(name, &out->patch), out);
}

static double depth_of(const stp_gpu_frame *frame, const stored_sample *s)
{
    double depth = 0.0, step = step_of(&s->patch);
    for (int i = 0; i < 3; i++)
        depth -= (double)frame->axis_back[i] *
                 ((double)s->chunk.offset[i] +
                  step * ((double)s->patch.origin[i] + s->sample.position[i]));
    return depth;
}

static unsigned corners_of(GLuint name)
{
    return name & STP_NAME_SEGMENT ? 2 : name & STP_NAME_TRIANGLE ? 3 : 1;
}

/* The depths of what a name stands for, which begins with a sample; of a grid's cell those of its
 * patch. False if a corner cannot be read. */
static bool read_depths(const stp_pick_params *params, GLuint name, GLuint sample,
                        const stored_sample *first, double depths[2])
{
    const bool square = (name & ~STP_NAME_SAMPLE) == STP_NAME_SQUARE;
    const double radius = stp_radius_decode(first->patch.bound_radius, 0) * step_of(&first->patch);
    const double about = square ? 2.0 * radius : 0.0;
    const double depth = depth_of(params->frame, first);
    depths[0] = depth - about;
    depths[1] = depth + about;
    for (unsigned i = 1; i < corners_of(name) && !square; i++) {
        stored_sample corner;
        if (!read_sample(params->texture, sample + i, &corner))
            return false;
        depths[0] = fmin(depths[0], depth_of(params->frame, &corner));
        depths[1] = fmax(depths[1], depth_of(params->frame, &corner));
    }
    return true;
}

/* Describes a sample of the Object Texture, if it is still the sample that was drawn. For a
 * segment, a triangle or the cell of a grid, describes the sample that it begins with. */
static void describe(const stp_pick_params *params, const drawn_sample *drawn, stp_pick *out)
{
    stored_sample first;
    double depths[2];
    const GLuint sample = stp_squares_sample(params->squares, drawn->name);
    if (!read_sample(params->texture, sample, &first) ||
        !read_depths(params, drawn->name, sample, &first, depths))
        return;
    const double depth = -drawn->centre.z;
    const double tolerance = DEPTH_TOLERANCE * stp_dvec3_length(drawn->centre);
    if (!(depth >= depths[0] - tolerance && depth <= depths[1] + tolerance))
        return;
    out->chunk = first.chunk.id;
    out->level = stp_name_level(sample);
    out->class_id = first.sample.class_id;
    out->intensity = first.sample.intensity / 255.0;
}

/* Moves `at` along its ray into the ball of a sample, or, if the ray misses the ball, to the point
 * of the ball nearest to the ray. A place inside the ball stays. */
static stp_dvec3 hold(const stp_gpu_frame *frame, const drawn_sample *sample, stp_dvec3 at)
{
    stp_dvec3 away = stp_dvec3_sub(at, sample->centre);
    if (stp_dvec3_length(away) <= sample->radius)
        return at;
    stp_dvec3 way = frame->modes[0] != 0 ? (stp_dvec3){0.0, 0.0, -1.0} : stp_dvec3_normalize(at);
    double along = stp_dvec3_dot(away, way);
    stp_dvec3 aside = stp_dvec3_sub(away, stp_dvec3_scale(way, along)); /* to the ray, shortest */
    double distance = stp_dvec3_length(aside), radius = sample->radius;
    if (distance >= radius)
        aside = stp_dvec3_scale(aside, distance > 0.0 ? radius / distance : 0.0);
    else
        aside = stp_dvec3_add(
            aside,
            stp_dvec3_scale(way, copysign(sqrt(radius * radius - distance * distance), along)));
    return stp_dvec3_add(sample->centre, aside);
}

/* Describes the sample nearest to `at`, and moves `at` to within the sample's radius of its centre:
 * ellipses hang over outlines, and planes of grazing ellipses come far forward. */
static stp_status find_sample(const stp_pick_params *params, stp_dvec3 *at, stp_pick *out,
                              stp_error *err)
{
    surrounding s = around(params, out->pyramid_level);
    stp_status status = read_surrounding(params, &s, err);
    if (status == STP_OK) {
        drawn_sample sample = nearest_sample(params, &s, *at);
        describe(params, &sample, out);
        if (sample.radius > 0.0) {
            *at = hold(params->frame, &sample, *at);
            out->radius = sample.radius;
        }
    }
    free_surrounding(&s);
    return status;
}

/* ---- the whole ---- */

/* The colour of a surface pixel, unlit. Elevation is looked up by the height (shade.glsl). */
static void set_colour(const stp_draw_params *drawn, const pixel *p, stp_pick *pick)
{
    const double low = drawn->colour_range[0], high = drawn->colour_range[1];
    const bool laid = drawn->shade >= STP_SHADE_LEVEL; /* an overlay, alone or mixed in */
    const double share = !laid || drawn->shade == STP_SHADE_CONFIDENCE ? 0.0 : drawn->overlay;
    const bool looked_up = drawn->colour == STP_COLOUR_ELEVATION && (!laid || drawn->overlay > 0.0);
    float own[3] = {0.0f, 0.0f, 0.0f};
    if (looked_up)
        stp_palette_colour(stp_colour_palette(drawn),
                           high > low ? (pick->position.z - low) / (high - low) : 0.0, own);
    for (int i = 0; i < 3; i++) {
        const double c = looked_up ? (1.0 - share) * (double)own[i] + share * p->rgb[i] : p->rgb[i];
        pick->rgb[i] = (uint8_t)(255.0 * c + 0.5);
    }
}

bool stp_pick_choose(const stp_pyramid *pyramid, int *x, int *y)
{
    enum { REACH = STP_PICK_REACH_PX, SIDE = 2 * REACH + 1 };
    float depths[SIDE * SIDE];
    int x0 = *x < REACH ? 0 : *x - REACH, y0 = *y < REACH ? 0 : *y - REACH;
    int x1 = *x + REACH < pyramid->width ? *x + REACH : pyramid->width - 1;
    int y1 = *y + REACH < pyramid->height ? *y + REACH : pyramid->height - 1;
    int width = x1 - x0 + 1, height = y1 - y0 + 1, found = -1;
    double least = INFINITY;
    glGetTextureSubImage(pyramid->picture_depth, 0, x0, y0, 0, width, height, 1, GL_RED, GL_FLOAT,
                         sizeof depths, depths);
    for (int i = 0; i < width * height; i++) {
        int dx = x0 + i % width - *x, dy = y0 + i / width - *y;
        double away = hypot(dx, dy);
        if (!(depths[i] > 0.0f) || away > REACH || away > least ||
            (away == least && depths[i] >= depths[found]))
            continue;
        least = away;
        found = i;
    }
    if (found < 0)
        return false;
    *x = x0 + found % width;
    *y = y0 + found / width;
    return true;
}

stp_status stp_pick_find(stp_pick *out, const stp_pick_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_pyramid_level *level = &params->pyramid->levels[0];
    stp_pick pick = {.chunk = STP_PICK_NO_CHUNK, .level = -1};
    texels t;
    read_texels(params->finished ? level->finished : level->pulled, params->x, params->y, &t);
    pixel p = unpack(params->frame, &t, params->x, params->y);
    if (p.tag != 0) {
        stp_dvec3 seen = stp_pixel_normal(params->frame, p.normal, p.tag, params->x, params->y);
        stp_dvec3 at = meet(params->frame, &p, params->x, params->y);
        pick.hit = true;
        pick.depth = p.z_min;
        pick.depth_end = p.z_max;
        pick.normal = stp_normal_to_world(params->frame, seen);
        pick.radius = p.radius;
        pick.pyramid_level = (p.tag - 1) >> 4;
        pick.interpolated = pick.pyramid_level > 0;
        STP_TRY(find_sample(params, &at, &pick, err));
        pick.radius /= stp_disc_stretch(params->frame, pick.normal);
        pick.position = stp_dvec3_add(params->eye, stp_place_to_world(params->frame, at));
        set_colour(params->drawn, &p, &pick);
    }
    STP_TRY(stp_gl_check("picking", err));
    *out = pick;
done:
    return status;
}
