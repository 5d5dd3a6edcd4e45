/* Builds one patch: quantised samples, merged levels and their errors. */
#include "preprocess/patch/patch_build.h"

#include "formats/chunk/measure/surroundings.h"
#include "formats/chunk/sample/normal_grid.h"
#include "formats/chunk/sample/sublattice.h"
#include "preprocess/patch/left_out.h"
#include "preprocess/patch/level_error.h"
#include "preprocess/patch/merged_radius.h"
#include "preprocess/patch/partition.h"

#include <string.h>

typedef struct builder {
    const stp_item *items;
    const uint32_t *order;
    unsigned count;
    const stp_patch_ground *ground;
    unsigned sublattice; /* of level 0 */
    double most_area;    /* limit for the sum of areas, however many items lie at one place */
    stp_patch *patch;
    stp_patch_samples *samples;
    /* by level: decoded discs and their areas */
    stp_disc discs[STP_LEVEL_COUNT][STP_PATCH_SAMPLES];
    double areas[STP_LEVEL_COUNT][STP_PATCH_SAMPLES];
    stp_dvec3 places[STP_LEVEL_COUNT][STP_PATCH_SAMPLES]; /* centres before they are quantised */
    stp_merge_error total;                                /* of the patch vertex */
    double noise;                      /* of a grid's heights: merged samples are moved by less */
    double spreads[STP_PATCH_SAMPLES]; /* of the items */
    bool beside_holes;                 /* some merged disc is limited by them */
    double radius;                     /* of the last disc that was stored; less than 0: none */
    uint8_t radius_code;
} builder;

/* Converts to multiples of a power of two, and from these to the patch's steps. */
typedef struct spacing {
    double inverse, ratio;
} spacing;

static spacing spacing_of(const builder *b, int exponent)
{
    return (spacing){ldexp(1.0, -exponent), ldexp(1.0, exponent - b->patch->exponent)};
}

static int32_t lattice_floor(double value, double step)
{
    return (int32_t)floor(value / step);
}

/* Chooses step and origin so that positions of all items, and of merges on the vertex's coarser
 * lattice, fit in 16 bits. */
static bool place(builder *b, int vertex_exponent)
{
    stp_dbox box = stp_dbox_empty();
    int exponent = vertex_exponent;
    double loose = INFINITY;
    for (unsigned i = 0; i < b->count; i++) {
        const stp_item *item = &b->items[b->order[i]];
        exponent = item->exponent < exponent ? item->exponent : exponent;
        loose = stp_min(loose, item->loose);
        stp_dbox_add(&box, stp_dvec3_sub(item->disc.centre, b->ground->origin));
    }
    double step = ldexp(1.0, exponent);
    b->sublattice = b->ground->copied ? 0 : stp_sublattice_within(loose / step);
    double margin = ldexp(1.0, vertex_exponent);
    /* Merged samples are moved along the heights if the lattice reaches as far. */
    b->noise = b->ground->grid ? b->ground->grid->noise : 0.0;
    if (stp_dbox_side(&box) + 2.0 * (b->noise + margin) > STP_POSITION_STEPS * step)
        b->noise = 0.0;
    margin = stp_max(margin, b->noise);
    if (b->sublattice > 0) /* samples may go farther off */
        margin += stp_sublattice_reach(b->sublattice) * step;
    double low[3] = {box.min.x - margin, box.min.y - margin, box.min.z - margin};
    double high[3] = {box.max.x + margin, box.max.y + margin, box.max.z + margin};
    b->patch->exponent = (int16_t)exponent;
    for (int axis = 0; axis < 3; axis++) {
        if (high[axis] - low[axis] > STP_POSITION_STEPS * step)
            return false;
        if (fabs(low[axis]) > STP_ORIGIN_STEPS * step || fabs(high[axis]) > STP_ORIGIN_STEPS * step)
            return false;
        b->patch->origin[axis] = lattice_floor(low[axis], step);
    }
    return true;
}

/* The nearest of `steps` + k * ratio, k a whole number, that 16 bits hold. A place on the mean ray
 * of pixels of a depth image may lie outside the box of their samples. Yet it stays on its lattice,
 * which the chunk above counts on. */
