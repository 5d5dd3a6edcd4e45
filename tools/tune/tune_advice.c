/* The advice of a sweep. */
#include "tools/tune/tune_advice.h"

#include <stdio.h>

static size_t finest_of(const tune_choice *choices, size_t count)
{
    size_t finest = 0;
    for (size_t i = 1; i < count; i++)
        finest = choices[i].threshold_px < choices[finest].threshold_px ? i : finest;
    return finest;
}

/* Whether all choices up to a threshold look like the finest. */
static bool holds_to(const tune_choice *choices, size_t count, double threshold_px, double least_db)
{
    for (size_t i = 0; i < count; i++)
        if (choices[i].threshold_px <= threshold_px && choices[i].psnr_db < least_db)
            return false;
    return true;
}

bool tune_advise(const tune_choice *choices, size_t count, tune_advice *out)
{
    if (count < 2)
        return false;
    const size_t finest = finest_of(choices, count);
    const double least_db = choices[finest].psnr_db - TUNE_ADVICE_DB;
    size_t chosen = finest;
    for (size_t i = 0; i < count; i++)
        if (choices[i].threshold_px > choices[chosen].threshold_px &&
            holds_to(choices, count, choices[i].threshold_px, least_db))
            chosen = i;
    size_t next = finest;
    for (size_t i = 0; i < count; i++)
        if (choices[i].threshold_px > choices[finest].threshold_px &&
            (next == finest || choices[i].threshold_px < choices[next].threshold_px))
            next = i;
    *out = (tune_advice){
        .chosen = chosen,
        .finest = finest,
        .next = next,
        .loss_db = choices[finest].psnr_db - choices[chosen].psnr_db,
        .faster = choices[chosen].ms > 0.0 ? choices[finest].ms / choices[chosen].ms : 1.0,
        .fewer =
            choices[chosen].points > 0.0 ? choices[finest].points / choices[chosen].points : 1.0};
    return true;
}

void tune_advice_words(const tune_advice *a, const tune_choice *choices, char out[240])
{
    const double chosen = choices[a->chosen].threshold_px, finest = choices[a->finest].threshold_px;
    if (a->chosen == a->finest) {
        snprintf(out, 240,
                 "recommended: --threshold %.4g: the next coarser one, %.4g px, loses %.2f dB",
                 chosen, choices[a->next].threshold_px,
                 choices[a->finest].psnr_db - choices[a->next].psnr_db);
        return;
    }
    int length = snprintf(out, 240, "recommended: --threshold %.4g: it looks like %.4g px (",
                          chosen, finest);
    length += a->loss_db > 0.005
                  ? snprintf(out + length, 240 - (size_t)length, "%.2f dB less", a->loss_db)
                  : snprintf(out + length, 240 - (size_t)length, "no dB less");
    length += snprintf(out + length, 240 - (size_t)length, "), draws %.1f times fewer samples and ",
                       a->fewer);
    if (a->faster >= TUNE_ADVICE_FASTER)
        snprintf(out + length, 240 - (size_t)length, "is %.1f times as fast", a->faster);
    else if (a->faster * TUNE_ADVICE_FASTER >= 1.0)
        snprintf(out + length, 240 - (size_t)length, "is as fast on this machine");
    else
        snprintf(out + length, 240 - (size_t)length, "is slower on this machine");
}
