/* Reads glTF 2.0 (.gltf, .glb) into a point mesh: all meshes of the default scene where its nodes
 * place them.
 *
 * y points up, which the scan's reader tells (stp_scan_info.y_up). It reads triangles, strips, fans
 * and points, and lines as edges; numbers of any type (KHR_mesh_quantization); colours of vertices
 * and base colours, which glTF has in linear light, as sRGB; base-colour images, in the file or
 * beside it (KHR_texture_transform), that repeat, end or are mirrored. If faces have images,
 * colours of vertices are left out. Skins, morphs and animations are left at rest. Meshes
 * compressed by Draco (KHR_draco_mesh_compression) and meshoptimizer (EXT_meshopt_compression) are
 * read. Source: glTF 2.0 Specification (Khronos). Memory: the file, its buffers, views that
 * meshoptimizer compressed, and one primitive of Draco, beside the mesh. Threads: any, one file
 * each. */
#ifndef STP_FORMATS_SCAN_GLTF_GLTF_H
#define STP_FORMATS_SCAN_GLTF_GLTF_H

#include "formats/scan/mesh/point_mesh.h"

/* *mesh must be empty. Errors: NOT_FOUND, IO, FORMAT, CORRUPT, UNSUPPORTED, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_gltf_read(stp_point_mesh *mesh, const char *path, stp_error *err);

#endif
