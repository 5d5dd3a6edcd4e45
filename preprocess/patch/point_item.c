/* Makes points of a scan into items of a leaf chunk. */
#include "preprocess/patch/point_item.h"

#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/patch/patch_build.h"
#include "preprocess/patch/world_lattice.h"

#include <limits.h>
#include <string.h>

/* Points closer than their coordinates over 2^ROUNDING_OCTAVES should be one: only rounding
 * separates them. */
#define ROUNDING_OCTAVES 40
/* A chunk is at most 2^CHUNK_OCTAVES steps of its finest lattice wide. */
#define CHUNK_OCTAVES 28
/* For floats the lattice is this many octaves finer than the spacing: 8 x 8 points then fit in the
 * 16 bits of a patch. */
#define FLOAT_OCTAVES 12
/* A disc smaller than 2^RADIUS_OCTAVES steps, and the bound of a patch around it, have codes. */
#define RADIUS_OCTAVES 15

/* The exponent of a lattice on which the inputs' numbers come back exactly. */
static int exact_exponent(double spacing, const stp_resolution *r)
{
    int exponent = INT_MAX;
    if (r->step > 0.0) /* on half steps the error is at most a quarter step */
        exponent = stp_floor_log2(0.5 * r->step);
    if (r->floats && spacing > 0.0 && stp_floor_log2(spacing) - FLOAT_OCTAVES < exponent)
        exponent = stp_floor_log2(spacing) - FLOAT_OCTAVES;
    return exponent;
}

int stp_point_exponent(stp_dvec3 position, double spacing, const stp_point_item_params *params)
{
    const int least = params->vertex_least - STP_VERTEX_OCTAVES;
    const stp_resolution *r = &params->resolution;
    const double radius = r->exact ? 0.0 : params->lambda * spacing;
    int exponent = stp_lattice_exponent(spacing, radius, r->precision, position);
    if (r->exact && exact_exponent(spacing, r) < exponent)
        exponent = exact_exponent(spacing, r);
    return exponent > least ? exponent : least;
}

bool stp_point_is_rounded(stp_dvec3 p, int exponent)
{
    const double size = stp_max(fabs(p.x), stp_max(fabs(p.y), fabs(p.z)));
    return size > 0.0 && exponent < stp_floor_log2(size) - ROUNDING_OCTAVES;
}

int stp_point_finest(double side)
{
    return side > 0.0 ? stp_floor_log2(side) - CHUNK_OCTAVES : INT_MIN;
}

int stp_point_exponent_lifted(stp_dvec3 p, int exponent, int finest)
{
    return exponent < finest && stp_point_is_rounded(p, exponent) ? finest : exponent;
}

double stp_point_spacing_on(double spacing, int exponent, const stp_point_item_params *params)
{
    if (!params->resolution.exact)
        return spacing;
    return stp_min(spacing, ldexp(1.0 - 0x1p-20, exponent + RADIUS_OCTAVES) / params->lambda);
}

uint8_t stp_point_intensity(uint16_t intensity, uint32_t greatest)
{
    if (intensity >= greatest)
        return greatest ? UINT8_MAX : 0;
    return (uint8_t)((intensity * 255u + greatest / 2) / greatest);
}

static stp_sample_fit fit_of(const stp_cloud *cloud, uint64_t i)
{
    const stp_cloud_point *point = &cloud->points[i];
    if (point->given == STP_GIVEN_INPUT && !(cloud->marks[i] & STP_MARK_WIDE))
        return STP_FIT_GIVEN;
    if (point->given == STP_GIVEN_IMAGE || cloud->marks[i] & STP_MARK_WIDEST)
        return STP_FIT_WIDEST;
    return cloud->marks[i] & STP_MARK_WIDE ? STP_FIT_WIDE : STP_FIT_NEAREST;
}

static uint8_t flags_of(const stp_cloud *cloud, uint64_t i)
{
    bool oriented = cloud->marks[i] & STP_MARK_ORIENTED;
    return (uint8_t)((stp_has_normal(&cloud->points[i]) ? STP_SAMPLE_HAS_NORMAL : 0) |
                     (oriented ? STP_SAMPLE_ORIENTED : 0) |
                     (cloud->marks[i] & STP_MARK_OUTLIER ? STP_SAMPLE_OUTLIER : 0) |
                     (cloud->marks[i] & STP_MARK_CLOSED ? STP_SAMPLE_CLOSED : 0) |
                     (unsigned)fit_of(cloud, i) << STP_SAMPLE_FIT_SHIFT);
}

