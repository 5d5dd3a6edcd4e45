/* Where an eye is outside a model's closed surfaces for certain: the metadata's key "closed".
 *
 * A coarse grid of cubes, each of which is outside or not; all beyond the grid is outside. Does not
 * say which samples are closed: STP_SAMPLE_CLOSED does. docs/closed.md has the proof. Units: the
 * scan's own. Threads: any. */
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

/* A ball through which closed samples' backs may be seen. */
typedef struct stp_opening {
    stp_dvec3 centre; /* world */
    double radius;
} stp_opening;

typedef struct stp_outside {
    uint64_t point_count; /* that are closed; 0: there is no grid */
    stp_dvec3 origin;     /* the grid's least corner, world */
    double cell;          /* side of a cube, > 0 */
    int cells[3];
    uint8_t *outside; /* by cube, x fastest, then y: 1 if all of it is outside */
    stp_opening *openings;
    uint32_t opening_count; /* up to STP_OPENINGS_LIMIT */
} stp_outside;

struct cJSON;

/* The value of "closed"; NULL: no memory. */
struct cJSON *stp_outside_to_json(const stp_outside *outside);
/* Reads the metadata of a file; one without the key, or that is no JSON, has no grid. *out needs
 * stp_outside_clear. Errors: CORRUPT (the key is not as SPEC.md says), OUT_OF_MEMORY. */
stp_status stp_outside_read(stp_outside *out, const char *metadata, size_t bytes, stp_error *err);
void stp_outside_clear(stp_outside *outside);

/* Whether all of a ball is outside. No: nothing is known. */
bool stp_outside_holds(const stp_outside *outside, stp_dvec3 centre, double radius);

#endif
