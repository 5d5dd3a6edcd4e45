/* Takes a glTF file apart. */
#include "formats/scan/gltf/gltf_file.h"

#include "formats/scan/gltf/gltf_meshopt.h"

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

static uint32_t word_at(const uint8_t *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* Finds the JSON and the binary chunk. */
static stp_status split_binary(stp_gltf_file *f, const uint8_t **json, size_t *json_size,
                               stp_error *err)
{
    *json = NULL;
    if (f->size < GLB_HEAD_BYTES + GLB_CHUNK_HEAD_BYTES)
        return stp_gltf_corrupt(f, err, "it ends within its header");
    if (word_at(f->bytes + 4) != 2)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: glTF of version %u: convert it to 2.0 (Blender does)", f->path,
                             word_at(f->bytes + 4));
    for (size_t at = GLB_HEAD_BYTES; f->size - at >= GLB_CHUNK_HEAD_BYTES;) {
        const uint32_t bytes = word_at(f->bytes + at), kind = word_at(f->bytes + at + 4);
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

/* ---- buffers, views and accessors ---- */

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

typedef struct stp_gltf_unpacked {
    stp_gltf_bytes bytes;
    size_t stride;
} stp_gltf_unpacked;

static stp_status unpack_views(stp_gltf_file *f, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = f->counts[STP_GLTF_VIEWS];
    STP_TRY(stp_alloc(&f->views, count, sizeof *f->views, "buffer views", err));
    for (uint32_t i = 0; i < count; i++) {
        const cJSON *extensions =
            cJSON_GetObjectItemCaseSensitive(f->lists[STP_GLTF_VIEWS][i], "extensions");
        const cJSON *packed = cJSON_GetObjectItemCaseSensitive(extensions, STP_GLTF_MESHOPT);
        if (packed != NULL)
            STP_TRY(
                stp_gltf_meshopt_decode(f, packed, &f->views[i].bytes, &f->views[i].stride, err));
    }
done:
    return status;
}

stp_status stp_gltf_view(const stp_gltf_file *f, uint32_t index, const uint8_t **data, size_t *size,
                         size_t *stride, stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *view = stp_gltf_item(f, STP_GLTF_VIEWS, index);
    uint64_t offset, bytes, step;
    uint32_t buffer;
    if (view == NULL)
        return stp_gltf_corrupt(f, err, "there is no buffer view %u", index);
    if (f->views && f->views[index].bytes.data) {
        *data = f->views[index].bytes.data;
        *size = f->views[index].bytes.size;
        *stride = f->views[index].stride;
        return STP_OK;
    }
    STP_TRY(stp_gltf_index(f, view, "buffer", &buffer, err));
    STP_TRY(stp_gltf_whole(f, view, "byteOffset", 0, &offset, err));
    STP_TRY(stp_gltf_whole(f, view, "byteLength", 0, &bytes, err));
    STP_TRY(stp_gltf_whole(f, view, "byteStride", 0, &step, err));
    if (buffer >= f->buffer_count || offset > f->buffers[buffer].size ||
        bytes > f->buffers[buffer].size - offset)
        return stp_gltf_corrupt(f, err, "buffer view %u reaches beyond its buffer", index);
    *data = f->buffers[buffer].data + offset;
    *size = (size_t)bytes;
    *stride = (size_t)step;
done:
    return status;
}

unsigned stp_gltf_type_bytes(unsigned type)
{
    return type == 5120 || type == 5121   ? 1u
           : type == 5122 || type == 5123 ? 2u
           : type == 5125 || type == 5126 ? 4u
                                          : 0u;
}

static unsigned components_of(const cJSON *accessor)
{
    const cJSON *type = cJSON_GetObjectItemCaseSensitive(accessor, "type");
    const char *word = cJSON_IsString(type) ? type->valuestring : "";
    return strcmp(word, "SCALAR") == 0 ? 1u
           : strncmp(word, "VEC", 3) == 0 && word[3] >= '2' && word[3] <= '4' && word[4] == '\0'
               ? (unsigned)(word[3] - '0')
               : 0u;
}

/* A sparse accessor without numbers of its own has at most so many items, all zero but for few. */
#define ZEROS_MOST 65536u

/* Finds `count` items of `item` bytes each, one behind the other. `what` names them. */
static stp_status find_packed(const stp_gltf_file *f, const cJSON *object, uint64_t count,
                              size_t item, const char *what, const uint8_t **out, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t offset;
    uint32_t view;
    size_t size = 0, stride = 0;
    STP_TRY(stp_gltf_index(f, object, "bufferView", &view, err));
    STP_TRY(stp_gltf_whole(f, object, "byteOffset", 0, &offset, err));
    STP_TRY(stp_gltf_view(f, view, out, &size, &stride, err));
    if (item == 0 || offset > size || count > (size - offset) / item)
        return stp_gltf_corrupt(f, err, "%s of a sparse accessor reach beyond their buffer view",
                                what);
    *out += offset;
done:
    return status;
}

static uint32_t place_at(const stp_gltf_sparse *s, size_t i)
{
    const uint8_t *at = s->places + i * s->place_bytes;
    return s->place_bytes == 4   ? word_at(at)
           : s->place_bytes == 2 ? (uint32_t)(at[0] | at[1] << 8)
                                 : at[0];
}

static stp_status read_sparse(const stp_gltf_file *f, const cJSON *accessor,
                              stp_gltf_numbers *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *sparse = cJSON_GetObjectItemCaseSensitive(accessor, "sparse");
    const cJSON *places = cJSON_GetObjectItemCaseSensitive(sparse, "indices");
    const cJSON *items = cJSON_GetObjectItemCaseSensitive(sparse, "values");
    stp_gltf_sparse *s = &numbers->sparse;
    uint64_t count, type;
    STP_TRY(stp_gltf_whole(f, sparse, "count", 0, &count, err));
    STP_TRY(stp_gltf_whole(f, places, "componentType", 0, &type, err));
    s->place_bytes =
        type == 5121 || type == 5123 || type == 5125 ? stp_gltf_type_bytes((unsigned)type) : 0;
    STP_TRY(find_packed(f, places, count, s->place_bytes, "indices", &s->places, err));
    STP_TRY(find_packed(f, items, count,
                        (size_t)stp_gltf_type_bytes(numbers->type) * numbers->components, "values",
                        &s->items, err));
    for (size_t i = 0; i < count; i++)
        if (place_at(s, i) >= numbers->count || (i > 0 && place_at(s, i) <= place_at(s, i - 1)))
            return stp_gltf_corrupt(f, err, "the indices of a sparse accessor do not ascend");
    s->count = (size_t)count;
done:
    return status;
}

stp_status stp_gltf_numbers_of(const stp_gltf_file *f, uint32_t index, unsigned components,
                               stp_gltf_numbers *out, stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *accessor = stp_gltf_item(f, STP_GLTF_ACCESSORS, index);
    uint64_t count, offset, type;
    uint32_t view;
    size_t size = 0;
    if (accessor == NULL)
        return stp_gltf_corrupt(f, err, "there is no accessor %u", index);
    STP_TRY(stp_gltf_whole(f, accessor, "count", 0, &count, err));
    STP_TRY(stp_gltf_whole(f, accessor, "byteOffset", 0, &offset, err));
    STP_TRY(stp_gltf_whole(f, accessor, "componentType", 0, &type, err));
    STP_TRY(stp_gltf_index(f, accessor, "bufferView", &view, err));
    *out = (stp_gltf_numbers){.count = (size_t)count, .components = components_of(accessor)};
    out->type = type <= 5126 ? (unsigned)type : 0;
    out->normalized = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(accessor, "normalized"));
    const size_t item = (size_t)stp_gltf_type_bytes(out->type) * out->components;
    if (item == 0 || (components >> out->components & 1u) == 0)
        return stp_gltf_corrupt(
            f, err, "accessor %u has numbers of another kind than its use needs", index);
    if (count > UINT32_MAX)
        return stp_error_set(err, STP_LIMIT,
                             "%s: accessor %u has more than %u items: part the mesh", f->path,
                             index, UINT32_MAX);
    const bool sparse = stp_json_has(accessor, "sparse");
    if (sparse)
        STP_TRY(read_sparse(f, accessor, out, err));
    if (view == STP_GLTF_NONE)
        return count > (sparse ? ZEROS_MOST : 1)
                   ? stp_gltf_corrupt(f, err, "accessor %u has no buffer view", index)
                   : STP_OK;
    STP_TRY(stp_gltf_view(f, view, &out->data, &size, &out->stride, err));
    out->stride = out->stride != 0 ? out->stride : item;
    if (offset > size ||
        (count > 0 && (size - offset < item || (count - 1) > (size - offset - item) / out->stride)))
        return stp_gltf_corrupt(f, err, "accessor %u reaches beyond its buffer view", index);
    out->data += offset;
done:
    return status;
}

/* The bytes of an item; NULL: its numbers are zero. */
static const uint8_t *item_at(const stp_gltf_numbers *n, size_t item)
{
    const stp_gltf_sparse *s = &n->sparse;
    size_t low = 0, high = s->count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (place_at(s, middle) < item)
            low = middle + 1;
        else
            high = middle;
    }
    if (low < s->count && place_at(s, low) == item)
        return s->items + low * stp_gltf_type_bytes(n->type) * n->components;
    return n->data ? n->data + item * n->stride : NULL;
}

