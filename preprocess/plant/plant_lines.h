/* A growing set of lines: strips are added one after the other. Threads: one at a time. */
#ifndef STP_PREPROCESS_PLANT_PLANT_LINES_H
#define STP_PREPROCESS_PLANT_PLANT_LINES_H

#include "base/error.h"
#include "formats/scan/mesh/line_set.h"

#include <stddef.h>

/* The radius of a pointed end over that of its neighbour: near zero, but not zero. */
#define STP_PLANT_TIP_SHARE 0.01

typedef struct stp_plant_lines {
    stp_line_set set;
    size_t vertex_capacity, strip_capacity;
} stp_plant_lines;

/* Adds a strip of count vertices. Errors: OUT_OF_MEMORY. */
stp_status stp_plant_lines_add(stp_plant_lines *lines, stp_line_kind kind,
                               const stp_line_vertex *vertices, size_t count, stp_error *err);

#endif
