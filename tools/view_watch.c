/* The state of a folder of shaders. */
#include "tools/view_watch.h"

#include <dirent.h>
#include <fcntl.h>
#include <stddef.h>
#include <sys/stat.h>

/* FNV-1a of eight bytes. */
static uint64_t mix(uint64_t hash, uint64_t value)
{
    for (int i = 0; i < 8; i++)
        hash = (hash ^ (value >> (8 * i) & 0xff)) * UINT64_C(0x100000001b3);
    return hash;
}

uint64_t view_watch_state(const char *folder)
{
    uint64_t state = 0;
    DIR *dir = folder != NULL ? opendir(folder) : NULL;
    const struct dirent *entry;
    if (dir == NULL)
        return 0;
    while ((entry = readdir(dir)) != NULL) {
        struct stat s;
        uint64_t hash = UINT64_C(0xcbf29ce484222325);
        if (fstatat(dirfd(dir), entry->d_name, &s, 0) != 0 || !S_ISREG(s.st_mode))
            continue;
        for (const char *c = entry->d_name; *c != '\0'; c++)
            hash = mix(hash, (unsigned char)*c);
        hash = mix(hash, (uint64_t)s.st_size);
        hash = mix(hash, (uint64_t)s.st_mtim.tv_sec);
        state += mix(hash, (uint64_t)s.st_mtim.tv_nsec); /* in whatever order they are listed */
    }
    closedir(dir);
    return state;
}
