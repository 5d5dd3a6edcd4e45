/* Opens inputs that lie on web servers. */
#include "tools/prep/prep_web.h"

#include "base/memory.h"
#include "formats/scan/octree/ept_files.h"
#include "tools/cli/cli.h"

#include <string.h>

/* Waiting for an almost silent server, as commands that draw have it without --timeout. */
#define PATIENCE_MS 60000u

static bool is_interrupted(void *context)
{
    (void)context;
    return cli_interrupted();
}

const stp_byte_source_params *prep_web_params(void)
{
    static const stp_byte_source_params params = {.patience_ms = PATIENCE_MS,
                                                  .cancelled = is_interrupted};
    return &params;
}

stp_status prep_web_open(stp_file_mirror **mirror, const char *path, const char *folder,
                         stp_error *err)
{
    const stp_mirror_params params = {.folder = folder, .web = prep_web_params()};
    if (!stp_is_address(path) || stp_ept_is_named(path))
        return STP_OK;
    return stp_mirror_open(mirror, path, &params, err);
}

stp_status prep_web_name(char **out, const char *path, stp_error *err)
{
    const size_t end = stp_is_address(path) ? strcspn(path, "?#") : strlen(path);
    unsigned parts = stp_ept_is_named(path) ? 2 : 1;
    size_t begin = end;
    while (begin > 0 && (path[begin - 1] != '/' || --parts > 0))
        begin--;
    const stp_status status = stp_alloc(out, end - begin + 1, 1, "a name", err);
    if (status == STP_OK)
        memcpy(*out, path + begin, end - begin);
    return status;
}
