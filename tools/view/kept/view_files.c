/* Makes names of files that the viewer writes. */
#include "tools/view/kept/view_files.h"

#include "base/file.h"
#include "formats/chunk/byte_source.h"
#include "formats/chunk/layout.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define NUMBERS_LIMIT 10000

const char *view_files_base(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL && slash[1] != '\0' ? slash + 1 : path;
}

stp_status view_files_free(char out[VIEW_PATH_BYTES], const char *model, const char *ending,
                           stp_error *err)
{
    const char *name = view_files_base(model), *dot = strrchr(name, '.');
    int length = dot != NULL && dot > name ? (int)(dot - name) : (int)strlen(name);
    struct stat found;
    for (int i = 1; i < NUMBERS_LIMIT; i++) {
        snprintf(out, VIEW_PATH_BYTES, "%.*s-%d%s", length < 200 ? length : 200, name, i, ending);
        if (lstat(out, &found) != 0 && errno == ENOENT)
            return STP_OK;
    }
    return stp_error_set(err, STP_EXISTS, "no name like %s is free here: move some away", out);
}

stp_status view_files_make_folders(const char *path, stp_error *err)
{
    char folder[VIEW_PATH_BYTES];
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash != NULL ? (int)(slash - path) : 0, path);
    return stp_folder_make(folder, 0777, err);
}

stp_status view_files_state(char out[VIEW_PATH_BYTES], const char *name, stp_error *err)
{
    const char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    int length = 0;
    if (state != NULL && state[0] == '/') /* the XDG specification says to ignore relative paths */
        length = snprintf(out, VIEW_PATH_BYTES, "%s/stipple/%s", state, name);
    else if (home != NULL && home[0] == '/')
        length = snprintf(out, VIEW_PATH_BYTES, "%s/.local/state/stipple/%s", home, name);
    else
        return stp_error_set(err, STP_IO, "there is no folder for %s: set HOME or XDG_STATE_HOME",
                             name);
    if (length >= VIEW_PATH_BYTES)
        return stp_error_set(err, STP_LIMIT, "the folder of states has too long a name");
    return STP_OK;
}

/* The same for a file that belongs to a model, by the model's path or address. Errors: those of
 * view_files_state. */
static stp_status model_state(char out[VIEW_PATH_BYTES], const char *model, const char *ending,
                              stp_error *err)
{
    char name[320];
    char *real = stp_is_address(model) ? NULL : realpath(model, NULL);
    const char *whole = real != NULL ? real : model; /* distinguishes models of the same name */
    snprintf(name, sizeof name, "%.200s-%016" PRIx64 "%s", view_files_base(model),
             stp_hash(whole, strlen(whole)), ending);
    free(real);
    return view_files_state(out, name, err);
}

static stp_status beside(char out[VIEW_PATH_BYTES], const char *model, const char *ending,
                         stp_error *err)
{
    if (snprintf(out, VIEW_PATH_BYTES, "%s%s", model, ending) >= VIEW_PATH_BYTES)
        return stp_error_set(err, STP_LIMIT, "the model has too long a name");
    return STP_OK;
}

stp_status view_files_find(char out[VIEW_PATH_BYTES], bool *found, const char *model,
                           const char *ending, stp_error *err)
{
    stp_status status = STP_OK;
    *found = model_state(out, model, ending, NULL) == STP_OK && access(out, F_OK) == 0;
    if (!*found && !stp_is_address(model)) {
        STP_TRY(beside(out, model, ending, err));
        *found = access(out, F_OK) == 0;
    }
done:
    return status;
}

stp_status view_files_save(char path[VIEW_PATH_BYTES], const char *model, const char *ending,
                           cJSON *(*make)(const void *), const void *context, stp_error *err)
{
    stp_status status = STP_OK;
    char other[VIEW_PATH_BYTES];
    if (path[0] != '\0' && stp_json_save(make(context), path, true, NULL) == STP_OK)
        return STP_OK;
    if (!stp_is_address(model)) {
        STP_TRY(beside(other, model, ending, err));
        if (stp_json_save(make(context), other, true, NULL) == STP_OK) {
            memcpy(path, other, sizeof other);
            return STP_OK;
        }
    }
    STP_TRY(model_state(other, model, ending, err));
    STP_TRY(view_files_make_folders(other, err));
    STP_TRY(stp_json_save(make(context), other, true, err));
    memcpy(path, other, sizeof other);
done:
    return status;
}
