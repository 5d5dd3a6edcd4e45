// Draco's decoder of meshes behind C.
#include "formats/scan/gltf/draco_mesh_shim.h"

#include <draco/compression/decode.h>
#include <draco/core/varint_decoding.h>

#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>
#include <utility>

struct stp_draco_mesh {
    std::unique_ptr<draco::Mesh> mesh;
};

namespace
{

// A plane of 2048 x 2048 squares takes a byte for 687 faces.
constexpr uint64_t faces_free = UINT64_C(1) << 22, faces_a_byte = 1024,
                   faces_most = UINT64_C(1) << 28;
// Of an edgebreaker mesh: sets of attributes with seams of their own. Each takes memory by faces.
constexpr uint8_t sets_most = 16;
constexpr size_t header_bytes = 11;

stp_status corrupt(stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT, "Draco cannot decode it");
}

// Reads the header and the counts behind it (Draco bitstream specification, sections 4 and 5).
stp_status check(const uint8_t *bytes, size_t size, stp_error *err)
{
    if (size < header_bytes + 2 || memcmp(bytes, "DRACO", 5) != 0)
        return stp_error_set(err, STP_CORRUPT, "it has no Draco stream");
    const bool edgebreaker = bytes[8] == 1;
    if (bytes[5] != 2 || bytes[6] != 2 || bytes[7] != 1 || bytes[8] > 1 || (bytes[10] & 0x80) != 0)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "its Draco stream is no mesh of version 2.2 without metadata");
    draco::DecoderBuffer buffer;
    uint32_t first = 0, second = 0;
    uint8_t sets = 0;
    const size_t at = header_bytes + (edgebreaker ? 1 : 0); // the kind of traversal
    buffer.Init(reinterpret_cast<const char *>(bytes) + at, size - at, 2 << 8 | 2);
    if (!draco::DecodeVarint(&first, &buffer) || !draco::DecodeVarint(&second, &buffer) ||
        (edgebreaker && !buffer.Decode(&sets)))
        return corrupt(err);
    const uint64_t faces = edgebreaker ? second : first, vertices = edgebreaker ? first : second;
    if (faces > faces_most || sets > sets_most)
        return stp_error_set(err, STP_LIMIT,
                             "it has %llu faces and %u sets of attributes, at most %llu and %u are "
                             "read: part it",
                             static_cast<unsigned long long>(faces), sets,
                             static_cast<unsigned long long>(faces_most), sets_most);
    return faces > faces_free + faces_a_byte * size || vertices > 3 * faces ? corrupt(err) : STP_OK;
}

stp_status decode(stp_draco_mesh **out, const uint8_t *bytes, size_t size, stp_error *err)
{
    draco::DecoderBuffer buffer;
    draco::Decoder decoder;
    buffer.Init(reinterpret_cast<const char *>(bytes), size);
    auto mesh = decoder.DecodeMeshFromBuffer(&buffer);
    if (!mesh.ok())
        return corrupt(err);
    std::unique_ptr<stp_draco_mesh> made(new stp_draco_mesh{std::move(mesh).value()});
    for (draco::FaceIndex i(0); i < made->mesh->num_faces(); ++i)
        for (const draco::PointIndex &corner : made->mesh->face(i))
            if (corner >= made->mesh->num_points())
                return corrupt(err);
    *out = made.release();
    return STP_OK;
}

unsigned type_of(draco::DataType type)
{
    switch (type) {
    case draco::DT_INT8:
        return 5120;
    case draco::DT_UINT8:
        return 5121;
    case draco::DT_INT16:
        return 5122;
    case draco::DT_UINT16:
        return 5123;
    case draco::DT_UINT32:
        return 5125;
    case draco::DT_FLOAT32:
        return 5126;
    default:
        return 0;
    }
}

} // namespace

stp_status stp_draco_mesh_decode(stp_draco_mesh **out, const uint8_t *bytes, size_t size,
                                 stp_error *err)
{
    *out = nullptr;
    try {
        const stp_status status = check(bytes, size, err);
        return status == STP_OK ? decode(out, bytes, size, err) : status;
    } catch (const std::bad_alloc &) {
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for a Draco mesh");
    } catch (...) {
        return corrupt(err);
    }
}

void stp_draco_mesh_destroy(stp_draco_mesh **mesh)
{
    delete *mesh;
    *mesh = nullptr;
}

uint32_t stp_draco_mesh_vertex_count(const stp_draco_mesh *mesh)
{
    return mesh->mesh->num_points();
}

uint32_t stp_draco_mesh_face_count(const stp_draco_mesh *mesh)
{
    return mesh->mesh->num_faces();
}

void stp_draco_mesh_face(const stp_draco_mesh *mesh, uint32_t face, uint32_t corners[3])
{
    const draco::Mesh::Face &f = mesh->mesh->face(draco::FaceIndex(face));
    for (size_t k = 0; k < 3; k++)
        corners[k] = f[k].value();
}

stp_status stp_draco_mesh_numbers(const stp_draco_mesh *mesh, uint32_t id, stp_draco_numbers *out,
                                  stp_error *err)
try {
    const draco::PointAttribute *a = mesh->mesh->GetAttributeByUniqueId(id);
    const unsigned type = a != nullptr ? type_of(a->data_type()) : 0;
    const uint32_t count = mesh->mesh->num_points();
    *out = {};
    if (type == 0 || a->num_components() < 1 || a->num_components() > 4)
        return stp_error_set(err, STP_CORRUPT,
                             "its Draco stream lacks attribute %u, or its type is none of glTF's",
                             id);
    const auto item = static_cast<size_t>(draco::DataTypeLength(a->data_type())) *
                      static_cast<size_t>(a->num_components());
    if (static_cast<size_t>(a->byte_stride()) != item)
        return corrupt(err);
    auto *data = static_cast<uint8_t *>(malloc(item * count + 1));
    if (data == nullptr)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for a Draco mesh");
    for (uint32_t i = 0; i < count; i++) {
        const draco::AttributeValueIndex value = a->mapped_index(draco::PointIndex(i));
        if (value >= a->size()) {
            free(data);
            return corrupt(err);
        }
        a->GetValue(value, data + i * item);
    }
    *out = {data, type, static_cast<unsigned>(a->num_components())};
    return STP_OK;
} catch (const std::bad_alloc &) {
    return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for a Draco mesh");
} catch (...) {
    return corrupt(err);
}
