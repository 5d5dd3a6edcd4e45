/* A light that stands still in the world. */
#include "tools/draw/draw_light.h"

#include "base/error.h"

#include <math.h>
#include <stdio.h>

#define DEGREE (M_PI / 180.0)

void draw_light_set(stp_draw_params *params, double azimuth, double altitude)
{
    const double level = cos(altitude * DEGREE);
    params->light[0] = level * sin(azimuth * DEGREE);
    params->light[1] = level * cos(azimuth * DEGREE);
    params->light[2] = sin(altitude * DEGREE);
}

bool draw_light_get(const stp_draw_params *params, double *azimuth, double *altitude)
{
    const double *l = params->light, level = hypot(l[0], l[1]);
    const bool fixed = level > 0.0 || l[2] != 0.0;
    const double turned = atan2(l[0], l[1]) / DEGREE;
    *azimuth = fixed ? turned < 0.0 ? turned + 360.0 : turned : DRAW_LIGHT_AZIMUTH;
    *altitude = fixed ? atan2(l[2], level) / DEGREE : DRAW_LIGHT_ALTITUDE;
    return fixed;
}

stp_status draw_light_parse(const char *text, stp_draw_params *params, stp_error *err)
{
    double azimuth = 0.0, altitude = 0.0;
    int used = 0;
    const int count = sscanf(text, "%lf,%lf%n", &azimuth, &altitude, &used);
    if (count != 2 || text[used] || !isfinite(azimuth) || !(fabs(altitude) <= 90.0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--light %s: give AZIMUTH,ALTITUDE in degrees, like 315,45", text);
    draw_light_set(params, azimuth, altitude);
    return STP_OK;
}
