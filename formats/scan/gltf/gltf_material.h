/* The materials of a glTF file as a mesh has them. Threads: any, one file each. */
#ifndef STP_FORMATS_SCAN_GLTF_GLTF_MATERIAL_H
#define STP_FORMATS_SCAN_GLTF_GLTF_MATERIAL_H

#include "formats/scan/gltf/gltf_file.h"
#include "formats/scan/mesh/material.h"

/* What a mesh's materials do not hold. How texture coordinates of a material become those of its
 * image (KHR_texture_transform): set, and (u, v) = offset + rotate(scale * (u, v)). */
typedef struct stp_gltf_place {
    double factor[3]; /* of the colours of vertices, in linear light */
    uint32_t set;
    double offset[2], scale[2], rotation;
} stp_gltf_place;

/* Adds the file's materials to an empty list, in their order. *places: one for each; free with
 * free(). An image that cannot be read costs its colours alone. Errors: FORMAT, CORRUPT, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_gltf_materials(const stp_gltf_file *file, stp_materials *materials,
                              stp_gltf_place **places, stp_error *err);
/* Linear light, 0 to 1, as sRGB, 0 to 65535 (IEC 61966-2-1). */
uint16_t stp_gltf_srgb(double linear);

#endif
