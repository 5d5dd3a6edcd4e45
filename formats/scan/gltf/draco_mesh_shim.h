/* A C interface to Draco's decoder of meshes, for glTF (KHR_draco_mesh_compression).
 *
 * Reads bitstream 2.2 without metadata, which is what glTF's writers make. Memory: some 100 bytes a
 * face, and more for each attribute. A stream may claim 2^22 faces and 1024 a byte more, since flat
 * meshes need little, but 2^28 at most. Threads: any. */
#ifndef STP_FORMATS_SCAN_GLTF_DRACO_MESH_SHIM_H
#define STP_FORMATS_SCAN_GLTF_DRACO_MESH_SHIM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#include "base/error.h"

typedef struct stp_draco_mesh stp_draco_mesh;

/* Numbers of an attribute, vertex by vertex. */
typedef struct stp_draco_numbers {
    uint8_t *data; /* owned: free() */
    unsigned type; /* as glTF has it: 5120 (a byte) to 5126 (a float) */
    unsigned components;
} stp_draco_numbers;

/* Errors: CORRUPT, UNSUPPORTED (another version, metadata, no mesh), LIMIT, OUT_OF_MEMORY. */
stp_status stp_draco_mesh_decode(stp_draco_mesh **out, const uint8_t *bytes, size_t size,
                                 stp_error *err);
void stp_draco_mesh_destroy(stp_draco_mesh **mesh);
uint32_t stp_draco_mesh_vertex_count(const stp_draco_mesh *mesh);
uint32_t stp_draco_mesh_face_count(const stp_draco_mesh *mesh);
/* Corners of a face, each less than the number of vertices. */
void stp_draco_mesh_face(const stp_draco_mesh *mesh, uint32_t face, uint32_t corners[3]);
/* The numbers of the attribute that has this id in the stream. Errors: CORRUPT (there is none, or
 * of another kind than glTF has), OUT_OF_MEMORY. */
stp_status stp_draco_mesh_numbers(const stp_draco_mesh *mesh, uint32_t id, stp_draco_numbers *out,
                                  stp_error *err);

#ifdef __cplusplus
}
#endif

#endif
