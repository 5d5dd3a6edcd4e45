/* Loads libcurl and finds its functions. */
#include "formats/chunk/remote/curl_library.h"

#include <dlfcn.h>
#include <pthread.h>
#include <stdbool.h>
#include <string.h>

#define LIBRARY "libcurl.so.4"

/* A process loads libcurl once, and libcurl must be initialised once: hence statics, written before
 * any thread reads them. */
static stp_curl functions;
static bool loaded;

static bool find(void *library, const char *name, void *function)
{
    void *found = dlsym(library, name);
    memcpy(function, &found, sizeof found);
    return found != NULL;
}

static void load(void)
{
    void *library = dlopen(LIBRARY, RTLD_NOW | RTLD_LOCAL);
    if (library == NULL)
        return;
    loaded = true;
#define X(name) loaded = find(library, "curl_" #name, &functions.name) && loaded;
    STP_CURL_LIST(X)
#undef X
    loaded = loaded && functions.global_init(CURL_GLOBAL_DEFAULT) == CURLE_OK;
}

const stp_curl *stp_curl_load(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    (void)pthread_once(&once, load);
    return loaded ? &functions : NULL;
}
