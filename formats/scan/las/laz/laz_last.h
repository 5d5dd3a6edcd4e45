/* What each scanner channel keeps of its last point, for layered items other than POINT14. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_LAST_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_LAST_H

#include "formats/scan/las/laz/laz_item.h"

#include <string.h>

/* Extra bytes of a point that can be unpacked. */
#define STP_LAZ_EXTRA_MOST 1024u

typedef struct stp_laz_last {
    unsigned bytes, current;
    bool used[STP_LAZ_CHANNELS];
    unsigned char kept[STP_LAZ_CHANNELS][STP_LAZ_EXTRA_MOST];
} stp_laz_last;

static inline void stp_laz_last_begin(stp_laz_last *l, const unsigned char *first, unsigned channel)
{
    memset(l->used, 0, sizeof l->used);
    l->used[channel] = true;
    l->current = channel;
    memcpy(l->kept[channel], first, l->bytes);
}

/* Changes to the next point's channel. Returns where the last point is read and the next one kept:
 * the channel's own place. But in version 3, if the channel changes to one in use, it is the place
 * of the channel before. */
static inline unsigned char *stp_laz_last_enter(stp_laz_last *l, unsigned channel, bool version_3)
{
    const unsigned before = l->current;
    const bool known = l->used[channel];
    if (channel == before)
        return l->kept[channel];
    l->current = channel;
    l->used[channel] = true;
    if (!known)
        memcpy(l->kept[channel], l->kept[before], l->bytes);
    return l->kept[known && version_3 ? before : channel];
}

#endif
