/* Reads the base colours of materials. */
#include "formats/scan/gltf/gltf_material.h"

#include "base/json.h"
#include "base/memory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

uint16_t stp_gltf_srgb(double linear)
{
    const double x = isfinite(linear) ? fmin(fmax(linear, 0.0), 1.0) : 0.0;
    return (uint16_t)lrint(65535.0 *
                           (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055));
}

/* Adds the image of a texture, whose bytes lie in the file or beside it. *image: STP_NO_MATERIAL if
 * there is none. */
static stp_status add_image(const stp_gltf_file *f, const cJSON *info, stp_materials *materials,
                            uint32_t *image, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t texture, source, view;
    const uint8_t *data = NULL;
    size_t size = 0, stride;
    stp_gltf_bytes fetched = {0};
    char name[32];
    *image = STP_NO_MATERIAL;
    STP_TRY(stp_gltf_index(f, info, "index", &texture, err));
    STP_TRY(
        stp_gltf_index(f, stp_gltf_item(f, STP_GLTF_TEXTURES, texture), "source", &source, err));
    const cJSON *item = stp_gltf_item(f, STP_GLTF_IMAGES, source);
    const cJSON *uri = cJSON_GetObjectItemCaseSensitive(item, "uri");
    if (item == NULL)
        return STP_OK; /* only extensions name an image */
    snprintf(name, sizeof name, "image %u", source);
    if (cJSON_IsString(uri)) {
        stp_error why = {0};
        const stp_status got = stp_gltf_fetch(f, uri->valuestring, &fetched, &why);
        if (got == STP_OUT_OF_MEMORY)
            STP_TRY(stp_error_set(err, got, "%s", why.message));
        if (got != STP_OK && materials->missing[0] == '\0')
            snprintf(materials->missing, sizeof materials->missing, "%s", why.message);
        data = fetched.data;
        size = fetched.size;
    } else {
        STP_TRY(stp_gltf_index(f, item, "bufferView", &view, err));
        STP_TRY(stp_gltf_view(f, view, &data, &size, &stride, err));
    }
    if (data != NULL)
        STP_TRY(stp_materials_embed(materials, name, data, size, image, err));
done:
    free(fetched.owned);
    return status;
}

/* The object that holds a material's base colour, and the names of its members. */
static const cJSON *colours_of(const cJSON *material, const char **factor, const char **texture)
{
    const cJSON *base = cJSON_GetObjectItemCaseSensitive(material, "pbrMetallicRoughness");
    const cJSON *glossy =
        cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItemCaseSensitive(material, "extensions"),
                                         "KHR_materials_pbrSpecularGlossiness");
    const bool old = base == NULL && glossy != NULL;
    *factor = old ? "diffuseFactor" : "baseColorFactor";
    *texture = old ? "diffuseTexture" : "baseColorTexture";
    return old ? glossy : base;
}

static stp_status add_material(const stp_gltf_file *f, const cJSON *material,
                               stp_materials *materials, stp_gltf_place *place, stp_error *err)
{
    stp_status status = STP_OK;
    const char *factor, *texture;
    const cJSON *base = colours_of(material, &factor, &texture);
    const cJSON *info = cJSON_GetObjectItemCaseSensitive(base, texture);
    const cJSON *way = cJSON_GetObjectItemCaseSensitive(
        cJSON_GetObjectItemCaseSensitive(info, "extensions"), "KHR_texture_transform");
    double rgba[4] = {1.0, 1.0, 1.0, 1.0};
    uint32_t image = STP_NO_MATERIAL;
    uint64_t set;
    *place = (stp_gltf_place){.scale = {1.0, 1.0}};
    STP_TRY(stp_json_numbers(base, factor, rgba, 4, f->path, err));
    memcpy(place->factor, rgba, sizeof place->factor);
    STP_TRY(stp_json_numbers(way, "offset", place->offset, 2, f->path, err));
    STP_TRY(stp_json_numbers(way, "scale", place->scale, 2, f->path, err));
    STP_TRY(stp_json_numbers(way, "rotation", &place->rotation, 1, f->path, err));
    STP_TRY(stp_gltf_whole(f, info, "texCoord", 0, &set, err));
    STP_TRY(stp_gltf_whole(f, way, "texCoord", set, &set, err));
    place->set = set < 100 ? (uint32_t)set : 100u;
    if (info != NULL)
        STP_TRY(add_image(f, info, materials, &image, err));
    const uint16_t rgb[3] = {stp_gltf_srgb(rgba[0]), stp_gltf_srgb(rgba[1]),
                             stp_gltf_srgb(rgba[2])};
    STP_TRY(stp_materials_add(materials, rgb, image, err));
done:
    return status;
}

stp_status stp_gltf_materials(const stp_gltf_file *f, stp_materials *materials,
                              stp_gltf_place **places, stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(f->json, "materials"), *item;
    size_t i = 0;
    STP_TRY(stp_alloc(places, (size_t)(cJSON_IsArray(list) ? cJSON_GetArraySize(list) : 0) + 1,
                      sizeof **places, "materials", err));
    cJSON_ArrayForEach(item, list) STP_TRY(add_material(f, item, materials, &(*places)[i++], err));
done:
    return status;
}
