/* Decodes buffer views by meshoptimizer. */
#include "formats/scan/gltf/gltf_meshopt.h"

#include "base/memory.h"

#include <meshoptimizer.h>
#include <string.h>

/* A byte of a stream stands for at most so many: 4 bytes of headers for 256 equal bytes. */
#define BYTES_MOST 64u
/* A stream has a head and a tail, so a few items may take more. */
#define BYTES_FREE 65536u
/* Of an item of attributes: a multiple of 4. */
#define STRIDE_MOST 256u

typedef struct packed_view {
    stp_gltf_bytes bytes;
    uint64_t count, stride;
    const char *mode, *filter;
} packed_view;

static const char *word_of(const cJSON *object, const char *key, const char *otherwise)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    return cJSON_IsString(item) ? item->valuestring : otherwise;
}

/* Reads and checks the numbers of an extension. */
static stp_status read_view(const stp_gltf_file *f, const cJSON *extension, packed_view *out,
                            stp_error *err)
{
    stp_status status = STP_OK;
    *out = (packed_view){.mode = word_of(extension, "mode", ""),
                         .filter = word_of(extension, "filter", "NONE")};
    STP_TRY(stp_gltf_range(f, extension, &out->bytes, err));
    STP_TRY(stp_gltf_whole(f, extension, "byteStride", 0, &out->stride, err));
    STP_TRY(stp_gltf_whole(f, extension, "count", 0, &out->count, err));
    const bool attributes = strcmp(out->mode, "ATTRIBUTES") == 0;
    const bool strides = attributes
                             ? out->stride > 0 && out->stride <= STRIDE_MOST && out->stride % 4 == 0
                             : out->stride == 2 || out->stride == 4;
    if (!strides ||
        out->count > (BYTES_MOST * (uint64_t)out->bytes.size + BYTES_FREE) / out->stride)
        return stp_gltf_corrupt(f, err, "a view of meshopt has a size that its bytes cannot have");
done:
    return status;
}

/* False if there is no such filter, or not for this size of items. */
static bool undo_filter(const packed_view *v, void *data)
{
    const size_t count = (size_t)v->count, stride = (size_t)v->stride;
    if (strcmp(v->filter, "NONE") == 0)
        return true;
    if (strcmp(v->filter, "OCTAHEDRAL") == 0 && (stride == 4 || stride == 8))
        return meshopt_decodeFilterOct(data, count, stride), true;
    if (strcmp(v->filter, "QUATERNION") == 0 && stride == 8)
        return meshopt_decodeFilterQuat(data, count, stride), true;
    if (strcmp(v->filter, "EXPONENTIAL") == 0)
        return meshopt_decodeFilterExp(data, count, stride), true;
    return false;
}

/* False if the stream is damaged, or of a mode that is not known. */
static bool unpack(const packed_view *v, void *data)
{
    const size_t count = (size_t)v->count, stride = (size_t)v->stride, size = v->bytes.size;
    const uint8_t *bytes = v->bytes.data;
    if (strcmp(v->mode, "ATTRIBUTES") == 0)
        return meshopt_decodeVertexBuffer(data, count, stride, bytes, size) == 0 &&
               undo_filter(v, data);
    if (strcmp(v->mode, "TRIANGLES") == 0)
        return count % 3 == 0 && meshopt_decodeIndexBuffer(data, count, stride, bytes, size) == 0;
    return strcmp(v->mode, "INDICES") == 0 &&
           meshopt_decodeIndexSequence(data, count, stride, bytes, size) == 0;
}

stp_status stp_gltf_meshopt_decode(const stp_gltf_file *f, const cJSON *extension,
                                   stp_gltf_bytes *out, size_t *stride, stp_error *err)
{
    stp_status status = STP_OK;
    packed_view v;
    *out = (stp_gltf_bytes){0};
    STP_TRY(read_view(f, extension, &v, err));
    /* one more byte: also a view without items has data */
    STP_TRY(stp_alloc(&out->owned, (size_t)(v.count * v.stride) + 1, 1, "a buffer view", err));
    if (v.count > 0 && !unpack(&v, out->owned)) {
        status = stp_gltf_corrupt(f, err, "a view of meshopt cannot be decoded");
        goto done;
    }
    out->data = out->owned;
    out->size = (size_t)(v.count * v.stride);
    *stride = (size_t)v.stride;
done:
    return status;
}
