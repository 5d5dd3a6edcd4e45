/* A light that stands still in the world, by azimuth and altitude, as maps with hill shading have
 * it. Angles in degrees: azimuth clockwise from +y, altitude above level. Threads: any. */
#ifndef STP_TOOLS_DRAW_DRAW_LIGHT_H
#define STP_TOOLS_DRAW_DRAW_LIGHT_H

#include "runtime/stipple.h"

/* The light of maps: from the upper left. */
#define DRAW_LIGHT_AZIMUTH 315.0
#define DRAW_LIGHT_ALTITUDE 45.0

void draw_light_set(stp_draw_params *params, double azimuth, double altitude);
/* False if the light moves with the camera; the angles are then those of maps. */
bool draw_light_get(const stp_draw_params *params, double *azimuth, double *altitude);
/* Parses "AZIMUTH,ALTITUDE". Errors: INVALID_ARGUMENT. */
stp_status draw_light_parse(const char *text, stp_draw_params *params, stp_error *err);

#endif
