/* Which normals face the stations that saw their points.
 *
 * A scanner sees the outside of a surface, so the normal of a point leans towards its station, the
 * more surely the less it was seen at a grazing angle. Where it was, and where the station is not
 * known, the neighbours have a say. Local: a point's neighbours and theirs decide. Threads: one
 * call at a time. */
#ifndef STP_PREPROCESS_ORIENT_FACING_H
#define STP_PREPROCESS_ORIENT_FACING_H

#include "preprocess/orient/sheets.h"

/* The cosine under which its station sees a point with this normal, below 0 from behind; 0 where
 * the station is unknown. stations: NULL if none is known. */
double stp_facing(const stp_cloud_point *point, vec3s normal, const stp_dvec3 *stations);
/* Whether it is seen so steeply, from before or behind, that its neighbours are not asked. */
bool stp_facing_plainly(const stp_cloud_point *point, const stp_dvec3 *stations);
/* Turns the oriented points that are not plainly seen by the sum of the logarithms of the odds that
 * their station and each of their neighbours give, stations having at least one. The same for any
 * number of threads. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_facing_settle(const stp_sheets *sheets, const stp_dvec3 *stations, stp_pool *pool,
                             stp_error *err);

#endif