/* How far off a position may be stored: 1/32 of the spacing, or the precision, unless the input has
 * steps of its own, coarser than the lattice: then positions stay what they are. */
static double loose_of(const stp_point_facts *facts, int exponent, const stp_resolution *r)
{
    const double most = facts->spacing / STP_SPACING_PARTS;
    if (r->exact || r->step > ldexp(1.0, exponent))
        return 0.0;
    return r->precision > 0.0 ? stp_min(most, r->precision) : most;
}

void stp_point_item_set(stp_item *out, const stp_point_facts *facts, int exponent,
                        const stp_point_item_params *params)
{
    const double spacing = stp_point_spacing_on(facts->spacing, exponent, params);
    const double full = params->lambda * spacing;
    const double radius =
        facts->measured ? stp_radius_on_grid(full, 0.0, STP_RADII_BY_OCTAVE) : full;
    memset(out, 0, sizeof *out);
    out->disc.centre = facts->position;
    out->disc.normal = stp_dvec3_from_float(facts->normal);
    out->disc.radius = out->disc.reach = out->disc.bound = radius;
    for (int c = 0; c < 3; c++)
        out->disc.rgb[c] = (double)facts->rgb[c] / 257.0;
    out->area = spacing * spacing;
    out->loose = facts->measured ? loose_of(facts, exponent, &params->resolution) : 0.0;
    out->exponent = exponent;
    out->sheet = facts->sheet;
    out->source = facts->source;
    out->intensity = facts->intensity;
    out->class_id = facts->class_id;
    out->flags = facts->flags;
    if (facts->normal_step > 0)
        stp_normal_encode_by(facts->normal, facts->normal_step, out->normal);
    else
        memcpy(out->normal, facts->normal_code, sizeof out->normal);
}

static void set_item(stp_item *out, const stp_cloud *cloud, uint64_t i, double spacing,
                     bool measured, int exponent, const stp_point_item_params *params)
{
    const stp_cloud_point *point = &cloud->points[i];
    const stp_point_facts facts = {
        .position = point->position,
        .normal = stp_cloud_normal(cloud, i),
        .normal_step = point->given == STP_GIVEN_INPUT ? stp_normal_bits_step(params->given_bits)
                                                       : params->normal_step,
        .spacing = spacing,
        .measured = measured,
        .rgb = {point->rgb[0], point->rgb[1], point->rgb[2]},
        .sheet = cloud->sheets[i],
        .source = point->source,
        .intensity = stp_point_intensity(point->intensity, params->intensity_max),
        .class_id = point->class_id,
        .flags = flags_of(cloud, i)};
    stp_point_item_set(out, &facts, exponent, params);
}

stp_item stp_point_item_of(const stp_cloud *cloud, uint64_t i, double spacing,
                           const stp_point_item_params *params)
{
    stp_item item;
    set_item(&item, cloud, i, spacing, false,
             stp_point_exponent(cloud->points[i].position, spacing, params), params);
    return item;
}

void stp_point_item_make(stp_item *out, const stp_cloud *cloud, uint64_t i, int exponent,
                         const stp_point_item_params *params)
{
    set_item(out, cloud, i, (double)cloud->points[i].spacing, true, exponent, params);
}

void stp_point_items_make(stp_item *items, const stp_cloud *cloud, uint64_t begin, uint64_t end,
                          const stp_point_item_params *params)
{
    const stp_dbox box = stp_points_box(cloud->points + begin, end - begin);
    const int finest = stp_point_finest(stp_dbox_side(&box));
    for (uint64_t i = begin; i < end; i++) {
        const stp_cloud_point *p = &cloud->points[i];
        const int exponent = stp_point_exponent(p->position, (double)p->spacing, params);
        stp_point_item_make(&items[i - begin], cloud, i,
                            stp_point_exponent_lifted(p->position, exponent, finest), params);
    }
}
