/* Temporary names, their locks and marks. */
#include "base/temporary.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#define DIGITS 16
static const char mark[] = "user.stipple.part";

bool stp_temporary_name(char *out, const char *path)
{
    uint64_t number = 0;
    if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number)
        return false;
    snprintf(out, strlen(path) + STP_TEMPORARY_BYTES, "%s.%016" PRIx64 ".part", path, number);
    return true;
}

bool stp_temporary_mark(int descriptor)
{
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return false;
    (void)fsetxattr(descriptor, mark, "", 0, 0);
    return true;
}

void stp_temporary_unmark(int descriptor)
{
    (void)fremovexattr(descriptor, mark);
}

static bool is_temporary_of(const char *entry, const char *name)
{
    size_t length = strlen(name);
    if (strncmp(entry, name, length) != 0 || entry[length] != '.')
        return false;
    const char *number = entry + length + 1;
    return strspn(number, "0123456789abcdef") == DIGITS && strcmp(number + DIGITS, ".part") == 0;
}

/* Whether a killed run left this entry: nobody holds its lock, its type is right, and it has our
 * mark (or the file system has no attributes). */
static bool is_left(int descriptor, bool folders, struct stat *info)
{
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 || fstat(descriptor, info) != 0 ||
        (folders ? !S_ISDIR(info->st_mode) : !S_ISREG(info->st_mode)))
        return false;
    return fgetxattr(descriptor, mark, NULL, 0) >= 0 || errno == ENOTSUP;
}

uint64_t stp_temporary_sweep(const char *path, bool folders, stp_temporary_remove *remove,
                             uint64_t *bytes)
{
    char *folder_copy = strdup(path), *name_copy = strdup(path);
    DIR *folder = folder_copy ? opendir(dirname(folder_copy)) : NULL;
    const char *name = folder && name_copy ? basename(name_copy) : NULL;
    const int mode = (folders ? O_RDONLY | O_DIRECTORY : O_RDWR) | O_NONBLOCK;
    uint64_t count = 0, sum = 0;
    for (struct dirent *e = name ? readdir(folder) : NULL; e; e = readdir(folder)) {
        struct stat info;
        if (!is_temporary_of(e->d_name, name))
            continue;
        int entry = openat(dirfd(folder), e->d_name, mode | O_CLOEXEC | O_NOFOLLOW);
        if (entry < 0)
            continue;
        if (is_left(entry, folders, &info) && remove(dirfd(folder), e->d_name)) {
            count++;
            sum += (uint64_t)info.st_size;
        }
        close(entry);
    }
    if (folder)
        closedir(folder);
    free(folder_copy);
    free(name_copy);
    if (bytes)
        *bytes = sum;
    return count;
}

int stp_temporary_nameless(const char *folder)
{
    int descriptor = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, S_IRUSR | S_IWUSR);
    if (descriptor >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL))
        return descriptor;
    size_t size = strlen(folder) + sizeof "/.stipple-XXXXXX";
    char *path = malloc(size); /* an older file system: the file has a name for a moment */
    if (!path)
        return -1;
    snprintf(path, size, "%s/.stipple-XXXXXX", folder);
    descriptor = mkostemp(path, O_CLOEXEC);
    if (descriptor >= 0)
        unlink(path);
    free(path);
    return descriptor;
}