static double in_range(double steps, double ratio)
{
    const double most = UINT16_MAX;
    if (steps < 0.0)
        return steps + ceil(-steps / ratio) * ratio;
    return steps > most ? steps - ceil((steps - most) / ratio) * ratio : steps;
}

/* Writes a position (relative to the chunk's origin) rounded to multiples of 2^lattice. */
static void encode_position(const builder *b, stp_dvec3 p, spacing on, stp_sample *out)
{
    double v[3] = {p.x, p.y, p.z};
    for (int axis = 0; axis < 3; axis++) {
        const double steps =
            stp_nearest_whole(v[axis] * on.inverse) * on.ratio - (double)b->patch->origin[axis];
        out->position[axis] = (uint16_t)in_range(steps, on.ratio);
    }
}

static uint8_t byte(double value)
{
    return (uint8_t)lrint(stp_max(0.0, stp_min(255.0, value)));
}

/* Quantises a disc into the sample. Many have the radius of the one before. */
static void encode(builder *b, const stp_disc *disc, spacing on, stp_sample *out)
{
    encode_position(b, disc->centre, on, out);
    if (disc->radius != b->radius) {
        b->radius = disc->radius;
        b->radius_code = stp_radius_encode(disc->radius, b->patch->exponent);
    }
    out->radius = b->radius_code;
    for (int i = 0; i < 3; i++)
        out->rgb[i] = byte(disc->rgb[i]);
}

/* Updates a disc to what its sample decodes to. Everything after sees the decoded disc. */
static void take_decoded(stp_disc *disc, const stp_flat_disc *decoded, const stp_sample *sample)
{
    disc->centre = decoded->centre;
    disc->normal = decoded->normal;
    disc->radius = decoded->radius;
    for (int i = 0; i < 3; i++)
        disc->rgb[i] = sample->rgb[i];
    disc->reach = stp_max(disc->reach, decoded->radius);
    disc->bound = stp_max(disc->bound, decoded->radius);
}

/* Bits of the grid of a level's normals. A merged sample is twice as wide as those it is merged
 * from, and the noise of four normals in their mean is half that of one: both ask for a bit more.
 * Codecs tell the last child by its parent, four times as wrong as the parent is, so one more bit
 * of the parent saves more than it takes. Normals of squares follow from heights; for those of
 * merged samples, which do so only nearly, steps of 0.3 degrees will do, on maps also wider ones.
 */
static unsigned level_bits(const builder *b, int level)
{
    const bool square = b->ground->grid || b->ground->even;
    const unsigned bits = b->ground->normal_bits + (unsigned)level + (square ? 0 : 1);
    const unsigned most = b->ground->grid   ? b->ground->grid->merged_bits
                          : b->ground->even ? STP_MERGED_SQUARE_BITS
                                            : STP_NORMAL_BITS;
    return bits < most ? bits : most;
}

/* Quantises a merged disc into a sample and reads it back. `like` holds the sample's other fields.
 */
static void store(builder *b, int level, unsigned index, const stp_disc *disc, spacing on,
                  stp_sample like)
{
    stp_sample *out = &b->samples->level[level][index];
    *out = like;
    encode(b, disc, on, out);
    if (stp_sample_kind_of(&like) == STP_KIND_SURFACE)
        stp_normal_encode_on(stp_dvec3_to_float(disc->normal), level_bits(b, level), out->normal);
    if (b->ground->even)
        stp_normal_code_side(out->normal, level_bits(b, level));
    stp_flat_disc decoded = stp_flat_disc_from_sample(out, b->patch);
    b->discs[level][index] = *disc;
    take_decoded(&b->discs[level][index], &decoded, out);
}

static bool is_copied(const stp_disc *disc, const stp_flat_disc *decoded)
{
    return stp_dvec3_equal(disc->centre, decoded->centre) && disc->radius == decoded->radius;
}

/* Moves a sample of level 0 to the nearest place on the patch's sublattice. */
static void encode_on_sublattice(const builder *b, stp_dvec3 p, stp_sample *out)
{
    const double inverse = ldexp(1.0, -b->patch->exponent);
    const double place[3] = {p.x * inverse, p.y * inverse, p.z * inverse};
    double nearest[3];
    stp_sublattice_nearest(b->sublattice, place, nearest);
    for (int axis = 0; axis < 3; axis++)
        out->position[axis] = (uint16_t)(nearest[axis] - (double)b->patch->origin[axis]);
}

