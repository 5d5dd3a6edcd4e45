/* Triangles of a model. */
#include "formats/scan/mesh/triangle_set.h"

#include <stdlib.h>

void stp_triangle_set_clear(stp_triangle_set *set)
{
    free(set->vertices);
    free(set->triangles);
    free(set->lattices);
    *set = (stp_triangle_set){0};
}