double stp_gltf_number(const stp_gltf_numbers *n, size_t item, unsigned component)
{
    const uint8_t *at = item_at(n, item);
    if (at == NULL)
        return 0.0;
    at += (size_t)stp_gltf_type_bytes(n->type) * component;
    const unsigned half = at[0] | (stp_gltf_type_bytes(n->type) > 1 ? (unsigned)at[1] << 8 : 0u);
    const uint32_t word = stp_gltf_type_bytes(n->type) > 2 ? word_at(at) : half;
    float real;
    switch (n->type) {
    case 5120:
        return n->normalized ? (int8_t)half / 127.0 : (int8_t)half;
    case 5121:
        return n->normalized ? half / 255.0 : half;
    case 5122:
        return n->normalized ? (int16_t)half / 32767.0 : (int16_t)half;
    case 5123:
        return n->normalized ? half / 65535.0 : half;
    case 5125:
        return word;
    default:
        memcpy(&real, &word, sizeof real);
        return (double)real;
    }
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
    STP_TRY(unpack_views(&f, err));
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
    for (uint32_t i = 0; f->views && i < f->counts[STP_GLTF_VIEWS]; i++)
        free(f->views[i].bytes.owned);
    for (int i = 0; i < STP_GLTF_LIST_COUNT; i++)
        free(f->lists[i]);
    free(f->views);
    free(f->buffers);
    cJSON_Delete(f->json);
    free(f->bytes);
    *f = (stp_gltf_file){0};
}
