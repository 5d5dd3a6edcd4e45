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

/* Bytes of images, at most: the file may name the same ones again and again. */
#define IMAGE_BYTES_LIMIT (UINT64_C(4) << 30)

/* What reading the materials needs. */
typedef struct reading {
    const stp_gltf_file *file;
    stp_materials *materials;
    uint32_t *images; /* in materials, by image of the file; STP_NO_MATERIAL: not read yet */
    uint64_t image_bytes;
} reading;

static void note_missing(const reading *r, const char *what)
{
    if (r->materials->missing[0] == '\0')
        snprintf(r->materials->missing, sizeof r->materials->missing, "%s", what);
}

/* Adds an image whose bytes lie in the file or beside it. If they cannot be read, says so. */
static stp_status read_image(reading *r, uint32_t source, uint32_t *image, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_gltf_file *f = r->file;
    const cJSON *item = stp_gltf_item(f, STP_GLTF_IMAGES, source);
    const cJSON *uri = cJSON_GetObjectItemCaseSensitive(item, "uri");
    stp_gltf_bytes bytes = {0};
    uint32_t view;
    size_t stride;
    char name[32];
    if (cJSON_IsString(uri)) {
        stp_error why = {0};
        const stp_status got = stp_gltf_fetch(f, uri->valuestring, &bytes, &why);
        if (got == STP_OUT_OF_MEMORY)
            STP_TRY(stp_error_set(err, got, "%s", why.message));
        if (got != STP_OK)
            note_missing(r, why.message);
    } else {
        STP_TRY(stp_gltf_index(f, item, "bufferView", &view, err));
        STP_TRY(stp_gltf_view(f, view, &bytes.data, &bytes.size, &stride, err));
    }
    r->image_bytes += bytes.size;
    if (r->image_bytes > IMAGE_BYTES_LIMIT)
        STP_TRY(stp_error_set(err, STP_LIMIT,
                              "%s: images of more than %llu bytes: make them smaller", f->path,
                              (unsigned long long)IMAGE_BYTES_LIMIT));
    snprintf(name, sizeof name, "image %u", source);
    if (bytes.data != NULL)
        STP_TRY(stp_materials_embed(r->materials, name, bytes.data, bytes.size, image, err));
done:
    free(bytes.owned);
    return status;
}

/* The image of a texture. *image: STP_NO_MATERIAL if there is none. */
static stp_status add_image(reading *r, const cJSON *info, uint32_t *image, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_gltf_file *f = r->file;
    uint32_t texture, source;
    char what[256];
    STP_TRY(stp_gltf_index(f, info, "index", &texture, err));
    STP_TRY(
        stp_gltf_index(f, stp_gltf_item(f, STP_GLTF_TEXTURES, texture), "source", &source, err));
    if (stp_gltf_item(f, STP_GLTF_IMAGES, source) == NULL) {
        snprintf(what, sizeof what,
                 "%.150s: texture %u has no PNG or JPEG image: export it with one", f->path,
                 texture);
        note_missing(r, what);
        return STP_OK;
    }
    if (r->images[source] == STP_NO_MATERIAL)
        STP_TRY(read_image(r, source, &r->images[source], err));
    *image = r->images[source];
done:
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

/* How the image of a texture goes on beyond its borders. */
static stp_status read_wrap(const stp_gltf_file *f, const cJSON *info, stp_wrap wrap[2],
                            stp_error *err)
{
    static const char *const keys[2] = {"wrapS", "wrapT"};
    stp_status status = STP_OK;
    uint32_t texture, sampler;
    STP_TRY(stp_gltf_index(f, info, "index", &texture, err));
    STP_TRY(
        stp_gltf_index(f, stp_gltf_item(f, STP_GLTF_TEXTURES, texture), "sampler", &sampler, err));
    for (int i = 0; i < 2; i++) {
        uint64_t mode;
        STP_TRY(stp_gltf_whole(f, stp_gltf_item(f, STP_GLTF_SAMPLERS, sampler), keys[i], 10497,
                               &mode, err));
        wrap[i] = mode == 33071   ? STP_WRAP_CLAMP
                  : mode == 33648 ? STP_WRAP_MIRROR
                                  : STP_WRAP_REPEAT;
    }
done:
    return status;
}

static stp_status add_material(reading *r, const cJSON *material, stp_gltf_place *place,
                               stp_error *err)
{
    stp_status status = STP_OK;
    const stp_gltf_file *f = r->file;
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
        STP_TRY(add_image(r, info, &image, err));
    const uint16_t rgb[3] = {stp_gltf_srgb(rgba[0]), stp_gltf_srgb(rgba[1]),
                             stp_gltf_srgb(rgba[2])};
    STP_TRY(stp_materials_add(r->materials, rgb, image, err));
    stp_material *added = &r->materials->list[r->materials->count - 1];
    added->tinted = true;
    if (info != NULL)
        STP_TRY(read_wrap(f, info, added->wrap, err));
done:
    return status;
}

stp_status stp_gltf_materials(const stp_gltf_file *f, stp_materials *materials,
                              stp_gltf_place **places, stp_error *err)
{
    stp_status status = STP_OK;
    reading r = {.file = f, .materials = materials};
    const uint32_t images = f->counts[STP_GLTF_IMAGES], count = f->counts[STP_GLTF_MATERIALS];
    STP_TRY(stp_alloc(places, (size_t)count + 1, sizeof **places, "materials", err));
    STP_TRY(stp_alloc(&r.images, (size_t)images + 1, sizeof *r.images, "images", err));
    for (uint32_t i = 0; i < images; i++)
        r.images[i] = STP_NO_MATERIAL;
    for (uint32_t i = 0; i < count; i++)
        STP_TRY(add_material(&r, stp_gltf_item(f, STP_GLTF_MATERIALS, i), &(*places)[i], err));
done:
    free(r.images);
    return status;
}
