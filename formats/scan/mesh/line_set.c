/* Polylines of a model. */
#include "formats/scan/mesh/line_set.h"

#include <stdlib.h>

void stp_line_set_clear(stp_line_set *set)
{
    free(set->vertices);
    free(set->strips);
    *set = (stp_line_set){0};
}