/* Stores level 0. False if an item that must be copied would read back differently. */
static bool store_items(builder *b)
{
    const spacing on = spacing_of(b, b->patch->exponent);
    stp_sample *samples = b->samples->level[0];
    stp_sample_lanes lanes;
    for (unsigned i = 0; i < b->count; i++) {
        const stp_item *item = &b->items[b->order[i]];
        stp_disc *disc = &b->discs[0][i];
        *disc = item->disc;
        disc->centre = stp_dvec3_sub(disc->centre, b->ground->origin);
        b->places[0][i] = disc->centre;
        samples[i] = (stp_sample){.normal = {item->normal[0], item->normal[1], item->normal[2]},
                                  .flags = item->flags,
                                  .intensity = item->intensity,
                                  .class_id = item->class_id};
        encode(b, disc, on, &samples[i]);
        if (b->sublattice > 0)
            encode_on_sublattice(b, disc->centre, &samples[i]);
        b->areas[0][i] = item->area;
        b->spreads[i] = item->spread;
    }
    stp_samples_decode(samples, b->count, b->patch, &lanes);
    for (unsigned i = 0; i < b->count; i++) {
        const stp_flat_disc decoded = stp_flat_disc_from_lanes(&lanes, i);
        if (b->ground->copied && !is_copied(&b->discs[0][i], &decoded))
            return false;
        take_decoded(&b->discs[0][i], &decoded, &samples[i]);
    }
    b->patch->counts[0] = (uint8_t)b->count;
    return true;
}

/* Area-weighted mean of the finer samples [begin, end). A weight is r^2 in steps; if all radii are
 * 0, or the ground says so, weights are equal. A sample of a line keeps its kind and its tangent in
 * place of a normal as long as it is alone; merged, it is surface. */
static stp_disc merge(const builder *b, int level, unsigned begin, unsigned end, stp_sample *like,
                      double *area)
{
    const stp_disc *finer = b->discs[level - 1];
    const stp_sample *samples = b->samples->level[level - 1];
    stp_disc out = {0};
    double sum = 0.0, intensity = 0.0, largest = -1.0;
    const double inverse = ldexp(1.0, -b->patch->exponent);
    stp_dvec3 lead = {0.0, 0.0, 0.0};
    unsigned fit = STP_FIT_GIVEN, flags = STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL |
                                          STP_SAMPLE_OUTLIER | STP_SAMPLE_CLOSED;
    *area = 0.0;
    for (unsigned i = begin; i < end; i++) {
        double steps = finer[i].radius * inverse, weight = steps > 0.0 ? steps * steps : 1e-30;
        weight = b->ground->even ? 1.0 : weight;
        bool against =
            !(samples[i].flags & STP_SAMPLE_ORIENTED) && stp_dvec3_dot(finer[i].normal, lead) < 0.0;
        out.centre = stp_dvec3_add(out.centre, stp_dvec3_scale(finer[i].centre, weight));
        out.normal =
            stp_dvec3_add(out.normal, stp_dvec3_scale(finer[i].normal, against ? -weight : weight));
        for (int c = 0; c < 3; c++)
            out.rgb[c] += weight * finer[i].rgb[c];
        intensity += weight * samples[i].intensity;
        flags &= samples[i].flags;
        fit = stp_sample_fit_least(&samples[i], fit);
        sum += weight;
        *area += b->areas[level - 1][i];
        if (i == begin)
            lead = finer[i].normal;
        if (weight > largest) {
            largest = weight;
            like->class_id = samples[i].class_id;
        }
    }
    *area = stp_min(*area, b->most_area);
    out.centre = stp_dvec3_scale(out.centre, 1.0 / sum);
    out.normal = stp_dvec3_normalize(out.normal);
    for (int c = 0; c < 3; c++)
        out.rgb[c] /= sum;
    if (out.normal.x == 0.0 && out.normal.y == 0.0 && out.normal.z == 0.0)
        flags &= ~(unsigned)STP_SAMPLE_HAS_NORMAL;
    like->intensity = byte(intensity / sum);
    like->flags = (uint8_t)(flags | fit << STP_SAMPLE_FIT_SHIFT);
    if (end - begin == 1 && stp_sample_kind_of(&samples[begin]) != STP_KIND_SURFACE) {
        like->flags = samples[begin].flags;
        memcpy(like->normal, samples[begin].normal, sizeof like->normal);
    }
    return out;
}

