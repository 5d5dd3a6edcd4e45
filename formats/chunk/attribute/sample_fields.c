/* Fields of samples. */
#include "formats/chunk/attribute/sample_fields.h"

#include <cjson/cJSON.h>
#include <math.h>

uint32_t stp_sample_fields(const stp_chunk_file_info *info)
{
    const bool has[STP_FIELD_COUNT] = {
        [STP_FIELD_x] = true,
        [STP_FIELD_y] = true,
        [STP_FIELD_z] = true,
        [STP_FIELD_intensity] = info->attributes & STP_HAS_INTENSITY,
        [STP_FIELD_class] = info->attributes & STP_HAS_CLASS,
        [STP_FIELD_outlier] = info->attributes & STP_HAS_OUTLIERS,
        [STP_FIELD_red] = info->attributes & STP_HAS_COLOUR,
        [STP_FIELD_green] = info->attributes & STP_HAS_COLOUR,
        [STP_FIELD_blue] = info->attributes & STP_HAS_COLOUR,
    };
    uint32_t out = 0;
    for (int f = 0; f < (int)STP_FIELD_COUNT; f++)
        out |= (uint32_t)has[f] << f;
    return out;
}

double stp_sample_intensity_step(const stp_chunk_file_info *info)
{
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(metadata, "intensity_max");
    const double most = cJSON_IsNumber(number) ? number->valuedouble : 0.0;
    cJSON_Delete(metadata);
    return (most > 0.0 && isfinite(most) ? most : 65535.0) / 255.0;
}

uint16_t stp_sample_intensity(const stp_sample *sample, double intensity_step)
{
    return (uint16_t)fmin(65535.0, sample->intensity * intensity_step + 0.5);
}

void stp_sample_values(const stp_sample *sample, stp_dvec3 position, double intensity_step,
                       double out[STP_FIELD_COUNT])
{
    out[STP_FIELD_x] = position.x;
    out[STP_FIELD_y] = position.y;
    out[STP_FIELD_z] = position.z;
    out[STP_FIELD_intensity] = stp_sample_intensity(sample, intensity_step);
    out[STP_FIELD_class] = sample->class_id;
    out[STP_FIELD_outlier] = (sample->flags & STP_SAMPLE_OUTLIER) != 0;
    out[STP_FIELD_red] = sample->rgb[0];
    out[STP_FIELD_green] = sample->rgb[1];
    out[STP_FIELD_blue] = sample->rgb[2];
}
