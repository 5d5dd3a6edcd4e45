/* Expands files, folders, patterns and lists. */
#include "tools/prep/prep_paths.h"

#include "base/memory.h"
#include "formats/chunk/byte_source.h"
#include "formats/scan/octree/ept_files.h"

#include <errno.h>
#include <fts.h>
#include <glob.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

static stp_status add(prep_paths *paths, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    char *copy = NULL;
    STP_TRY(stp_grow(&paths->list, &paths->capacity, paths->count + 1, sizeof *paths->list,
                     "inputs", err));
    STP_TRY(stp_text_copy(&copy, path, "a path", err));
    paths->list[paths->count++] = copy;
done:
    return status;
}

bool prep_paths_is_scan(const char *name)
{
    const size_t length = stp_is_address(name) ? strcspn(name, "?#") : strlen(name);
    static const char *const endings[] = {".ply", ".obj", ".off", ".stl", ".gltf", ".glb",
                                          ".las", ".laz", ".xyz", ".txt", ".csv",  ".asc",
                                          ".hgt", ".pts", ".ptx", ".pcd", ".e57"};
    for (size_t i = 0; i < sizeof endings / sizeof *endings; i++) {
        const size_t ending = strlen(endings[i]);
        if (length > ending && strncasecmp(name + length - ending, endings[i], ending) == 0)
            return true;
    }
    return stp_is_address(name) && stp_ept_is_named(name);
}

/* Adds FOLDER/ept.json, if it is there. *added says so. */
static stp_status add_set(prep_paths *paths, const char *folder, bool *added, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t length = strlen(folder), size = length + sizeof "/ept.json";
    char *path = NULL;
    STP_TRY(stp_alloc(&path, size, 1, "a path", err));
    snprintf(path, size, "%s%sept.json", folder,
             length > 0 && folder[length - 1] == '/' ? "" : "/");
    *added = access(path, F_OK) == 0;
    if (*added)
        STP_TRY(add(paths, path, err));
done:
    free(path);
    return status;
}

static int compare_entries(const FTSENT **a, const FTSENT **b)
{
    return strcmp((*a)->fts_name, (*b)->fts_name);
}

/* Adds an entry that the walk through a folder met. A scan that cannot be examined is added, too:
 * opening reports links to nothing, pipes and the like. */
static stp_status add_entry(prep_paths *paths, FTS *walk, FTSENT *e, stp_error *err)
{
    const bool hidden = e->fts_level > 0 && e->fts_name[0] == '.';
    switch (e->fts_info) {
    case FTS_D: {
        bool set = false;
        const stp_status status = hidden ? STP_OK : add_set(paths, e->fts_path, &set, err);
        if (hidden || set)
            fts_set(walk, e, FTS_SKIP);
        return status;
    }
    case FTS_F:
    case FTS_SL:
    case FTS_SLNONE:
    case FTS_DEFAULT:
        return !hidden && prep_paths_is_scan(e->fts_name) ? add(paths, e->fts_path, err) : STP_OK;
    case FTS_DNR:
    case FTS_NS:
        return add(paths, e->fts_path, err); /* reported when it is opened */
    case FTS_ERR:
        return stp_error_set(err, STP_IO,
                             "%s cannot be read: %s: allow it, or name the files to be read",
                             e->fts_path, strerror(e->fts_errno));
    default: /* a folder that was left, or one that is met again within itself */
        return STP_OK;
    }
}

static stp_status add_folder(prep_paths *paths, const char *folder, stp_error *err)
{
    stp_status status = STP_OK;
    size_t before = paths->count;
    char *copy = NULL;
    FTS *walk = NULL;
    STP_TRY(stp_text_copy(&copy, folder, "a path", err));
    char *roots[] = {copy, NULL};
    walk = fts_open(roots, FTS_LOGICAL | FTS_NOCHDIR, compare_entries);
    errno = walk ? 0 : errno;
    for (FTSENT *e = walk ? fts_read(walk) : NULL; e; e = fts_read(walk))
        STP_TRY(add_entry(paths, walk, e, err));
    if (errno != 0)
        status = stp_error_set(err, STP_IO, "%s cannot be read: %s", folder, strerror(errno));
    else if (paths->count == before)
        status = stp_error_set(
            err, STP_NOT_FOUND,
            "%s: no file in this folder has the name of a scan (.ply, .las, ...), and "
            "there is no ept.json: "
            "name the files",
            folder);
done:
    if (walk)
        fts_close(walk);
    free(copy);
    return status;
}

