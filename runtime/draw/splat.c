/* Lists splats by bins of the picture; pixels then draw them. */
#include "runtime/draw/splat.h"

#include "runtime/gl/gl_context.h"
#include "runtime/gl/gpu_layout.h"
#include "runtime/gl/shader.h"

/* The same as in shaders/splat/splat_bins.glsl and the shaders' bindings. */
#define BIN_WIDTH_PX 4
#define BIN_HEIGHT_PX 2
#define BIN_REACH_PX 8
#define HEAD_WORDS 4
#define BLOCKS_LIMIT 4096
#define GROUP_BLOCKS 64
enum { STORE_BINS = STP_STORAGE_FREE, STORE_LISTS, STORE_LOOKS };
enum { UNIT_BINS = 9, UNIFORM_SPLAT = 5, UNIFORM_SQUARES = 4 };

/* Groups of invocations in a row; a square is a group. */
#define ROW_SQUARES 1024u

/* Bytes of a word of the bins, of a splat in a list, of a splat's look. */
#define WORD_BYTES 4
#define SPLAT_BYTES 32
#define LOOK_BYTES 8

typedef struct bins_head {
    GLuint levels_used, total, unused[HEAD_WORDS - 2];
} bins_head;

stp_status stp_splat_create(stp_splat *out, bool maps, const char *folder, const char *defines,
                            stp_error *err)
{
    stp_splat s = {.bins = {.format = GL_R32UI, .texel_bytes = 4},
                   .lists = {.format = GL_RGBA32F, .texel_bytes = 16},
                   .looks = {.format = GL_RG32UI, .texel_bytes = 8}};
    stp_status status = STP_OK;
    const struct {
        GLuint *program;
        const char *vertex, *fragment, *compute;
    } programs[3] = {{&s.scan, NULL, NULL, "splat_scan.comp"},
                     {&s.fronts, "screen.vert", maps ? "map_front.frag" : "splat_front.frag", NULL},
                     {maps ? &s.list_squares : &s.blends, maps ? NULL : "screen.vert",
                      maps ? NULL : "splat_blend.frag", maps ? "map_list.comp" : NULL}};
    if (!maps)
        STP_TRY(stp_each_create(&s.list, "splat.comp", false, folder, defines, err));
    for (int i = 0; i < 3; i++)
        STP_TRY(stp_program_create(programs[i].program,
                                   &(stp_program_params){.vertex = programs[i].vertex,
                                                         .fragment = programs[i].fragment,
                                                         .compute = programs[i].compute,
                                                         .defines = defines,
                                                         .folder = folder},
                                   err));
    *out = s;
    s = (stp_splat){0};
done:
    stp_splat_destroy(&s);
    return status;
}

static void empty_store(stp_splat_store *store)
{
    if (store->buffer != 0) {
        glDeleteBuffers(1, &store->buffer);
        glDeleteTextures(1, &store->texture);
    }
    *store = (stp_splat_store){.format = store->format, .texel_bytes = store->texel_bytes};
}

void stp_splat_destroy(stp_splat *s)
{
    stp_each_destroy(&s->list);
    glDeleteProgram(s->list_squares);
    glDeleteProgram(s->scan);
    glDeleteProgram(s->fronts);
    glDeleteProgram(s->blends);
    empty_store(&s->bins);
    empty_store(&s->lists);
    empty_store(&s->looks);
    *s = (stp_splat){0};
}

/* Gives a store room for at least so many bytes; its contents are lost. */
static stp_status reserve(stp_splat_store *store, size_t bytes, stp_error *err)
{
    GLint limit = 0;
    if (bytes <= store->bytes)
        return STP_OK;
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &limit);
    if (bytes / store->texel_bytes > (size_t)limit)
        return stp_error_set(err, STP_LIMIT,
                             "splats need %zu texels, a texture of this OpenGL has %d: give a "
                             "greater --threshold or a smaller --size",
                             bytes / store->texel_bytes, limit);
    empty_store(store);
    store->bytes = bytes + bytes / 4 / SPLAT_BYTES * SPLAT_BYTES;
    glCreateBuffers(1, &store->buffer);
    glNamedBufferStorage(store->buffer, (GLsizeiptr)store->bytes, NULL, 0);
    glCreateTextures(GL_TEXTURE_BUFFER, 1, &store->texture);
    glTextureBuffer(store->texture, store->format, store->buffer);
    return stp_gl_check("making room for splats", err);
}

