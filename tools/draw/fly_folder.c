/* Numbered frames, with fly.json beside them. */
#include "tools/draw/fly_folder.h"

#include "base/json.h"
#include "base/memory.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define NAME_BYTES 64
static const char job_name[] = "fly.json";
/* The endings of a frame's files. */
static const char *const endings[3] = {".png", "_depth.exr", "_normals.exr"};

struct fly_folder {
    char *path;
    char *files[3]; /* names of the files of the last frame asked for */
    size_t file_bytes;
    bool depth, normals;
};

/* True if the name is one that fly itself gives to a frame. */
static bool is_frame(const char *name)
{
    static const char start[] = "frame_";
    if (strncmp(name, start, sizeof start - 1) != 0)
        return false;
    name += sizeof start - 1;
    size_t digits = strspn(name, "0123456789");
    bool known = false;
    for (int i = 0; i < 3; i++)
        known |= strcmp(name + digits, endings[i]) == 0;
    return known && digits >= 6;
}

/* Counts the frames in a folder, or removes them. */
static stp_status walk_frames(const char *path, bool removes, uint64_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    DIR *folder = opendir(path);
    *count = 0;
    if (folder == NULL)
        return stp_error_set(err, STP_IO, "%s: the folder cannot be read: %s", path,
                             strerror(errno));
    for (struct dirent *e = readdir(folder); e != NULL; e = readdir(folder)) {
        if (!is_frame(e->d_name))
            continue;
        ++*count;
        if (removes && unlinkat(dirfd(folder), e->d_name, 0) != 0) {
            status = stp_error_set(err, STP_IO, "%s/%s: cannot be replaced: %s", path, e->d_name,
                                   strerror(errno));
            break;
        }
    }
    closedir(folder);
    return status;
}

static stp_status make_folder(const char *path, stp_error *err)
{
    struct stat info;
    if (mkdir(path, 0777) == 0)
        return STP_OK;
    int reason = errno;
    if (reason == EEXIST && stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return STP_OK;
    if (reason == EEXIST)
        return stp_error_set(err, STP_EXISTS,
                             "%s is a file: give -o a folder, or a film's name that ends in .mp4",
                             path);
    return stp_error_set(err, STP_IO, "%s: the folder cannot be made: %s", path, strerror(reason));
}

/* Compares the job of the folder with the present job. */
static stp_status compare_jobs(const cJSON *there, const cJSON *job, const char *path,
                               stp_error *err)
{
    const cJSON *item = NULL;
    cJSON_ArrayForEach(item, job)
    {
        const cJSON *other = cJSON_GetObjectItemCaseSensitive(there, item->string);
        const char *text = cJSON_IsString(other) ? other->valuestring : "not said";
        if (!cJSON_IsString(other) || strcmp(text, item->valuestring) != 0)
            return stp_error_set(
                err, STP_EXISTS,
                "%s: the frames there are of another job (%s: %.200s, now %.200s): "
                "give another folder, or --force to make them anew",
                path, item->string, text, item->valuestring);
    }
    return STP_OK;
}

/* Continues the job in the folder, or begins one. */
static stp_status settle_job(const fly_folder_params *params, const char *file, stp_error *err)
{
    stp_status status = STP_OK;
    cJSON *there = NULL;
    uint64_t frames = 0;
    STP_TRY(walk_frames(params->path, params->force, &frames, err));
    bool known = access(file, F_OK) == 0;
    if (!params->force && frames > 0 && !known) {
        status = stp_error_set(err, STP_EXISTS,
                               "%s holds frames, but no %s that says of what: give another folder, "
                               "or --force to replace them",
                               params->path, job_name);
        goto done;
    }
    if (known && !params->force && frames > 0) {
        STP_TRY(stp_json_load(&there, file, "what fly writes beside its frames", err));
        STP_TRY(compare_jobs(there, params->job, params->path, err));
        goto done;
    }
    STP_TRY(stp_json_save(cJSON_Duplicate(params->job, true), file, true, err));
done:
    cJSON_Delete(there);
    return status;
}

stp_status fly_folder_open(fly_folder **out, const fly_folder_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    fly_folder *folder = NULL;
    STP_TRY(stp_alloc(&folder, 1, sizeof *folder, "a folder of frames", err));
    folder->depth = params->depth;
    folder->normals = params->normals;
    folder->file_bytes = strlen(params->path) + NAME_BYTES;
    STP_TRY(stp_text_copy(&folder->path, params->path, "a path", err));
    for (int i = 0; i < 3; i++)
        STP_TRY(stp_alloc(&folder->files[i], folder->file_bytes, 1, "a path", err));
    STP_TRY(make_folder(params->path, err));
    snprintf(folder->files[0], folder->file_bytes, "%s/%s", params->path, job_name);
    STP_TRY(settle_job(params, folder->files[0], err));
    *out = folder;
    folder = NULL;
done:
    fly_folder_close(&folder);
    return status;
}

void fly_folder_close(fly_folder **folder)
{
    if (*folder == NULL)
        return;
    for (int i = 0; i < 3; i++)
        free((*folder)->files[i]);
    free((*folder)->path);
    free(*folder);
    *folder = NULL;
}

draw_outputs fly_folder_files(fly_folder *f, uint64_t number)
{
    for (int i = 0; i < 3; i++)
        snprintf(f->files[i], f->file_bytes, "%s/frame_%06llu%s", f->path,
                 (unsigned long long)number, endings[i]);
    return (draw_outputs){.picture = f->files[0],
                          .depth = f->depth ? f->files[1] : NULL,
                          .normals = f->normals ? f->files[2] : NULL};
}

bool fly_folder_has(fly_folder *f, uint64_t number)
{
    draw_outputs files = fly_folder_files(f, number);
    return access(files.picture, F_OK) == 0 &&
           (files.depth == NULL || access(files.depth, F_OK) == 0) &&
           (files.normals == NULL || access(files.normals, F_OK) == 0);
}
