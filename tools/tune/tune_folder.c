/* Writes a folder under a temporary name until it is whole. */
#include "tools/tune/tune_folder.h"

#include "base/memory.h"
#include "base/temporary.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define NAME_BYTES 64 /* greater than STP_TEMPORARY_BYTES */

struct tune_folder {
    char *path, *part, *old; /* final name, temporary name, name for the folder that is replaced */
    char *file;
    bool force;
    int lock; /* lock on the temporary folder; -1: none */
};

/* True if the name is that of a report's file, temporary names included. */
static bool is_ours(const char *name)
{
    static const char *const names[] = {"tune.csv",  "tune.json",   "index.html",  "quality.svg",
                                        "times.svg", "promise.svg", "popping.svg", "picture.png"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(name, names[i]) == 0)
            return true;
    return strcmp(name, ".") == 0 || strcmp(name, "..") == 0;
}

/* Removes our files in a folder, and the folder if nothing else is in it. */
static bool remove_left(int parent, const char *name)
{
    int descriptor = openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    DIR *folder = descriptor >= 0 ? fdopendir(descriptor) : NULL;
    if (folder == NULL) {
        if (descriptor >= 0)
            close(descriptor);
        return false;
    }
    for (struct dirent *e = readdir(folder); e != NULL; e = readdir(folder))
        if (is_ours(e->d_name))
            (void)unlinkat(dirfd(folder), e->d_name, 0);
    closedir(folder);
    return unlinkat(parent, name, AT_REMOVEDIR) == 0;
}

static void remove_folder(const char *path)
{
    (void)remove_left(AT_FDCWD, path);
}

/* Locks and marks a folder until the descriptor is closed; -1 if it cannot. */
static int hold_folder(const char *path)
{
    int folder = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0)
        (void)stp_temporary_mark(folder);
    return folder;
}

/* Checks whether all files in a folder are ours. *any: the folder is not empty. *strange: the first
 * name that is not ours. */
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
    folder->lock = -1;
    STP_TRY(stp_text_copy(&folder->path, path, "a path", err));
    while (length > 1 && folder->path[length - 1] == '/')
        folder->path[--length] = '\0';
    STP_TRY(stp_alloc(&folder->part, bytes, 1, "a path", err));
    STP_TRY(stp_alloc(&folder->old, bytes, 1, "a path", err));
    STP_TRY(stp_alloc(&folder->file, 2 * bytes, 1, "a path", err));
    (void)stp_temporary_sweep(folder->path, true, remove_left, NULL);
    if (!stp_temporary_name(folder->part, folder->path) ||
        !stp_temporary_name(folder->old, folder->path) || mkdir(folder->part, 0777) != 0) {
        status =
            stp_error_set(err, STP_IO, "%s: the folder cannot be made: %s", path, strerror(errno));
        folder->part[0] = '\0';
        goto done;
    }
    folder->lock = hold_folder(folder->part);
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

/* Gives the folder its final name. If a folder has that name, the two swap names, so that a whole
 * folder is always there; then the old one is removed. If the file system cannot swap, the old
 * folder is moved aside first. Returns false and sets errno on failure. */
static bool take_place(tune_folder *f)
{
    int old = hold_folder(f->path);
    bool done = old >= 0 && renameat2(AT_FDCWD, f->part, AT_FDCWD, f->path, RENAME_EXCHANGE) == 0;
    if (old >= 0 && !done)
        stp_temporary_unmark(old);
    if (!done) {
        bool moved = rename(f->path, f->old) == 0;
        done = rename(f->part, f->path) == 0;
        if (moved)
            done ? remove_folder(f->old) : (void)rename(f->old, f->path);
        if (done)
            f->part[0] = '\0';
    }
    int reason = errno;
    if (old >= 0)
        close(old);
    errno = reason;
    return done;
}

stp_status tune_folder_commit(tune_folder **folder, stp_error *err)
{
    stp_status status = STP_OK;
    tune_folder *f = *folder;
    STP_TRY(tune_folder_check(f->path, f->force, err));
    if (!take_place(f)) {
        status = stp_error_set(err, STP_IO, "%s: the folder cannot be made: %s", f->path,
                               strerror(errno));
        goto done;
    }
    if (f->lock >= 0)
        stp_temporary_unmark(f->lock);
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
    if ((*folder)->lock >= 0)
        close((*folder)->lock);
    free((*folder)->path);
    free((*folder)->part);
    free((*folder)->old);
    free((*folder)->file);
    free(*folder);
    *folder = NULL;
}
