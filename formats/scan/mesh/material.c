/* The colours of a mesh's faces. */
#include "formats/scan/mesh/material.h"

#include "base/memory.h"
#include "formats/image/image.h"
#include "formats/scan/mesh/mesh_text.h"
#include "formats/scan/number.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/mman.h>
#include <unistd.h>

static stp_status copy_part(char **out, const char *begin, const char *end, stp_error *err)
{
    stp_status status = stp_alloc(out, (size_t)(end - begin) + 1, 1, "a name", err);
    if (status == STP_OK)
        memcpy(*out, begin, (size_t)(end - begin));
    return status;
}

/* The first so many bytes of folder, and name. */
static stp_status join(char **out, const char *folder, size_t folder_bytes, const char *name,
                       stp_error *err)
{
    stp_status status = stp_alloc(out, folder_bytes + strlen(name) + 1, 1, "a path", err);
    if (status != STP_OK)
        return status;
    memcpy(*out, folder, folder_bytes);
    memcpy(*out + folder_bytes, name, strlen(name));
    return STP_OK;
}

/* Finds a file of this name in a folder, if only in other case; of several the first in order. */
static stp_status find_beside(char **out, const char *mesh_path, size_t folder_bytes,
                              const char *name, stp_error *err)
{
    stp_status status = STP_OK;
    char *folder = NULL, *found = NULL;
    DIR *listing = NULL;
    STP_TRY(join(&folder, mesh_path, folder_bytes, folder_bytes > 0 ? "" : ".", err));
    listing = opendir(folder);
    for (struct dirent *e = listing ? readdir(listing) : NULL; e; e = readdir(listing)) {
        const bool exact = strcmp(e->d_name, name) == 0;
        if (strcasecmp(e->d_name, name) != 0 || (found && !exact && strcmp(found, e->d_name) < 0))
            continue;
        free(found);
        found = NULL;
        STP_TRY(join(&found, e->d_name, strlen(e->d_name), "", err));
        if (exact)
            break;
    }
    if (found) {
        free(*out);
        *out = NULL;
        STP_TRY(join(out, mesh_path, folder_bytes, found, err));
    }
done:
    if (listing)
        closedir(listing);
    free(found);
    free(folder);
    return status;
}

/* The path of a file beside the mesh. Windows writes backslashes. Programs name folders of the
 * machine that they ran on: a file that is not there is looked for beside the mesh. */
static stp_status path_beside(char **out, const char *mesh_path, const char *name, stp_error *err)
{
    stp_status status = STP_OK;
    const char *slash = strrchr(mesh_path, '/');
    const size_t beside = slash ? (size_t)(slash + 1 - mesh_path) : 0;
    const size_t folder = *name != '/' ? beside : 0;
    STP_TRY(join(out, mesh_path, folder, name, err));
    for (char *c = *out + folder; *c; c++)
        *c = *c == '\\' ? '/' : *c;
    if (access(*out, F_OK) != 0) {
        const char *last = strrchr(*out, '/');
        STP_TRY(find_beside(out, mesh_path, beside, last ? last + 1 : *out, err));
    }
done:
    return status;
}

static void note_missing(stp_materials *m, const stp_error *why)
{
    if (m->missing[0] == '\0')
        snprintf(m->missing, sizeof m->missing, "%s", why->message);
}

uint32_t stp_materials_find(const stp_materials *m, const char *name, const char *name_end)
{
    for (size_t i = 0; i < m->count; i++)
        if (stp_text_token_is(name, name_end, m->list[i].name))
            return (uint32_t)i;
    return STP_NO_MATERIAL;
}

static stp_status find_image(stp_materials *m, const char *begin, const char *end, uint32_t *image,
                             stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t i = 0; i < m->image_count; i++)
        if (stp_text_token_is(begin, end, m->images[i].name)) {
            *image = (uint32_t)i;
            return STP_OK;
        }
    STP_TRY(stp_grow(&m->images, &m->image_capacity, m->image_count + 1, sizeof *m->images,
                     "images", err));
    m->images[m->image_count] = (stp_texture){0};
    STP_TRY(copy_part(&m->images[m->image_count].name, begin, end, err));
    *image = (uint32_t)m->image_count++;
