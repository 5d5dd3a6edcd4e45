/* Lists a folder for the viewer's dialog. */
#include "tools/view/dialog/view_folder.h"

#include "base/memory.h"
#include "tools/prep/prep_paths.h"

#include <dirent.h>
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static bool is_offered(const char *name)
{
    static const char *const endings[] = {"stipple", "tif", "tiff", "png", "exr",
                                          "pfm",     "pgm", "ppm",  "al3d"};
    const char *dot = strrchr(name, '.');
    for (size_t i = 0; dot && i < sizeof endings / sizeof *endings; i++)
        if (strcasecmp(dot + 1, endings[i]) == 0)
            return true;
    return prep_paths_is_scan(name) || strcmp(name, "ept.json") == 0;
}

static int compare_names(const void *a, const void *b)
{
    const char *x = *(char *const *)a, *y = *(char *const *)b;
    if (view_folder_is_sub(x) != view_folder_is_sub(y))
        return view_folder_is_sub(x) ? -1 : 1;
    return strcoll(x, y);
}

/* Adds a name of the open folder if the dialog offers it. */
static stp_status add(view_folder *folder, DIR *open, const char *name, stp_error *err)
{
    struct stat is;
    const size_t size = strlen(name) + 2;
    if (fstatat(dirfd(open), name, &is, 0) != 0 ||
        !(S_ISDIR(is.st_mode) || (S_ISREG(is.st_mode) && is_offered(name))))
        return STP_OK;
    folder->is_cut = folder->count == VIEW_FOLDER_LIMIT;
    if (folder->is_cut)
        return STP_OK;
    char **added = &folder->names[folder->count];
    const stp_status status = stp_alloc(added, size, 1, "a name", err);
    if (status != STP_OK)
        return status;
    snprintf(*added, size, "%s%s", name, S_ISDIR(is.st_mode) ? "/" : "");
    folder->count++;
    return STP_OK;
}

stp_status view_folder_list(view_folder *folder, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    view_folder_clear(folder);
    DIR *open = opendir(path);
    const struct dirent *entry = NULL;
    if (!open)
        return stp_error_set(err, STP_IO, "%s: cannot be read: %s", path, strerror(errno));
    STP_TRY(stp_alloc(&folder->names, VIEW_FOLDER_LIMIT, sizeof *folder->names, "names", err));
    while (!folder->is_cut && (errno = 0, entry = readdir(open)) != NULL)
        if (entry->d_name[0] != '.')
            STP_TRY(add(folder, open, entry->d_name, err));
    if (!entry && errno != 0)
        STP_TRY(stp_error_set(err, STP_IO, "%s: cannot be read: %s", path, strerror(errno)));
    qsort(folder->names, folder->count, sizeof *folder->names, compare_names);
done:
    closedir(open);
    if (status != STP_OK)
        view_folder_clear(folder);
    return status;
}

void view_folder_clear(view_folder *folder)
{
    for (size_t i = 0; i < folder->count; i++)
        free(folder->names[i]);
    free(folder->names);
    *folder = (view_folder){0};
}
