/* A growing set of lines. */
#include "preprocess/plant/plant_lines.h"

#include "base/memory.h"

#include <string.h>

stp_status stp_plant_lines_add(stp_plant_lines *lines, stp_line_kind kind,
                               const stp_line_vertex *vertices, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_line_set *set = &lines->set;
    const size_t begin = (size_t)set->vertex_count, strip = (size_t)set->strip_count;
    STP_TRY(stp_grow(&set->vertices, &lines->vertex_capacity, begin + count, sizeof *set->vertices,
                     "line vertices", err));
    STP_TRY(stp_grow(&set->strips, &lines->strip_capacity, strip + 1, sizeof *set->strips, "lines",
                     err));
    memcpy(set->vertices + begin, vertices, count * sizeof *vertices);
    set->strips[strip] = (stp_line_strip){.begin = begin, .count = count, .kind = kind};
    set->vertex_count += count;
    set->strip_count++;
done:
    return status;
}
