/* Where the places of an exaggerated world are drawn. */
#include "base/vec.h"
#include "runtime/stipple.h"

#include <math.h>

static double times_of(const stp_draw_params *params)
{
    return params->exaggerate > 0.0 ? params->exaggerate : 1.0;
}

stp_dvec3 stp_exaggerated(const stp_draw_params *params, stp_dvec3 place)
{
    place.z += (times_of(params) - 1.0) * (place.z - params->exaggerate_about);
    return place;
}

stp_dvec3 stp_unexaggerated(const stp_draw_params *params, stp_dvec3 drawn)
{
    drawn.z += (1.0 / times_of(params) - 1.0) * (drawn.z - params->exaggerate_about);
    return drawn;
}

stp_ball stp_exaggerated_ball(const stp_draw_params *params, const stp_ball *ball)
{
    return (stp_ball){stp_exaggerated(params, ball->centre),
                      ball->radius * fmax(1.0, times_of(params))};
}
