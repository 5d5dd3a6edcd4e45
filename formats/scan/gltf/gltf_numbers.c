/* Reads buffer views and accessors of a glTF file. */
#include "formats/scan/gltf/gltf_meshopt.h"

#include "base/json.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* Decoded views take at most so many times the bytes of all buffers, beside a few: views may share
 * bytes. */
#define UNPACKED_TIMES 64u
#define UNPACKED_FREE (UINT64_C(1) << 20)

/* Decodes a view if it is compressed. *out: NULL if it is not. */
static stp_status unpack(const stp_gltf_file *f, uint32_t index, const stp_gltf_unpacked_view **out,
                         stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *extensions =
        cJSON_GetObjectItemCaseSensitive(f->lists[STP_GLTF_VIEWS][index], "extensions");
    const cJSON *packed = cJSON_GetObjectItemCaseSensitive(extensions, STP_GLTF_MESHOPT);
    stp_gltf_unpacked_view *view = &f->unpacked->views[index];
    uint64_t most = UNPACKED_FREE;
    *out = NULL;
    if (packed == NULL)
        return STP_OK;
    for (uint32_t i = 0; i < f->buffer_count; i++)
        most += UNPACKED_TIMES * (uint64_t)f->buffers[i].size;
    if (view->bytes.data == NULL) {
        STP_TRY(stp_gltf_meshopt_decode(f, packed, &view->bytes, &view->stride, err));
        f->unpacked->bytes += view->bytes.size;
    }
    if (f->unpacked->bytes > most)
        STP_TRY(stp_error_set(err, STP_LIMIT,
                              "%s: its views use the same bytes again and again: export it again",
                              f->path));
    *out = view;
done:
    return status;
}

stp_status stp_gltf_view(const stp_gltf_file *f, uint32_t index, const uint8_t **data, size_t *size,
                         size_t *stride, stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *view = stp_gltf_item(f, STP_GLTF_VIEWS, index);
    stp_gltf_bytes bytes;
    uint64_t step;
    if (view == NULL)
        return stp_gltf_corrupt(f, err, "there is no buffer view %u", index);
    const stp_gltf_unpacked_view *unpacked;
    STP_TRY(unpack(f, index, &unpacked, err));
    if (unpacked) {
        *data = unpacked->bytes.data;
        *size = unpacked->bytes.size;
        *stride = unpacked->stride;
        return STP_OK;
    }
    STP_TRY(stp_gltf_range(f, view, &bytes, err));
    STP_TRY(stp_gltf_whole(f, view, "byteStride", 0, &step, err));
    *data = bytes.data;
    *size = bytes.size;
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
    return s->place_bytes == 4   ? stp_gltf_word(at)
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
    if (view == STP_GLTF_NONE && sparse && count > ZEROS_MOST)
        return stp_error_set(err, STP_LIMIT,
                             "%s: sparse accessor %u has more than %u items without a buffer view: "
                             "export it with one",
                             f->path, index, ZEROS_MOST);
    if (view == STP_GLTF_NONE)
        return count > 1 && !sparse
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
    const uint32_t word = stp_gltf_type_bytes(n->type) > 2 ? stp_gltf_word(at) : half;
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
