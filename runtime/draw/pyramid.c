/* Makes the textures and framebuffers of the pyramid. */
#include "runtime/draw/pyramid.h"

#include "runtime/gl/gl_context.h"

static void set_nearest(GLuint texture)
{
    glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
}

static GLuint create_texture(GLenum format, int width, int height)
{
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, format, width, height);
    set_nearest(texture);
    return texture;
}

/* Makes a framebuffer of `count` colour textures; all are drawn to. */
static GLuint create_frame(const GLuint *textures, int count)
{
    static const GLenum buffers[3] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1,
                                      GL_COLOR_ATTACHMENT2};
    GLuint frame = 0;
    glCreateFramebuffers(1, &frame);
    for (int i = 0; i < count; i++)
        glNamedFramebufferTexture(frame, buffers[i], textures[i], 0);
    glNamedFramebufferDrawBuffers(frame, count, buffers);
    return frame;
}

/* Clears a target, since passes never write outside a frame's tiles. */
static void clear_target(GLuint texture)
{
    glClearTexImage(texture, 0, GL_RGBA_INTEGER, GL_UNSIGNED_INT, NULL);
}

static GLuint create_target(const stp_pyramid_level *level)
{
    GLuint texture = create_texture(GL_RGBA32UI, level->width, level->height);
    clear_target(texture);
    return texture;
}

/* The smallest number >= size whose halves, `halvings` times, are no smaller than those of size
 * rounded up. */
static int even_size(int size, int halvings)
{
    return (size + (1 << halvings) - 1) >> halvings << halvings;
}