/* The step that heights of merged samples are multiples of: their noise, which is half that of the
 * finer ones, hides it. */
static double height_step(const builder *b, int level, int lattice)
{
    const double noise = ldexp(b->noise, -level);
    const bool fine = level == STP_LEVEL_COUNT - 1 || !(noise > 0.0);
    return ldexp(1.0, fine || stp_floor_log2(noise) < lattice ? lattice : stp_floor_log2(noise));
}

static double height_of(stp_dvec3 along, stp_dvec3 p)
{
    return along.x == 1.0 ? p.x : along.y == 1.0 ? p.y : p.z;
}

/* The place at the mean depth on the mean of the finer samples' rays. *ray: that, by a unit of
 * depth. */
static stp_dvec3 amid_rays(const builder *b, int level, unsigned begin, unsigned end,
                           stp_dvec3 *ray)
{
    const stp_patch_grid *grid = b->ground->grid;
    const stp_dvec3 from = stp_dvec3_sub(grid->station, b->ground->origin);
    const double share = 1.0 / (end - begin);
    double depth = 0.0;
    *ray = (stp_dvec3){0.0, 0.0, 0.0};
    for (unsigned i = begin; i < end; i++) {
        const stp_dvec3 seen = stp_dvec3_sub(b->places[level - 1][i], from);
        const double own = height_of(grid->along, seen);
        depth += share * own;
        *ray = stp_dvec3_add(*ray, stp_dvec3_scale(seen, share / own));
    }
    return stp_dvec3_add(from, stp_dvec3_scale(*ray, depth));
}

/* Where the codec expects a merged sample of a grid: amid the finer samples' places, along whose
 * ray or axis its height is moved to a multiple of the step. centre: amid the finer samples. */
static stp_dvec3 place_on_grid(const builder *b, int level, unsigned begin, unsigned end,
                               stp_dvec3 centre, double step)
{
    const stp_patch_grid *grid = b->ground->grid;
    stp_dvec3 mean = {0.0, 0.0, 0.0}, along = grid->along;
    if (grid->level)
        mean = centre;
    else if (grid->spreads)
        mean = amid_rays(b, level, begin, end, &along);
    else
        for (unsigned i = begin; i < end; i++)
            mean =
                stp_dvec3_add(mean, stp_dvec3_scale(b->places[level - 1][i], 1.0 / (end - begin)));
    const double height = height_of(grid->along, mean);
    const double rounded = stp_nearest_whole(height / step) * step;
    return stp_dvec3_add(mean, stp_dvec3_scale(along, rounded - height));
}

/* Of a map: the radius of a merged disc whose cell is full, by the steepness of its normal. The
 * codec expects it. */
static double full_radius(const builder *b, const stp_disc *merged, int level)
{
    const stp_patch_grid *grid = b->ground->grid;
    const double cosine = stp_dvec3_dot(merged->normal, stp_dvec3_normalize(grid->along));
    return STP_MERGED_LAMBDA * ldexp(grid->spacing, level) * sqrt(stp_stretch(cosine));
}

/* A radius that covers the centres of the finer samples and the disc's own share of the surface. It
 * is at least a step of its lattice, so that it has a code in the chunk above, too. */
