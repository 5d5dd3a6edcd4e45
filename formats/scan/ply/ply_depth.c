/* Finds out from the data whether wide colours are 8-bit values in disguise, and whether there are
 * any. */
#include "formats/scan/ply/ply_columns.h"
#include "formats/scan/value_range.h"

#include <math.h>
#include <string.h>

#define STP_PLY_SAMPLE_BLOCKS 64u
#define STP_PLY_SAMPLE_PREFIX 65536u

/* The values so far. */
typedef struct depth_spans {
    stp_value_span colour, intensity;
    double colour_min;
} depth_spans;

static void add_column(const stp_ply *ply, stp_ply_target target, size_t count,
                       stp_value_span *span)
{
    for (size_t i = 0; i < count; i++)
        stp_value_span_add(span, ply->columns[target][i]);
}

static void add_block(const stp_ply *ply, size_t count, depth_spans *spans)
{
    if (ply->attributes & STP_POINT_HAS_COLOUR) {
        add_column(ply, STP_PLY_RED, count, &spans->colour);
        add_column(ply, STP_PLY_GREEN, count, &spans->colour);
        add_column(ply, STP_PLY_BLUE, count, &spans->colour);
        for (int k = 0; k < 3; k++)
            for (size_t i = 0; i < count; i++)
                spans->colour_min = fmin(spans->colour_min, ply->columns[STP_PLY_RED + k][i]);
    }
    if (ply->attributes & STP_POINT_HAS_INTENSITY)
        add_column(ply, STP_PLY_INTENSITY, count, &spans->intensity);
}

static stp_status sample_spread(stp_ply *ply, depth_spans *spans, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t total = ply->vertex->count;
    const uint64_t blocks = STP_PLY_SAMPLE_BLOCKS;
    uint64_t next = 0;
    for (uint64_t block = 0; block < blocks; block++) {
        uint64_t first = stp_spread_begin(total, block, blocks);
        first = first > next ? first : next; /* else blocks of small files would overlap */
        const uint64_t left = total - first;
        const size_t count = left < STP_PLY_BLOCK_POINTS ? (size_t)left : STP_PLY_BLOCK_POINTS;
        stp_source_seek(&ply->source, ply->vertex_offset + first * ply->vertex->stride, 0);
        ply->cursor.index = first;
        STP_TRY(stp_ply_read_columns(ply, count, err));
        add_block(ply, count, spans);
        next = first + count;
    }
done:
    return status;
}

static stp_status sample_prefix(stp_ply *ply, depth_spans *spans, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t left = ply->vertex->count;
    left = left < STP_PLY_SAMPLE_PREFIX ? left : STP_PLY_SAMPLE_PREFIX;
    while (left > 0) {
        const size_t count = left < STP_PLY_BLOCK_POINTS ? (size_t)left : STP_PLY_BLOCK_POINTS;
        STP_TRY(stp_ply_read_columns(ply, count, err));
        add_block(ply, count, spans);
        left -= count;
    }
done:
    return status;
}

static bool is_eight_bit(stp_ply_type type)
{
    return stp_ply_type_size(type) == 1;
}

static double find_colour_scale(stp_ply_type type, double maximum)
{
    return stp_value_range_scale(stp_value_range_guess_colour(
        type >= STP_PLY_FLOAT32, (unsigned)stp_ply_type_size(type), maximum));
}

static void find_intensity_scale(stp_ply *ply, stp_ply_type type, stp_value_span span)
{
    const stp_value_range range = stp_value_range_guess_intensity(
        type >= STP_PLY_FLOAT32, (unsigned)stp_ply_type_size(type), span);
    ply->intensity_low = range.low;
    ply->intensity_scale = stp_value_range_scale(range);
}

static bool is_wide(const stp_ply *ply, stp_ply_target target)
{
    const stp_ply_property *property = stp_ply_target_property(ply, target);
    return property && !is_eight_bit(property->type);
}

bool stp_ply_is_harmonic(const stp_ply_property *property)
{
    return strncmp(property->name, "f_dc_", 5) == 0;
}

bool stp_ply_has_splats(const stp_ply *ply)
{
    const stp_ply_property *red = stp_ply_target_property(ply, STP_PLY_RED);
    return ply->packed || (red && stp_ply_is_harmonic(red));
}

stp_status stp_ply_find_depths(stp_ply *ply, stp_error *err)
{
    stp_status status = STP_OK;
    depth_spans spans = {.colour_min = INFINITY};
    const stp_ply_property *red = stp_ply_target_property(ply, STP_PLY_RED);
    const stp_ply_property *intensity = stp_ply_target_property(ply, STP_PLY_INTENSITY);
    const bool harmonic = red && stp_ply_is_harmonic(red);
    const bool fixed = stp_ply_has_fixed_records(ply);
    if (ply->vertex->count > 0 &&
        (ply->attributes & STP_POINT_HAS_COLOUR || is_wide(ply, STP_PLY_INTENSITY))) {
        STP_TRY(fixed ? sample_spread(ply, &spans, err) : sample_prefix(ply, &spans, err));
        const bool all = fixed || ply->vertex->count <= STP_PLY_SAMPLE_PREFIX;
        /* Colours that are all zero are none: a program wrote them for want of any. So are white
         * ones that would hide intensities. */
        const bool white = ply->attributes & STP_POINT_HAS_INTENSITY &&
                           stp_value_is_white(spans.colour_min, spans.colour.max);
        if ((spans.colour.max <= 0.0 || white) && all && !harmonic)
            ply->attributes &= ~(uint32_t)STP_POINT_HAS_COLOUR;
        /* A dark beginning does not say that 1 is full. */
        if (!all && red && red->type < STP_PLY_FLOAT32 && spans.colour.max <= 1.0)
            spans.colour.max = 255.0;
        stp_source_seek(&ply->source, ply->vertex_offset, ply->vertex_line);
        ply->cursor.index = 0;
    }
    if (harmonic) {
        ply->colour_low = -sqrt(M_PI);
        ply->colour_scale = 65535.0 / (2.0 * sqrt(M_PI));
    } else if (ply->packed) {
        ply->colour_scale = 65535.0;
    } else if (red) {
        ply->colour_scale =
            find_colour_scale(stp_ply_is_packed(red) ? STP_PLY_UINT8 : red->type, spans.colour.max);
    }
    if (intensity)
        find_intensity_scale(ply, intensity->type, spans.intensity);
done:
    return status;
}
