/* Lists squares of grids and maps with those beside them, and draws triangles of them. */
#include "runtime/draw/squares.h"

#include "base/memory.h"
#include "base/random.h"
#include "formats/chunk/codec/square/square.h"
#include "runtime/draw/project.h"
#include "runtime/draw/road.h"

#include <stdlib.h>
#include <string.h>

/* So many squares are listed, then drawn: few on a software driver, whose cache then holds the
 * list. */
static const GLsizei part_squares[2] = {1024, 256};

/* The same as in pieces.glsl, square.comp and square.vert. */
enum {
    SQUARE_CELLS = 81,
    SQUARE_TRIANGLES = 640,
    SQUARE_PLACES = 1105,
    PLACE_BYTES = 12,
    DRAW_BYTES = 16,
    LIST_GROUP = 8
};
static const GLuint no_quarters[4] = {0, 1, 1, 0};
enum { STORAGE_PLACES = 1, STORAGE_TRIANGLES, STORAGE_DRAWS, STORAGE_QUARTERS };
enum { UNIFORM_SQUARES = 4, UNIT_TRIANGLES = 9, UNIT_PLACES = 10 };

/* A square is beside another if it is where the other's grid goes on, to within this part of the
 * other's side: grids that are not straight bend a little from piece to piece. */
#define OFF_MOST (1.0 / 16.0)

/* Where a square is: on the map if its raster is upright, else by columns and rows. */
typedef struct stp_square_key {
    uint64_t grid;     /* the same for all squares that may be beside it */
    int64_t bucket[2]; /* of `at` */
    double at[2];      /* of its first sample */
    double step[2][2]; /* to the next square by columns, and by rows */
    uint32_t next;     /* the next of those that may share its bucket; UINT32_MAX: none */
} stp_square_key;

void stp_squares_destroy(stp_squares *s)
{
    const GLuint buffers[5] = {s->buffer, s->places, s->triangle_names, s->draws, s->quarters};
    const GLuint textures[3] = {s->texture, s->triangle_texture, s->place_texture};
    glDeleteProgram(s->list);
    glDeleteProgram(s->list_quarters);
    glDeleteProgram(s->program);
    glDeleteProgram(s->resolve);
    stp_splat_destroy(&s->splat);
    if (s->buffer != 0) {
        glDeleteTextures(3, textures);
        glDeleteBuffers(5, buffers);
    }
    free(s->records);
    free(s->keys);
    free(s->heads);
    *s = (stp_squares){0};
}

static uint64_t mix(uint64_t hash, const void *bytes, size_t size)
{
    for (size_t i = 0; i < size; i += sizeof hash) {
        uint64_t word = 0;
        memcpy(&word, (const uint8_t *)bytes + i, size - i < sizeof word ? size - i : sizeof word);
        hash = stp_random_u64(hash, word);
    }
    return hash;
}

/* Places a square on the map. */
static void place_on_map(stp_square_key *key, const stp_square *square, const stp_raster *raster,
                         stp_dvec3 origin)
{
    const double from[2] = {origin.x, origin.y};
    for (int k = 0; k < 2; k++) {
        const double *a = raster->across[k];
        key->step[0][k] = STP_SQUARE_SIDE * a[1];
        key->step[1][k] = STP_SQUARE_SIDE * a[2];
        key->at[k] =
            from[k] + a[0] + square->column * key->step[0][k] + square->row * key->step[1][k];
    }
}

/* Places a square among those of a tilted grid, by columns and rows from where the grid meets the
 * world's own axis along which its heights go. The same grid has other columns in each chunk, but
 * the same slopes, which tell it from others. */