static double merged_radius(const builder *b, const stp_disc *merged, int level, unsigned begin,
                            unsigned end, double area, int lattice)
{
    const stp_disc *finer = b->discs[level - 1];
    const bool alone = end - begin == 1; /* the sample itself, unmerged */
    double reach = 0.0;
    for (unsigned i = begin; i < end && !alone; i++)
        reach = stp_max(reach, stp_dvec3_length(stp_dvec3_sub(finer[i].centre, merged->centre)));
    double radius = alone ? finer[begin].radius
                          : stp_max(reach, stp_wanted_radius(b->ground->regular, area, reach));
    if (b->ground->grid && b->ground->grid->spacing > 0.0 && !alone && radius > 0.0)
        radius = stp_radius_on_map(radius, full_radius(b, merged, level), reach);
    const bool spreads = b->ground->grid && b->ground->grid->spreads;
    if (spreads && !b->ground->holes)
        radius = stp_radius_on_image(radius, reach, alone);
    else if ((!b->ground->even || spreads || b->ground->regular) && !alone)
        radius = stp_radius_on_grid(radius, reach, STP_RADII_BY_OCTAVE);
    return radius > 0.0 ? stp_max(radius, ldexp(1.0, lattice)) : 0.0;
}

/* The greatest radius with a code that is no greater. */
static double radius_below(const builder *b, double radius)
{
    uint8_t code = stp_radius_encode(radius, b->patch->exponent);
    while (code > 0 && stp_radius_decode(code, b->patch->exponent) > radius)
        code--;
    return stp_radius_decode(code, b->patch->exponent);
}

/* Limits a merged disc to where the grid has samples. */
static void limit_to_samples(builder *b, int level, unsigned begin, unsigned end, int lattice,
                             stp_disc *disc)
{
    const stp_holes *holes = b->ground->holes;
    const uint32_t sheet = b->items[b->order[0]].sheet & ~STP_SHEET_APART;
    if (!holes || !stp_holes_limit(&holes[sheet], b->ground->origin, &b->discs[level - 1][begin],
                                   end - begin, ldexp(1.0, lattice), disc))
        return;
    b->beside_holes = true;
    disc->radius = radius_below(b, disc->radius);
}

/* Merges the samples [from, to) of a level from the finer level. */
static void merge_level(builder *b, int level, unsigned from, unsigned to, int lattice)
{
    unsigned finer_count = b->patch->counts[level - 1];
    unsigned count = b->patch->counts[level];
    const spacing on = spacing_of(b, lattice);
    const double step = b->ground->grid ? height_step(b, level, lattice) : 0.0;
    for (unsigned j = from; j < to; j++) {
        unsigned begin = stp_level_children_begin(j, count, finer_count);
        unsigned end = stp_level_children_begin(j + 1, count, finer_count);
        stp_sample like = {0};
        double area = 0.0;
        stp_disc disc = merge(b, level, begin, end, &like, &area);
        if (b->ground->grid)
            disc.centre = place_on_grid(b, level, begin, end, disc.centre, step);
        if (b->ground->grid && level <= 2 && b->ground->grid->merged_counts[level - 1] == count)
            disc.normal = b->ground->grid->merged[level - 1][j];
        disc.radius = merged_radius(b, &disc, level, begin, end, area, lattice);
        limit_to_samples(b, level, begin, end, lattice, &disc);
        b->places[level][j] = disc.centre;
        store(b, level, j, &disc, on, like);
        b->areas[level][j] = area;
    }
}

/* Sets the cone of normals, and the bounding sphere of every disc and what it stands for. Its
 * centre is the patch vertex, so that one place serves for both. False if the sphere is too large
 * for the patch's lattice. */
