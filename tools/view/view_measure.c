/* The list of measured lines. */
#include "tools/view/view_measure.h"

#include "base/vec.h"

#include <string.h>

bool view_measure_add(view_measure *m, stp_dvec3 point)
{
    if (m->line_count == VIEW_LINES_LIMIT)
        return false;
    if (!m->begun) {
        m->first = point;
    } else {
        m->lines[m->line_count][0] = m->first;
        m->lines[m->line_count++][1] = point;
    }
    m->begun = !m->begun;
    return true;
}

void view_measure_remove(view_measure *m, int index)
{
    m->line_count--;
    memmove(m->lines + index, m->lines + index + 1,
            (size_t)(m->line_count - index) * sizeof *m->lines);
}

const stp_dvec3 *view_measure_last(const view_measure *m)
{
    return m->begun || m->line_count == 0 ? NULL : m->lines[m->line_count - 1];
}

double view_measure_length(const stp_dvec3 ends[2])
{
    return stp_dvec3_length(stp_dvec3_sub(ends[1], ends[0]));
}