static void place_on_tilted(stp_square_key *key, const stp_raster *raster, stp_dvec3 origin)
{
    const double from[3] = {origin.x, origin.y, origin.z};
    const double *a = raster->across[0], *b = raster->across[1];
    const double x = a[0] + from[(raster->axis + 1) % 3] - from[raster->axis] * a[3];
    const double y = b[0] + from[(raster->axis + 2) % 3] - from[raster->axis] * b[3];
    const double turn = STP_SQUARE_SIDE * (a[1] * b[2] - a[2] * b[1]);
    key->at[0] += (b[2] * x - a[2] * y) / turn;
    key->at[1] += (a[1] * y - b[1] * x) / turn;
    for (int k = 0; k < 2; k++)
        key->grid = mix(key->grid, raster->across[k] + 1, 3 * sizeof(double));
}

static stp_square_key key_of(const stp_project_params *params, uint32_t block,
                             const stp_square *square, const stp_raster *raster)
{
    const uint32_t chunk = params->scene->blocks[block].chunk;
    const stp_scene_model *model = stp_scene_find(params->scene, chunk);
    const uint64_t number = (uint64_t)(model - params->scene->models);
    const stp_dvec3 origin = stp_scene_entry(params->scene, block)->origin;
    stp_square_key key = {.at = {square->column, square->row}, .step = {{1.0, 0.0}, {0.0, 1.0}}};
    if (stp_raster_is_upright(raster) && !model->model->is_maps) {
        key.grid = number;
        place_on_map(&key, square, raster, origin);
        return key;
    }
    key.grid = mix(UINT64_MAX, &number, sizeof number);
    key.grid = mix(key.grid, &raster->axis, sizeof raster->axis);
    if (stp_raster_spreads(raster)) {
        key.grid = mix(key.grid, &chunk, sizeof chunk);
        key.grid = mix(key.grid, raster->across, sizeof raster->across);
    } else {
        place_on_tilted(&key, raster, origin);
    }
    key.grid |= UINT64_C(1) << 63; /* no model's */
    return key;
}

/* Sets how differences of places in eye space tell those of columns and rows: the inverse of the
 * square's steps, as normals come to eye space (shaders/README.md, "Exaggerated heights"). */
static void set_grid(stp_gpu_square *out, const stp_gpu_frame *frame)
{
    const float *const axes[3] = {frame->axis_right, frame->axis_up, frame->axis_back};
    const float *c = out->column, *r = out->row, turn = c[0] * r[1] - c[1] * r[0];
    const float across[2][2] = {{r[1] / turn, -r[0] / turn}, {-c[1] / turn, c[0] / turn}};
    for (int i = 0; i < 2; i++) {
        float world[3] = {0.0f, 0.0f, 0.0f}, *to = i == 0 ? out->to_column : out->to_row;
        world[out->axis] = -(across[i][0] * out->up[0] + across[i][1] * out->up[1]);
        world[(out->axis + 1) % 3] = across[i][0];
        world[(out->axis + 2) % 3] = across[i][1];
        world[2] *= frame->centre[3];
        for (int k = 0; k < 3; k++)
            to[k] = axes[k][0] * world[0] + axes[k][1] * world[1] + axes[k][2] * world[2];
    }
}

static stp_gpu_square record_of(const stp_square *square, const stp_raster *raster,
                                const stp_mirror_patch *patch, const stp_gpu_chunk *chunk,
                                const stp_model *model)
{
    const bool overlaps = model->is_maps || !stp_raster_is_upright(raster);
    stp_gpu_square out = {.step = patch->step,
                          .samples = {(uint32_t)square->samples, (uint32_t)(square->samples >> 32)},
                          .axis = raster->axis,
                          .flags = (overlaps ? STP_SQUARE_OVERLAPS : 0u) |
                                   (model->is_maps ? STP_SQUARE_OF_MAP : 0u)};
    for (int i = 0; i < 3; i++)
        out.origin[i] = patch->origin[i] + chunk->offset[i];
    /* A camera's columns and rows spread: they are taken as in the square's middle. */
    const double height = (double)patch->bound_centre[raster->axis];
    const double column = (square->column + 0.5) * STP_SQUARE_SIDE;
    const double row = (square->row + 0.5) * STP_SQUARE_SIDE;
    for (int k = 0; k < 2; k++) {
        const double *a = raster->across[k];
        out.column[k] = (float)(a[1] + height * a[4]);
        out.row[k] = (float)(a[2] + height * a[5]);
        out.up[k] = (float)(a[3] + column * a[4] + row * a[5]);
    }
    return out;
}

