/* Embeds stipple: a host application that draws a model among its own triangles, into its own
 * framebuffer, with its own matrices. A ring passes through the model, partly in front of it and
 * partly behind it.
 *
 *     embed M.stipple PICTURE.ppm
 *
 * The example is headless. With a window, only make_framebuffer and write_picture change. */
#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stipple/gl_context.h>
#include <stipple/stipple.h>

enum { WIDTH = 800, HEIGHT = 600, RING_CORNERS = 2 * 128 + 2 };

/* ---- the host's own drawing ---- */

static const char *const ring_shaders[2] = {
    "#version 450 core\n"
    "layout(location = 0) uniform mat4 clip;\n"
    "layout(location = 1) uniform float radius;\n"
    "out float around;\n"
    "void main() {\n" /* corners alternate between inside and outside, about the vertical axis */
    "    around = 6.2831853 * float(gl_VertexID / 2) / 128.0;\n"
    "    float r = radius * (gl_VertexID % 2 == 0 ? 0.3 : 0.55);\n"
    "    gl_Position = clip * vec4(r * cos(around), 0.0, r * sin(around), 1.0);\n"
    "}\n",
    "#version 450 core\n"
    "in float around;\n"
    "layout(location = 0) out vec4 colour;\n"
    "void main() { colour = vec4(0.9, 0.55 + 0.15 * sign(sin(16.0 * around)), 0.1, 1.0); }\n"};

static GLuint make_ring(void)
{
    GLuint program = glCreateProgram();
    for (int i = 0; i < 2; i++) {
        GLuint shader = glCreateShader(i == 0 ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
        glShaderSource(shader, 1, &ring_shaders[i], NULL);
        glCompileShader(shader);
        glAttachShader(program, shader);
    }
    glLinkProgram(program);
    return program;
}

static void draw_ring(GLuint program, const double clip[16], double radius)
{
    float matrix[16];
    for (int i = 0; i < 16; i++)
        matrix[i] = (float)clip[i];
    glUseProgram(program);
    glUniformMatrix4fv(0, 1, GL_FALSE, matrix);
    glUniform1f(1, (float)radius);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, RING_CORNERS);
}

static void make_framebuffer(void)
{
    GLuint frame, array, buffers[2];
    glCreateFramebuffers(1, &frame);
    glCreateRenderbuffers(2, buffers);
    glNamedRenderbufferStorage(buffers[0], GL_RGBA8, WIDTH, HEIGHT);
    glNamedRenderbufferStorage(buffers[1], GL_DEPTH_COMPONENT24, WIDTH, HEIGHT);
    glNamedFramebufferRenderbuffer(frame, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, buffers[0]);
    glNamedFramebufferRenderbuffer(frame, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, buffers[1]);
    glBindFramebuffer(GL_FRAMEBUFFER, frame);
    glCreateVertexArrays(1, &array);
    glBindVertexArray(array); /* without attributes: the shader makes the ring's corners */
}

static bool write_picture(const char *path)
{
    static unsigned char pixels[HEIGHT][3 * WIDTH];
    FILE *file = fopen(path, "wb");
    if (file == NULL)
        return false;
    glReadPixels(0, 0, WIDTH, HEIGHT, GL_RGB, GL_UNSIGNED_BYTE, pixels);
    fprintf(file, "P6\n%d %d\n255\n", WIDTH, HEIGHT);
    for (int y = HEIGHT - 1; y >= 0; y--)
        fwrite(pixels[y], 1, sizeof pixels[y], file);
    return fclose(file) == 0;
}

/* Multiplies matrices, columns first. In double, since a scan's coordinates may be in the
 * millions. */
static void multiply(double out[16], const double a[16], const double b[16])
{
    for (int i = 0; i < 16; i++) {
        out[i] = 0.0;
        for (int k = 0; k < 4; k++)
            out[i] += a[4 * k + i % 4] * b[i / 4 * 4 + k];
    }
}

/* ---- the model among it ---- */

static stp_status draw_scene(const stp_model *model, stp_renderer *renderer, stp_error *err)
{
    /* The model's middle is the origin of the host's world; the eye looks at it from above. */
    const stp_ball ball = stp_model_ball(model);
    const double c = cos(0.35), s = sin(0.35), near = ball.radius, far = 6.0 * ball.radius;
    const double view[16] = {1, 0, 0, 0, 0, c, s, 0, 0, -s, c, 0, 0, 0, -2.5 * ball.radius, 1};
    const double place[16] = {
        1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -ball.centre.x, -ball.centre.y, -ball.centre.z, 1};
    const double projection[16] = {[0] = 2.5 * HEIGHT / WIDTH,
                                   [5] = 2.5,
                                   [10] = (near + far) / (near - far),
                                   [11] = -1.0,
                                   [14] = 2.0 * near * far / (near - far)};
    const stp_draw_params params = {.threshold_px = 1.0}; /* waits until all chunks are loaded */
    double model_view[16], clip[16];
    stp_view seen;
    multiply(model_view, view, place);
    multiply(clip, projection, view);

    glViewport(0, 0, WIDTH, HEIGHT);
    glEnable(GL_DEPTH_TEST);
    glClearColor(0.15f, 0.17f, 0.2f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    draw_ring(make_ring(), clip, ball.radius);
    if (stp_view_from_matrices(&seen, model_view, projection, &ball, WIDTH, HEIGHT, err) != STP_OK)
        return err->status;
    return stp_renderer_draw_into(renderer, &seen, &params, NULL, NULL, err);
}

int main(int argc, char **argv)
{
    stp_error err = {0};
    stp_gl_context *context = NULL;
    stp_model *model = NULL;
    stp_renderer *renderer = NULL;
    if (argc != 3) {
        fprintf(stderr, "usage: embed M.stipple PICTURE.ppm\n");
        return 2;
    }
    bool drawn =
        stp_gl_context_create(&context, &err) == STP_OK &&
        stp_model_open(&model, argv[1], &err) == STP_OK &&
        stp_renderer_create(&renderer, &(stp_renderer_params){.model = model}, &err) == STP_OK;
    if (drawn) {
        make_framebuffer();
        drawn = draw_scene(model, renderer, &err) == STP_OK;
    }
    bool written = drawn && write_picture(argv[2]);
    if (!written)
        fprintf(stderr, "embed: %s\n", drawn ? "the picture could not be written" : err.message);
    stp_renderer_destroy(&renderer);
    stp_model_close(&model);
    stp_gl_context_destroy(&context);
    return written ? 0 : 1;
}
