/* Measures how far stored points are from the points that were read. */
#include "preprocess/patch/displacement.h"

#include "preprocess/patch/patch_build.h"

/* Tolerance for rounding in comparisons. */
#define ROUNDING 1e-9

/* Whether the stored number rounds to the number that was read: to the nearest step, float or
 * double. */
static bool is_same(double stored, double read, const stp_resolution *r)
{
    const bool is_float = (double)(float)read == read;
    if (r->step > 0.0 && !(r->floats && is_float))
        return fabs(stored - read) < 0.5 * r->step * (1.0 - ROUNDING);
    return is_float ? (float)stored == (float)read : stored == read;
}

void stp_displacement_add(stp_displacement *d, const stp_item *item, stp_dvec3 stored,
                          const stp_resolution *r)
{
    const stp_dvec3 read = item->disc.centre;
    d->points++;
    if (stp_dvec3_equal(stored, read))
        return;
    const double length = stp_dvec3_length(stp_dvec3_sub(stored, read));
    const double limit = r->precision > 0.0 ? r->precision : sqrt(item->area) / STP_SPACING_PARTS;
    d->greatest = stp_max(d->greatest, length);
    d->sum += length;
    d->beyond += length > limit * (1.0 + ROUNDING);
    d->changed += !(is_same(stored.x, read.x, r) && is_same(stored.y, read.y, r) &&
                    is_same(stored.z, read.z, r));
}

void stp_displacement_join(stp_displacement *d, const stp_displacement *other)
{
    d->points += other->points;
    d->greatest = stp_max(d->greatest, other->greatest);
    d->sum += other->sum;
    d->beyond += other->beyond;
    d->changed += other->changed;
}

double stp_displacement_mean(const stp_displacement *d)
{
    return d->points > 0 ? d->sum / (double)d->points : 0.0;
}