/* Lists the squares of one draw: those drawn as triangles, or those drawn as splats. */
static void list_draw(stp_squares *s, const stp_project_params *params, size_t draw, bool splats,
                      uint64_t *points)
{
    const stp_sight_list *list = &params->sight->lists[STP_SIGHT_SQUARES];
    const uint32_t block = params->draws[draw].block;
    const stp_resident *r =
        stp_block_cache_get(params->cache, stp_block_cache_slot(params->cache, block));
    const stp_gpu_chunk chunk =
        stp_gpu_chunk_from_draw(params->scene, &params->draws[draw], params->eye);
    const stp_model *model =
        stp_scene_find(params->scene, params->scene->blocks[block].chunk)->model;
    for (size_t i = list->begin[draw]; i < list->begin[draw + 1]; i++) {
        const uint32_t of = list->items[i] - r->placement.patches.begin;
        const stp_square *square = &r->mirror.squares[of];
        const stp_raster *raster = &r->mirror.rasters[square->raster];
        stp_gpu_square *record = &s->records[s->count];
        if ((s->maps != 0 && stp_raster_is_map(raster)) != splats)
            continue;
        *record = record_of(square, raster, &r->mirror.patches[of], &chunk, model);
        record->patch = list->items[i];
        if (splats)
            set_grid(record, params->frame);
        s->keys[s->count] = key_of(params, block, square, raster);
        *points += r->mirror.patches[of].count[0];
        s->count++;
    }
}

/* The place of a key's grid among those of the models; the last one is all others'. */
static size_t grid_place(const stp_square_key *key)
{
    return key->grid < STP_SCENE_MODELS_LIMIT ? (size_t)key->grid : STP_SCENE_MODELS_LIMIT;
}

static double side_of(const stp_square_key *key)
{
    return fmin(hypot(key->step[0][0], key->step[0][1]), hypot(key->step[1][0], key->step[1][1]));
}

/* The place of a key's bucket among the heads. */
static size_t head_of(const stp_squares *s, const stp_square_key *key)
{
    const uint64_t row = stp_random_u64(key->grid, (uint64_t)key->bucket[1]);
    return (size_t)stp_random_u64(row, (uint64_t)key->bucket[0]) & (s->head_count - 1);
}

/* Puts the squares into buckets half as wide as the least square of their grid. Gets that width by
 * grid_place. */
static void put_in_buckets(stp_squares *s, double width[STP_SCENE_MODELS_LIMIT + 1])
{
    for (size_t i = 0; i <= STP_SCENE_MODELS_LIMIT; i++)
        width[i] = INFINITY;
    for (size_t i = 0; i < s->count; i++) {
        double *of = &width[grid_place(&s->keys[i])];
        *of = fmin(*of, 0.5 * side_of(&s->keys[i]));
    }
    memset(s->heads, 0xff, s->head_count * sizeof *s->heads);
    for (size_t i = s->count; i-- > 0;) { /* a bucket lists the first square first */
        stp_square_key *key = &s->keys[i];
        for (int k = 0; k < 2; k++)
            key->bucket[k] = (int64_t)floor(key->at[k] / width[grid_place(key)]);
        uint32_t *head = &s->heads[head_of(s, key)];
        key->next = *head;
        *head = (uint32_t)i;
    }
}

/* Whether a square is beside another, to within `off`. wanted: the place and bucket of that one. */
static bool is_beside(const stp_square_key *key, const stp_square_key *of,
                      const stp_square_key *wanted, double off)
{
    return key->grid == wanted->grid && key->bucket[0] == wanted->bucket[0] &&
           key->bucket[1] == wanted->bucket[1] && fabs(key->at[0] - wanted->at[0]) <= off &&
           fabs(key->at[1] - wanted->at[1]) <= off &&
           fabs(key->step[0][0] - of->step[0][0]) <= off &&
           fabs(key->step[0][1] - of->step[0][1]) <= off;
}

