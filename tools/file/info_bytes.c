/* Counts what the bytes of a chunk file hold, by attribute. */
#include "tools/file/info_bytes.h"

#include "base/memory.h"
#include "formats/chunk/attribute/attribute_file.h"
#include "formats/chunk/free_ranges.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* A position error of 1/32 of the spacing: half the diagonal of a cell of this many spacings. */
#define SPACING_STEP (2.0 / 32.0 / sqrt(3.0))

static const char *const share_name[STP_SHARE_COUNT] = {[STP_SHARE_POSITIONS] = "positions",
                                                        [STP_SHARE_NORMALS] = "normals",
                                                        [STP_SHARE_RADII] = "radii",
                                                        [STP_SHARE_COLOURS] = "colours",
                                                        [STP_SHARE_INTENSITIES] = "intensities",
                                                        [STP_SHARE_CLASSES] = "classes",
                                                        [STP_SHARE_PATCHES] = "patches",
                                                        [STP_SHARE_FRAME] = "frame"};

/* By radius code: bits of a position beyond those that the spacing asks for. */
static void fill_scale_bits(double lambda, uint64_t out[256])
{
    for (unsigned code = 0; code < 256; code++) {
        const double spacing = stp_radius_decode((uint8_t)code, 0) / lambda; /* in steps */
        const double octaves = spacing > 0.0 ? floor(log2(spacing * SPACING_STEP)) : 0.0;
        out[code] = octaves > 0.0 ? 3 * (uint64_t)octaves : 0;
    }
}

static stp_status count_chunk(stp_chunk_file *file, uint32_t id, const uint64_t scale_bits[256],
                              stp_chunk_scratch *scratch, info_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry entry;
    stp_chunk *chunk = NULL;
    uint8_t *payload = NULL;
    STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
    const uint32_t size = stp_chunk_payload_bytes(&entry, 0);
    STP_TRY(stp_alloc(&payload, (size_t)size + 1, 1, "payload", err));
    STP_TRY(stp_chunk_file_fetch(file, id, 0, size, payload, err));
    STP_TRY(stp_chunk_file_decode(file, id, 0, payload, scratch, &chunk, err));
    for (uint32_t i = 0; entry.child_count == 0 && i < entry.sample_count[0]; i++)
        out->scale_bits += scale_bits[chunk->samples[0][i].radius];
done:
    free(payload);
    if (chunk)
        stp_chunk_recycle(&chunk, scratch);
    return status;
}

/* Sums up the parts of each attribute. */
static stp_status count_attributes(stp_chunk_file *file, info_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_attribute_file *attributes = NULL;
    STP_TRY(stp_attribute_file_open(&attributes, file, err));
    out->attributes = *stp_attribute_file_list(attributes);
    for (uint32_t a = 0; a < out->attributes.count; a++)
        for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
            stp_attribute_row row;
            STP_TRY(stp_attribute_file_row(attributes, a, id, &row, err));
            for (int k = 0; k < STP_LEVEL_COUNT; k++)
                out->attribute_bytes[a] += row.bytes[k];
        }
done:
    stp_attribute_file_close(&attributes);
    return status;
}

stp_status info_bytes_count(stp_chunk_file *file, info_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    uint64_t scale_bits[256], unused = 0;
    stp_chunk_scratch scratch = {.shares = &out->shares};
    fill_scale_bits(info->lambda, scale_bits);
    for (uint32_t id = 0; id < info->chunk_count; id++)
        STP_TRY(count_chunk(file, id, scale_bits, &scratch, out, err));
    STP_TRY(stp_free_ranges_sum(file, &unused, err));
    out->shares.bytes[STP_SHARE_FRAME] +=
        info->file_bytes - (info->payloads_end - info->payloads_begin) + unused;
    STP_TRY(count_attributes(file, out, err));
    for (uint32_t a = 0; a < out->attributes.count; a++)
        out->shares.bytes[STP_SHARE_FRAME] -= out->attribute_bytes[a];
done:
    stp_chunk_scratch_free(&scratch);
    return status;
}

void info_bytes_print(const info_bytes *bytes, const stp_chunk_file_info *info)
{
    const double points = (double)info->point_count;
    printf("\n%-14s %14s %14s\n", "what", "bytes", "bytes a point");
    for (int s = 0; s < STP_SHARE_COUNT; s++)
        printf("%-14s %14" PRIu64 " %14.3f\n", share_name[s], bytes->shares.bytes[s],
               (double)bytes->shares.bytes[s] / points);
    for (uint32_t a = 0; a < bytes->attributes.count; a++)
        printf("%-19s %9" PRIu64 " %14.3f\n", bytes->attributes.items[a].name,
               bytes->attribute_bytes[a], (double)bytes->attribute_bytes[a] / points);
    printf(
        "classes: and flags; patches: headers of patches; frame: all else. All levels together\n");
    const double scale = (double)bytes->scale_bits / 8.0 / points;
    if (scale >= 0.05)
        printf(
            "Up to %.2f bytes a point of the positions keep the scan's own scale: they are finer "
            "than 1/32 of the spacing.\n",
            scale);
}

void info_bytes_json(const info_bytes *bytes, cJSON *json)
{
    cJSON *out = cJSON_AddObjectToObject(json, "bytes");
    for (int s = 0; s < STP_SHARE_COUNT; s++)
        cJSON_AddNumberToObject(out, share_name[s], (double)bytes->shares.bytes[s]);
    for (uint32_t a = 0; a < bytes->attributes.count; a++)
        cJSON_AddNumberToObject(out, bytes->attributes.items[a].name,
                                (double)bytes->attribute_bytes[a]);
    cJSON_AddNumberToObject(json, "scale_bytes", (double)bytes->scale_bits / 8.0);
}