done:
    return status;
}

/* Skips options like `-s 1 1 1` and `-clamp on`: a word, then numbers or one more word. */
static void skip_options(stp_text_lines *lines)
{
    const char *begin, *end, *before = lines->cursor;
    double number;
    while ((begin = stp_text_next_token(lines, &end)) && *begin == '-') {
        before = lines->cursor;
        bool first = true;
        while ((begin = stp_text_next_token(lines, &end)) &&
               (stp_number_parse(begin, end, &number) ||
                (first && (stp_text_token_is(begin, end, "on") ||
                           stp_text_token_is(begin, end, "off") || end - begin == 1)))) {
            before = lines->cursor;
            first = false;
        }
        lines->cursor = before;
    }
    lines->cursor = before;
}

static stp_status add_material(stp_materials *m, const char *begin, const char *end, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_grow(&m->list, &m->capacity, m->count + 1, sizeof *m->list, "materials", err));
    m->list[m->count] = (stp_material){.rgb = {52428, 52428, 52428}, .image = STP_NO_MATERIAL};
    STP_TRY(copy_part(&m->list[m->count].name, begin, end, err));
    m->count++;
done:
    return status;
}

stp_status stp_materials_add_image(stp_materials *m, const char *name, const char *name_end,
                                   stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(add_material(m, name, name_end, err));
    STP_TRY(find_image(m, name, name_end, &m->list[m->count - 1].image, err));
done:
    return status;
}

stp_status stp_materials_add(stp_materials *m, const uint16_t rgb[3], uint32_t image,
                             stp_error *err)
{
    stp_status status = add_material(m, "", "", err);
    if (status != STP_OK)
        return status;
    memcpy(m->list[m->count - 1].rgb, rgb, sizeof m->list[m->count - 1].rgb);
    m->list[m->count - 1].image = image;
    return STP_OK;
}

stp_status stp_materials_embed(stp_materials *m, const char *name, const uint8_t *bytes,
                               size_t byte_count, uint32_t *image, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(find_image(m, name, name + strlen(name), image, err));
    stp_texture *texture = &m->images[*image];
    if (texture->bytes != NULL)
        return STP_OK;
    STP_TRY(stp_alloc(&texture->bytes, byte_count + 1, 1, "an image", err));
    memcpy(texture->bytes, bytes, byte_count);
    texture->byte_count = byte_count;
done:
    return status;
}

/* `Kd r g b`; anything else is left as it is. */
static void set_diffuse(stp_material *material, stp_text_lines *lines)
{
    double rgb[3];
    for (int k = 0; k < 3; k++) {
        const char *end, *begin = stp_text_next_token(lines, &end);
        if (!begin || !stp_number_parse(begin, end, &rgb[k]) || !isfinite(rgb[k]))
            return;
    }
    for (int k = 0; k < 3; k++)
        material->rgb[k] = (uint16_t)lrint(65535.0 * fmin(fmax(rgb[k], 0.0), 1.0));
}

static stp_status read_library(stp_materials *m, const stp_mesh_text *text, stp_error *err)
{
    stp_status status = STP_OK;
    stp_text_lines lines = stp_text_lines_begin(text);
    const size_t before = m->count;
    while (stp_text_next_line(&lines)) {
        const char *end, *begin = stp_text_next_token(&lines, &end);
        if (!begin)
            continue;
        stp_material *last = m->count > before ? &m->list[m->count - 1] : NULL;
        if (stp_text_token_is(begin, end, "newmtl")) {
            stp_text_rest(&lines, &begin, &end);
            STP_TRY(add_material(m, begin, end, err));
        } else if (last && stp_text_token_is(begin, end, "Kd")) {
            set_diffuse(last, &lines);
        } else if (last && (stp_text_token_is(begin, end, "map_Kd") ||
                            stp_text_token_is(begin, end, "map_kd"))) {
            skip_options(&lines);
            stp_text_rest(&lines, &begin, &end);
            if (end - begin > 2 && *begin == '"' && end[-1] == '"') {
                begin++;
                end--;
            }
            if (begin < end)
                STP_TRY(find_image(m, begin, end, &last->image, err));
        }
    }
done:
    return status;
}

