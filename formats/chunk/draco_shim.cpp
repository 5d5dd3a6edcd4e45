// Draco behind C: a column of integers as a Draco point cloud.
#include "formats/chunk/draco_shim.h"

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/point_cloud/point_cloud.h>

#include <cstdlib>
#include <cstring>
#include <new>
#include <vector>

namespace
{

using draco::AttributeValueIndex;
using draco::GeometryAttribute;
using draco::PointAttribute;
using draco::PointCloud;

// What every stream of so many values begins with: Draco header, point count, one attributes
// encoder, one attribute (its type, its unique id 0), its integer encoder.
std::vector<char> stream_head(uint32_t count)
{
    std::vector<char> head = {'D', 'R', 'A', 'C', 'O', 2, 3, 0, 0, 0, 0};
    for (int i = 0; i < 4; i++)
        head.push_back(static_cast<char>(count >> (8 * i) & 255));
    head.insert(head.end(), {1, 1, GeometryAttribute::GENERIC, draco::DT_INT16, 1, 0, 0,
                             draco::SEQUENTIAL_ATTRIBUTE_ENCODER_INTEGER});
    return head;
}

stp_status check_count(uint32_t count, stp_error *err)
{
    if (count < 1 || count > STP_DRACO_VALUES_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%u values for Draco: use 1 to %u", count,
                             STP_DRACO_VALUES_LIMIT);
    return STP_OK;
}

void fill_cloud(PointCloud &cloud, const int16_t *values, uint32_t count)
{
    GeometryAttribute description;
    description.Init(GeometryAttribute::GENERIC, nullptr, 1, draco::DT_INT16, false, 2, 0);
    cloud.set_num_points(count);
    int id = cloud.AddAttribute(description, true, count);
    cloud.attribute(id)->buffer()->Write(0, values, count * sizeof *values);
}

stp_status encode(const int16_t *values, uint32_t count, void **stream, size_t *stream_bytes,
                  stp_error *err)
{
    PointCloud cloud;
    fill_cloud(cloud, values, count);
    draco::ExpertEncoder encoder(cloud);
    encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
    // Speeds 3 and 4 give the smallest streams of all (smaller symbol tables than 0 to 2); a
    // prediction of Draco's on top of ours makes them larger.
    encoder.SetSpeedOptions(4, 4);
    encoder.SetAttributePredictionScheme(0, draco::PREDICTION_NONE);
    draco::EncoderBuffer buffer;
    draco::Status result = encoder.EncodeToBuffer(&buffer);
    if (!result.ok())
        return stp_error_set(err, STP_INTERNAL, "Draco cannot encode: %s", result.error_msg());
    std::vector<char> head = stream_head(count);
    if (buffer.size() <= head.size() || memcmp(buffer.data(), head.data(), head.size()) != 0)
        return stp_error_set(err, STP_INTERNAL,
                             "this Draco library writes another stream version than 2.3: use 1.5");
    size_t size = buffer.size() - head.size();
    void *copy = malloc(size);
    if (!copy)
        throw std::bad_alloc();
    memcpy(copy, buffer.data() + head.size(), size);
    *stream = copy;
    *stream_bytes = size;
    return STP_OK;
}

stp_status decode(const void *stream, size_t stream_bytes, int16_t *values, uint32_t count,
                  stp_error *err)
{
    std::vector<char> bytes = stream_head(count);
    const char *body = static_cast<const char *>(stream);
    bytes.insert(bytes.end(), body, body + stream_bytes);
    draco::DecoderBuffer buffer;
    buffer.Init(bytes.data(), bytes.size());
    draco::Decoder decoder;
    auto result = decoder.DecodePointCloudFromBuffer(&buffer);
    if (!result.ok())
        return stp_error_set(err, STP_CORRUPT, "Draco cannot decode the stream: %s",
                             result.status().error_msg());
    const PointCloud &cloud = *result.value();
    if (cloud.num_points() != count || cloud.num_attributes() != 1)
        return stp_error_set(err, STP_CORRUPT, "Draco decodes other counts than expected");
    const PointAttribute *attribute = cloud.attribute(0);
    if (attribute->data_type() != draco::DT_INT16 || attribute->num_components() != 1 ||
        attribute->size() != count || !attribute->is_mapping_identity())
        return stp_error_set(err, STP_CORRUPT, "Draco decodes another type than expected");
    memcpy(values, attribute->GetAddress(AttributeValueIndex(0)), count * sizeof *values);
    return STP_OK;
}

} // namespace

stp_status stp_draco_encode(const int16_t *values, uint32_t count, void **stream,
                            size_t *stream_bytes, stp_error *err)
{
    stp_status status = check_count(count, err);
    if (status != STP_OK)
        return status;
    try {
        return encode(values, count, stream, stream_bytes, err);
    } catch (const std::bad_alloc &) {
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to encode %u values", count);
    } catch (...) {
        return stp_error_set(err, STP_INTERNAL, "Draco failed while encoding");
    }
}

stp_status stp_draco_decode(const void *stream, size_t stream_bytes, int16_t *values,
                            uint32_t count, stp_error *err)
{
    stp_status status = check_count(count, err);
    if (status != STP_OK)
        return status;
    try {
        return decode(stream, stream_bytes, values, count, err);
    } catch (const std::bad_alloc &) {
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to decode %u values", count);
    } catch (...) {
        return stp_error_set(err, STP_CORRUPT, "Draco failed while decoding");
    }
}