/* Makes the textures of pulled levels 1..level_count as mips, so that a shader can search all. */
static void create_pulled_above(stp_pyramid *p)
{
    int halvings = p->level_count - 1;
    for (int i = 0; i < STP_TARGET_COUNT && p->level_count > 0; i++) {
        GLuint texture = 0;
        glCreateTextures(GL_TEXTURE_2D, 1, &texture);
        glTextureStorage2D(texture, p->level_count, GL_RGBA32UI,
                           even_size(p->levels[1].width, halvings),
                           even_size(p->levels[1].height, halvings));
        glTextureParameteri(texture, GL_TEXTURE_MIN_FILTER, GL_NEAREST_MIPMAP_NEAREST);
        glTextureParameteri(texture, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        p->pulled_above[i] = texture;
    }
}

static void create_pulled(stp_pyramid *p, int l)
{
    stp_pyramid_level *level = &p->levels[l];
    for (int i = 0; i < STP_TARGET_COUNT; i++) {
        if (l == 0) {
            level->pulled[i] = create_target(level);
            continue;
        }
        glGenTextures(1, &level->pulled[i]);
        glTextureView(level->pulled[i], GL_TEXTURE_2D, p->pulled_above[i], GL_RGBA32UI,
                      (GLuint)(l - 1), 1, 0, 1);
        set_nearest(level->pulled[i]);
        clear_target(level->pulled[i]);
    }
    level->pulled_frame = create_frame(level->pulled, STP_TARGET_COUNT);
}

/* Makes the textures of a level as finished. */
static void create_finished(stp_pyramid_level *level)
{
    for (int i = 0; i < STP_TARGET_COUNT; i++)
        level->finished[i] = create_target(level);
    level->finished_frame = create_frame(level->finished, STP_TARGET_COUNT);
}

static void create_picture_frames(const stp_pyramid *p, GLuint picture,
                                  GLuint frames[STP_PICTURE_FRAMES])
{
    const GLuint targets[3] = {picture, p->picture_depth, p->picture_mark};
    frames[STP_PICTURE_WITH_DEPTH] = create_frame(targets, 2);
    frames[STP_PICTURE_WITH_MARK] = create_frame(targets, 3);
    frames[STP_PICTURE_ALONE] = create_frame(targets, 1);
}

stp_status stp_pyramid_resize(stp_pyramid *pyramid, int width, int height, stp_error *err)
{
    GLint limit = 0;
    if (pyramid->width == width && pyramid->height == height)
        return STP_OK;
    glGetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
    limit =
        limit < 1 << (STP_PYRAMID_LEVELS_LIMIT - 1) ? limit : 1 << (STP_PYRAMID_LEVELS_LIMIT - 1);
    if (width < 1 || height < 1 || width > limit || height > limit)
        return stp_error_set(err, STP_LIMIT,
                             "a picture of %d x %d pixels: give each side 1 to %d, or draw it in "
                             "parts",
                             width, height, limit);
    stp_pyramid_destroy(pyramid);
    stp_pyramid p = {.width = width, .height = height};
    while ((1 << p.level_count) < width || (1 << p.level_count) < height)
        p.level_count++;
    for (int l = 0; l <= p.level_count; l++) {
        p.levels[l].width = (width + (1 << l) - 1) >> l;
        p.levels[l].height = (height + (1 << l) - 1) >> l;
    }
    create_pulled_above(&p);
    for (int l = 0; l <= p.level_count; l++) {
        create_pulled(&p, l);
        if (l > 0)
            create_finished(&p.levels[l]);
    }
    p.nearest = create_texture(GL_R32UI, width, height);
    p.scatter_depth = create_texture(GL_R32UI, width, height);
    p.nearest_depth = create_texture(GL_DEPTH_COMPONENT32F, width, height);
    p.nearest_frame = create_frame(&p.nearest, 1);
    glNamedFramebufferTexture(p.nearest_frame, GL_DEPTH_ATTACHMENT, p.nearest_depth, 0);
    glNamedFramebufferTexture(p.levels[0].pulled_frame, GL_DEPTH_ATTACHMENT, p.nearest_depth, 0);
    p.picture = create_texture(GL_RGBA8, width, height);
    p.picture_depth = create_texture(GL_R32F, width, height);
    p.picture_mark = create_texture(GL_R8UI, width, height);
    create_picture_frames(&p, p.picture, p.picture_frames);
    stp_status status = stp_gl_check("making the image pyramid", err);
    if (status == STP_OK)
        *pyramid = p;
    else
        stp_pyramid_destroy(&p);
    return status;
}

stp_status stp_pyramid_keep_level_0(stp_pyramid *pyramid, stp_error *err)
{
    if (pyramid->levels[0].finished_frame != 0)
        return STP_OK;
    create_finished(&pyramid->levels[0]);
    return stp_gl_check("making room for the pixels kept", err);
}

stp_status stp_pyramid_keep_sums(stp_pyramid *pyramid, stp_error *err)
{
    if (pyramid->sum_frame != 0)
        return STP_OK;
    for (int i = 0; i < 2; i++)
        pyramid->sums[i] = create_texture(GL_RGBA32F, pyramid->width, pyramid->height);
    pyramid->sum_frame = create_frame(pyramid->sums, 2);
    return stp_gl_check("making room for splats", err);
}

stp_status stp_pyramid_keep_rough(stp_pyramid *p, stp_error *err)
{
    if (p->rough != 0)
        return STP_OK;
    p->rough = create_texture(GL_RGBA8, p->width, p->height);
    create_picture_frames(p, p->rough, p->rough_frames);
    return stp_gl_check("making room for smooth edges", err);
}

stp_status stp_pyramid_keep_steps(stp_pyramid *p, stp_error *err)
{
    if (p->picture_steps == 0)
        p->picture_steps = create_texture(GL_RGBA32F, p->width, p->height);
    return stp_gl_check("making room for contours", err);
}

void stp_pyramid_destroy(stp_pyramid *p)
{
    const GLuint frames[2] = {p->nearest_frame, p->sum_frame};
    const GLuint textures[10] = {p->nearest,       p->nearest_depth, p->scatter_depth, p->picture,
                                 p->picture_depth, p->picture_mark,  p->sums[0],       p->sums[1],
                                 p->rough,         p->picture_steps};
    if (p->width == 0)
        return;
    for (int l = 0; l <= p->level_count; l++) {
        glDeleteFramebuffers(1, &p->levels[l].pulled_frame);
        glDeleteFramebuffers(1, &p->levels[l].finished_frame);
        glDeleteTextures(STP_TARGET_COUNT, p->levels[l].pulled);
        glDeleteTextures(STP_TARGET_COUNT, p->levels[l].finished);
    }
    glDeleteTextures(STP_TARGET_COUNT, p->pulled_above);
    glDeleteFramebuffers(2, frames);
    glDeleteFramebuffers(STP_PICTURE_FRAMES, p->picture_frames);
    glDeleteFramebuffers(STP_PICTURE_FRAMES, p->rough_frames);
    glDeleteTextures(10, textures);
    *p = (stp_pyramid){0};
}
