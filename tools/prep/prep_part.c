/* Reads a part of all inputs: that of one of several processes. */
#include "tools/prep/prep_inputs.h"

/* The points that an input has as far as the survey knows. */
static uint64_t points_of(const prep_inputs *in, size_t i)
{
    return in->facts[i].why ? 0 : in->facts[i].points;
}

/* The input that a place lies in; the last one for the end. *first: the place of its first record.
 */
static size_t input_at(const prep_inputs *in, uint64_t place, uint64_t *first)
{
    size_t i = 0;
    *first = 0;
    while (i + 1 < in->count && place - *first >= points_of(in, i))
        *first += points_of(in, i++);
    return i;
}

uint64_t prep_inputs_part_begin(void *context, uint64_t place)
{
    const prep_inputs *in = context;
    uint64_t first = 0;
    const size_t i = input_at(in, place, &first);
    /* normals of images come from all of their pixels */
    const bool whole = in->files[i].grid.columns > 0 || in->files[i].image_count > 0;
    const uint64_t seek = whole ? 0 : in->facts[i].seek_points;
    return seek > 0 ? place - (place - first) % seek : first;
}

stp_status prep_inputs_read_part(void *context, uint64_t begin, uint64_t end, stp_error *err)
{
    prep_inputs *in = context;
    uint64_t first = begin;
    (void)err;
    stp_scan_close(&in->scan);
    in->in_part = end != UINT64_MAX;
    in->part_left = end - begin;
    in->current = in->in_part ? input_at(in, begin, &first) : 0;
    in->part_skip = begin < end ? begin - first : 0;
    in->stations_before = in->files[in->current].station_begin;
    for (size_t i = 0; i < in->count; i++)
        in->files[i].point_count = in->in_part ? points_of(in, i) : 0;
    return STP_OK;
}
