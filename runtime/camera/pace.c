/* Least squares over the last frames, and steps of resolution with hysteresis. */
#include "runtime/camera/pace.h"

#include <math.h>

/* Each frame, the earlier frames keep this share of their weight. */
#define KEPT 0.9
/* The standard deviation of samples over their mean: below SPREAD_LEAST, frames tell nothing about
 * the time of a sample; at SPREAD_HALF, half of sample_ms is replaced. */
#define SPREAD_LEAST 0.1
#define SPREAD_HALF 0.2
/* A doubled threshold saves at most 3/4 of the samples. It helps if this saves 15 % of the time:
 * 0.75 s >= 0.15 (fixed + s), so the samples' time s must be at least 0.25 fixed. */
#define USEFUL 0.25
/* One frame changes the threshold by at most these factors; a smaller change than DEAD_BAND, of the
 * logarithm, is left out; one below SETTLED will not hold the rate. */
#define COARSER_MOST 2.0
#define FINER_MOST 1.5
#define DEAD_BAND 0.06
#define SETTLED 0.1
/* A frame strays if its time is off by this factor, whatever a sample costs. */
#define STRAY 1.8
/* A frame rate counts as held if it is missed by less than this factor. */
#define TOLERANCE 1.15
/* The resolution falls after SLOW_FRAMES. It rises after QUICK_FRAMES, if the frame would then take
 * at most QUICK of the time that drawing may take. */
#define SLOW_FRAMES 3
#define QUICK_FRAMES 10
#define QUICK 0.8
/* A step to fewer pixels helps if the frame takes at most this share of the time before. */
#define STEP_HELPS 0.85
/* After so many slow frames, a step that did not help is tried again. */
#define RETRY_FRAMES 60

static double clamp(double x, double least, double most)
{
    return fmin(fmax(x, least), most);
}

static double most_px(const stp_pace *p)
{
    return fmax(p->asked_px, STP_PACE_THRESHOLD_MOST_PX);
}

static double target_ms(const stp_pace *p)
{
    return STP_PACE_SHARE * 1e3 / p->fps;
}

/* The part of a frame's time that samples do not cause. */
static double fixed_ms(const stp_pace *p)
{
    return fmax(p->ms - p->sample_ms * p->samples, 0.0);
}

void stp_pace_ask(stp_pace *p, double fps, double asked_px)
{
    if (p->scale <= 0.0)
        *p = (stp_pace){.scale = 1.0, .most_step = STP_PACE_STEPS_MOST};
    p->fps = fps;
    p->asked_px = asked_px;
    p->threshold_px = clamp(p->threshold_px, asked_px, most_px(p));
}

/* Whether the frame's time is far off, be it caused by pixels alone or by samples alone. */
static bool strays(const stp_pace *p, double samples, double ms)
{
    double by_samples = p->ms * samples / p->samples;
    return p->weight > 0.0 &&
           (ms > STRAY * fmax(p->ms, by_samples) || STRAY * ms < fmin(p->ms, by_samples));
}

/* Forgets the last frames. Samples keep their share of the time; at first it is half of it. */
static void restart(stp_pace *p, double samples, double ms)
{
    double share = p->weight > 0.0 ? p->sample_ms * p->samples / p->ms : 0.5;
    p->weight = p->samples_samples = p->samples_ms = 0.0;
    p->sample_ms = share * ms / samples;
}

static void learn(stp_pace *p, double samples, double ms)
{
    double off = samples - p->samples, off_ms = ms - p->ms, kept = KEPT * p->weight;
    p->weight = kept + 1.0;
    p->samples += off / p->weight;
    p->ms += off_ms / p->weight;
    p->samples_samples = KEPT * p->samples_samples + kept / p->weight * off * off;
    p->samples_ms = KEPT * p->samples_ms + kept / p->weight * off * off_ms;
    double spread = sqrt(p->samples_samples / p->weight) / p->samples;
    if (spread < SPREAD_LEAST)
        return;
    double slope = clamp(p->samples_ms / p->samples_samples, 0.0, p->ms / p->samples);
    double share = spread * spread / (spread * spread + SPREAD_HALF * SPREAD_HALF);
    p->sample_ms += share * (slope - p->sample_ms);
}

