/* Brings positions from one coordinate system to another, by PROJ.
 *
 * PROJ is in a module that is loaded with the first scan that needs it. Positions are x to the east
 * (or longitude, degrees), y to the north (or latitude), whatever order the systems' definitions
 * have. Heights change their unit alone: the one of a system's vertical part, else that of x and y.
 * Threads: one at a time per projection. */
#ifndef STP_FORMATS_SCAN_GEO_PROJECTION_H
#define STP_FORMATS_SCAN_GEO_PROJECTION_H

#include "base/error.h"
#include "base/vec.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct stp_projection stp_projection;

/* from, to: WKT, "EPSG:25832", or whatever else PROJ takes. to NULL: the zone of UTM in which `at`
 * lies, a longitude and latitude of `from`. Errors: UNSUPPORTED (no PROJ, no such system, no way
 * between the two), OUT_OF_MEMORY. */
stp_status stp_projection_create(stp_projection **out, const char *from, const char *to,
                                 stp_dvec3 at, stp_error *err);
/* Moves a position. One that has none in the other system becomes NaN. */
stp_dvec3 stp_projection_apply(stp_projection *projection, stp_dvec3 position);
/* The name of the system that positions are brought to, and its definition as WKT. */
const char *stp_projection_name(const stp_projection *projection);
const char *stp_projection_wkt(const stp_projection *projection);
/* About what a unit of x and y, and exactly what one of heights becomes. */
double stp_projection_unit(const stp_projection *projection);
double stp_projection_height_unit(const stp_projection *projection);
void stp_projection_destroy(stp_projection **projection);

/* The definition of a system, such as "EPSG:25832", as well-known text: version 1, which LAS wants,
 * or 2 if it has no other. Free with free(). Errors: UNSUPPORTED (no PROJ, no such system),
 * OUT_OF_MEMORY. */
stp_status stp_system_wkt(char **out, const char *definition, stp_error *err);

/* Whether two definitions are of one system: x and y mean the same in both, and heights have one
 * unit, whatever they are above. Errors: UNSUPPORTED (no PROJ, or it does not know one of them). */
stp_status stp_system_same(bool *same, const char *a, const char *b, stp_error *err);

/* ---- for the module ---- */

typedef struct stp_projection_library {
    stp_status (*create)(stp_projection **out, const char *from, const char *to, stp_dvec3 at,
                         stp_error *err);
    stp_dvec3 (*apply)(stp_projection *projection, stp_dvec3 position);
    const char *(*name)(const stp_projection *projection);
    const char *(*wkt)(const stp_projection *projection);
    double (*unit)(const stp_projection *projection);
    double (*height_unit)(const stp_projection *projection);
    void (*destroy)(stp_projection **projection);
    stp_status (*system_wkt)(char **out, const char *definition, stp_error *err);
    stp_status (*system_same)(bool *same, const char *a, const char *b, stp_error *err);
} stp_projection_library;

extern const stp_projection_library stp_projection_proj; /* in the module libstipple-proj.so */

#endif
