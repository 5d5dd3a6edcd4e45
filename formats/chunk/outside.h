/* Where an eye is certainly outside a model's closed surfaces: the metadata's key "closed".
 *
 * A coarse grid of cubes, each outside or not; everything beyond the grid is outside.
 * STP_SAMPLE_CLOSED says which samples are closed, not this file. docs/closed.md has the proof.
 * Units: the scan's own. Threads: any. */
#ifndef STP_FORMATS_CHUNK_OUTSIDE_H
#define STP_FORMATS_CHUNK_OUTSIDE_H

#include "base/error.h"
#include "base/vec.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Most cubes along an axis. */
#define STP_OUTSIDE_CELLS_LIMIT 256
#define STP_OPENINGS_LIMIT 128

/* A ball through which the backs of closed samples may be seen. */
typedef struct stp_opening {
    stp_dvec3 centre; /* world */
    double radius;
} stp_opening;

typedef struct stp_outside {
    uint64_t point_count; /* closed points; 0: there is no grid */
    stp_dvec3 origin;     /* the grid's least corner, world */
    double cell;          /* side of a cube, > 0 */
    int cells[3];
    uint8_t *outside; /* by cube, x fastest, then y: 1 if all of it is outside */
    stp_opening *openings;
    uint32_t opening_count; /* up to STP_OPENINGS_LIMIT */
} stp_outside;

struct cJSON;

/* The value of the key "closed". NULL: no memory. */
struct cJSON *stp_outside_to_json(const stp_outside *outside);
/* Reads the key from a file's metadata. If the key is missing, or the metadata is no JSON, there is
 * no grid. *out needs stp_outside_clear. Errors: CORRUPT (the key is not as SPEC.md says),
 * OUT_OF_MEMORY. */
stp_status stp_outside_read(stp_outside *out, const char *metadata, size_t bytes, stp_error *err);
void stp_outside_clear(stp_outside *outside);

/* True if all of a ball is outside. False says nothing. */
bool stp_outside_holds(const stp_outside *outside, stp_dvec3 centre, double radius);

#endif