/* The number of bins of all levels of the grid. */
static size_t count_bins(const stp_pyramid *p)
{
    int most = p->width > p->height ? p->width : p->height;
    size_t bins = 0;
    for (int l = 0;; l++) {
        int width = BIN_WIDTH_PX << l, height = BIN_HEIGHT_PX << l;
        bins +=
            (size_t)((p->width + width - 1) / width) * (size_t)((p->height + height - 1) / height);
        if (BIN_REACH_PX << l >= most)
            return bins;
    }
}

/* Turns the counts of bins into the places where their lists begin; one invocation per block of
 * bins. */
static void scan_bins(const stp_splat *s, size_t bins)
{
    GLuint groups = BLOCKS_LIMIT / GROUP_BLOCKS;
    glUseProgram(s->scan);
    glUniform1ui(STP_UNIFORM_VERTICES, (GLuint)bins);
    for (GLuint step = 0; step < 3; step++) {
        glUniform1ui(STP_UNIFORM_SETTING, step);
        glDispatchCompute(step == 1 ? 1 : groups, 1, 1);
        glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT);
    }
}

/* What is listed: the samples in runs, or squares of maps if these are NULL. */
typedef struct listed {
    const stp_runs *runs;
    stp_range squares;
} listed;

static void visit_samples(const stp_splat *s, const listed *of, bool listing)
{
    if (of->runs != NULL) {
        stp_each_set(&s->list, STP_UNIFORM_SETTING, listing);
        stp_runs_each(of->runs, &s->list, UNIFORM_SPLAT);
    } else {
        const GLuint rows = (of->squares.count + ROW_SQUARES - 1) / ROW_SQUARES;
        glUseProgram(s->list_squares);
        glUniform1i(STP_UNIFORM_SETTING, listing);
        glUniform2ui(UNIFORM_SQUARES, of->squares.begin, of->squares.begin + of->squares.count);
        glDispatchCompute(of->squares.count < ROW_SQUARES ? of->squares.count : ROW_SQUARES, rows,
                          1);
    }
    glMemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
}

static stp_status list(stp_splat *s, const listed *of, const stp_pyramid *pyramid, stp_error *err)
{
    stp_status status = STP_OK;
    size_t bins = count_bins(pyramid);
    size_t places = of->runs != NULL
                        ? stp_runs_places(of->runs)
                        : ((size_t)of->squares.begin + of->squares.count) * STP_PATCH_SAMPLES;
    bins_head head;
    STP_TRY(reserve(&s->bins, (HEAD_WORDS + bins + BLOCKS_LIMIT) * WORD_BYTES, err));
    STP_TRY(reserve(&s->looks, (places + 1) * LOOK_BYTES, err));
    glClearNamedBufferData(s->bins.buffer, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, NULL);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, STORE_BINS, s->bins.buffer);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, STORE_LOOKS, s->looks.buffer);
    visit_samples(s, of, false);
    scan_bins(s, bins);
    glGetNamedBufferSubData(s->bins.buffer, 0, sizeof head, &head);
    s->levels_used = head.levels_used;
    STP_TRY(reserve(&s->lists, (head.total + (size_t)1) * SPLAT_BYTES, err));
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, STORE_LISTS, s->lists.buffer);
    visit_samples(s, of, true);
    STP_TRY(stp_gl_check("listing splats", err));
done:
    return status;
}

stp_status stp_splat_list(stp_splat *s, const stp_runs *runs, const stp_pyramid *pyramid,
                          stp_error *err)
{
    return list(s, &(listed){.runs = runs}, pyramid, err);
}

stp_status stp_splat_list_squares(stp_splat *s, stp_range squares, const stp_pyramid *pyramid,
                                  stp_error *err)
{
    return list(s, &(listed){.squares = squares}, pyramid, err);
}

void stp_splat_bind(const stp_splat *s, GLuint program)
{
    const GLuint textures[3] = {s->bins.texture, s->lists.texture, s->looks.texture};
    glProgramUniform1ui(program, STP_UNIFORM_SETTING, s->levels_used);
    glBindTextures(UNIT_BINS, 3, textures);
}

static void draw(const stp_splat *s, GLuint program, const stp_tiles *tiles)
{
    stp_splat_bind(s, program);
    glUseProgram(program);
    stp_tiles_draw(tiles, 0);
}

void stp_splat_draw_fronts(const stp_splat *s, const stp_tiles *tiles)
{
    draw(s, s->fronts, tiles);
}

void stp_splat_draw_blends(const stp_splat *s, const stp_pyramid *pyramid, const stp_tiles *tiles)
{
    glBindTextureUnit(STP_UNIT_FRONT, pyramid->nearest_depth);
    draw(s, s->blends, tiles);
}
