/* Names, times and sizes in the folder of prepared scans. */
#include "tools/open/open_cache.h"

#include "base/file.h"
#include "base/memory.h"
#include "tools/prep/prep_system.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#define KEY_DIGITS 32
#define ENDING ".stipple"
#define NAME_LENGTH (KEY_DIGITS + sizeof ENDING - 1)
/* Part of every key. Raise it when prep writes other bytes for the same scan and options. */
#define PREP_STATE "stipple " STIPPLE_VERSION " prep 2"

/* Joins two parts of a path. */
static stp_status join(char **out, const char *folder, const char *name, stp_error *err)
{
    const size_t bytes = strlen(folder) + strlen(name) + 2;
    stp_status status = stp_alloc(out, bytes, 1, "a path", err);
    if (status == STP_OK)
        snprintf(*out, bytes, "%s/%s", folder, name);
    return status;
}

/* The XDG specification says to ignore relative paths. */
stp_status open_cache_folder(char **out, const char *given, stp_error *err)
{
    const char *cache = getenv("XDG_CACHE_HOME"), *home = getenv("HOME");
    if (given)
        return stp_text_copy(out, given, "a path", err);
    if (cache && cache[0] == '/')
        return join(out, cache, "stipple", err);
    if (home && home[0] == '/')
        return join(out, home, ".cache/stipple", err);
    return stp_error_set(err, STP_IO,
                         "there is no folder to keep models in: set HOME or "
                         "XDG_CACHE_HOME");
}

stp_status open_cache_make(const char *folder, stp_error *err)
{
    stp_status status = STP_OK;
    char *probe = NULL;
    stp_output *output = NULL;
    STP_TRY(stp_folder_make(folder, 0700, err));
    STP_TRY(join(&probe, folder, "probe", err));
    STP_TRY(stp_output_create(&output, probe, true, err));
done:
    stp_output_destroy(&output);
    free(probe);
    return status;
}

static void add_text(XXH3_state_t *hash, const char *text)
{
    XXH3_128bits_update(hash, text, strlen(text) + 1);
}

/* Adds the size and time of a file; zeros if there is none. */
static void add_state(XXH3_state_t *hash, const char *path)
{
    struct stat facts = {0};
    (void)stat(path, &facts);
    const int64_t numbers[] = {facts.st_size, facts.st_mtim.tv_sec, facts.st_mtim.tv_nsec};
    XXH3_128bits_update(hash, numbers, sizeof numbers);
}

/* Adds a scan, and the file beside it that may say its coordinate system. */
static void add_scan(XXH3_state_t *hash, const char *path)
{
    char *real = realpath(path, NULL), *beside = NULL;
    add_text(hash, real ? real : path);
    add_state(hash, path);
    if (prep_system_prj(&beside, path, NULL) == STP_OK)
        add_state(hash, beside);
    free(beside);
    free(real);
}

stp_status open_cache_path(char **out, const char *folder, const prep_paths *scans,
                           const char *attributes, stp_error *err)
{
    char name[NAME_LENGTH + 1];
    XXH3_state_t *hash = XXH3_createState();
    if (!hash)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for a hash");
    XXH3_128bits_reset(hash);
    add_text(hash, PREP_STATE);
    if (attributes)
        add_text(hash, attributes);
    for (size_t i = 0; i < scans->count; i++)
        add_scan(hash, scans->list[i]);
    const XXH128_hash_t key = XXH3_128bits_digest(hash);
    XXH3_freeState(hash);
    snprintf(name, sizeof name, "%016" PRIx64 "%016" PRIx64 ENDING, (uint64_t)key.high64,
             (uint64_t)key.low64);
    return join(out, folder, name, err);
}

void open_cache_use(const char *path)
{
    const struct timespec times[2] = {{.tv_nsec = UTIME_NOW}, {.tv_nsec = UTIME_OMIT}};
    (void)utimensat(AT_FDCWD, path, times, 0);
}

/* ---- keeping within the bound ---- */

typedef struct kept {
    char name[NAME_LENGTH + 1];
    uint64_t bytes;
    struct timespec used;
} kept;

/* Whether a name is KEY.stipple, perhaps with more behind it. */
static bool is_kept_name(const char *name)
{
    return strspn(name, "0123456789abcdef") == KEY_DIGITS &&
           strncmp(name + KEY_DIGITS, ENDING, sizeof ENDING - 1) == 0;
}

/* The one that was used last comes first. */
static int compare_use(const void *a, const void *b)
{
    const struct timespec *x = &((const kept *)a)->used, *y = &((const kept *)b)->used;
    if (x->tv_sec != y->tv_sec)
        return x->tv_sec < y->tv_sec ? 1 : -1;
    return (x->tv_nsec < y->tv_nsec) - (x->tv_nsec > y->tv_nsec);
}

/* Removes a temporary file of a killed run, KEY.stipple.DIGITS.part. */
static void sweep(const char *folder, const char *name)
{
    char model[NAME_LENGTH + 1] = "", *path = NULL;
    memcpy(model, name, NAME_LENGTH);
    if (join(&path, folder, model, NULL) == STP_OK)
        (void)stp_output_sweep(path, NULL);
    free(path);
}

void open_cache_trim(const char *folder, uint64_t bytes)
{
    DIR *dir = opendir(folder);
    kept *list = NULL;
    size_t count = 0, capacity = 0;
    uint64_t sum = 0;
    for (struct dirent *e = dir ? readdir(dir) : NULL; e; e = readdir(dir)) {
        struct stat facts;
        if (!is_kept_name(e->d_name))
            continue;
        if (e->d_name[NAME_LENGTH] != '\0')
            sweep(folder, e->d_name);
        else if (fstatat(dirfd(dir), e->d_name, &facts, AT_SYMLINK_NOFOLLOW) == 0 &&
                 S_ISREG(facts.st_mode) &&
                 stp_grow(&list, &capacity, count + 1, sizeof *list, "the cache", NULL) == STP_OK) {
            list[count] = (kept){.bytes = (uint64_t)facts.st_size, .used = facts.st_atim};
            memcpy(list[count++].name, e->d_name, NAME_LENGTH + 1);
        }
    }
    if (count > 0)
        qsort(list, count, sizeof *list, compare_use);
    for (size_t i = 0; i < count; i++) {
        sum += list[i].bytes;
        if (sum > bytes)
            (void)unlinkat(dirfd(dir), list[i].name, 0);
    }
    if (dir)
        closedir(dir);
    free(list);
}