/* The number of the square beside another on this side (-1, 0 or 1 by columns and by rows), or
 * UINT32_MAX. width: of a bucket. */
static uint32_t find_beside(const stp_squares *s, const stp_square_key *of, const int side[2],
                            double width)
{
    const double off = OFF_MOST * side_of(of);
    stp_square_key wanted = {.grid = of->grid};
    int64_t low[2], high[2]; /* the place may lie at the border of buckets */
    for (int k = 0; k < 2; k++) {
        wanted.at[k] = of->at[k] + side[0] * of->step[0][k] + side[1] * of->step[1][k];
        low[k] = (int64_t)floor((wanted.at[k] - off) / width);
        high[k] = (int64_t)floor((wanted.at[k] + off) / width);
    }
    for (wanted.bucket[1] = low[1]; wanted.bucket[1] <= high[1]; wanted.bucket[1]++)
        for (wanted.bucket[0] = low[0]; wanted.bucket[0] <= high[0]; wanted.bucket[0]++)
            for (uint32_t i = s->heads[head_of(s, &wanted)]; i != UINT32_MAX; i = s->keys[i].next)
                if (is_beside(&s->keys[i], of, &wanted, off))
                    return i;
    return UINT32_MAX;
}

/* Sets the squares beside each square. What one square says of another, the other says of it, so
 * they share the cells between them. */
static void link_squares(stp_squares *s)
{
    static const int sides[4][2] = {{1, 0}, {-1, 1}, {0, 1}, {1, 1}}; /* words 4 to 7 */
    double width[STP_SCENE_MODELS_LIMIT + 1];
    put_in_buckets(s, width);
    for (size_t i = 0; i < s->count; i++)
        memset(s->records[i].beside, 0xff, sizeof s->records[i].beside);
    for (size_t i = 0; i < s->count; i++)
        for (int k = 0; k < 4; k++) {
            const stp_square_key *of = &s->keys[i];
            const uint32_t found = find_beside(s, of, sides[k], width[grid_place(of)]);
            if (found == UINT32_MAX)
                continue;
            s->records[i].beside[4 + k] = found;
            s->records[found].beside[3 - k] = (uint32_t)i;
        }
}

/* Makes room for so many squares. */
static stp_status reserve(stp_squares *s, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_grow(&s->records, &s->capacity, count, sizeof *s->records, "squares", err));
    STP_TRY(stp_grow(&s->keys, &s->key_capacity, count, sizeof *s->keys, "squares", err));
    for (s->head_count = 16; s->head_count < count; s->head_count *= 2)
        ;
    STP_TRY(
        stp_grow(&s->heads, &s->head_capacity, s->head_count, sizeof *s->heads, "squares", err));
done:
    return status;
}

/* Makes a buffer that a texture shows; format 0: none does. */
static void create_list(GLuint *buffer, GLuint *texture, GLsizeiptr bytes, GLenum format)
{
    glCreateBuffers(1, buffer);
    glNamedBufferStorage(*buffer, bytes, NULL, GL_DYNAMIC_STORAGE_BIT);
    if (format != 0) {
        glCreateTextures(GL_TEXTURE_BUFFER, 1, texture);
        glTextureBuffer(*texture, format, *buffer);
    }
}

/* Makes the buffers for what square.comp lists. */
static void create_lists(stp_squares *s)
{
    const GLsizeiptr squares = part_squares[stp_road_is_software()];
    create_list(&s->places, &s->place_texture, squares * SQUARE_PLACES * PLACE_BYTES, GL_RGB32F);
    create_list(&s->triangle_names, &s->triangle_texture, squares * SQUARE_TRIANGLES * 4, GL_R32UI);
    create_list(&s->draws, NULL, squares * DRAW_BYTES, 0);
    create_list(&s->quarters, NULL, (GLsizeiptr)sizeof no_quarters + squares * SQUARE_CELLS * 4, 0);
}

