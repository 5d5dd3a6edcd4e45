/* Takes a glTF file apart. */
#include "formats/scan/gltf/gltf_file.h"

#include "formats/scan/gltf/gltf_meshopt.h" /* the name of the extension */

#include "base/file.h"
#include "base/json.h"
#include "base/memory.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The chunks of a .glb, whose words are little-endian (glTF 2.0, 4.4). */
#define GLB_HEAD_BYTES 12u
#define GLB_CHUNK_HEAD_BYTES 8u
#define GLB_JSON 0x4e4f534au
#define GLB_BINARY 0x004e4942u

stp_status stp_gltf_corrupt(const stp_gltf_file *file, stp_error *err, const char *format, ...)
{
    char what[160];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    return stp_error_set(err, STP_CORRUPT, "%s: %s: mend the file or export it again", file->path,
                         what);
}

/* Finds the JSON and the binary chunk. */
static stp_status split_binary(stp_gltf_file *f, const uint8_t **json, size_t *json_size,
                               stp_error *err)
{
    *json = NULL;
    if (f->size < GLB_HEAD_BYTES + GLB_CHUNK_HEAD_BYTES)
        return stp_gltf_corrupt(f, err, "it ends within its header");
    if (stp_gltf_word(f->bytes + 4) != 2)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: glTF of version %u: convert it to 2.0 (Blender does)", f->path,
                             stp_gltf_word(f->bytes + 4));
    for (size_t at = GLB_HEAD_BYTES; f->size - at >= GLB_CHUNK_HEAD_BYTES;) {
        const uint32_t bytes = stp_gltf_word(f->bytes + at),
                       kind = stp_gltf_word(f->bytes + at + 4);
        at += GLB_CHUNK_HEAD_BYTES;
        if (bytes > f->size - at)
            return stp_gltf_corrupt(f, err, "it ends within a chunk");
        if (kind == GLB_JSON && *json == NULL) {
            *json = f->bytes + at;
            *json_size = bytes;
        } else if (kind == GLB_BINARY && f->binary.data == NULL) {
            f->binary = (stp_gltf_bytes){f->bytes + at, bytes, NULL};
        }
        at += bytes;
    }
    return *json != NULL ? STP_OK : stp_gltf_corrupt(f, err, "it has no JSON chunk");
}

const cJSON *stp_gltf_item(const stp_gltf_file *f, stp_gltf_list list, uint32_t index)
{
    return index < f->counts[list] ? f->lists[list][index] : NULL;
}

/* cJSON's lists are chains. */
static stp_status list_items(stp_gltf_file *f, stp_error *err)
{
    static const char *const names[STP_GLTF_LIST_COUNT] = {
        "scenes",   "nodes",  "meshes",    "accessors", "bufferViews",
        "textures", "images", "materials", "buffers",   "samplers"};
    for (int i = 0; i < STP_GLTF_LIST_COUNT; i++) {
        const cJSON *list = cJSON_GetObjectItemCaseSensitive(f->json, names[i]), *item;
        const int count = cJSON_IsArray(list) ? cJSON_GetArraySize(list) : 0;
        stp_status status = stp_alloc(&f->lists[i], (size_t)count + 1, sizeof *f->lists[i],
                                      "lists of a glTF file", err);
        if (status != STP_OK)
            return status;
        item = count > 0 ? list->child : NULL;
        for (; item != NULL; item = item->next)
            f->lists[i][f->counts[i]++] = item;
    }
    return STP_OK;
}

stp_status stp_gltf_whole(const stp_gltf_file *f, const cJSON *object, const char *key,
                          uint64_t otherwise, uint64_t *out, stp_error *err)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    *out = otherwise;
    if (item == NULL)
        return STP_OK;
    const double number = cJSON_IsNumber(item) ? item->valuedouble : -1.0;
    if (!(number >= 0.0 && number < 9e15) || (double)(uint64_t)number != number)
        return stp_gltf_corrupt(f, err, "\"%s\" is no whole number", key);
    *out = (uint64_t)number;
    return STP_OK;
}

stp_status stp_gltf_index(const stp_gltf_file *f, const cJSON *object, const char *key,
                          uint32_t *out, stp_error *err)
{
    uint64_t whole;
    stp_status status = stp_gltf_whole(f, object, key, STP_GLTF_NONE, &whole, err);
    *out = whole < STP_GLTF_NONE ? (uint32_t)whole : STP_GLTF_NONE;
    return status;
}

