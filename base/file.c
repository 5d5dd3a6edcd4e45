/* Output files that appear whole or not at all; input files; folders. */
#include "base/file.h"

#include "base/memory.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define STP_OUTPUT_BUFFER_BYTES (1u << 20)
#define TEMPORARY_SUFFIX_LIMIT 32

struct stp_output {
    int descriptor;
    bool force;
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

static stp_status write_all(stp_output *output, const void *data, size_t size, uint64_t offset,
                            stp_error *err)
{
    const unsigned char *bytes = data;
    while (size > 0) {
        ssize_t written = pwrite(output->descriptor, bytes, size, (off_t)offset);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return write_failed(output->path, err);
        bytes += written;
        offset += (uint64_t)written;
        size -= (size_t)written;
    }
    return STP_OK;
}

static stp_status flush(stp_output *output, stp_error *err)
{
    stp_status status =
        write_all(output, output->buffer, output->buffered, output->size - output->buffered, err);
    if (status == STP_OK)
        output->buffered = 0;
    return status;
}

/* True for "NAME.123.part", the temporary file of an output called NAME. */
static bool is_temporary_of(const char *entry, const char *name)
{
    size_t length = strlen(name);
    if (strncmp(entry, name, length) != 0 || entry[length] != '.')
        return false;
    const char *number = entry + length + 1;
    size_t digits = strspn(number, "0123456789");
    return digits > 0 && strcmp(number + digits, ".part") == 0;
}

uint64_t stp_output_sweep(const char *path, uint64_t *bytes)
{
    char *folder_copy = strdup(path), *name_copy = strdup(path);
    DIR *folder = folder_copy ? opendir(dirname(folder_copy)) : NULL;
    const char *name = folder && name_copy ? basename(name_copy) : NULL;
    uint64_t count = 0, sum = 0;
    for (struct dirent *e = name ? readdir(folder) : NULL; e; e = readdir(folder)) {
        struct stat info;
        if (!is_temporary_of(e->d_name, name))
            continue;
        int file = openat(dirfd(folder), e->d_name, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
        if (file < 0)
            continue;
        if (flock(file, LOCK_EX | LOCK_NB) == 0 && fstat(file, &info) == 0 &&
            unlinkat(dirfd(folder), e->d_name, 0) == 0) {
            count++;
            sum += (uint64_t)info.st_size;
        }
        close(file);
    }
    if (folder)
        closedir(folder);
    free(folder_copy);
    free(name_copy);
    if (bytes)
        *bytes = sum;
    return count;
}

/* Opens and locks the temporary file; -1 with errno set if that fails. Another run may sweep it
 * between the two steps: then it is made once more. A file system without locks is no failure. */
static int open_temporary(const char *path)
{
    for (int attempt = 0; attempt < 8; attempt++) {
        struct stat info;
        int file = open(path, O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
        if (file < 0)
            return -1;
        bool taken = flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
        if (!taken && fstat(file, &info) == 0 && info.st_nlink > 0)
            return file;
        close(file);
    }
    errno = EBUSY;
    return -1;
}

static void name_temporary(char *out, size_t size, const char *path)
{
    snprintf(out, size, "%s.%ld.part", path, (long)getpid());
}

stp_status stp_output_create(stp_output **out, const char *path, bool force, stp_error *err)
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
    size_t length = strlen(path) + TEMPORARY_SUFFIX_LIMIT;
    STP_TRY(stp_alloc(&output->path, length, 1, "path", err));
    STP_TRY(stp_alloc(&output->temporary, length, 1, "path", err));
    snprintf(output->path, length, "%s", path);
    name_temporary(output->temporary, length, path);
    (void)stp_output_sweep(path, NULL);
    output->descriptor = open_temporary(output->temporary);
    if (output->descriptor < 0) {
        status = stp_error_set(err, STP_IO, "%s: cannot be created: %s", path, strerror(errno));
        goto done;
    }
    *out = output;
    output = NULL;
done:
    stp_output_destroy(&output);
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

/* Two names of one output have one temporary file. */
stp_status stp_output_check_other(const stp_output *output, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    size_t length = strlen(path) + TEMPORARY_SUFFIX_LIMIT;
    struct stat own, other;
    char *temporary = NULL;
    STP_TRY(stp_alloc(&temporary, length, 1, "path", err));
    name_temporary(temporary, length, path);
    if (stat(temporary, &other) == 0 && fstat(output->descriptor, &own) == 0 &&
        own.st_dev == other.st_dev && own.st_ino == other.st_ino)
        status = stp_error_set(err, STP_INVALID_ARGUMENT,
                               "%s is to be written twice: give another name to one of the outputs",
                               path);
done:
    free(temporary);
    return status;
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

stp_status stp_output_write_at(stp_output *output, uint64_t offset, const void *data, size_t size,
                               stp_error *err)
{
    stp_status status = flush(output, err);
    return status == STP_OK ? write_all(output, data, size, offset, err) : status;
}

uint64_t stp_output_size(const stp_output *output)
{
    return output->size;
}

const char *stp_output_temporary_path(const stp_output *output)
{
    return output->temporary;
}

/* Makes the rename itself durable; a file system that cannot sync a folder is no failure. */
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

stp_status stp_output_commit(stp_output **output, stp_error *err)
{
    stp_output *o = *output;
    stp_status status = STP_OK;
    STP_TRY(flush(o, err));
    if (fsync(o->descriptor) != 0) {
        status = write_failed(o->path, err);
        goto done;
    }
    int descriptor = o->descriptor;
    o->descriptor = -1;
    if (close(descriptor) != 0) {
        status = write_failed(o->path, err);
        goto done;
    }
    /* Without force a name that appeared meanwhile must stay: link refuses it, rename would not. */
    int failed = o->force ? rename(o->temporary, o->path) : link(o->temporary, o->path);
    if (failed && !o->force && errno != EEXIST)
        failed = rename(o->temporary, o->path); /* a file system without hard links */
    if (failed) {
        status = errno == EEXIST
                     ? stp_error_set(err, STP_EXISTS,
                                     "%s appeared meanwhile: give another name or --force", o->path)
                     : write_failed(o->path, err);
        goto done;
    }
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
    if (o->descriptor >= 0)
        close(o->descriptor);
    if (o->temporary)
        (void)unlink(o->temporary);
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