/* The threshold for the next frame: as fine as the rate allows, as coarse as it helps. Samples fall
 * at most with the square of the threshold, so this never goes too far. */
static double wanted_px(const stp_pace *p)
{
    double fixed = fixed_ms(p), left = fmax(target_ms(p) - fixed, USEFUL * fixed);
    double px = p->threshold_px * sqrt(p->sample_ms * p->drawn / left);
    return clamp(px, p->asked_px, most_px(p));
}

/* The least time of a frame with `pixels` times as many pixels, by a threshold that still helps. */
static double least_ms(const stp_pace *p, double pixels)
{
    double fixed = pixels * fixed_ms(p), now = pixels * p->sample_ms * p->drawn;
    double coarsest = now * pow(p->threshold_px / most_px(p), 2.0);
    double finest = now * pow(p->threshold_px / p->asked_px, 2.0);
    return fixed + fmin(fmax(USEFUL * fixed, coarsest), finest);
}

/* Takes another resolution. Samples and time should change as the number of pixels does. */
static void go_to_step(stp_pace *p, int step)
{
    double pixels = pow(2.0, p->step - step);
    p->drawn *= pixels;
    p->samples *= pixels;
    p->ms *= pixels;
    p->samples_samples *= pixels * pixels;
    p->samples_ms *= pixels * pixels;
    p->step = step;
    p->scale = pow(2.0, -0.5 * step);
    p->slow = p->quick = 0;
    p->skips = true;
}

static void step_down(stp_pace *p, double ms)
{
    int step = p->step + 1;
    if (p->slow >= RETRY_FRAMES) {
        p->slow = SLOW_FRAMES;
        p->most_step = STP_PACE_STEPS_MOST;
    }
    if (p->before_ms > 0.0 && ms > STEP_HELPS * p->before_ms) {
        p->most_step = p->before_step;
        p->before_ms = 0.0;
        go_to_step(p, p->most_step);
    } else if (p->step < p->most_step) {
        while (step < p->most_step && least_ms(p, pow(2.0, p->step - step)) > target_ms(p))
            step++;
        p->before_step = p->step;
        p->before_ms = ms;
        go_to_step(p, step);
    }
}

/* Counts slow and quick frames and changes the resolution. settled: no coarser threshold helps. */
static void choose_step(stp_pace *p, bool settled)
{
    double ms = fixed_ms(p) + p->sample_ms * p->drawn, period_ms = 1e3 / p->fps;
    bool quick = p->step > 0 && least_ms(p, 2.0) <= QUICK * target_ms(p);
    p->quick = quick ? p->quick + 1 : 0;
    if (settled && ms > TOLERANCE * period_ms) {
        p->slow++;
    } else if (ms <= period_ms) {
        p->slow = 0;
        p->before_ms = 0.0;
        p->most_step = STP_PACE_STEPS_MOST;
    }
    if (p->quick >= QUICK_FRAMES)
        go_to_step(p, p->step - 1);
    else if (p->slow >= SLOW_FRAMES)
        step_down(p, ms);
}

void stp_pace_follow(stp_pace *p, double frame_ms, uint64_t samples)
{
    double ms = fmax(frame_ms, 1e-3), drawn = (double)samples;
    bool skips = p->skips || samples == 0; /* an empty picture tells nothing */
    p->skips = false;
    if (skips)
        return;
    bool off = strays(p, drawn, ms);
    if (off && !p->strayed) {
        p->strayed = true;
        return;
    }
    p->strayed = false;
    if (off || p->weight <= 0.0)
        restart(p, drawn, ms);
    learn(p, drawn, ms);
    p->drawn = drawn;
    choose_step(p, log(wanted_px(p) / p->threshold_px) < SETTLED);
    double px = wanted_px(p), way = log(px / p->threshold_px);
    if (fabs(way) > DEAD_BAND || px <= p->asked_px)
        p->threshold_px *= exp(clamp(way, -log(FINER_MOST), log(COARSER_MOST)));
}

bool stp_pace_holds(const stp_pace *p)
{
    return p->slow < SLOW_FRAMES;
}
