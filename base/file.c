/* Output files that appear whole or not at all; input files; folders; endings of names. */
#include "base/file.h"

#include "base/memory.h"
#include "base/temporary.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define STP_OUTPUT_BUFFER_BYTES (1u << 20)
#define ATTEMPTS 8 /* to find a free name */

struct stp_output {
    int descriptor;
    bool force;
    bool named; /* temporary is a name beside the final one; else it is a path to the descriptor */
    bool reopened; /* the file had its name before */
    uint64_t kept; /* of a reopened file: bytes that stay if the output is destroyed */
    char *path;
    char *temporary;
    uint64_t size;
    size_t buffered;
    unsigned char buffer[STP_OUTPUT_BUFFER_BYTES];
};

static stp_status write_failed(const char *path, stp_error *err)
{
    int reason = errno;
    if (reason == ENOSPC || reason == EDQUOT)
        return stp_error_set(err, STP_IO,
                             "%s: the disk is full: free some space or write elsewhere", path);
    return stp_error_set(err, STP_IO, "%s: writing failed: %s", path, strerror(reason));
}

stp_status stp_file_write_at(int descriptor, const char *path, uint64_t offset, const void *data,
                             size_t size, stp_error *err)
{
    const unsigned char *bytes = data;
    while (size > 0) {
        ssize_t written = pwrite(descriptor, bytes, size, (off_t)offset);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return write_failed(path, err);
        bytes += written;
        offset += (uint64_t)written;
        size -= (size_t)written;
    }
    return STP_OK;
}

static stp_status flush(stp_output *output, stp_error *err)
{
    stp_status status =
        stp_file_write_at(output->descriptor, output->path, output->size - output->buffered,
                          output->buffer, output->buffered, err);
    if (status == STP_OK)
        output->buffered = 0;
    return status;
}

static bool remove_file(int folder, const char *name)
{
    return unlinkat(folder, name, 0) == 0;
}

uint64_t stp_output_sweep(const char *path, uint64_t *bytes)
{
    return stp_temporary_sweep(path, false, remove_file, bytes);
}

/* Opens a nameless file in the output's folder. The file vanishes when its process ends. Not every
 * file system has such files, and naming one later needs /proc. */
static bool open_nameless(stp_output *output, size_t bytes)
{
    char *folder = strdup(output->path);
    if (!folder)
        return false;
    int file = open(dirname(folder), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
    free(folder);
    if (file < 0)
        return false;
    snprintf(output->temporary, bytes, "/proc/self/fd/%d", file);
    if (access(output->temporary, F_OK) != 0) {
        close(file);
        return false;
    }
    output->descriptor = file;
    return true;
}

/* Opens a file with a temporary name. False with errno set. */
static bool open_named(stp_output *output)
{
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        struct stat info;
        if (!stp_temporary_name(output->temporary, output->path))
            return false;
        int file =
            open(output->temporary, O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (file < 0 && errno != EEXIST)
            return false;
        output->named = file >= 0;
        if (file >= 0 && stp_temporary_mark(file) && fstat(file, &info) == 0 && info.st_nlink > 0) {
            output->descriptor = file;
            return true;
        }
        if (file >= 0) {
            (void)unlink(output->temporary);
            close(file);
        }
        errno = EBUSY;
    }
    return false;
}

static stp_status create(stp_output **out, const char *path, bool force, bool shared,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    struct stat info;
    if (!force && lstat(path, &info) == 0)
        return stp_error_set(err, STP_EXISTS,
                             "%s exists already: give another name or --force to replace it", path);
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode))
        return stp_error_set(err, STP_IO, "%s is not a regular file: give another output", path);
    STP_TRY(stp_alloc(&output, 1, sizeof *output, "output file", err));
    output->descriptor = -1;
    output->force = force;
    size_t bytes = strlen(path) + STP_TEMPORARY_BYTES;
    STP_TRY(stp_text_copy(&output->path, path, "a path", err));
    STP_TRY(stp_alloc(&output->temporary, bytes, 1, "a path", err));
    (void)stp_output_sweep(path, NULL);
    if ((shared || !open_nameless(output, bytes)) && !open_named(output)) {
        status = stp_error_set(err, STP_IO, "%s: cannot be created: %s", path, strerror(errno));
        goto done;
    }
    *out = output;
    output = NULL;
