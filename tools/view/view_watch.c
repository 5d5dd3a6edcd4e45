/* Computes the state of a folder of shaders. */
#include "tools/view/view_watch.h"

#include <dirent.h>
#include <fcntl.h>
#include <stddef.h>
#include <sys/stat.h>
#include <unistd.h>

#define OPEN_FLAGS (O_RDONLY | O_DIRECTORY | O_CLOEXEC)

/* Adds eight bytes by FNV-1a. */
static uint64_t mix(uint64_t hash, uint64_t value)
{
    for (int i = 0; i < 8; i++)
        hash = (hash ^ (value >> (8 * i) & 0xff)) * UINT64_C(0x100000001b3);
    return hash;
}

static uint64_t name_hash(const char *name)
{
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (; *name != '\0'; name++)
        hash = mix(hash, (unsigned char)*name);
    return hash;
}

/* The state of the files in an open folder and in folders one level below it. Closes the folder. */
static uint64_t folder_state(int folder, int below)
{
    uint64_t state = 0;
    DIR *dir = folder >= 0 ? fdopendir(folder) : NULL;
    const struct dirent *entry;
    if (dir == NULL) {
        if (folder >= 0)
            close(folder);
        return 0;
    }
    while ((entry = readdir(dir)) != NULL) {
        struct stat s;
        if (fstatat(dirfd(dir), entry->d_name, &s, 0) != 0)
            continue;
        if (S_ISDIR(s.st_mode) && below > 0 && entry->d_name[0] != '.')
            state += mix(name_hash(entry->d_name),
                         folder_state(openat(dirfd(dir), entry->d_name, OPEN_FLAGS), below - 1));
        if (!S_ISREG(s.st_mode))
            continue;
        uint64_t hash = mix(name_hash(entry->d_name), (uint64_t)s.st_size);
        hash = mix(hash, (uint64_t)s.st_mtim.tv_sec);
        state +=
            mix(hash,
                (uint64_t)s.st_mtim.tv_nsec); /* a sum does not depend on the order of the files */
    }
    closedir(dir);
    return state;
}

uint64_t view_watch_state(const char *folder)
{
    return folder != NULL ? folder_state(open(folder, OPEN_FLAGS), 1) : 0;
}