stp_status stp_gltf_range(const stp_gltf_file *f, const cJSON *object, stp_gltf_bytes *out,
                          stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t offset, size;
    uint32_t buffer;
    STP_TRY(stp_gltf_index(f, object, "buffer", &buffer, err));
    STP_TRY(stp_gltf_whole(f, object, "byteOffset", 0, &offset, err));
    STP_TRY(stp_gltf_whole(f, object, "byteLength", 0, &size, err));
    if (buffer >= f->buffer_count || offset > f->buffers[buffer].size ||
        size > f->buffers[buffer].size - offset)
        return stp_gltf_corrupt(f, err, "a buffer view reaches beyond its buffer");
    *out = (stp_gltf_bytes){.data = f->buffers[buffer].data + offset, .size = (size_t)size};
done:
    return status;
}

/* ---- what URIs name ---- */

/* The value of a digit of base64 (RFC 4648); 64: it is none. */
static unsigned base64_digit(char c)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = c != '\0' ? strchr(digits, c) : NULL;
    return at != NULL ? (unsigned)(at - digits) : 64u;
}

static stp_status decode_base64(const stp_gltf_file *f, const char *text, stp_gltf_bytes *out,
                                stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    size_t length = strcspn(text, "="), size = 0;
    uint32_t word = 0;
    STP_TRY(stp_alloc(&bytes, length / 4 * 3 + 3, 1, "a buffer", err));
    for (size_t i = 0; i < length; i++) {
        const unsigned digit = base64_digit(text[i]);
        if (digit == 64) {
            status = stp_gltf_corrupt(f, err, "a data URI is no base64");
            goto done;
        }
        word = word << 6 | digit;
        if (i % 4 != 0)
            bytes[size++] = (uint8_t)(word >> (6 - 2 * (i % 4)));
    }
    *out = (stp_gltf_bytes){bytes, size, bytes};
    bytes = NULL;
done:
    free(bytes);
    return status;
}

static int hex_digit(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

/* The path of a file that is named relative to this one, with %20 and the like. */
static stp_status path_of(const stp_gltf_file *f, const char *uri, char **out, stp_error *err)
{
    const char *slash = strrchr(f->path, '/');
    size_t folder = slash != NULL ? (size_t)(slash + 1 - f->path) : 0, at = folder;
    stp_status status = stp_alloc(out, folder + strlen(uri) + 1, 1, "a path", err);
    if (status != STP_OK)
        return status;
    memcpy(*out, f->path, folder);
    for (const char *c = uri; *c != '\0'; c++) {
        const bool coded = *c == '%' && hex_digit(c[1]) >= 0 && hex_digit(c[2]) >= 0;
        (*out)[at++] = coded ? (char)(16 * hex_digit(c[1]) + hex_digit(c[2])) : *c;
        c += coded ? 2 : 0;
    }
    return STP_OK;
}

stp_status stp_gltf_fetch(const stp_gltf_file *f, const char *uri, stp_gltf_bytes *out,
                          stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    char *path = NULL;
    size_t size = 0;
    if (strncmp(uri, "data:", 5) == 0) {
        const char *text = strstr(uri, ";base64,");
        return text != NULL ? decode_base64(f, text + 8, out, err)
                            : stp_gltf_corrupt(f, err, "a data URI is no base64");
    }
    if (strstr(uri, "://") != NULL)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s names %s: download it and write its file's name there", f->path,
                             uri);
    STP_TRY(path_of(f, uri, &path, err));
    status = stp_file_load(path, &out->owned, &size, &why);
    if (status != STP_OK)
        STP_TRY(stp_error_set(err, status, "%s names a file: %s", f->path, why.message));
    out->data = out->owned;
    out->size = size;
done:
    free(path);
    return status;
}

/* ---- buffers ---- */

