/* Counts which bytes of a payload hold what. */
#include "formats/chunk/codec/shares.h"

#include "formats/chunk/codec/predict/families.h"
#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/layout.h"

#include <math.h>

stp_share stp_share_of_column(unsigned column)
{
    static const uint8_t share[STP_SAMPLE_COLUMN_COUNT] = {
        [STP_COLUMN_RADIUS] = STP_SHARE_RADII,
        [STP_COLUMN_FLAGS] = STP_SHARE_CLASSES,
        [STP_COLUMN_CLASS] = STP_SHARE_CLASSES,
        [STP_COLUMN_NORMAL_U] = STP_SHARE_NORMALS,
        [STP_COLUMN_NORMAL_V] = STP_SHARE_NORMALS,
        [STP_COLUMN_GREEN] = STP_SHARE_COLOURS,
        [STP_COLUMN_RED] = STP_SHARE_COLOURS,
        [STP_COLUMN_BLUE] = STP_SHARE_COLOURS,
        [STP_COLUMN_INTENSITY] = STP_SHARE_INTENSITIES,
        [STP_COLUMN_POSITION_A] = STP_SHARE_POSITIONS,
        [STP_COLUMN_POSITION_B] = STP_SHARE_POSITIONS,
        [STP_COLUMN_POSITION_C] = STP_SHARE_POSITIONS,
    };
    return (stp_share)share[column];
}

stp_share stp_share_of_plane(unsigned plane)
{
    /* Planes follow the order of columns; a normal has one plane more, a position three. */
    return plane >= STP_PLANE_A_LOW       ? STP_SHARE_POSITIONS
           : plane >= STP_PLANE_NORMAL_U  ? STP_SHARE_NORMALS
           : plane == STP_PLANE_INTENSITY ? STP_SHARE_INTENSITIES
           : plane >= STP_PLANE_GREEN     ? STP_SHARE_COLOURS
           : plane == STP_PLANE_RADIUS    ? STP_SHARE_RADII
                                          : STP_SHARE_CLASSES;
}

void stp_shares_add_samples(stp_shares *shares, const uint64_t *column_bytes, uint64_t bytes)
{
    for (unsigned c = 0; c < STP_SAMPLE_COLUMN_COUNT; c++) {
        shares->bytes[stp_share_of_column(c)] += column_bytes[c];
        bytes -= column_bytes[c];
    }
    shares->bytes[STP_SHARE_FRAME] += bytes;
}

void stp_shares_add_raw(stp_shares *shares, uint64_t bytes)
{
    static const uint8_t sample_bytes[STP_SHARE_COUNT] = {
        [STP_SHARE_POSITIONS] = 6, [STP_SHARE_NORMALS] = 3,     [STP_SHARE_RADII] = 1,
        [STP_SHARE_COLOURS] = 3,   [STP_SHARE_INTENSITIES] = 1, [STP_SHARE_CLASSES] = 2};
    for (unsigned s = 0; s < STP_SHARE_COUNT; s++)
        shares->bytes[s] += bytes / STP_SAMPLE_BYTES * sample_bytes[s];
}

void stp_share_costs_add(stp_share_costs *costs, stp_share share, const uint8_t *plane,
                         size_t count)
{
    uint32_t counts[256] = {0};
    for (size_t i = 0; i < count; i++)
        counts[plane[i]]++;
    for (unsigned v = 0; v < 256; v++)
        if (counts[v])
            costs->cost[share] += counts[v] * log2((double)count / counts[v]);
}

void stp_shares_add_packed(stp_shares *shares, const stp_share_costs *costs, uint64_t bytes)
{
    double sum = 0.0, before = 0.0;
    uint64_t given = 0;
    for (unsigned s = 0; s < STP_SHARE_COUNT; s++)
        sum += costs->cost[s];
    for (unsigned s = 0; s < STP_SHARE_COUNT && sum > 0.0; s++) {
        before += costs->cost[s];
        const uint64_t end = (uint64_t)((double)bytes * fmin(1.0, before / sum));
        shares->bytes[s] += end - given;
        given = end;
    }
    shares->bytes[STP_SHARE_FRAME] += bytes - given;
}
