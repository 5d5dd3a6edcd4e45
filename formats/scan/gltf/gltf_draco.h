/* Primitives of a glTF file that Draco compressed (KHR_draco_mesh_compression). Threads: any, one
 * file each. */
#ifndef STP_FORMATS_SCAN_GLTF_GLTF_DRACO_H
#define STP_FORMATS_SCAN_GLTF_GLTF_DRACO_H

#include "formats/scan/gltf/gltf_file.h"

#define STP_GLTF_DRACO_ARRAYS 5

/* Zero: not compressed. */
typedef struct stp_gltf_draco {
    const stp_gltf_file *file; /* borrowed */
    struct stp_draco_mesh *mesh;
    const cJSON *ids;                       /* by attribute: its id in the stream */
    uint8_t *arrays[STP_GLTF_DRACO_ARRAYS]; /* owned: what the numbers point into */
    unsigned array_count;
} stp_gltf_draco;

/* Decodes the primitive if it is compressed. If its stream cannot be decoded and the file has its
 * numbers once more, these are left to be read. Errors: CORRUPT, UNSUPPORTED, LIMIT, OUT_OF_MEMORY.
 */
stp_status stp_gltf_draco_open(stp_gltf_draco *out, const stp_gltf_file *file,
                               const cJSON *primitive, stp_error *err);
void stp_gltf_draco_close(stp_gltf_draco *draco);

/* The numbers of an attribute, if the stream has it: *found. accessor, components: as in
 * stp_gltf_numbers_of. *out is borrowed from *draco. Errors: CORRUPT, OUT_OF_MEMORY. */
stp_status stp_gltf_draco_numbers(stp_gltf_draco *draco, const char *name, uint32_t accessor,
                                  unsigned components, stp_gltf_numbers *out, bool *found,
                                  stp_error *err);
/* The corners of all faces. Borrowed likewise. Errors: OUT_OF_MEMORY. */
stp_status stp_gltf_draco_indices(stp_gltf_draco *draco, stp_gltf_numbers *out, stp_error *err);

#endif
