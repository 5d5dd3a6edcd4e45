/* Loads the module through the program's run path and keeps it loaded. */
#include "formats/image/image_module.h"

#include <dlfcn.h>
#include <string.h>

#define MODULE_NAME "libstipple-image.so"

/* dlsym returns a data pointer; POSIX allows to use it as a function pointer. */
static void take_symbol(void *module, const char *name, void *function_pointer)
{
    void *symbol = dlsym(module, name);
    memcpy(function_pointer, &symbol, sizeof symbol);
}

stp_status stp_image_module_get(stp_image_module *out, stp_error *err)
{
    stp_image_module found = {0};
    /* dlopen loads it once, however often it is called. It is never unloaded, because its libraries
     * keep threads. */
    void *module = dlopen(MODULE_NAME, RTLD_NOW | RTLD_LOCAL);
    if (module != NULL) {
        take_symbol(module, "stp_oiio_load", &found.load);
        take_symbol(module, "stp_oiio_open_heights", &found.open_heights);
        take_symbol(module, "stp_oiio_read_heights", &found.read_heights);
        take_symbol(module, "stp_oiio_close_heights", &found.close_heights);
        take_symbol(module, "stp_oiio_save", &found.save);
        take_symbol(module, "stp_oiio_save_floats", &found.save_floats);
    }
    if (found.load == NULL || found.open_heights == NULL || found.read_heights == NULL ||
        found.close_heights == NULL || found.save == NULL || found.save_floats == NULL)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "images cannot be read or written: %s: install stipple anew, or "
                             "OpenImageIO",
                             module == NULL ? dlerror() : MODULE_NAME);
    *out = found;
    return STP_OK;
}
