/* Part of every program built with sanitizers: libraries stay loaded until the process has ended.
 *
 * OpenGL drivers are unloaded when a context goes; what they still hold would then be reported from
 * nowhere, and no suppression could name them. */
#include <dlfcn.h>

int dlclose(void *handle)
{
    (void)handle;
    return 0;
}
