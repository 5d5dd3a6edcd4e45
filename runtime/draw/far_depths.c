/* Reduces the depths of a finished picture, level by level, to one for each cell. */
#include "runtime/draw/far_depths.h"

#include "runtime/gl/gl_context.h"

#include <string.h>

static int cells_across(int px)
{
    return (px + STP_OCCLUSION_CELL_PX - 1) / STP_OCCLUSION_CELL_PX;
}

static void destroy_textures(stp_far_depths *f)
{
    stp_far_depths_forget(f);
    glDeleteTextures(STP_PYRAMID_LEVELS_LIMIT, f->textures);
    glDeleteBuffers(1, &f->buffer);
    memset(f->textures, 0, sizeof f->textures);
    f->buffer = 0;
    f->width = f->height = 0;
}

static stp_status resize(stp_far_depths *f, const stp_pyramid *p, stp_error *err)
{
    if (f->width == p->width && f->height == p->height)
        return STP_OK;
    destroy_textures(f);
    for (int l = 0; l <= p->level_count; l++) {
        int width = l == 0 ? cells_across(p->width) : p->levels[l].width;
        int height = l == 0 ? cells_across(p->height) : p->levels[l].height;
        glCreateTextures(GL_TEXTURE_2D, 1, &f->textures[l]);
        glTextureStorage2D(f->textures[l], 1, l == 0 ? GL_R32F : GL_RG32F, width, height);
        glTextureParameteri(f->textures[l], GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTextureParameteri(f->textures[l], GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    }
    glCreateBuffers(1, &f->buffer);
    glNamedBufferStorage(
        f->buffer, (GLsizeiptr)sizeof(float) * cells_across(p->width) * cells_across(p->height),
        NULL, 0);
    stp_status status = stp_gl_check("making room for depths", err);
    if (status != STP_OK) {
        destroy_textures(f);
        return status;
    }
    f->width = p->width;
    f->height = p->height;
    return STP_OK;
}

static stp_status prepare(stp_far_depths *f, const stp_variant *variant, const char *folder,
                          stp_error *err)
{
    static const char *const files[2] = {"far.comp", "far_cells.comp"};
    GLuint *const programs[2] = {&f->level, &f->cells};
    char defines[STP_VARIANT_DEFINES_BYTES];
    stp_status status = STP_OK;
    stp_variant_defines(variant, defines);
    for (int i = 0; i < 2 && status == STP_OK; i++)
        if (*programs[i] == 0)
            status = stp_program_create(
                programs[i],
                &(stp_program_params){.compute = files[i], .defines = defines, .folder = folder},
                err);
    return status;
}

/* Runs the program in use on a level of so many pixels or cells, of which an invocation makes
 * side x side. */
static void run(int width, int height, int side)
{
    const int across = 8 * side;
    glDispatchCompute((GLuint)((width + across - 1) / across),
                      (GLuint)((height + across - 1) / across), 1);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
}

static const GLuint *finished(const stp_pyramid *p, int l, int levels)
{
    return l == levels ? p->levels[l].pulled : stp_pyramid_finished(p, l);
}

/* Finds the depths of a level by those of the next; none if it is the last. */
static void look_at_level(const stp_far_depths *f, const stp_pyramid *p, int l, int levels)
{
    const stp_pyramid_level *level = &p->levels[l];
    const bool top = l == levels;
    glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, l);
    glUniform2i(STP_UNIFORM_LEVEL_SIZE, level->width, level->height);
    glUniform2i(STP_UNIFORM_READ_SIZE, top ? 0 : p->levels[l + 1].width,
                top ? 0 : p->levels[l + 1].height);
    glBindImageTextures(STP_UNIT_FINE, STP_TARGET_COUNT, finished(p, l, levels));
    glBindImageTextures(STP_UNIT_COARSE, STP_TARGET_COUNT, finished(p, top ? l : l + 1, levels));
    glBindImageTexture(0, f->textures[l], 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32F);
    glBindImageTexture(1, f->textures[top ? l : l + 1], 0, GL_FALSE, 0, GL_READ_ONLY, GL_RG32F);
    run(level->width, level->height, 2);
}

static void look_at_cells(const stp_far_depths *f, const stp_pyramid *p, int levels)
{
    const int above = levels > 0 ? 1 : 0;
    glUniform1i(STP_UNIFORM_PYRAMID_LEVEL, levels);
    glUniform2i(STP_UNIFORM_LEVEL_SIZE, p->width, p->height);
    glUniform2i(STP_UNIFORM_READ_SIZE, p->levels[above].width, p->levels[above].height);
    glBindImageTexture(0, f->textures[0], 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    glBindImageTexture(1, f->textures[1], 0, GL_FALSE, 0, GL_READ_ONLY, GL_RG32F);
    glBindImageTexture(2, p->picture_depth, 0, GL_FALSE, 0, GL_READ_ONLY, GL_R32F);
    run(cells_across(p->width), cells_across(p->height), 1);
}

stp_status stp_far_depths_begin(stp_far_depths *f, const stp_pyramid *p, int levels,
                                const stp_gpu_frame *frame, stp_dvec3 eye,
                                const stp_variant *variant, const char *folder, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(resize(f, p, err));
    STP_TRY(prepare(f, variant, folder, err));
    stp_far_depths_forget(f);
    glMemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT); /* for what was rasterised */
    glUseProgram(f->level);
    for (int l = levels; l > 0; l--)
        look_at_level(f, p, l, levels);
    glUseProgram(f->cells);
    look_at_cells(f, p, levels);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, f->buffer);
    glGetTextureImage(f->textures[0], 0, GL_RED, GL_FLOAT,
                      (GLsizei)sizeof(float) * cells_across(p->width) * cells_across(p->height),
                      NULL);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    f->fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
    f->frame = *frame;
    f->eye = eye;
    status = stp_gl_check("reading the depths of a picture", err);
done:
    return status;
}

stp_status stp_far_depths_take(stp_far_depths *f, bool waits, stp_occlusion *out, bool *taken,
                               stp_error *err)
{
    stp_status status = STP_OK;
    *taken = false;
    if (f->fence == NULL)
        return STP_OK;
    GLenum state =
        glClientWaitSync(f->fence, waits ? GL_SYNC_FLUSH_COMMANDS_BIT : 0, waits ? UINT64_MAX : 0);
    if (state != GL_ALREADY_SIGNALED && state != GL_CONDITION_SATISFIED)
        return STP_OK;
    stp_far_depths_forget(f);
    STP_TRY(stp_occlusion_open(out, &f->frame, f->eye, err));
    glGetNamedBufferSubData(
        f->buffer, 0, (GLsizeiptr)sizeof(float) * out->levels[0].columns * out->levels[0].rows,
        out->far);
    stp_occlusion_close(out);
    *taken = true;
done:
    return status;
}

void stp_far_depths_forget(stp_far_depths *f)
{
    if (f->fence != NULL)
        glDeleteSync(f->fence);
    f->fence = NULL;
}

void stp_far_depths_destroy(stp_far_depths *f)
{
    if (f->width > 0)
        destroy_textures(f);
    if (f->level != 0)
        glDeleteProgram(f->level);
    if (f->cells != 0)
        glDeleteProgram(f->cells);
    *f = (stp_far_depths){0};
}
