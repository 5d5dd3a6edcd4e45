/* Makes headless OpenGL contexts through EGL: devices first, then the surfaceless platform. */
#include "runtime/gl/gl_context.h"

#include "base/memory.h"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define DEVICES_LIMIT 16
#define ADVICE                                                                                     \
    "install a driver with OpenGL 4.5 (on Debian: libegl1 and libgl1-mesa-dri for a software one)"

struct stp_gl_context {
    EGLDisplay display;
    EGLContext context;
};

/* epoxy ends the program if a library is missing, so this asks first. */
static bool library_exists(const char *name)
{
    void *handle = dlopen(name, RTLD_LAZY | RTLD_GLOBAL);
    return handle != NULL; /* stays open, since epoxy will use it */
}

static bool has_extension(const char *list, const char *name)
{
    size_t length = strlen(name);
    for (const char *at = list; at != NULL && (at = strstr(at, name)) != NULL; at += length)
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0'))
            return true;
    return false;
}

/* Makes a 4.5 core context of a display current. False if that fails; then nothing is left
 * behind. */
static bool try_display(EGLDisplay display, stp_gl_context *out)
{
    static const EGLint wanted[] = {EGL_CONTEXT_MAJOR_VERSION,
                                    4,
                                    EGL_CONTEXT_MINOR_VERSION,
                                    5,
                                    EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                    EGL_NONE};
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL))
        return false;
    const char *extensions = eglQueryString(display, EGL_EXTENSIONS);
    if (has_extension(extensions, "EGL_KHR_no_config_context") &&
        has_extension(extensions, "EGL_KHR_surfaceless_context") && eglBindAPI(EGL_OPENGL_API)) {
        EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, wanted);
        if (context != EGL_NO_CONTEXT &&
            eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
            *out = (stp_gl_context){display, context};
            return true;
        }
        if (context != EGL_NO_CONTEXT)
            eglDestroyContext(display, context);
    }
    eglTerminate(display);
    return false;
}

/* Tries the GPUs, or if software is true the software devices. */
static bool try_devices(bool software, stp_gl_context *out)
{
    PFNEGLQUERYDEVICESEXTPROC query =
        (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
    PFNEGLQUERYDEVICESTRINGEXTPROC query_string =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)eglGetProcAddress("eglQueryDeviceStringEXT");
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    EGLDeviceEXT devices[DEVICES_LIMIT];
    EGLint count = 0;
    if (query == NULL || query_string == NULL || get_display == NULL ||
        !query(DEVICES_LIMIT, devices, &count))
        return false;
    for (EGLint i = 0; i < count; i++) {
        const char *extensions = query_string(devices[i], EGL_EXTENSIONS);
        if (has_extension(extensions, "EGL_MESA_device_software") == software &&
            try_display(get_display(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL), out))
            return true;
    }
    return false;
}

static bool try_surfaceless(stp_gl_context *out)
{
    PFNEGLGETPLATFORMDISPLAYEXTPROC get_display =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    const char *extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    return get_display != NULL && has_extension(extensions, "EGL_MESA_platform_surfaceless") &&
           try_display(get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL), out);
}

stp_status stp_gl_context_check(stp_error *err)
{
    int version = epoxy_gl_version();
    if (!epoxy_is_desktop_gl() || version < 45)
        return stp_error_set(err, STP_GL, "OpenGL %d.%d is too old: stipple needs 4.5; %s",
                             version / 10, version % 10, ADVICE);
    return STP_OK;
}

stp_status stp_gl_context_create(stp_gl_context **out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_gl_context *context = NULL;
    if (!library_exists("libEGL.so.1"))
        return stp_error_set(err, STP_GL, "no OpenGL here: libEGL.so.1 is missing; %s", ADVICE);
    if (!library_exists("libOpenGL.so.0") && !library_exists("libGL.so.1"))
        return stp_error_set(err, STP_GL, "no OpenGL here: libOpenGL.so.0 is missing; %s", ADVICE);
    STP_TRY(stp_alloc(&context, 1, sizeof *context, "an OpenGL context", err));
    if (!try_devices(false, context) && !try_surfaceless(context) && !try_devices(true, context)) {
        status = stp_error_set(err, STP_GL,
                               "no OpenGL 4.5 context could be made without a display; %s", ADVICE);
        goto done;
    }
    STP_TRY(stp_gl_context_check(err));
    *out = context;
    context = NULL;
done:
    stp_gl_context_destroy(&context);
    return status;
}

void stp_gl_context_destroy(stp_gl_context **context)
{
    stp_gl_context *c = *context;
    if (c == NULL)
        return;
    if (c->context != EGL_NO_CONTEXT) {
        eglMakeCurrent(c->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        eglDestroyContext(c->display, c->context);
        eglTerminate(c->display);
    }
    free(c);
    *context = NULL;
}

stp_status stp_gl_check(const char *what, stp_error *err)
{
    GLenum code = glGetError();
    if (code == GL_NO_ERROR)
        return STP_OK;
    while (glGetError() != GL_NO_ERROR)
        continue;
    if (code == GL_OUT_OF_MEMORY)
        return stp_error_set(
            err, STP_GL, "%s: the GPU's memory is exhausted: give a smaller --gpu-memory", what);
    return stp_error_set(err, STP_GL, "%s: OpenGL error 0x%04x", what, code);
}