done:
    stp_output_destroy(&output);
    return status;
}

stp_status stp_output_create(stp_output **out, const char *path, bool force, stp_error *err)
{
    return create(out, path, force, false, err);
}

stp_status stp_output_create_shared(stp_output **out, const char *path, bool force, stp_error *err)
{
    return create(out, path, force, true, err);
}

/* ---- files that are changed in place ---- */

/* Locks the file that has the path. Fails if another file got the path meanwhile. */
static stp_status lock(const stp_output *o, const struct stat *opened, stp_error *err)
{
    struct stat named;
    if (flock(o->descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return stp_error_set(err, STP_IO,
                             "%s: another run is changing this file: try again when it has ended",
                             o->path);
    if (stat(o->path, &named) != 0 || named.st_dev != opened->st_dev ||
        named.st_ino != opened->st_ino)
        return stp_error_set(err, STP_IO, "%s was replaced meanwhile: try again", o->path);
    return STP_OK;
}

stp_status stp_output_reopen(stp_output **out, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *o = NULL;
    struct stat info = {0};
    STP_TRY(stp_alloc(&o, 1, sizeof *o, "output file", err));
    o->descriptor = -1;
    STP_TRY(stp_text_copy(&o->path, path, "a path", err));
    const int file = open(path, O_RDWR | O_CLOEXEC | O_NONBLOCK);
    if (file < 0) {
        status = stp_error_set(err, errno == ENOENT ? STP_NOT_FOUND : STP_IO,
                               "%s: cannot be opened for writing: %s", path, strerror(errno));
        goto done;
    }
    o->descriptor = file;
    if (fstat(file, &info) != 0 || !S_ISREG(info.st_mode) || (info.st_mode & 0222) == 0) {
        status = stp_error_set(err, STP_IO, "%s is %s", path,
                               S_ISREG(info.st_mode) ? "write-protected: allow writing, or copy it"
                                                     : "not a regular file: give a file");
        goto done;
    }
    STP_TRY(lock(o, &info, err));
    o->kept = o->size = (uint64_t)info.st_size;
    o->reopened = true;
    *out = o;
    o = NULL;
done:
    stp_output_destroy(&o);
    return status;
}

stp_status stp_output_keep(stp_output *output, uint64_t size, stp_error *err)
{
    if (ftruncate(output->descriptor, (off_t)size) != 0)
        return write_failed(output->path, err);
    output->kept = output->size = size;
    return STP_OK;
}

stp_status stp_output_sync(stp_output *output, stp_error *err)
{
    stp_status status = flush(output, err);
    if (status == STP_OK && fsync(output->descriptor) != 0)
        status = write_failed(output->path, err);
    if (status == STP_OK)
        output->kept = output->size;
    return status;
}

stp_status stp_output_check_input(const char *path, const char *input, stp_error *err)
{
    struct stat out, in;
    if (stat(path, &out) != 0 || stat(input, &in) != 0 || out.st_dev != in.st_dev ||
        out.st_ino != in.st_ino)
        return STP_OK;
    return stp_error_set(err, STP_INVALID_ARGUMENT, "%s is also an input: give another output",
                         path);
}

/* Whether two paths name the same place, that is, the same name in the same folder. The files need
 * not exist. */
static bool is_same_place(const char *a, const char *b)
{
    struct stat one, other;
    char *texts[4] = {strdup(a), strdup(a), strdup(b), strdup(b)};
    bool same = texts[0] && texts[1] && texts[2] && texts[3] &&
                strcmp(basename(texts[0]), basename(texts[2])) == 0 &&
                stat(dirname(texts[1]), &one) == 0 && stat(dirname(texts[3]), &other) == 0 &&
                one.st_dev == other.st_dev && one.st_ino == other.st_ino;
    for (int i = 0; i < 4; i++)
        free(texts[i]);
    return same;
}

stp_status stp_output_check_other(const stp_output *output, const char *path, stp_error *err)
{
    if (!is_same_place(output->path, path))
        return STP_OK;
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "%s is to be written twice: give another name to one of the outputs",
                         path);
}

stp_status stp_output_write(stp_output *output, const void *data, size_t size, stp_error *err)
{
    const unsigned char *bytes = data;
    while (size > 0) {
        size_t room = STP_OUTPUT_BUFFER_BYTES - output->buffered;
        size_t part = size < room ? size : room;
        memcpy(output->buffer + output->buffered, bytes, part);
        output->buffered += part;
        output->size += part;
        bytes += part;
        size -= part;
        if (output->buffered == STP_OUTPUT_BUFFER_BYTES) {
            stp_status status = flush(output, err);
            if (status != STP_OK)
                return status;
        }
    }
    return STP_OK;
}

stp_status stp_output_skip(stp_output *output, uint64_t size, stp_error *err)
{
    const stp_status status = flush(output, err);
    output->size += status == STP_OK ? size : 0;
    return status;
}

stp_status stp_output_write_at(stp_output *output, uint64_t offset, const void *data, size_t size,
                               stp_error *err)
{
    stp_status status = flush(output, err);
    return status == STP_OK
               ? stp_file_write_at(output->descriptor, output->path, offset, data, size, err)
               : status;
}

uint64_t stp_output_size(const stp_output *output)
{
    return output->size;
}

int stp_output_descriptor(const stp_output *output)
{
    return output->descriptor;
}

const char *stp_output_temporary_path(const stp_output *output)
{
    return output->temporary;
}

/* Makes the rename itself durable. If the file system cannot sync a folder, that is no failure. */
static void sync_folder(const char *path)
{
    char *copy = strdup(path);
    if (!copy)
        return;
    int folder = open(dirname(copy), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (folder >= 0) {
        (void)fsync(folder);
        close(folder);
    }
    free(copy);
}

/* Gives the file its name only if the name is free, which rename would not check. False with errno
 * set. */
static bool appear(stp_output *o)
{
    if (linkat(AT_FDCWD, o->temporary, AT_FDCWD, o->path, AT_SYMLINK_FOLLOW) == 0)
        return true;
    if (!o->named || errno == EEXIST)
        return false;
    /* A file system without hard links. */
    o->named = rename(o->temporary, o->path) != 0;
    return !o->named;
}

/* Gives the file its name and replaces whatever has the name now. A nameless file first gets a
 * temporary name. It stays locked meanwhile, so that no other run sweeps it. False with errno set.
 */
static bool replace(stp_output *o)
{
    char nameless[32];
    snprintf(nameless, sizeof nameless, "/proc/self/fd/%d", o->descriptor);
    if (!o->named)
        (void)stp_temporary_mark(o->descriptor);
    for (int attempt = 0; attempt < ATTEMPTS && !o->named; attempt++) {
        if (!stp_temporary_name(o->temporary, o->path))
            return false;
        o->named = linkat(AT_FDCWD, nameless, AT_FDCWD, o->temporary, AT_SYMLINK_FOLLOW) == 0;
        if (!o->named && errno != EEXIST)
            return false;
    }
    if (!o->named || rename(o->temporary, o->path) != 0)
        return false;
    o->named = false;
    return true;
}

stp_status stp_output_commit(stp_output **output, stp_error *err)
{
    stp_output *o = *output;
    stp_status status = STP_OK;
    STP_TRY(flush(o, err));
    if (fsync(o->descriptor) != 0) {
        status = write_failed(o->path, err);
        goto done;
    }
    if (!(o->force ? replace(o) : appear(o))) {
        status = errno == EEXIST
                     ? stp_error_set(err, STP_EXISTS,
                                     "%s appeared meanwhile: give another name or --force", o->path)
                     : write_failed(o->path, err);
        goto done;
    }
    stp_temporary_unmark(o->descriptor);
    sync_folder(o->path);
done:
    stp_output_destroy(output);
    return status;
}

void stp_output_destroy(stp_output **output)
{
    stp_output *o = *output;
    if (!o)
        return;
    if (o->named)
        (void)unlink(o->temporary);
    if (o->reopened && o->size > o->kept) /* else the next change drops what is left */
        (void)!ftruncate(o->descriptor, (off_t)o->kept);
    if (o->descriptor >= 0)
        close(o->descriptor);
    free(o->temporary);
    free(o->path);
    free(o);
    *output = NULL;
}

stp_status stp_file_open(const char *path, int *descriptor, uint64_t *size, stp_error *err)
{
    struct stat info;
    int opened = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* a pipe would wait for a writer */
    if (opened < 0)
        return stp_error_set(err, errno == ENOENT ? STP_NOT_FOUND : STP_IO,
                             "%s: cannot be opened: %s", path, strerror(errno));
    if (fstat(opened, &info) != 0 || !S_ISREG(info.st_mode)) {
        close(opened);
        return stp_error_set(err, STP_IO, "%s is not a regular file: give a file", path);
    }
    *descriptor = opened;
    *size = (uint64_t)info.st_size;
    return STP_OK;
}

stp_status stp_file_join(const char *path, int *descriptor, stp_error *err)
{
    const int opened = open(path, O_WRONLY | O_NOFOLLOW | O_CLOEXEC);
    if (opened < 0)
        return stp_error_set(err, STP_IO, "%s: cannot be opened for writing: %s", path,
                             strerror(errno));
    *descriptor = opened;
    return STP_OK;
}

stp_status stp_file_close(int descriptor, const char *path, stp_error *err)
{
    stp_status status = fsync(descriptor) == 0 ? STP_OK : write_failed(path, err);
    if (close(descriptor) != 0 && status == STP_OK)
        status = write_failed(path, err);
    return status;
}

stp_status stp_file_load(const char *path, uint8_t **out, size_t *size, stp_error *err)
{
    stp_status status = STP_OK;
    int descriptor = -1;
    uint64_t bytes = 0;
    uint8_t *data = NULL;
    STP_TRY(stp_file_open(path, &descriptor, &bytes, err));
    STP_TRY(stp_alloc(&data, (size_t)bytes + 1, 1, "a file", err));
    STP_TRY(stp_file_read_at(descriptor, path, 0, data, (size_t)bytes, err));
    *out = data;
    *size = (size_t)bytes;
    data = NULL;
done:
    free(data);
    if (descriptor >= 0)
        close(descriptor);
    return status;
}

stp_status stp_file_read_at(int descriptor, const char *path, uint64_t offset, void *data,
                            size_t size, stp_error *err)
{
    unsigned char *bytes = data;
    while (size > 0) {
        ssize_t got = pread(descriptor, bytes, size, (off_t)offset);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return stp_error_set(err, STP_IO, "%s: reading at byte %llu failed: %s", path,
                                 (unsigned long long)offset, strerror(errno));
        if (got == 0)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s ends at byte %llu, %zu bytes early: the file was cut; copy it "
                                 "again",
                                 path, (unsigned long long)offset, size);
        bytes += got;
        offset += (uint64_t)got;
        size -= (size_t)got;
    }
    return STP_OK;
}

stp_status stp_folder_make(const char *path, unsigned mode, stp_error *err)
{
    stp_status status = STP_OK;
    char *part = NULL;
    int reason = ENOMEM;
    STP_TRY(stp_text_copy(&part, path, "a path", err));
    for (char *at = part; *at != '\0';) {
        at += strspn(at, "/");
        at += strcspn(at, "/");
        char behind = *at;
        *at = '\0';
        reason = mkdir(part, (mode_t)mode) == 0 || errno == EEXIST ? 0 : errno;
        if (reason != 0) {
            status = stp_error_set(err, STP_IO, "%s: cannot be made: %s", part, strerror(reason));
            goto done;
        }
        *at = behind;
    }
done:
    free(part);
    errno = reason;
    return status;
}

bool stp_path_ends_in(const char *path, const char *ending)
{
    const size_t length = strlen(path), ending_length = strlen(ending);
    return length >= ending_length && strcasecmp(path + length - ending_length, ending) == 0;
}