stp_status stp_materials_read(stp_materials *m, const char *mesh_path, const char *name,
                              const char *name_end, stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    stp_mesh_text text = {0};
    char *copy = NULL, *path = NULL;
    if (name == name_end)
        return STP_OK;
    STP_TRY(copy_part(&copy, name, name_end, err));
    STP_TRY(path_beside(&path, mesh_path, copy, err));
    stp_status loaded = stp_mesh_text_load(&text, path, &why);
    if (loaded ==
        STP_NOT_FOUND) { /* the mesh has another name since: its library may have it, too */
        const char *end = strrchr(mesh_path, '.');
        free(path);
        path = NULL;
        STP_TRY(join(&path, mesh_path, (size_t)(end ? end - mesh_path : 0), ".mtl", err));
        loaded = stp_mesh_text_load(&text, path, NULL);
    }
    if (loaded == STP_OK)
        STP_TRY(read_library(m, &text, err));
    else if (loaded == STP_OUT_OF_MEMORY)
        status = stp_error_set(err, loaded, "no memory for %s", path);
    else
        note_missing(m, &why);
done:
    stp_mesh_text_free(&text);
    free(copy);
    free(path);
    return status;
}

stp_status stp_materials_add_triangle(stp_materials *m, uint32_t material,
                                      const float corners[3][2], stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_grow(&m->of_triangle, &m->triangle_capacity, m->triangle_count + 1,
                     sizeof *m->of_triangle, "triangles", err));
    STP_TRY(stp_grow(&m->corners, &m->corner_capacity, m->triangle_count + 1, sizeof *m->corners,
                     "texture coordinates", err));
    m->of_triangle[m->triangle_count] = material;
    memcpy(m->corners[m->triangle_count++], corners, sizeof *m->corners);
done:
    return status;
}

stp_status stp_materials_add_plain(stp_materials *m, const uint16_t rgb[3], uint64_t count,
                                   stp_error *err)
{
    stp_status status = STP_OK;
    static const float nowhere[3][2] = {{NAN, NAN}, {NAN, NAN}, {NAN, NAN}};
    const stp_material *last = m->count > 0 ? &m->list[m->count - 1] : NULL;
    if (rgb && !(last && memcmp(last->rgb, rgb, sizeof last->rgb) == 0))
        STP_TRY(stp_materials_add(m, rgb, STP_NO_MATERIAL, err));
    const uint32_t material = rgb ? (uint32_t)(m->count - 1) : STP_NO_MATERIAL;
    for (uint64_t i = 0; i < count; i++)
        STP_TRY(stp_materials_add_triangle(m, material, nowhere, err));
done:
    return status;
}

/* Makes a level of half the size: means of 2 x 2 texels, of fewer at odd borders. */
static stp_status halve(const stp_texture_level *from, stp_texture_level *to, stp_error *err)
{
    stp_status status = STP_OK;
    to->width = (from->width + 1) / 2;
    to->height = (from->height + 1) / 2;
    STP_TRY(stp_alloc(&to->rgb, (size_t)to->width * to->height, sizeof *to->rgb, "texels", err));
    for (uint32_t y = 0; y < to->height; y++)
        for (uint32_t x = 0; x < to->width; x++) {
            unsigned sum[3] = {0, 0, 0};
            for (uint32_t i = 0; i < 4; i++) {
                const uint32_t sx = 2 * x + i % 2, sy = 2 * y + i / 2;
                const uint8_t *texel =
                    from->rgb[(size_t)(sy < from->height ? sy : sy - 1) * from->width +
                              (sx < from->width ? sx : sx - 1)];
                for (int k = 0; k < 3; k++)
                    sum[k] += texel[k];
            }
            for (int k = 0; k < 3; k++)
                to->rgb[(size_t)y * to->width + x][k] = (uint8_t)((sum[k] + 2) / 4);
        }
done:
    return status;
}

