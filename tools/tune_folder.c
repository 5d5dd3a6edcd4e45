/* A folder under a temporary name until it is whole. */
#include "tools/tune_folder.h"

#include "base/memory.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define NAME_BYTES 64

struct tune_folder {
    char *path, *part, *old; /* what it becomes, what it is, where the one before goes */
    char *file;
    bool force;
};

/* What a report is made of, temporary names included. */
static bool is_ours(const char *name)
{
    static const char *const names[] = {"tune.csv",  "tune.json",   "index.html",  "quality.svg",
                                        "times.svg", "promise.svg", "popping.svg", "picture.png"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(name, names[i]) == 0)
            return true;
    return strcmp(name, ".") == 0 || strcmp(name, "..") == 0;
}

/* Removes a folder's files of ours, and the folder where nothing else is in it. */
static void remove_folder(const char *path)
{
    DIR *folder = opendir(path);
    if (folder == NULL)
        return;
    for (struct dirent *e = readdir(folder); e != NULL; e = readdir(folder))
        if (is_ours(e->d_name))
            (void)unlinkat(dirfd(folder), e->d_name, 0);
    closedir(folder);
    (void)rmdir(path);
}

/* Whether all in a folder is ours; *any: there is something. *strange gets the first that is not.
 */
static stp_status look_into(const char *path, bool *any, char strange[256], stp_error *err)
{
    DIR *folder = opendir(path);
    *any = false;
    strange[0] = '\0';
    if (folder == NULL && errno == ENOTDIR)
        return stp_error_set(err, STP_EXISTS, "%s is a file: give -o a folder", path);
    if (folder == NULL)
        return errno == ENOENT ? STP_OK
                               : stp_error_set(err, STP_IO, "%s: the folder cannot be read: %s",
                                               path, strerror(errno));
    for (struct dirent *e = readdir(folder); e != NULL; e = readdir(folder)) {
        *any |= strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
        if (!is_ours(e->d_name))
            snprintf(strange, 256, "%.255s", e->d_name);
    }
    closedir(folder);
    return STP_OK;
}

stp_status tune_folder_check(const char *path, bool force, stp_error *err)
{
    char strange[256];
    bool any;
    stp_status status = look_into(path, &any, strange, err);
    if (status != STP_OK)
        return status;
    if (strange[0] != '\0')
        return stp_error_set(err, STP_EXISTS,
                             "%s holds %s, which is not of a report: give another folder", path,
                             strange);
    if (any && !force)
        return stp_error_set(err, STP_EXISTS, "%s exists: give another folder, or --force", path);
    return STP_OK;
}

stp_status tune_folder_create(tune_folder **out, const char *path, bool force, stp_error *err)
{
    stp_status status = STP_OK;
    tune_folder *folder = NULL;
    size_t bytes = strlen(path) + NAME_BYTES, length = strlen(path);
    STP_TRY(tune_folder_check(path, force, err));
    STP_TRY(stp_alloc(&folder, 1, sizeof *folder, "a folder", err));
    folder->force = force;
    STP_TRY(stp_text_copy(&folder->path, path, "a path", err));
    while (length > 1 && folder->path[length - 1] == '/')
        folder->path[--length] = '\0';
    STP_TRY(stp_alloc(&folder->part, bytes, 1, "a path", err));
    STP_TRY(stp_alloc(&folder->old, bytes, 1, "a path", err));
    STP_TRY(stp_alloc(&folder->file, 2 * bytes, 1, "a path", err));
    snprintf(folder->part, bytes, "%s.%ld.part", folder->path, (long)getpid());
    snprintf(folder->old, bytes, "%s.%ld.old", folder->path, (long)getpid());
    if (mkdir(folder->part, 0777) != 0) {
        status =
            stp_error_set(err, STP_IO, "%s: the folder cannot be made: %s", path, strerror(errno));
        folder->part[0] = '\0';
        goto done;
    }
    *out = folder;
    folder = NULL;
done:
    tune_folder_destroy(&folder);
    return status;
}

const char *tune_folder_file(tune_folder *folder, const char *name)
{
    snprintf(folder->file, 2 * (strlen(folder->path) + NAME_BYTES), "%s/%s", folder->part, name);
    return folder->file;
}

stp_status tune_folder_commit(tune_folder **folder, stp_error *err)
{
    stp_status status = STP_OK;
    tune_folder *f = *folder;
    STP_TRY(tune_folder_check(f->path, f->force, err));
    /* A folder that holds nothing gives way by itself, one that does moves aside first. */
    bool moved = rename(f->path, f->old) == 0;
    if (!moved && errno != ENOENT) {
        status = stp_error_set(err, STP_IO, "%s: cannot be replaced: %s", f->path, strerror(errno));
        goto done;
    }
    if (rename(f->part, f->path) != 0) {
        status = stp_error_set(err, STP_IO, "%s: the folder cannot be made: %s", f->path,
                               strerror(errno));
        if (moved)
            (void)rename(f->old, f->path);
        goto done;
    }
    f->part[0] = '\0';
    if (moved)
        remove_folder(f->old);
done:
    tune_folder_destroy(folder);
    return status;
}

void tune_folder_destroy(tune_folder **folder)
{
    if (*folder == NULL)
        return;
    if ((*folder)->part != NULL && (*folder)->part[0] != '\0')
        remove_folder((*folder)->part);
    free((*folder)->path);
    free((*folder)->part);
    free((*folder)->old);
    free((*folder)->file);
    free(*folder);
    *folder = NULL;
}
