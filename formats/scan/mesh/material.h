/* The colours of a mesh's faces: the materials of OBJ files (MTL: Kd and map_Kd) and of glTF, those
 * that PLY and OFF have by face, and images, which PLY files name, too.
 *
 * Texture coordinates are (u right, v up), from 0 to 1 over an image; a material says what is
 * beyond. An image is held as levels, each of half the size of the one before, and looked up where
 * its texels are about as far apart as the points. Images that are larger than STP_TEXTURE_TEXELS
 * are halved first. A file that is missing or no image costs its colours alone; `missing` names it.
 *
 * Memory: 28 bytes a triangle, 4 a texel. Threads: one at a time; colours may be looked up on any.
 */
#ifndef STP_FORMATS_SCAN_MESH_MATERIAL_H
#define STP_FORMATS_SCAN_MESH_MATERIAL_H

#include "base/error.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Most texels of an image that are kept. */
#define STP_TEXTURE_TEXELS (UINT64_C(1) << 26)
#define STP_TEXTURE_LEVELS 32u
#define STP_NO_MATERIAL UINT32_MAX

typedef struct stp_texture_level {
    uint32_t width, height;
    uint8_t (*rgb)[3]; /* the top row first */
} stp_texture_level;

typedef struct stp_texture {
    char *name;     /* as the materials have it */
    uint8_t *bytes; /* of the image's file, if it is not one beside the mesh, until it is loaded */
    size_t byte_count;
    stp_texture_level levels[STP_TEXTURE_LEVELS];
    unsigned level_count; /* 0: it could not be loaded */
} stp_texture;

/* How an image goes on beyond its borders. */
typedef enum stp_wrap { STP_WRAP_REPEAT = 0, STP_WRAP_CLAMP, STP_WRAP_MIRROR } stp_wrap;

typedef struct stp_material {
    char *name;
    uint16_t rgb[3];  /* 0..65535 */
    uint32_t image;   /* in images; STP_NO_MATERIAL: none */
    stp_wrap wrap[2]; /* along u and v */
    bool tinted;      /* the image is multiplied by rgb */
} stp_material;

typedef struct stp_materials {
    stp_material *list;
    size_t count, capacity;
    stp_texture *images;
    size_t image_count, image_capacity;
    uint32_t *of_triangle;  /* in list, by triangle of the mesh; STP_NO_MATERIAL: none */
    float (*corners)[3][2]; /* texture coordinates, likewise; NaN: none */
    size_t triangle_count, triangle_capacity, corner_capacity;
    char missing[1024]; /* the first file that could not be read, and why; "": none */
} stp_materials;

/* A texture coordinate as it is kept: NaN if it is none, or so far off that floats know no texel.
 */
static inline float stp_texture_place(double number)
{
    return fabs(number) < 1e6 ? (float)number : NAN;
}

/* Adds the materials of a library that the OBJ file at mesh_path names. Errors: OUT_OF_MEMORY. */
stp_status stp_materials_read(stp_materials *materials, const char *mesh_path, const char *name,
                              const char *name_end, stp_error *err);
/* Adds a material that is an image, by its file's name. Errors: OUT_OF_MEMORY. */
stp_status stp_materials_add_image(stp_materials *materials, const char *name, const char *name_end,
                                   stp_error *err);
/* Adds a material without a name. image: in images, or STP_NO_MATERIAL. Errors: OUT_OF_MEMORY. */
stp_status stp_materials_add(stp_materials *materials, const uint16_t rgb[3], uint32_t image,
                             stp_error *err);
/* Adds an image, the bytes of its file, and keeps a copy of them; the same name is the same image.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_materials_embed(stp_materials *materials, const char *name, const uint8_t *bytes,
                               size_t byte_count, uint32_t *image, stp_error *err);
/* The number of a material; STP_NO_MATERIAL: none has this name. */
uint32_t stp_materials_find(const stp_materials *materials, const char *name, const char *name_end);
/* Adds the next triangle. Errors: OUT_OF_MEMORY. */
stp_status stp_materials_add_triangle(stp_materials *materials, uint32_t material,
                                      const float corners[3][2], stp_error *err);
/* Adds the next `count` triangles, of one colour; rgb NULL: of none. Errors: OUT_OF_MEMORY. */
stp_status stp_materials_add_plain(stp_materials *materials, const uint16_t rgb[3], uint64_t count,
                                   stp_error *err);
/* Loads the images that triangles use. Errors: OUT_OF_MEMORY. */
stp_status stp_materials_load_images(stp_materials *materials, const char *mesh_path,
                                     stp_error *err);
/* Whether the triangle's colours come from an image. */
bool stp_materials_textured(const stp_materials *materials, size_t triangle);
/* Texels of the finest level that the triangle covers, or 0. */
double stp_materials_texels(const stp_materials *materials, size_t triangle);
/* The colour of a triangle where its corners weigh this much, averaged over `texels` texels of the
 * finest level, or its material's. False, and rgb is left: it has no material. */
bool stp_materials_colour(const stp_materials *materials, size_t triangle, const double weights[3],
                          double texels, uint16_t rgb[3]);
/* Moves the colours of a triangle to the place of another, as its caller moves the triangle. */
void stp_materials_move(stp_materials *materials, size_t to, size_t from);
/* Frees all but `missing`. */
void stp_materials_clear(stp_materials *materials);

#endif