static bool bound(builder *b)
{
    stp_patch *patch = b->patch;
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    unsigned common = UINT8_MAX; /* flags that all samples have */
    for (unsigned i = 0; i < b->count; i++) {
        sum = stp_dvec3_add(sum, b->discs[0][i].normal);
        common &= b->samples->level[0][i].flags;
    }
    if (~common & (STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL))
        patch->flags |= STP_PATCH_TWO_SIDED;
    if (common & STP_SAMPLE_CLOSED)
        patch->flags |= STP_PATCH_CLOSED;
    const stp_sample *vertex = &b->samples->level[STP_LEVEL_COUNT - 1][0];
    if (vertex->flags & STP_SAMPLE_HAS_NORMAL)
        memcpy(patch->cone_axis, vertex->normal, sizeof patch->cone_axis);
    else
        stp_normal_encode(stp_dvec3_to_float(stp_dvec3_normalize(sum)), patch->cone_axis);
    stp_dvec3 axis = stp_dvec3_from_float(stp_normal_decode(patch->cone_axis));
    double angle = 0.0;
    double least_cosine = 1.0; /* of normals of discs without a cone */
    unsigned count = b->count;
    for (int level = 0; level < STP_LEVEL_COUNT; level++, count = stp_level_count_above(count)) {
        for (unsigned i = 0; i < count; i++) {
            const stp_disc *d = &b->discs[level][i];
            bool known = d->normal.x != 0.0 || d->normal.y != 0.0 || d->normal.z != 0.0;
            double cosine = known ? stp_dvec3_dot(d->normal, axis) : -1.0;
            if (level == 0 && d->cone > 0.0)
                angle = stp_max(angle, acos(stp_max(-1.0, stp_min(1.0, cosine))) + d->cone);
            else
                least_cosine = stp_min(least_cosine, cosine);
        }
    }
    angle = stp_max(angle, acos(stp_max(-1.0, least_cosine)));
    patch->cone_angle = stp_cone_angle_encode(angle + 1e-6);
    memcpy(patch->bound_centre, vertex->position, sizeof patch->bound_centre);
    const stp_dvec3 c = stp_sample_position(vertex, patch);
    double radius = 0.0;
    for (int level = 0; level < STP_LEVEL_COUNT; level++) {
        for (unsigned i = 0; i < patch->counts[level]; i++) {
            const stp_disc *d = &b->discs[level][i];
            radius = stp_max(radius, stp_dvec3_length(stp_dvec3_sub(d->centre, c)) + d->bound);
            patch->radius[level] = b->samples->level[level][i].radius > patch->radius[level]
                                       ? b->samples->level[level][i].radius
                                       : patch->radius[level];
        }
    }
    patch->bound_radius = stp_radius_encode(radius, patch->exponent);
    return stp_radius_decode(patch->bound_radius, patch->exponent) * (1.0 + 1e-9) >= radius;
}

/* Returns the lattice of the patch vertex. Also sets most_area: items that pile up in one place
 * cover no more than their extent. */
static int choose_vertex_lattice(builder *b)
{
    double area = 0.0, wide = 0.0, greatest = 0.0;
    int lattice = STP_LATTICE_MAX;
    stp_dbox box = stp_dbox_empty();
    /* cppcheck-suppress ctuuninitvar ; what is not set yet is not read here */
    for (unsigned i = 0; i < b->count; i++) {
        const stp_item *item = &b->items[b->order[i]];
        area += item->area;
        greatest = stp_max(greatest, item->area);
        wide = stp_max(wide, item->disc.bound);
        lattice = item->exponent < lattice ? item->exponent : lattice;
        stp_dbox_add(&box, item->disc.centre);
    }
    const double diagonal = stp_dvec3_length(stp_dvec3_sub(box.max, box.min));
    const double side = diagonal + 2.0 * sqrt(greatest);
    b->most_area = side * side;
    lattice = stp_vertex_exponent(stp_min(area, b->most_area), diagonal + 2.0 * wide, lattice);
    return lattice > b->ground->vertex_least ? lattice : b->ground->vertex_least;
}

static void fill_vertex(const builder *b, int lattice, stp_item *vertex)
{
    const stp_sample *sample = &b->samples->level[STP_LEVEL_COUNT - 1][0];
    stp_disc disc = b->discs[STP_LEVEL_COUNT - 1][0];
    const stp_patch *patch = b->patch;
    disc.centre = stp_dvec3_add(disc.centre, b->ground->origin);
    disc.low = stp_min(0.0, b->total.low); /* the disc itself is drawn, too */
    disc.high = stp_max(0.0, b->total.high);
    disc.reach = stp_max(disc.radius, b->total.reach);
    disc.bound = stp_max(disc.radius, b->total.bound);
    disc.cone = b->total.cone;
    disc.error = stp_error_decode(patch->error[STP_LEVEL_COUNT - 1], patch->exponent);
    disc.colour_error = patch->colour_error[STP_LEVEL_COUNT - 1];
    *vertex = (stp_item){.disc = disc,
                         .spread = stp_left_out_spread(&b->discs[STP_LEVEL_COUNT - 1][0],
                                                       b->discs[0], b->spreads, b->count),
                         .area = b->areas[STP_LEVEL_COUNT - 1][0],
                         .exponent = lattice,
                         .sheet = b->ground->holes ? b->items[b->order[0]].sheet : 0,
                         .intensity = sample->intensity,
                         .class_id = sample->class_id,
                         .flags = sample->flags,
                         .normal = {sample->normal[0], sample->normal[1], sample->normal[2]}};
}

