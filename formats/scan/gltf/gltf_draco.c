/* Decodes compressed primitives. */
#include "formats/scan/gltf/gltf_draco.h"

#include "base/memory.h"
#include "formats/scan/gltf/draco_mesh_shim.h"

#include <stdlib.h>

static stp_status say(const stp_gltf_draco *d, stp_status status, const stp_error *why,
                      stp_error *err)
{
    return stp_error_set(err, status, "%s: a compressed mesh cannot be read: %s", d->file->path,
                         why->message);
}

/* Keeps an array until the primitive is closed; frees it at once if there is no room. */
static stp_status keep(stp_gltf_draco *d, uint8_t *array, stp_error *err)
{
    if (d->array_count == STP_GLTF_DRACO_ARRAYS) {
        free(array);
        return stp_error_set(err, STP_INTERNAL, "a primitive has too many attributes");
    }
    d->arrays[d->array_count++] = array;
    return STP_OK;
}

/* Whether the file has the primitive's positions once more, not compressed. */
static bool is_twice(const stp_gltf_file *file, const cJSON *primitive)
{
    uint32_t accessor;
    const cJSON *attributes = cJSON_GetObjectItemCaseSensitive(primitive, "attributes");
    return !stp_gltf_requires(file, "KHR_draco_mesh_compression") &&
           stp_gltf_index(file, attributes, "POSITION", &accessor, NULL) == STP_OK &&
           cJSON_GetObjectItemCaseSensitive(stp_gltf_item(file, STP_GLTF_ACCESSORS, accessor),
                                            "bufferView") != NULL;
}

stp_status stp_gltf_draco_open(stp_gltf_draco *out, const stp_gltf_file *file,
                               const cJSON *primitive, stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    const cJSON *extension = cJSON_GetObjectItemCaseSensitive(
        cJSON_GetObjectItemCaseSensitive(primitive, "extensions"), "KHR_draco_mesh_compression");
    const uint8_t *bytes = NULL;
    size_t size = 0, stride = 0;
    uint32_t view;
    *out = (stp_gltf_draco){.file = file};
    if (extension == NULL)
        return STP_OK;
    out->ids = cJSON_GetObjectItemCaseSensitive(extension, "attributes");
    STP_TRY(stp_gltf_index(file, extension, "bufferView", &view, err));
    STP_TRY(stp_gltf_view(file, view, &bytes, &size, &stride, err));
    status = stp_draco_mesh_decode(&out->mesh, bytes, size, &why);
    if (status != STP_OK && status != STP_OUT_OF_MEMORY && is_twice(file, primitive))
        return STP_OK;
    if (status != STP_OK)
        return say(out, status, &why, err);
done:
    return status;
}

void stp_gltf_draco_close(stp_gltf_draco *draco)
{
    for (unsigned i = 0; i < draco->array_count; i++)
        free(draco->arrays[i]);
    stp_draco_mesh_destroy(&draco->mesh);
    *draco = (stp_gltf_draco){0};
}

stp_status stp_gltf_draco_numbers(stp_gltf_draco *d, const char *name, uint32_t accessor,
                                  unsigned components, stp_gltf_numbers *out, bool *found,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    stp_draco_numbers numbers;
    uint32_t id;
    *found = false;
    if (d->mesh == NULL)
        return STP_OK;
    STP_TRY(stp_gltf_index(d->file, d->ids, name, &id, err));
    if (id == STP_GLTF_NONE)
        return STP_OK;
    status = stp_draco_mesh_numbers(d->mesh, id, &numbers, &why);
    if (status != STP_OK)
        return say(d, status, &why, err);
    STP_TRY(keep(d, numbers.data, err));
    if ((components >> numbers.components & 1u) == 0)
        return stp_gltf_corrupt(d->file, err, "%s of a compressed mesh has %u numbers a vertex",
                                name, numbers.components);
    *found = true;
    *out = (stp_gltf_numbers){
        .data = numbers.data,
        .count = stp_draco_mesh_vertex_count(d->mesh),
        .stride = stp_gltf_type_bytes(numbers.type) * (size_t)numbers.components,
        .components = numbers.components,
        .type = numbers.type,
        .normalized = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(
            stp_gltf_item(d->file, STP_GLTF_ACCESSORS, accessor), "normalized"))};
done:
    return status;
}

stp_status stp_gltf_draco_indices(stp_gltf_draco *d, stp_gltf_numbers *out, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = stp_draco_mesh_face_count(d->mesh);
    uint32_t *corners = NULL;
    STP_TRY(stp_alloc(&corners, 3 * (size_t)count + 1, sizeof *corners, "faces", err));
    for (uint32_t i = 0; i < count; i++)
        stp_draco_mesh_face(d->mesh, i, corners + 3 * (size_t)i);
    STP_TRY(keep(d, (uint8_t *)corners, err));
    *out = (stp_gltf_numbers){.data = (const uint8_t *)corners,
                              .count = 3 * (size_t)count,
                              .stride = sizeof *corners,
                              .components = 1,
                              .type = 5125};
done:
    return status;
}
