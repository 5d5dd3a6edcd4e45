/* Finds the scan's own scale in positions. */
#include "formats/chunk/codec/predict/scale.h"

#include "base/wide.h"
#include "formats/chunk/codec/inline.h"
#include "formats/chunk/layout.h"

/* Steps that are tried: 1, 0.1, 0.01 and so on. */
#define STEPS_TRIED 7

/* Samples looked at together. */
#define LANES 8u
_Static_assert(STP_PATCH_SAMPLES % LANES == 0, "a patch fills whole lanes");

/* Where the multiples may lie along an axis, in steps from the first position's. */
typedef struct window {
    double first; /* the first position, in steps */
    double low, high;
} window;

/* Narrows the window to what rounds to each of the positions, of which a multiple of LANES are
 * there. half: of a step of the lattice. False if nothing is left of it. */
STP_INLINE bool window_take(window *w, const double *positions, unsigned count, double half)
{
    double low[LANES], high[LANES];
    for (unsigned k = 0; k < LANES; k++) {
        low[k] = w->low;
        high[k] = w->high;
    }
    for (unsigned i = 0; i < count; i += LANES)
        for (unsigned k = 0; k < LANES; k++) {
            double off = positions[i + k] - w->first;
            off -= floor(off + 0.5);
            low[k] = off - half > low[k] ? off - half : low[k];
            high[k] = off + half < high[k] ? off + half : high[k];
        }
    for (unsigned k = 0; k < LANES; k++) {
        w->low = fmax(w->low, low[k]);
        w->high = fmin(w->high, high[k]);
    }
    return w->low < w->high;
}

STP_WIDE
static bool find_phase(const stp_chunk *chunk, double step, int axis, uint16_t *out)
{
    window w = {.low = -0.5, .high = 0.5};
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        const double places = ldexp(1.0, patch->exponent) / step;
        const stp_sample *samples = chunk->samples[0] + chunk->level_begin[0][p];
        double at[STP_PATCH_SAMPLES] = {0.0};
        unsigned count = patch->counts[0];
        for (unsigned i = 0; i < count; i++)
            at[i] = ((double)patch->origin[axis] + samples[i].position[axis]) * places;
        for (; count % LANES > 0; count++)
            at[count] = at[0];
        w.first = p == 0 ? at[0] : w.first;
        if (!window_take(&w, at, count, places / 2.0))
            return false;
    }
    const double phase = w.first + (w.low + w.high) / 2.0;
    *out = (uint16_t)(uint32_t)((phase - floor(phase)) * STP_SCALE_PHASES + 0.5);
    return true;
}

/* Whether every position comes back from its place. */
STP_WIDE
static bool holds(const stp_chunk *chunk, const stp_scale *scale)
{
    bool used = false;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch_scale s = stp_scale_of_patch(scale, &chunk->patches[p]);
        const stp_sample *samples = chunk->samples[0] + chunk->level_begin[0][p];
        used = used || s.used;
        for (unsigned i = 0; s.used && i < chunk->patches[p].counts[0]; i++)
            for (int a = 0; a < 3; a++) {
                const int32_t place = stp_scale_place(&s, a, samples[i].position[a]);
                if (place > 0xffff || stp_scale_position(&s, a, place) != samples[i].position[a])
                    return false;
            }
    }
    return used;
}

/* Whether some patch would be coded by the scale. */
static bool serves(const stp_chunk *chunk, const stp_scale *scale)
{
    bool used = false;
    for (uint32_t p = 0; p < chunk->patch_count && !used; p++)
        used = stp_scale_of_patch(scale, &chunk->patches[p]).used;
    return used;
}

void stp_scale_find(const stp_chunk *chunk, stp_scale *out)
{
    double step = 1.0;
    for (int k = 0; k < STEPS_TRIED; k++, step /= 10.0) {
        stp_scale scale = {.step = step};
        bool found = serves(chunk, &scale);   /* on a coarse lattice any fine step would do */
        for (int a = 2; a >= 0 && found; a--) /* heights of grids tell first */
            found = find_phase(chunk, step, a, &scale.phase[a]);
        if (found && holds(chunk, &scale)) {
            *out = scale;
            return;
        }
    }
    *out = (stp_scale){0};
}

void stp_scale_write(const stp_scale *scale, uint8_t bytes[STP_SCALE_BYTES])
{
    stp_put_f64(bytes, scale->step);
    for (int i = 0; i < 3; i++)
        stp_put_u16(bytes + 8 + 2 * i, scale->phase[i]);
}

stp_status stp_scale_read(const uint8_t bytes[STP_SCALE_BYTES], stp_scale *out, stp_error *err)
{
    const double step = stp_get_f64(bytes);
    if (!(step > 0.0 && step <= STP_SCALE_LIMIT))
        return stp_error_set(err, STP_CORRUPT, "a table has a scale of %g", step);
    out->step = step;
    for (int i = 0; i < 3; i++)
        out->phase[i] = stp_get_u16(bytes + 8 + 2 * i);
    return STP_OK;
}