static void upload(stp_squares *s)
{
    if (s->buffer == 0) {
        glCreateBuffers(1, &s->buffer);
        glCreateTextures(GL_TEXTURE_BUFFER, 1, &s->texture);
        create_lists(s);
    }
    glNamedBufferData(s->buffer, (GLsizeiptr)(s->count * sizeof *s->records), s->records,
                      GL_STREAM_DRAW);
    glTextureBuffer(s->texture, GL_RGBA32UI, s->buffer);
    glBindTextureUnit(STP_UNIT_SQUARES, s->texture);
}

stp_status stp_squares_list(stp_squares *s, const stp_project_params *params, uint64_t *points,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const size_t count = params->sight->lists[STP_SIGHT_SQUARES].begin[params->draw_count];
    s->count = 0;
    if (count > STP_NAMED_SQUARES_LIMIT)
        return stp_error_set(err, STP_LIMIT,
                             "%zu squares of grids or maps are too many to be drawn as such: draw "
                             "grids and maps as points",
                             count);
    STP_TRY(reserve(s, count, err));
    for (size_t i = 0; i < params->draw_count; i++)
        list_draw(s, params, i, false, points);
    s->triangles = s->count;
    for (size_t i = 0; i < params->draw_count && s->maps != 0; i++)
        list_draw(s, params, i, true, points);
    link_squares(s);
    upload(s);
done:
    return status;
}

void stp_squares_draw(const stp_squares *s, const stp_project_params *params)
{
    const size_t most = (size_t)part_squares[stp_road_is_software()];
    glProgramUniform1i(s->program, STP_UNIFORM_SCATTERED, params->lod == STP_LOD_COMPUTE);
    const GLuint lists[4] = {s->places, s->triangle_names, s->draws, s->quarters};
    const GLuint programs[3] = {s->list, s->list_quarters, s->program};
    glBindVertexArray(stp_block_cache_texture(params->cache)->empty_array);
    glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, STORAGE_PLACES, 4, lists);
    glBindTextureUnit(UNIT_TRIANGLES, s->triangle_texture);
    glBindTextureUnit(UNIT_PLACES, s->place_texture);
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, s->draws);
    glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, s->quarters);
    for (size_t i = 0; i < s->triangles; i += most) {
        const size_t count = s->triangles - i < most ? s->triangles - i : most;
        for (int k = 0; k < 3; k++)
            glProgramUniform2ui(programs[k], UNIFORM_SQUARES, (GLuint)i, (GLuint)count);
        glNamedBufferSubData(s->quarters, 0, sizeof no_quarters, no_quarters);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT); /* the last part is drawn */
        glUseProgram(s->list);
        glDispatchCompute(((GLuint)count + LIST_GROUP - 1) / LIST_GROUP, 1, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT);
        glUseProgram(s->list_quarters);
        glDispatchComputeIndirect(0);
        glMemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_COMMAND_BARRIER_BIT |
                        GL_BUFFER_UPDATE_BARRIER_BIT);
        glUseProgram(s->program);
        glMultiDrawArraysIndirect(GL_TRIANGLES, NULL, (GLsizei)count, 0);
    }
}

GLuint stp_squares_sample(const stp_squares *s, GLuint name)
{
    const GLuint number = (name & STP_NAME_SAMPLE) >> STP_NAME_SQUARE_SHIFT;
    if ((name & ~STP_NAME_SAMPLE) != STP_NAME_SQUARE)
        return name & STP_NAME_SAMPLE;
    if (number >= s->count)
        return UINT32_MAX;
    const stp_gpu_square *square = &s->records[number];
    const uint64_t samples = square->samples[0] | (uint64_t)square->samples[1] << 32;
    const uint64_t before = (UINT64_C(1) << (name >> STP_NAME_PLACE_SHIFT & 63u)) - 1;
    return stp_name_of(square->patch, 0, (uint32_t)__builtin_popcountll(samples & before));
}
