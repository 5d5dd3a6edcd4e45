/* Turns normals to the stations that saw their points.
 *
 * A scanner sees the outside of a surface, so a point's normal leans towards its station. The less
 * grazing the view, the surer that is. If the view is grazing or the station is unknown, the
 * neighbours have a say. Local: only a point's neighbours and their neighbours count. Threads: one
 * call at a time. */
#ifndef STP_PREPROCESS_ORIENT_FACING_H
#define STP_PREPROCESS_ORIENT_FACING_H

#include "preprocess/orient/sheets.h"

/* The cosine between the normal and the direction to the point's station; below 0 if the station
 * sees the back; 0 if the station is unknown. stations: NULL if none is known. */
double stp_facing(const stp_cloud_point *point, vec3s normal, const stp_dvec3 *stations);
/* Whether the station sees the point so steeply, from the front or the back, that its neighbours
 * are not asked. */
bool stp_facing_plainly(const stp_cloud_point *point, const stp_dvec3 *stations);
/* Turns oriented points that are not seen plainly, by the sum of the log odds from their station
 * and from each of their neighbours. stations has at least one. The result is the same for any
 * number of threads. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_facing_correct(const stp_sheets *sheets, const stp_dvec3 *stations, stp_pool *pool,
                              stp_error *err);

#endif
