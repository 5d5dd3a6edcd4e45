/* Loads the module of PROJ when the first projection is needed. */
#include "formats/scan/geo/projection.h"

#include <dlfcn.h>

/* Loaded through the program's run path, once, and kept. */
static const stp_projection_library *library;

static stp_status load(stp_error *err)
{
    if (library == NULL) {
        void *module = dlopen("libstipple-proj.so", RTLD_NOW | RTLD_LOCAL);
        library = module != NULL ? dlsym(module, "stp_projection_proj") : NULL;
    }
    if (library == NULL)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "coordinates cannot be projected: %s: install stipple anew, or PROJ",
                             dlerror());
    return STP_OK;
}

stp_status stp_projection_create(stp_projection **out, const char *from, const char *to,
                                 stp_dvec3 at, stp_error *err)
{
    const stp_status status = load(err);
    return status == STP_OK ? library->create(out, from, to, at, err) : status;
}

stp_status stp_system_wkt(char **out, const char *definition, stp_error *err)
{
    const stp_status status = load(err);
    return status == STP_OK ? library->system_wkt(out, definition, err) : status;
}

stp_status stp_system_same(bool *same, const char *a, const char *b, stp_error *err)
{
    const stp_status status = load(err);
    return status == STP_OK ? library->system_same(same, a, b, err) : status;
}

stp_dvec3 stp_projection_apply(stp_projection *projection, stp_dvec3 position)
{
    return library->apply(projection, position);
}

const char *stp_projection_name(const stp_projection *projection)
{
    return library->name(projection);
}

const char *stp_projection_wkt(const stp_projection *projection)
{
    return library->wkt(projection);
}

double stp_projection_unit(const stp_projection *projection)
{
    return library->unit(projection);
}

double stp_projection_height_unit(const stp_projection *projection)
{
    return library->height_unit(projection);
}

void stp_projection_destroy(stp_projection **projection)
{
    if (*projection != NULL)
        library->destroy(projection);
}
