/* Polylines of a model: ribbons and tubes (MKC08, section 4). Threads: any once filled. */
#ifndef STP_FORMATS_SCAN_MESH_LINE_SET_H
#define STP_FORMATS_SCAN_MESH_LINE_SET_H

#include "base/vec.h"

#include <stdint.h>

typedef enum stp_line_kind { STP_LINE_RIBBON = 1, STP_LINE_TUBE = 2 } stp_line_kind;

typedef struct stp_line_vertex {
    stp_dvec3 position;
    vec3s direction; /* ribbon: normal; tube: tangent; unit, zero if unknown */
    float radius;    /* half the width, in the model's unit */
    uint16_t rgb[3]; /* full range 0..65535 */
    uint16_t intensity;
    uint8_t class_id;
} stp_line_vertex;

/* The vertices [begin, begin + count) in this order. */
typedef struct stp_line_strip {
    uint64_t begin;
    uint64_t count;
    stp_line_kind kind;
} stp_line_strip;

typedef struct stp_line_set {
    stp_line_vertex *vertices;
    uint64_t vertex_count;
    stp_line_strip *strips;
    uint64_t strip_count;
} stp_line_set;

/* Frees what the set owns. */
void stp_line_set_clear(stp_line_set *set);

#endif