/* Worst error of level-0 samples [begin, end): what items carry (inner chunks), or the quantisation
 * error (points). */
static double item_error(const builder *b, unsigned begin, unsigned end)
{
    double worst = ldexp(stp_sublattice_reach(b->sublattice), b->patch->exponent);
    for (unsigned i = begin; i < end; i++)
        worst = stp_max(worst, b->discs[0][i].error);
    return worst;
}

static uint8_t error_code(const builder *b, int level, double error)
{
    const bool rough = level > 0 && b->ground->grid && b->ground->grid->spreads;
    const uint8_t code = stp_error_encode(error, b->patch->exponent);
    return rough ? stp_rough_error(code) : code;
}

/* Stores how much colour each level averages away; never less than at a finer level. */
static void store_variations(const builder *b)
{
    double greatest = 0.0;
    for (int level = 0; level < STP_LEVEL_COUNT; level++) {
        double variation =
            stp_colour_variation(b->discs[level], b->discs[0], b->patch->counts, level);
        greatest = stp_max(greatest, variation);
        b->patch->colour_error[level] = byte(ceil(greatest));
    }
}

/* Merges levels 1 and 2 quarter by quarter, then level 3. No error is less than a finer level's. */
static void merge_levels(builder *b, int vertex_lattice)
{
    stp_patch *patch = b->patch;
    const uint8_t *counts = patch->counts;
    double worst[3] = {0.0};
    for (int level = 1; level < STP_LEVEL_COUNT; level++)
        patch->counts[level] = (uint8_t)stp_level_count_above(patch->counts[level - 1]);
    for (unsigned q = 0; q < counts[2]; q++) {
        double e =
            item_error(b, stp_quarter_begin(counts, 0, q), stp_quarter_begin(counts, 0, q + 1));
        worst[0] = stp_max(worst[0], e);
        for (int level = 1; level <= 2; level++) {
            unsigned from = stp_quarter_begin(counts, level, q);
            unsigned to = stp_quarter_begin(counts, level, q + 1);
            merge_level(b, level, from, to, patch->exponent);
            const stp_level_discs discs = {b->discs[0], b->discs[level], counts, level};
            e = stp_level_error(&discs, from, to, patch->exponent, e);
            patch->quarter_error[level - 1][q] = error_code(b, level, e);
            worst[level] = stp_max(worst[level], e);
        }
    }
    for (int level = 0; level <= 2; level++)
        patch->error[level] = error_code(b, level, worst[level]);
    merge_level(b, 3, 0, 1, vertex_lattice);
    b->total = stp_merge_measure(b->discs[3], b->discs[0], counts[0]);
    patch->error[3] = error_code(b, 3, stp_max(worst[2], b->total.error));
    store_variations(b);
    if (b->beside_holes)
        stp_left_out_store(patch, (const stp_disc(*)[STP_PATCH_SAMPLES])b->discs, b->spreads);
}

bool stp_patch_build(const stp_item *items, const uint32_t *order, unsigned count,
                     const stp_patch_ground *ground, stp_patch *patch, stp_patch_samples *samples,
                     stp_item *vertex)
{
    builder b; /* not initialised: only discs that are built are read */
    b.items = items;
    b.order = order;
    b.count = count;
    b.ground = ground;
    b.patch = patch;
    b.samples = samples;
    b.beside_holes = false;
    b.radius = -1.0;
    b.radius_code = 0;
    int vertex_lattice = choose_vertex_lattice(&b);
    *patch = (stp_patch){.child = STP_PATCH_NO_CHILD};
    if (!place(&b, vertex_lattice) || !store_items(&b))
        return false;
    merge_levels(&b, vertex_lattice);
    if (!bound(&b) && count > 1)
        return false;
    fill_vertex(&b, vertex_lattice, vertex);
    return true;
}
