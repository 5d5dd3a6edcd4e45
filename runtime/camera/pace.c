/* An integral controller in the logarithm of the threshold. */
#include "runtime/camera/pace.h"

#include <math.h>

/* The share of the correction, as the slope predicts it, that one frame applies. */
#define GAIN 0.6
/* A smaller error of the logarithm is not corrected. */
#define DEAD_BAND 0.04
/* One frame changes the threshold by at most these factors. A far too slow frame may coarsen it
 * quickly. */
#define COARSER_MOST 8.0
#define FINER_MOST 1.8
/* Limits of the slope. Samples fall at most with the inverse square of the threshold. The lower
 * limit keeps the threshold from running away if the cost hardly falls. */
#define SLOPE_MOST 2.0
#define SLOPE_LEAST 0.25
/* If two thresholds differ by less than this factor, they tell nothing about the slope. */
#define SLOPE_STEP 1.08
#define SPIKE 1.8
#define SLOW_FRAMES 4
/* A frame rate counts as held if it is missed by less than this factor. */
#define TOLERANCE 1.15

stp_pace stp_pace_begin(double fps, double asked_px)
{
    return (stp_pace){
        .fps = fps, .asked_px = asked_px, .threshold_px = asked_px, .slope = SLOPE_MOST};
}

static double clamp(double x, double least, double most)
{
    return fmin(fmax(x, least), most);
}

/* New slope: half from this frame and the last, half from before. */
static void learn_slope(stp_pace *p, double frame_ms)
{
    double way = log(p->threshold_px / p->last_px);
    if (fabs(way) < log(SLOPE_STEP))
        return;
    double slope = clamp(-log(frame_ms / p->last_ms) / way, SLOPE_LEAST, SLOPE_MOST);
    p->slope = 0.5 * (p->slope + slope);
}

void stp_pace_follow(stp_pace *p, double frame_ms)
{
    double period_ms = 1e3 / p->fps, ms = fmax(frame_ms, 1e-3);
    bool spike = p->last_ms > 0.0 && !p->spiked && ms > SPIKE * p->last_ms;
    p->spiked = spike;
    if (spike)
        return;
    if (p->last_ms > 0.0)
        learn_slope(p, ms);
    p->last_ms = ms;
    p->last_px = p->threshold_px;
    double off = log(ms / (STP_PACE_SHARE * period_ms));
    if (fabs(off) > DEAD_BAND)
        p->threshold_px *= exp(clamp(GAIN * off / p->slope, -log(FINER_MOST), log(COARSER_MOST)));
    bool most = p->threshold_px >= STP_PACE_THRESHOLD_MOST_PX;
    p->threshold_px = clamp(p->threshold_px, p->asked_px, STP_PACE_THRESHOLD_MOST_PX);
    bool slow = most && ms > TOLERANCE * period_ms;
    if (slow && p->slow_frames < 2 * SLOW_FRAMES)
        p->slow_frames++;
    else if (!slow && p->slow_frames > 0)
        p->slow_frames--;
}

bool stp_pace_holds(const stp_pace *p)
{
    return p->slow_frames < SLOW_FRAMES;
}
