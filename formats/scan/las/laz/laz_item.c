/* Finds the coder of a LAZ item. */
#include "formats/scan/las/laz/laz_item.h"

#define SKIPPED_WAVE(item_version)                                                                 \
    {                                                                                              \
        .type = STP_LAZ_WAVE14, .version = (item_version), .bytes = 29, .layers = 1,               \
        .skipped = true                                                                            \
    }
static const stp_laz_coder wave14_v3 = SKIPPED_WAVE(3), wave14_v4 = SKIPPED_WAVE(4);

const stp_laz_coder *stp_laz_coder_find(unsigned type, unsigned version)
{
    static const stp_laz_coder *const all[] = {
        &stp_laz_point10_v1, &stp_laz_point10_v2,  &stp_laz_time11_v1,   &stp_laz_time11_v2,
        &stp_laz_rgb12_v1,   &stp_laz_rgb12_v2,    &stp_laz_wave13,      &stp_laz_bytes_v1,
        &stp_laz_bytes_v2,   &stp_laz_point14_v3,  &stp_laz_point14_v4,  &stp_laz_rgb14_v3,
        &stp_laz_rgb14_v4,   &stp_laz_rgbnir14_v3, &stp_laz_rgbnir14_v4, &wave14_v3,
        &wave14_v4,          &stp_laz_bytes14_v3,  &stp_laz_bytes14_v4};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (all[i]->type == type && all[i]->version == version)
            return all[i];
    return NULL;
}