static stp_status load_buffers(stp_gltf_file *f, stp_error *err)
{
    static const uint8_t nothing = 0;
    stp_status status = STP_OK;
    const uint32_t count = f->counts[STP_GLTF_BUFFERS];
    STP_TRY(stp_alloc(&f->buffers, (size_t)count + 1, sizeof *f->buffers, "buffers", err));
    while (f->buffer_count < count) {
        const uint32_t i = f->buffer_count++;
        const cJSON *uri = cJSON_GetObjectItemCaseSensitive(f->lists[STP_GLTF_BUFFERS][i], "uri");
        f->buffers[i] = (stp_gltf_bytes){&nothing, 0, NULL};
        if (cJSON_IsString(uri))
            STP_TRY(stp_gltf_fetch(f, uri->valuestring, &f->buffers[i], err));
        else if (i == 0 && f->binary.data != NULL)
            f->buffers[i] = f->binary;
    }
done:
    return status;
}

/* ---- the file ---- */

bool stp_gltf_requires(const stp_gltf_file *f, const char *extension)
{
    const cJSON *item;
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(f->json, "extensionsRequired"))
    {
        if (cJSON_IsString(item) && strcmp(item->valuestring, extension) == 0)
            return true;
    }
    return false;
}

/* Extensions that are read, or without which the file may be read as it is: those of materials. */
static stp_status check_extensions(const stp_gltf_file *f, stp_error *err)
{
    static const char *const known[] = {"KHR_mesh_quantization", "KHR_materials", "KHR_texture",
                                        "EXT_texture",           "KHR_lights",    "KHR_draco",
                                        STP_GLTF_MESHOPT};
    const cJSON *item;
    cJSON_ArrayForEach(item, cJSON_GetObjectItemCaseSensitive(f->json, "extensionsRequired"))
    {
        if (!cJSON_IsString(item))
            continue;
        const char *name = item->valuestring;
        bool found = false;
        for (size_t i = 0; i < sizeof known / sizeof *known; i++)
            found |= strncmp(name, known[i], strlen(known[i])) == 0;
        if (!found)
            return stp_error_set(
                err, STP_UNSUPPORTED,
                "%s needs %s, which is not read here: export it without compression, or as PLY",
                f->path, name);
    }
    return STP_OK;
}

static stp_status check_version(const stp_gltf_file *f, stp_error *err)
{
    const cJSON *asset = cJSON_GetObjectItemCaseSensitive(f->json, "asset");
    const cJSON *version = cJSON_GetObjectItemCaseSensitive(asset, "version");
    if (!cJSON_IsString(version))
        return stp_gltf_corrupt(f, err, "JSON without an asset's version is no glTF");
    if (strncmp(version->valuestring, "2.", 2) != 0)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: glTF of version %.20s: convert it to 2.0 (Blender does)", f->path,
                             version->valuestring);
    return STP_OK;
}

stp_status stp_gltf_file_open(stp_gltf_file *out, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_gltf_file f = {.path = path};
    STP_TRY(stp_file_load(path, &f.bytes, &f.size, err));
    const uint8_t *json = f.bytes;
    size_t json_size = f.size;
    if (f.size >= 4 && memcmp(f.bytes, "glTF", 4) == 0)
        STP_TRY(split_binary(&f, &json, &json_size, err));
    STP_TRY(stp_json_parse(&f.json, (const char *)json, json_size, path,
                           "glTF: its JSON is damaged or cut: copy or export it again", err));
    STP_TRY(check_version(&f, err));
    STP_TRY(check_extensions(&f, err));
    STP_TRY(list_items(&f, err));
    STP_TRY(load_buffers(&f, err));
    STP_TRY(stp_alloc(&f.unpacked,
                      sizeof *f.unpacked + f.counts[STP_GLTF_VIEWS] * sizeof *f.unpacked->views, 1,
                      "buffer views", err));
    *out = f;
    f = (stp_gltf_file){0};
done:
    stp_gltf_file_close(&f);
    return status;
}

void stp_gltf_file_close(stp_gltf_file *f)
{
    for (uint32_t i = 0; i < f->buffer_count; i++)
        free(f->buffers[i].owned);
    for (uint32_t i = 0; f->unpacked && i < f->counts[STP_GLTF_VIEWS]; i++)
        free(f->unpacked->views[i].bytes.owned);
    free(f->unpacked);
    for (int i = 0; i < STP_GLTF_LIST_COUNT; i++)
        free(f->lists[i]);
    free(f->buffers);
    cJSON_Delete(f->json);
    free(f->bytes);
    *f = (stp_gltf_file){0};
}