/* Adds a file or a folder. */
static stp_status add_plain(prep_paths *paths, const char *path, stp_error *err)
{
    struct stat facts;
    bool folder = stat(path, &facts) == 0 && S_ISDIR(facts.st_mode);
    return folder ? add_folder(paths, path, err) : add(paths, path, err);
}

static stp_status add_pattern(prep_paths *paths, const char *pattern, stp_error *err)
{
    stp_status status = STP_OK;
    glob_t found = {0};
    int code = glob(pattern, 0, NULL, &found);
    if (code == GLOB_NOSPACE)
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the files of %s", pattern);
    else if (code != 0)
        status = stp_error_set(err, STP_NOT_FOUND, "%s: no file is named like this", pattern);
    for (size_t i = 0; code == 0 && i < found.gl_pathc && status == STP_OK; i++)
        status = add_plain(paths, found.gl_pathv[i], err);
    globfree(&found);
    return status;
}

/* Adds one path or pattern. A missing file is reported when it is opened. */
static stp_status add_one(prep_paths *paths, const char *path, stp_error *err)
{
    if (stp_is_address(path))
        return add(paths, path, err);
    if (strpbrk(path, "*?[") && access(path, F_OK) != 0)
        return add_pattern(paths, path, err);
    return add_plain(paths, path, err);
}

/* Adds a line of a list, relative to the list's folder. */
static stp_status add_line(prep_paths *paths, const char *list, const char *line, stp_error *err)
{
    stp_status status = STP_OK;
    const char *slash = strrchr(list, '/');
    size_t folder = *line == '/' || !slash || stp_is_address(line) ? 0 : (size_t)(slash - list) + 1;
    char *path = NULL;
    STP_TRY(stp_alloc(&path, folder + strlen(line) + 1, 1, "a path", err));
    memcpy(path, list, folder);
    memcpy(path + folder, line, strlen(line) + 1);
    STP_TRY(add_one(paths, path, err));
done:
    free(path);
    return status;
}

static stp_status add_list(prep_paths *paths, const char *list, stp_error *err)
{
    stp_status status = STP_OK;
    char *line = NULL;
    size_t size = 0, before = paths->count;
    FILE *file = fopen(list, "r");
    if (!file)
        return stp_error_set(
            err, errno == ENOENT ? STP_NOT_FOUND : STP_IO,
            "the list of inputs `%s` cannot be opened: %s (of a file whose own name "
            "begins with @, write ./@...)",
            list, strerror(errno));
    for (bool first = true; getline(&line, &size, file) >= 0; first = false) {
        const bool marked = first && strncmp(line, "\xef\xbb\xbf", 3) == 0;
        char *begin = line + (marked ? 3 : 0);
        begin[strcspn(begin, "\r\n")] = '\0';
        if (*begin && *begin != '#')
            STP_TRY(add_line(paths, list, begin, err));
    }
    if (ferror(file))
        status = stp_error_set(err, STP_IO, "%s cannot be read: %s", list, strerror(errno));
    else if (paths->count == before)
        status = stp_error_set(err, STP_NOT_FOUND, "%s names no file: give one a line", list);
done:
    free(line);
    fclose(file);
    return status;
}

stp_status prep_paths_add(prep_paths *paths, const char *argument, stp_error *err)
{
    return *argument == '@' ? add_list(paths, argument + 1, err) : add_one(paths, argument, err);
}

void prep_paths_clear(prep_paths *paths)
{
    for (size_t i = 0; i < paths->count; i++)
        free(paths->list[i]);
    free(paths->list);
    *paths = (prep_paths){0};
}
