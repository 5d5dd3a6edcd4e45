/* Names and opens the files of an Entwine Point Tile set. */
#include "formats/scan/octree/ept_files.h"

#include "base/json.h"
#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define HEAD_NAME "ept.json"
/* A page of a million nodes has fewer bytes; what the JSON reader makes of it takes some twenty
 * times as many. */
#define PAGE_BYTES_MOST (24u << 20)
/* A tile has some megabytes. */
#define TILE_BYTES_MOST (UINT64_C(1) << 31)
#define KEY_BYTES 64u

/* The length of a path without a query. */
static size_t name_length(const char *path)
{
    return stp_is_address(path) ? strcspn(path, "?#") : strlen(path);
}

/* The length of the part that ends in the last slash. */
static size_t folder_length(const char *path, size_t length)
{
    while (length > 0 && path[length - 1] != '/')
        length--;
    return length;
}

bool stp_ept_is_named(const char *path)
{
    const size_t length = name_length(path), folder = folder_length(path, length);
    return length - folder == strlen(HEAD_NAME) &&
           strncasecmp(path + folder, HEAD_NAME, strlen(HEAD_NAME)) == 0;
}

stp_ept_files stp_ept_files_of(const char *path, const stp_byte_source_params *web)
{
    const size_t length = name_length(path);
    return (stp_ept_files){path, folder_length(path, length), length, web};
}

/* FOLDER/WITHIN/D-X-Y-Z.ENDING, with the query of ept.json. */
static stp_status name_file(char **out, const stp_ept_files *files, const char *within,
                            stp_octree_key key, const char *ending, stp_error *err)
{
    const char *query = files->path + files->name_length;
    const size_t bytes =
        files->folder_length + strlen(within) + KEY_BYTES + strlen(ending) + strlen(query);
    const stp_status status = stp_alloc(out, bytes, 1, "a path", err);
    if (status == STP_OK)
        snprintf(*out, bytes, "%.*s%s/%u-%u-%u-%u%s%s", (int)files->folder_length, files->path,
                 within, key.depth, key.x, key.y, key.z, ending, query);
    return status;
}

/* Passes a failure on. Of a file that is missing, says who needs it. */
static stp_status explain(stp_status status, const stp_error *why, stp_error *err)
{
    if (status == STP_OK)
        return STP_OK;
    if (status != STP_NOT_FOUND)
        return stp_error_set(err, status, "%s", why->message);
    return stp_error_set(err, status, "%s; the EPT needs it: copy the whole set again",
                         why->message);
}

/* ---- JSON ---- */

static stp_status read_text(char **out, size_t *size, char **name, const char *path,
                            const stp_byte_source_params *web, stp_error *err)
{
    stp_status status = STP_OK;
    stp_byte_source *source = NULL;
    char *text = NULL;
    STP_TRY(stp_byte_source_open(&source, path, web, err));
    STP_TRY(stp_text_copy(name, stp_byte_source_name(source), "a path", err));
    if (stp_byte_source_size(source) > PAGE_BYTES_MOST) {
        status =
            stp_error_set(err, STP_FORMAT,
                          "%s: has %llu bytes, and at most %u are read of a file of an EPT: "
                          "is it the right file?",
                          *name, (unsigned long long)stp_byte_source_size(source), PAGE_BYTES_MOST);
        goto done;
    }
    *size = (size_t)stp_byte_source_size(source);
    STP_TRY(stp_alloc(&text, *size + 1, 1, "a JSON file", err));
    STP_TRY(stp_byte_source_read(source, 0, text, *size, err));
    *out = text;
    text = NULL;
done:
    free(text);
    stp_byte_source_close(&source);
    return status;
}

stp_status stp_ept_files_json(const stp_ept_files *files, const stp_octree_key *key, cJSON **out,
                              char **name, stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    char *path = NULL, *text = NULL, *printed = NULL;
    size_t size = 0;
    if (key)
        STP_TRY(name_file(&path, files, "ept-hierarchy", *key, ".json", err));
    status = read_text(&text, &size, &printed, key ? path : files->path, files->web, &why);
    if (status != STP_OK) {
        status = key ? explain(status, &why, err) : stp_error_set(err, status, "%s", why.message);
        goto done;
    }
    STP_TRY(stp_json_parse(out, text, size, printed,
                           "a JSON object, as EPT has them: it was cut or is another file; copy "
                           "it again",
                           err));
    if (name) {
        *name = printed;
        printed = NULL;
    }
done:
    free(path);
    free(text);
    free(printed);
    return status;
}

/* ---- tiles ---- */

/* Copies a tile of a server. */
static stp_status copy_tile(const stp_ept_files *files, stp_ept_tile_file *file, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_mirror_params params = {.web = files->web};
    STP_TRY(stp_mirror_open(&file->mirror, file->path, &params, err));
    if (stp_mirror_size(file->mirror) > TILE_BYTES_MOST) {
        status = stp_error_set(err, STP_LIMIT,
                               "%s: has %llu bytes, and at most %llu are read of a tile: is it the "
                               "right file?",
                               stp_mirror_name(file->mirror),
                               (unsigned long long)stp_mirror_size(file->mirror),
                               (unsigned long long)TILE_BYTES_MOST);
        goto done;
    }
    STP_TRY(stp_mirror_need(file->mirror, 0, UINT64_MAX, err));
    STP_TRY(stp_text_copy(&file->name, stp_mirror_name(file->mirror), "a path", err));
    free(file->path);
    file->path = NULL;
    STP_TRY(stp_text_copy(&file->path, stp_mirror_path(file->mirror), "a path", err));
done:
    return status;
}

stp_status stp_ept_files_tile(const stp_ept_files *files, stp_octree_key key, const char *ending,
                              stp_ept_tile_file *file, stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    stp_byte_source *source = NULL;
    stp_ept_tile_file_close(file);
    STP_TRY(name_file(&file->path, files, "ept-data", key, ending, err));
    if (stp_is_address(file->path)) {
        STP_TRY(explain(copy_tile(files, file, &why), &why, err));
    } else {
        STP_TRY(explain(stp_byte_source_open(&source, file->path, NULL, &why), &why, err));
        STP_TRY(stp_text_copy(&file->name, file->path, "a path", err));
    }
done:
    stp_byte_source_close(&source);
    return status;
}

void stp_ept_tile_file_close(stp_ept_tile_file *file)
{
    stp_mirror_close(&file->mirror);
    free(file->path);
    free(file->name);
    *file = (stp_ept_tile_file){0};
}
