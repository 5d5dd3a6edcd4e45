/* The plane that fits best through samples of a grid, by least squares. Encoding, decoding and prep
 * run the same arithmetic (formats/SPEC.md, "Squares"). Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_PLANE_FIT_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_PLANE_FIT_H

#include "formats/chunk/codec/inline.h"

#include <stdbool.h>

/* Sums over samples at columns x and rows y, counted from the middle, of heights z. */
typedef struct stp_plane_sums {
    double n, x, y, z, xx, xy, yy, xz, yz;
} stp_plane_sums;

STP_INLINE void stp_plane_add(stp_plane_sums *s, int x, int y, double z)
{
    s->n += 1.0;
    s->x += x;
    s->y += y;
    s->z += z;
    s->xx += x * x;
    s->xy += x * y;
    s->yy += y * y;
    s->xz += x * z;
    s->yz += y * z;
}

/* The plane's slopes by column and by row, of one sample or more. False if all samples lie on one
 * line: then an unknown slope is 0, that by column, by row, or both. */
STP_INLINE bool stp_plane_slopes(const stp_plane_sums *s, double out[2])
{
    const double xx = s->xx - s->x * s->x / s->n, yy = s->yy - s->y * s->y / s->n;
    const double xy = s->xy - s->x * s->y / s->n;
    const double xz = s->xz - s->x * s->z / s->n, yz = s->yz - s->y * s->z / s->n;
    const double det = xx * yy - xy * xy;
    out[0] = out[1] = 0.0;
    if (det > 0x1p-20) {
        out[0] = (xz * yy - yz * xy) / det;
        out[1] = (yz * xx - xz * xy) / det;
        return true;
    }
    if (xx > 0x1p-20)
        out[0] = xz / xx;
    else if (yy > 0x1p-20)
        out[1] = yz / yy;
    return false;
}

#endif