static stp_status make_levels(stp_texture *texture, const stp_image *image, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t texels = (size_t)image->width * (size_t)image->height;
    stp_texture_level level = {(uint32_t)image->width, (uint32_t)image->height, NULL};
    STP_TRY(stp_alloc(&level.rgb, texels, sizeof *level.rgb, "texels", err));
    for (size_t i = 0; i < texels; i++)
        memcpy(level.rgb[i], image->rgba + 4 * i, 3);
    while ((uint64_t)level.width * level.height > STP_TEXTURE_TEXELS) {
        stp_texture_level half = {0, 0, NULL};
        STP_TRY(halve(&level, &half, err));
        free(level.rgb);
        level = half;
    }
    texture->levels[0] = level;
    texture->level_count = 1;
    level.rgb = NULL;
    for (stp_texture_level *last = texture->levels; last->width > 1 || last->height > 1; last++) {
        STP_TRY(halve(last, last + 1, err));
        texture->level_count++;
    }
done:
    free(level.rgb);
    return status;
}

/* Loads the image of bytes: as a file that lies in memory. */
static stp_status load_bytes(const stp_texture *texture, stp_image *image, stp_error *err)
{
    stp_status status = STP_OK;
    char path[32];
    const int descriptor = memfd_create("image", MFD_CLOEXEC);
    if (descriptor < 0)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for an image");
    snprintf(path, sizeof path, "/proc/self/fd/%d", descriptor);
    for (size_t at = 0; at < texture->byte_count && status == STP_OK;) {
        const ssize_t wrote = write(descriptor, texture->bytes + at, texture->byte_count - at);
        if (wrote < 0 && errno != EINTR)
            status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for an image");
        at += wrote > 0 ? (size_t)wrote : 0;
    }
    if (status == STP_OK)
        status = stp_image_load(image, path, err);
    close(descriptor);
    return status;
}

static stp_status load_image(stp_materials *m, stp_texture *texture, const char *mesh_path,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    stp_image image = {0};
    char *path = NULL;
    STP_TRY(path_beside(&path, mesh_path, texture->name, err));
    const stp_status loaded = texture->bytes != NULL ? load_bytes(texture, &image, &why)
                                                     : stp_image_load(&image, path, &why);
    if (texture->bytes != NULL && loaded != STP_OK)
        stp_error_set(&why, loaded, "%s: %s: no image that can be read", mesh_path, texture->name);
    if (loaded == STP_OK && image.width > 0 && image.height > 0)
        STP_TRY(make_levels(texture, &image, err));
    else if (loaded == STP_OUT_OF_MEMORY)
        status = stp_error_set(err, loaded, "%s", why.message);
    else
        note_missing(m, &why);
    free(texture->bytes);
    texture->bytes = NULL;
done:
    stp_image_destroy(&image);
    free(path);
    return status;
}

stp_status stp_materials_load_images(stp_materials *m, const char *mesh_path, stp_error *err)
{
    stp_status status = STP_OK;
    bool *used = NULL;
    STP_TRY(stp_alloc(&used, m->image_count, sizeof *used, "images", err));
    for (size_t t = 0; t < m->triangle_count; t++)
        if (m->of_triangle[t] != STP_NO_MATERIAL &&
            m->list[m->of_triangle[t]].image != STP_NO_MATERIAL)
            used[m->list[m->of_triangle[t]].image] = true;
    for (size_t i = 0; i < m->image_count; i++)
        if (used[i])
            STP_TRY(load_image(m, &m->images[i], mesh_path, err));
done:
    free(used);
    return status;
}

