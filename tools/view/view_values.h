/* The attributes of what was clicked, and which sample of a grid it is. Threads: the main thread
 * only. */
#ifndef STP_TOOLS_VIEW_VIEW_VALUES_H
#define STP_TOOLS_VIEW_VIEW_VALUES_H

#include "formats/attribute/attribute.h"
#include "runtime/stipple.h"

/* A sample of a survey's or a microscope's grid, or a pixel of a depth camera's image. */
typedef struct view_grid_sample {
    bool known;
    uint32_t column, row; /* of the image, the top row is 0 */
    bool is_depth;        /* of a camera's image */
    double height;        /* as stored; or the depth along the camera's axis */
    /* Of the 8 samples around it: those that the chunk tells of, and those of them that are not
     * there. */
    unsigned told, missing;
} view_grid_sample;

typedef struct view_values {
    view_grid_sample grid; /* if a finest sample is drawn at the clicked place */
    uint32_t count;
    char names[STP_ATTRIBUTES_LIMIT][STP_ATTRIBUTE_NAME_BYTES];
    double values[STP_ATTRIBUTES_LIMIT]; /* NaN: none */
} view_values;

/* Finds the point of the picked chunk that is nearest to the picked position, its attributes, and
 * its place in a grid. Leaves out what the model does not keep, or what cannot be read. Reads a
 * chunk from the file. */
void view_values_find(view_values *out, const stp_model *model, const stp_pick *pick);

#endif
