/* Linked into every program with sanitizers: libraries stay loaded until the process ends.
 *
 * OpenGL drivers are unloaded with their context. A leak in them would then be reported without a
 * library's name, and no suppression could match it. */
#include <dlfcn.h>

int dlclose(void *handle)
{
    (void)handle;
    return 0;
}