/* The image of a triangle; NULL: it has none, or no place in it. */
static const stp_texture *image_of(const stp_materials *m, size_t triangle)
{
    const uint32_t material =
        triangle < m->triangle_count ? m->of_triangle[triangle] : STP_NO_MATERIAL;
    const uint32_t image = material != STP_NO_MATERIAL ? m->list[material].image : STP_NO_MATERIAL;
    if (image == STP_NO_MATERIAL || m->images[image].level_count == 0)
        return NULL;
    for (int k = 0; k < 3; k++)
        if (!isfinite(m->corners[triangle][k][0]) || !isfinite(m->corners[triangle][k][1]))
            return NULL;
    return &m->images[image];
}

bool stp_materials_textured(const stp_materials *m, size_t triangle)
{
    return image_of(m, triangle) != NULL;
}

double stp_materials_texels(const stp_materials *m, size_t triangle)
{
    const stp_texture *image = image_of(m, triangle);
    if (!image)
        return 0.0;
    const float(*c)[2] = (const float(*)[2])m->corners[triangle];
    const double ux = (double)c[1][0] - (double)c[0][0], uy = (double)c[1][1] - (double)c[0][1];
    const double vx = (double)c[2][0] - (double)c[0][0], vy = (double)c[2][1] - (double)c[0][1];
    return 0.5 * fabs(ux * vy - uy * vx) * image->levels[0].width * image->levels[0].height;
}

/* The texel at a place: from 0 to 1 over the image. */
static uint32_t texel_at(double place, uint32_t size, stp_wrap wrap)
{
    if (wrap == STP_WRAP_CLAMP)
        place = fmin(fmax(place, 0.0), 1.0 - 0x1p-53);
    else if (wrap == STP_WRAP_MIRROR && fmod(floor(place), 2.0) != 0.0)
        place = 1.0 - (place - floor(place));
    const double part = (place - floor(place)) * size;
    return part < size ? (uint32_t)part : size - 1;
}

bool stp_materials_colour(const stp_materials *m, size_t triangle, const double weights[3],
                          double texels, uint16_t rgb[3])
{
    const stp_texture *image = image_of(m, triangle);
    if (triangle >= m->triangle_count || m->of_triangle[triangle] == STP_NO_MATERIAL)
        return false;
    const stp_material *material = &m->list[m->of_triangle[triangle]];
    if (!image) {
        memcpy(rgb, material->rgb, 3 * sizeof *rgb);
        return true;
    }
    unsigned level = 0; /* a texel of level l covers 4^l of the finest */
    for (double covered = 2.0; covered < texels && level + 1 < image->level_count; covered *= 4.0)
        level++;
    double u = 0.0, v = 0.0;
    for (int k = 0; k < 3; k++) {
        u += weights[k] * (double)m->corners[triangle][k][0];
        v += weights[k] * (double)m->corners[triangle][k][1];
    }
    const stp_texture_level *at = &image->levels[level];
    const uint8_t *texel =
        at->rgb[(size_t)texel_at(1.0 - v, at->height, material->wrap[1]) * at->width +
                texel_at(u, at->width, material->wrap[0])];
    for (int k = 0; k < 3; k++) /* a product of sRGB is nearly that of linear light */
        rgb[k] = (uint16_t)(texel[k] * (material->tinted ? material->rgb[k] / 255u : 257u));
    return true;
}

void stp_materials_move(stp_materials *m, size_t to, size_t from)
{
    if (from >= m->triangle_count)
        return;
    m->of_triangle[to] = m->of_triangle[from];
    memmove(m->corners[to], m->corners[from], sizeof *m->corners);
}

void stp_materials_clear(stp_materials *m)
{
    stp_materials cleared = {0};
    for (size_t i = 0; i < m->count; i++)
        free(m->list[i].name);
    for (size_t i = 0; i < m->image_count; i++) {
        for (unsigned l = 0; l < m->images[i].level_count; l++)
            free(m->images[i].levels[l].rgb);
        free(m->images[i].name);
        free(m->images[i].bytes);
    }
    free(m->list);
    free(m->images);
    free(m->of_triangle);
    free(m->corners);
    memcpy(cleared.missing, m->missing, sizeof cleared.missing);
    *m = cleared;
}
