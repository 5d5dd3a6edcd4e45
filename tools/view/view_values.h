/* The attributes of what was clicked. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_VALUES_H
#define STP_TOOLS_VIEW_VIEW_VALUES_H

#include "formats/attribute/attribute.h"
#include "runtime/stipple.h"

typedef struct view_values {
    uint32_t count;
    char names[STP_ATTRIBUTES_LIMIT][STP_ATTRIBUTE_NAME_BYTES];
    double values[STP_ATTRIBUTES_LIMIT]; /* NaN: none */
} view_values;

/* Finds the point of the picked chunk that is nearest to the picked position, and its attributes.
 * None if the model keeps none, or if they cannot be read. Reads a chunk from the file. */
void view_values_find(view_values *out, const stp_model *model, const stp_pick *pick);

#endif
