/* A glTF file: its JSON, its buffers, and the numbers in them. Threads: any, one file each. */
#ifndef STP_FORMATS_SCAN_GLTF_GLTF_FILE_H
#define STP_FORMATS_SCAN_GLTF_GLTF_FILE_H

#include "base/error.h"

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_GLTF_NONE UINT32_MAX

typedef struct stp_gltf_bytes {
    const uint8_t *data;
    size_t size;
    uint8_t *owned; /* NULL: inside the file */
} stp_gltf_bytes;

/* The file's lists of objects that others name by number. */
typedef enum stp_gltf_list {
    STP_GLTF_SCENES,
    STP_GLTF_NODES,
    STP_GLTF_MESHES,
    STP_GLTF_ACCESSORS,
    STP_GLTF_VIEWS,
    STP_GLTF_TEXTURES,
    STP_GLTF_IMAGES,
    STP_GLTF_MATERIALS,
    STP_GLTF_BUFFERS,
    STP_GLTF_SAMPLERS,
    STP_GLTF_LIST_COUNT
} stp_gltf_list;

/* A decoded buffer view. */
typedef struct stp_gltf_unpacked_view {
    stp_gltf_bytes bytes; /* data NULL: nobody asked for it yet, or it is not compressed */
    size_t stride;
} stp_gltf_unpacked_view;

typedef struct stp_gltf_unpacked {
    uint64_t bytes; /* of all views */
    stp_gltf_unpacked_view views[];
} stp_gltf_unpacked;

typedef struct stp_gltf_file {
    const char *path; /* borrowed */
    uint8_t *bytes;
    size_t size;
    cJSON *json;
    const cJSON **lists[STP_GLTF_LIST_COUNT];
    uint32_t counts[STP_GLTF_LIST_COUNT];
    stp_gltf_bytes binary; /* of a .glb */
    stp_gltf_bytes *buffers;
    uint32_t buffer_count;
    stp_gltf_unpacked *unpacked; /* owned */
} stp_gltf_file;

/* The items of a sparse accessor that others take the place of, in ascending order. */
typedef struct stp_gltf_sparse {
    const uint8_t *places, *items;
    size_t count;
    unsigned place_bytes;
} stp_gltf_sparse;

/* Numbers of an accessor, checked to lie in their buffer. */
typedef struct stp_gltf_numbers {
    const uint8_t *data; /* NULL: all are zero */
    stp_gltf_sparse sparse;
    size_t count, stride;
    unsigned components, type; /* type: as glTF has it, 5120 (a byte) to 5126 (a float) */
    bool normalized;
} stp_gltf_numbers;

/* A little-endian number of 32 bits. */
static inline uint32_t stp_gltf_word(const uint8_t *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* Errors: as stp_gltf_read. */
stp_status stp_gltf_file_open(stp_gltf_file *out, const char *path, stp_error *err);
void stp_gltf_file_close(stp_gltf_file *file);

/* Item `index` of a list; NULL: there is none. */
const cJSON *stp_gltf_item(const stp_gltf_file *file, stp_gltf_list list, uint32_t index);
/* A whole number of an object, or `otherwise`. Errors: CORRUPT (it is none that fits). */
stp_status stp_gltf_whole(const stp_gltf_file *file, const cJSON *object, const char *key,
                          uint64_t otherwise, uint64_t *out, stp_error *err);
/* The number of an item in another list; STP_GLTF_NONE if the key is missing. Errors: CORRUPT. */
stp_status stp_gltf_index(const stp_gltf_file *file, const cJSON *object, const char *key,
                          uint32_t *out, stp_error *err);
/* The bytes of a buffer that `buffer`, `byteOffset` and `byteLength` of an object name; nothing to
 * free. Errors: CORRUPT. */
stp_status stp_gltf_range(const stp_gltf_file *file, const cJSON *object, stp_gltf_bytes *out,
                          stp_error *err);
/* The bytes of a buffer view. Errors: CORRUPT. */
stp_status stp_gltf_view(const stp_gltf_file *file, uint32_t index, const uint8_t **data,
                         size_t *size, size_t *stride, stp_error *err);
/* Whether the file cannot be read without an extension. */
bool stp_gltf_requires(const stp_gltf_file *file, const char *extension);
/* Bytes of a number of a type, 5120 to 5126; 0: no such type. */
unsigned stp_gltf_type_bytes(unsigned type);
/* The numbers of an accessor. components: those wanted, in bits: 1 << 3 for three. Errors: CORRUPT,
 * UNSUPPORTED. */
stp_status stp_gltf_numbers_of(const stp_gltf_file *file, uint32_t index, unsigned components,
                               stp_gltf_numbers *out, stp_error *err);
/* A number; of normalized types as a fraction of 1. */
double stp_gltf_number(const stp_gltf_numbers *numbers, size_t item, unsigned component);
/* The bytes that a URI stands for: base64 in itself, or a file beside this one. Free out->owned.
 * Errors: NOT_FOUND, IO, CORRUPT, UNSUPPORTED (an address), OUT_OF_MEMORY. */
stp_status stp_gltf_fetch(const stp_gltf_file *file, const char *uri, stp_gltf_bytes *out,
                          stp_error *err);
/* Refuses the file. `format` says what is wrong where. */
__attribute__((format(printf, 3, 4))) stp_status
stp_gltf_corrupt(const stp_gltf_file *file, stp_error *err, const char *format, ...);

#endif
