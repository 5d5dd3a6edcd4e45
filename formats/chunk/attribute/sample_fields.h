/* The fields of a sample as conditions ask for them (formats/attribute/condition.h).
 * Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_ATTRIBUTE_SAMPLE_FIELDS_H
#define STP_FORMATS_CHUNK_ATTRIBUTE_SAMPLE_FIELDS_H

#include "formats/attribute/condition.h"
#include "formats/chunk/chunk_file.h"

/* Which fields a file's samples have: a bit for each stp_point_field. */
uint32_t stp_sample_fields(const stp_chunk_file_info *info);
/* What a sample's intensity of 1 stands for, on a scale to 65535. */
double stp_sample_intensity_step(const stp_chunk_file_info *info);
/* A sample's intensity on that scale. */
uint16_t stp_sample_intensity(const stp_sample *sample, double intensity_step);
/* position: of the sample, in the file's coordinates. */
void stp_sample_values(const stp_sample *sample, stp_dvec3 position, double intensity_step,
                       double out[STP_FIELD_COUNT]);

#endif
