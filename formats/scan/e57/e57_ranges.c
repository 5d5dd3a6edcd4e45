/* Finds the values of an E57 file that mean no and full intensity and colour. */
#include "formats/scan/e57/e57_ranges.h"

#include <math.h>

#define SAMPLE_POINTS 65536u
/* Bounds from here on are the type's, and say nothing. */
#define TYPE_RANGE_LEAST 1e30

static bool is_range(stp_value_range r)
{
    return r.high > r.low;
}

/* Finds the values of the targets from first to last in the scan's first points. */
static stp_status look(const stp_e57_scan *scan, stp_e57_target first, stp_e57_target last,
                       stp_e57_vector *v, stp_e57_pages *pages, stp_value_span *span,
                       stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t left = scan->record_count < SAMPLE_POINTS ? scan->record_count : SAMPLE_POINTS;
    *span = (stp_value_span){0};
    STP_TRY(stp_e57_vector_open(v, pages, scan, err));
    while (left > 0) {
        const size_t count = left < STP_E57_BLOCK_POINTS ? (size_t)left : STP_E57_BLOCK_POINTS;
        STP_TRY(stp_e57_vector_read(v, count, err));
        for (int t = (int)first; t <= (int)last; t++)
            for (size_t i = 0; i < count; i++)
                stp_value_span_add(span, v->columns[t][i]);
        left -= count;
    }
done:
    return status;
}

/* Finds the range from the scan's limits, else from its points. */
static stp_status find(const stp_e57_scan *scan, stp_e57_target first, stp_e57_target last,
                       stp_value_range said, stp_e57_vector *v, stp_e57_pages *pages,
                       stp_value_range *range, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_e57_field *field = &scan->fields[first];
    if (!field->present || scan->record_count == 0)
        return STP_OK;
    if (!is_range(said) && field->is_bounded && field->high - field->low < TYPE_RANGE_LEAST)
        said = (stp_value_range){field->low, field->high};
    if (!is_range(said)) {
        stp_value_span span;
        const bool is_float = field->type != STP_E57_INTEGER || field->is_scaled;
        const unsigned bytes = (field->bits + 7) / 8;
        STP_TRY(look(scan, first, last, v, pages, &span, err));
        said = first == STP_E57_RED ? stp_value_range_guess_colour(is_float, bytes, span.max)
                                    : stp_value_range_guess_intensity(is_float, bytes, span);
    }
    *range = is_range(*range) ? stp_value_range_join(*range, said) : said;
done:
    return status;
}

static stp_value_range slots(const stp_e57_scan *scan, stp_e57_slot minimum, stp_e57_slot maximum)
{
    if (!stp_e57_gives(scan, maximum))
        return (stp_value_range){0.0, 0.0};
    return (stp_value_range){scan->numbers[minimum], scan->numbers[maximum]};
}

/* Limits of colours should be what the camera can give, but some programs write what it gave. So
 * 8-bit whole numbers have the range 0..255, and no range begins above 0. */
static stp_value_range said_of_colours(const stp_e57_scan *scan)
{
    const stp_e57_field *red = &scan->fields[STP_E57_RED];
    const bool whole = red->type == STP_E57_INTEGER && !red->is_scaled;
    stp_value_range r = slots(scan, STP_E57_RED_MINIMUM, STP_E57_RED_MAXIMUM);
    if (whole && red->low == 0.0 && red->high == 255.0)
        return (stp_value_range){0.0, 255.0};
    r = stp_value_range_join(r, slots(scan, STP_E57_GREEN_MINIMUM, STP_E57_GREEN_MAXIMUM));
    r = stp_value_range_join(r, slots(scan, STP_E57_BLUE_MINIMUM, STP_E57_BLUE_MAXIMUM));
    r.low = fmin(r.low, 0.0);
    if (whole && r.low == 0.0 && r.high > 1.0 && r.high < 255.0)
        r.high = 255.0;
    return r;
}

stp_status stp_e57_ranges_find(stp_e57_ranges *ranges, const stp_e57_document *document,
                               stp_e57_vector *vector, stp_e57_pages *pages, stp_error *err)
{
    stp_status status = STP_OK;
    stp_e57_ranges found = {{0.0, 0.0}, {0.0, 0.0}};
    for (size_t i = 0; i < document->scan_count; i++) {
        const stp_e57_scan *scan = &document->scans[i];
        STP_TRY(find(scan, STP_E57_INTENSITY, STP_E57_INTENSITY,
                     slots(scan, STP_E57_INTENSITY_MINIMUM, STP_E57_INTENSITY_MAXIMUM), vector,
                     pages, &found.intensity, err));
        STP_TRY(find(scan, STP_E57_RED, STP_E57_BLUE, said_of_colours(scan), vector, pages,
                     &found.colour, err));
    }
    *ranges = found;
done:
    return status;
}
