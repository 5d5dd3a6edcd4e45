/* Buffer views of a glTF file that meshoptimizer compressed (EXT_meshopt_compression), as gltfpack
 * writes them. Threads: any, one file each. */
#ifndef STP_FORMATS_SCAN_GLTF_GLTF_MESHOPT_H
#define STP_FORMATS_SCAN_GLTF_GLTF_MESHOPT_H

#include "formats/scan/gltf/gltf_file.h"

#define STP_GLTF_MESHOPT "EXT_meshopt_compression"

/* Decodes what a view's extension says. *stride: bytes of an item. Free out->owned. Errors:
 * CORRUPT, OUT_OF_MEMORY. */
stp_status stp_gltf_meshopt_decode(const stp_gltf_file *file, const cJSON *extension,
                                   stp_gltf_bytes *out, size_t *stride, stp_error *err);

#endif
