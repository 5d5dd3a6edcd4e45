// Wraps Draco's point cloud decoder as a C function.
#include "tests/support/draco_cloud_shim.h"

#include <draco/compression/decode.h>
#include <draco/point_cloud/point_cloud.h>

#include <cstring>

int draco_cloud_read(const void *bytes, size_t size, int16_t *values, uint32_t count)
{
    try {
        draco::DecoderBuffer buffer;
        draco::Decoder decoder;
        buffer.Init(static_cast<const char *>(bytes), size);
        auto result = decoder.DecodePointCloudFromBuffer(&buffer);
        if (!result.ok() || result.value()->num_points() != count ||
            result.value()->num_attributes() != 1)
            return -1;
        const draco::PointAttribute *attribute = result.value()->attribute(0);
        if (attribute->data_type() != draco::DT_INT16 || attribute->num_components() != 1 ||
            attribute->size() != count || !attribute->is_mapping_identity())
            return -1;
        memcpy(values, attribute->GetAddress(draco::AttributeValueIndex(0)),
               count * sizeof *values);
        return 0;
    } catch (...) {
        return -1;
    }
}
