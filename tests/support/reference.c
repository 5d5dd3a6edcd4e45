/* Implements the reconstruction on the CPU; every function is one section of shaders/README.md. */
#include "tests/support/reference_parts.h"

#include "base/memory.h"
#include "formats/chunk/sample/sample.h"

#include <math.h>
#include <stdlib.h>

/* The least minor semi-axis at an outline. */
#define OUTLINE_FLOOR_PX 0.6
/* A nearer ellipse hides a measured pixel up to this q. */
#define HIDES_Q 0.75
/* Push looks so many coarse pixels further for what pull left out, if a disc is so wide. */
#define FURTHER 4
#define WIDE 2.0
/* How far an ellipse reaches into a gap. */
#define GAP_Q_3 2.0
#define GAP_Q_4 4.0
#define TEMPLATE_GAP_Q_3 3.0
#define TEMPLATE_GAP_Q_4 6.0
/* Ellipses whose centres are at most this far apart belong to one disc. */
#define SAME_PX 0.1

/* ---- spaces ---- */

stp_dvec3 reference_turn_to_eye(const stp_view *view, stp_dvec3 d)
{
    return (stp_dvec3){stp_dvec3_dot(view->right, d), stp_dvec3_dot(view->up, d),
                       stp_dvec3_dot(view->back, d)};
}

stp_dvec3 reference_to_eye(const stp_view *view, stp_dvec3 p)
{
    return reference_turn_to_eye(view, stp_dvec3_sub(p, view->eye));
}

static double centre_of(int i, int level)
{
    return (i + 0.5) * (double)(1 << level);
}

int reference_level_count(double radius_px, int width, int height)
{
    int most = 0;
    while ((1 << most) < width || (1 << most) < height)
        most++;
    if (!(radius_px > 0.0))
        return 0;
    double wanted = ceil(log2(6.0 * radius_px));
    return wanted <= 0.0 ? 0 : wanted < most ? (int)wanted : most;
}

/* ---- the pyramid ---- */

stp_status reference_create(reference_pyramid *out, const stp_view *view, reference_filter filter,
                            int level_count, stp_error *err)
{
    stp_status status = STP_OK;
    reference_pyramid p = {.view = *view, .filter = filter, .level_count = level_count};
    if (level_count < 0 || level_count > REFERENCE_LEVELS_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%d levels of a pyramid", level_count);
    for (int l = 0; l <= level_count; l++) {
        reference_level *level = &p.levels[l];
        level->width = (view->width + (1 << l) - 1) >> l;
        level->height = (view->height + (1 << l) - 1) >> l;
        size_t count = (size_t)level->width * (size_t)level->height;
        STP_TRY(stp_alloc(&level->pulled, count, sizeof *level->pulled, "a pyramid", err));
        STP_TRY(stp_alloc(&level->finished, count, sizeof *level->finished, "a pyramid", err));
    }
    *out = p;
    p = (reference_pyramid){0};
done:
    reference_destroy(&p);
    return status;
}

void reference_destroy(reference_pyramid *pyramid)
{
    for (int l = 0; l <= REFERENCE_LEVELS_LIMIT; l++) {
        free(pyramid->levels[l].pulled);
        free(pyramid->levels[l].finished);
    }
    *pyramid = (reference_pyramid){0};
}

/* ---- the tag ---- */

static int tag_with_source(int tag, int source)
{
    return 1 + ((tag - 1) & 15) + 16 * source;
}

/* ---- the ellipse ---- */

/* Whether an ellipse is too wide for a template's windows of this level. */
static bool carries(const reference_pyramid *pyramid, const reference_pixel *p, int level)
{
    return 2.0 * reference_radius_px(pyramid, p) > ((int)pyramid->filter - 1) * exp2(level);
}

/* ---- merging pixels that meet ---- */

/* Four pixels, 9 x 9, or 7 x 7 of each level. */
#define MEETING_LIMIT (81 * (REFERENCE_LEVELS_LIMIT + 1))

/* Pixels that may reach one place; (dx, dy) leads from the place to the centres of their
 * ellipses. */
typedef struct meeting {
    reference_pixel pixels[MEETING_LIMIT];
    double weights[MEETING_LIMIT], q[MEETING_LIMIT];
    int count;
} meeting;

/* Adds pixel (i, j) of a level to what meets at window (u, v), if it exists and is valid. */
static void meet(const reference_pyramid *pyramid, const reference_pixel *pixels, int level, int i,
                 int j, double u, double v, double weight, meeting *m)
{
    const reference_level *size = &pyramid->levels[level];
    if (i < 0 || j < 0 || i >= size->width || j >= size->height)
        return;
    reference_pixel p = pixels[j * size->width + i];
    if (p.tag == 0)
        return;
    double cx = centre_of(i, level) + p.dx, cy = centre_of(j, level) + p.dy;
    p.dx = cx - u;
    p.dy = cy - v;
    m->q[m->count] = reference_ellipse(pyramid, &p, cx, cy, u - cx, v - cy);
    m->weights[m->count] = weight;
    m->pixels[m->count++] = p;
}

/* Computes q again for what meets at window (u, v), with ellipses of a minor semi-axis of at least
 * least_px. */
static void meet_again(const reference_pyramid *pyramid, double u, double v, double least_px,
                       meeting *m)
{
    for (int k = 0; k < m->count; k++) {
        const reference_pixel *p = &m->pixels[k];
        m->q[k] =
            reference_ellipse_least(pyramid, p, u + p->dx, v + p->dy, -p->dx, -p->dy, least_px);
    }
}

/* Keeps the pixels whose ellipse reaches the place. */
static void keep_reaching(meeting *m, double greatest_q)
{
    int kept = 0;
    for (int i = 0; i < m->count; i++) {
        if (!(m->q[i] <= greatest_q))
            continue;
        m->pixels[kept] = m->pixels[i];
        m->weights[kept] = m->weights[i];
        m->q[kept++] = m->q[i];
    }
    m->count = kept;
}

/* The pixel with the least z_min, the first among equals, or NULL. */
static const reference_pixel *front_of(const meeting *m)
{
    const reference_pixel *front = NULL;
    for (int i = 0; i < m->count; i++)
        if (front == NULL || m->pixels[i].z_min < front->z_min)
            front = &m->pixels[i];
    return front;
}

/* Keeps the pixels whose interval meets the front's. */
static void keep_surface(meeting *m, const reference_pixel *front)
{
    int kept = 0;
    for (int i = 0; i < m->count; i++) {
        if (m->pixels[i].z_min > front->z_max)
            continue;
        m->pixels[kept] = m->pixels[i];
        m->weights[kept] = m->weights[i];
        m->q[kept++] = m->q[i];
    }
    m->count = kept;
}

reference_pixel reference_mean(const reference_pixel *pixels, const double *weights, int count,
                               const reference_pixel *front)
{
    reference_pixel sum = {.tag = front->tag};
    double total = 0.0;
    for (int i = 0; i < count; i++) {
        const reference_pixel *p = &pixels[i];
        double w = weights[i];
        bool turned = (reference_two_sided(front) || reference_two_sided(p)) &&
                      stp_dvec3_dot(p->normal, front->normal) < 0.0;
        if (reference_is_tube(p) == reference_is_tube(front))
            sum.normal = stp_dvec3_add(sum.normal, stp_dvec3_scale(p->normal, turned ? -w : w));
        sum.radius += w * p->radius;
        sum.z_min += w * (p->z_min - front->z_min);
        sum.z_max += w * (p->z_max - front->z_max);
        sum.dx += w * p->dx;
        sum.dy += w * p->dy;
        for (int k = 0; k < 3; k++)
            sum.rgb[k] += w * p->rgb[k];
        total += w;
    }
    sum.normal =
        stp_dvec3_length(sum.normal) > 0.0 ? stp_dvec3_normalize(sum.normal) : front->normal;
    sum.radius /= total;
    sum.z_min = front->z_min + sum.z_min / total;
    sum.z_max = front->z_max + sum.z_max / total;
    sum.dx /= total;
    sum.dy /= total;
    for (int k = 0; k < 3; k++)
        sum.rgb[k] /= total;
    return sum;
}

/* The weighted mean of the squared radii. */
static double square_radius(const meeting *m)
{
    double sum = 0.0, total = 0.0;
    for (int k = 0; k < m->count; k++) {
        sum += m->weights[k] * m->pixels[k].radius * m->pixels[k].radius;
        total += m->weights[k];
    }
    return sum / total;
}

/* ---- pull ---- */

/* Keeps the pixels that are carried on from a level. */
static void keep_carried(const reference_pyramid *pyramid, int level, meeting *m)
{
    int kept = 0;
    for (int i = 0; i < m->count; i++)
        if (carries(pyramid, &m->pixels[i], level)) {
            m->weights[kept] = m->weights[i];
            m->pixels[kept++] = m->pixels[i];
        }
    m->count = kept;
}

/* The radius of the disc that has the second moment of the pixels it stands for; `mean` is their
 * mean. */
static double moment_radius(const reference_pyramid *pyramid, const meeting *m,
                            const reference_pixel *mean)
{
    double ppu = reference_pixels_per_unit(&pyramid->view, mean->z_min), spread = 0.0;
    bool kept = pyramid->grid && pyramid->filter == REFERENCE_GAUSS;
    for (int k = 0; k < m->count; k++) {
        const reference_pixel *p = &m->pixels[k];
        double x = p->dx - mean->dx, y = p->dy - mean->dy;
        spread += reference_is_line(mean) || kept ? 0.0 : (x * x + y * y) / m->count;
    }
    return sqrt(square_radius(m) + 2.0 * spread / (ppu * ppu));
}

static reference_pixel pull_pixel(const reference_pyramid *pyramid, int level, int i, int j)
{
    const reference_pixel *finer = pyramid->levels[level - 1].pulled;
    double u = centre_of(i, level), v = centre_of(j, level);
    meeting m;
    m.count = 0;
    for (int k = 0; k < 4; k++)
        meet(pyramid, finer, level - 1, 2 * i + (k & 1), 2 * j + (k >> 1), u, v, 1.0, &m);
    for (int k = 0; k < m.count && pyramid->filter == REFERENCE_BOX; k++)
        m.q[k] = m.pixels[k].radius > 0.0 ? 0.0 : INFINITY; /* a box only asks for a radius */
    if (pyramid->filter >= REFERENCE_TEMPLATE3)
        keep_carried(pyramid, level - 1, &m);
    else
        keep_reaching(&m, 1.0);
    if (m.count == 0)
        return (reference_pixel){0};
    const reference_pixel front = *front_of(&m);
    keep_surface(&m, &front);
    reference_pixel out = reference_mean(m.pixels, m.weights, m.count, &front);
    out.tag = tag_with_source(front.tag, level);
    out.z_min = front.z_min;
    out.z_max = front.z_max;
    for (int k = 0; k < m.count; k++)
        out.z_max = fmax(out.z_max, m.pixels[k].z_max);
    if (pyramid->filter != REFERENCE_BOX)
        out.radius = moment_radius(pyramid, &m, &out);
    return out;
}

void reference_pull(reference_pyramid *pyramid)
{
    for (int l = 1; l <= pyramid->level_count; l++) {
        reference_level *level = &pyramid->levels[l];
        for (int j = 0; j < level->height; j++)
            for (int i = 0; i < level->width; i++)
                level->pulled[j * level->width + i] = pull_pixel(pyramid, l, i, j);
    }
}

/* ---- push ---- */

/* How large q may be. If three or four pixels of finite q, not all of one disc, lie around the
 * place and none reaches it: the q of the nearest. Otherwise: 1. */
static double push_reach(const reference_pyramid *pyramid, const meeting *m)
{
    double least = INFINITY, apart = 0.0;
    int around = 0;
    const reference_pixel *nearest = NULL;
    for (int k = 0; k < m->count; k++) {
        const reference_pixel *p = &m->pixels[k];
        nearest = m->q[k] < least ? p : nearest;
        least = fmin(least, m->q[k]);
        around += isfinite(m->q[k]) ? 1 : 0;
        apart = fmax(apart, hypot(p->dx - m->pixels[0].dx, p->dy - m->pixels[0].dy));
        if (reference_is_line(p))
            return 1.0;
    }
    if (!(apart > SAME_PX))
        return 1.0;
    double most = around == 4 ? GAP_Q_4 : around == 3 ? GAP_Q_3 : 1.0;
    most = nearest ? reference_gap(pyramid, nearest, most) : most;
    return least > 1.0 && least <= most ? least : 1.0;
}

/* Whether the place lies outside an outline: some of the four pixels are invalid, and the place
 * lies on the side to which the normals of the others point in the picture. */
static bool beyond_outline(const meeting *m)
{
    for (int k = 0; k < m->count; k++) {
        const reference_pixel *p = &m->pixels[k];
        if (reference_is_line(p) || !(p->dx * p->normal.x + p->dy * p->normal.y < 0.0))
            return false;
    }
    return m->count < 4;
}

/* Adds coarse pixel (i, j) to what meets; beyond the border the one mirrored there. */
static void meet_coarse(const reference_pyramid *pyramid, int level, int i, int j, double u,
                        double v, double weight, meeting *m)
{
    const reference_level *coarse = &pyramid->levels[level];
    i = abs(i < coarse->width ? i : 2 * coarse->width - 2 - i);
    j = abs(j < coarse->height ? j : 2 * coarse->height - 2 - j);
    meet(pyramid, coarse->finished, level, i, j, u, v, weight, m);
}

/* A pixel that none of four coarse pixels reaches: the front of those around that do. Unless all
 * four are valid, depths that meet those of the four's front do not count. */
static reference_pixel push_further(const reference_pyramid *pyramid, int level, int i, int j,
                                    const reference_pixel *own, const meeting *four)
{
    const reference_pixel near = *front_of(four);
    meeting m;
    m.count = 0;
    double u = centre_of(i, level), v = centre_of(j, level);
    for (int k = -FURTHER; k <= FURTHER; k++)
        for (int h = -FURTHER; h <= FURTHER; h++)
            meet_coarse(pyramid, level + 1, (i >> 1) + h, (j >> 1) + k, u, v, 1.0, &m);
    meet_again(pyramid, u, v, OUTLINE_FLOOR_PX, &m);
    for (int k = 0; k < m.count && four->count < 4; k++)
        if (m.pixels[k].z_min <= near.z_max && m.pixels[k].z_max >= near.z_min)
            m.q[k] = INFINITY;
    keep_reaching(&m, 1.0);
    if (m.count == 0)
        return (reference_pixel){0};
    reference_pixel out = *front_of(&m);
    if (own->tag != 0 && !(out.z_min < own->z_min))
        return (reference_pixel){0};
    out.tag = tag_with_source(out.tag, level + 1);
    return out;
}

static reference_pixel push_pixel(const reference_pyramid *pyramid, int level, int i, int j)
{
    const reference_level *coarse = &pyramid->levels[level + 1];
    const reference_level *fine = &pyramid->levels[level];
    const reference_pixel own = fine->pulled[j * fine->width + i];
    const reference_pixel *parent = &coarse->finished[(j >> 1) * coarse->width + (i >> 1)];
    bool seen = own.tag != 0 && !(parent->tag != 0 && own.z_min > parent->z_max);
    static const double weights[4] = {9.0 / 16.0, 3.0 / 16.0, 3.0 / 16.0, 1.0 / 16.0};
    int side_x = i & 1 ? 1 : -1, side_y = j & 1 ? 1 : -1;
    double u = centre_of(i, level), v = centre_of(j, level);
    meeting m;
    m.count = 0;
    bool mirrored[4] = {false};
    for (int k = 0; k < 4; k++) {
        int x = (i >> 1) + (k & 1 ? side_x : 0), y = (j >> 1) + (k & 2 ? side_y : 0);
        mirrored[m.count] = x < 0 || y < 0 || x >= coarse->width || y >= coarse->height;
        meet_coarse(pyramid, level + 1, x, y, u, v, weights[k], &m);
    }
    const meeting four = m;
    if (seen || (own.tag == 0 && beyond_outline(&m)))
        meet_again(pyramid, u, v, OUTLINE_FLOOR_PX, &m);
    double least = INFINITY, inner = INFINITY, widest = 0.0;
    for (int k = 0; k < m.count; k++)
        inner = mirrored[k] ? inner : fmin(inner, m.q[k]);
    for (int k = 0; k < m.count; k++) { /* mirrored pixels count only if no other reaches */
        m.q[k] = mirrored[k] && inner <= 1.0 ? INFINITY : m.q[k];
        least = fmin(least, m.q[k]);
        widest = fmax(widest, m.pixels[k].radius *
                                  reference_pixels_per_unit(&pyramid->view, m.pixels[k].z_min));
    }
    if (level > 0 && !seen && least > 1.0 && widest > WIDE * exp2(level + 1)) {
        const reference_pixel further = push_further(pyramid, level, i, j, &own, &four);
        if (further.tag != 0)
            return further;
    }
    keep_reaching(&m, seen ? HIDES_Q : push_reach(pyramid, &m));
    for (int k = 0; k < m.count && pyramid->filter == REFERENCE_GAUSS; k++)
        m.weights[k] *= exp(-0.5 * m.q[k]);
    if (m.count == 0)
        return own;
    const reference_pixel front = *front_of(&m);
    if (own.tag != 0 && !(front.z_max < own.z_min))
        return own;
    keep_surface(&m, &front);
    reference_pixel out = reference_mean(m.pixels, m.weights, m.count, &front);
    if (pyramid->filter != REFERENCE_BOX)
        out.radius = sqrt(square_radius(&m));
    return out;
}

/* ---- templates ---- */

/* What comes near a place that nothing covers. */
typedef struct gap {
    unsigned sides_3, sides_4; /* bit sets of quadrants, up to each q */
    double q;                  /* the least */
    reference_pixel nearest;
} gap;

static void miss(const reference_pixel *p, double q, gap *g)
{
    unsigned side = 1u << ((p->dx > 0.0 ? 1 : 0) + (p->dy > 0.0 ? 2 : 0));
    g->sides_3 |= q <= TEMPLATE_GAP_Q_3 ? side : 0;
    g->sides_4 |= side;
    if (q < g->q) {
        g->q = q;
        g->nearest = *p;
    }
}

/* Adds the ellipse of pixel (i, j) of a level to `m` if it covers window (u, v), the centre of the
 * pixel `own`, or to `g` if it comes near. Its depths become those at that place. */
static void cover(const reference_pyramid *pyramid, int level, int i, int j, double u, double v,
                  const reference_pixel *own, meeting *m, gap *g)
{
    const reference_level *here = &pyramid->levels[level];
    if (i < 0 || j < 0 || i >= here->width || j >= here->height)
        return;
    const reference_pixel *source = &here->pulled[j * here->width + i];
    bool goes_on =
        source->tag != 0 && level < pyramid->level_count && carries(pyramid, source, level);
    if (goes_on) {
        const reference_level *above = &pyramid->levels[level + 1];
        goes_on = source->z_min <= above->pulled[(j >> 1) * above->width + (i >> 1)].z_max;
    }
    if (source->tag == 0 || goes_on)
        return;
    reference_pixel p = *source;
    double cx = centre_of(i, level) + p.dx, cy = centre_of(j, level) + p.dy;
    double extent = p.z_max - p.z_min, depth;
    double q = reference_meet(pyramid, &p, cx, cy, u, v, &depth);
    if (source == own)
        q = p.radius > 0.0 ? fmin(q, 1.0) : 0.0;
    p.z_min = depth;
    p.z_max = p.z_min + extent;
    p.dx = cx - u;
    p.dy = cy - v;
    if (q <= TEMPLATE_GAP_Q_4)
        miss(&p, q, g);
    if (!(q <= 1.0))
        return;
    m->q[m->count] = q;
    m->weights[m->count] = exp(-2.0 * q);
    m->pixels[m->count++] = p;
}

/* The lesser of `source` and the pixel's source, which counts as at least 1. */
static int least_source(int source, const reference_pixel *p)
{
    int own = (p->tag - 1) >> 4 > 1 ? (p->tag - 1) >> 4 : 1;
    return own < source ? own : source;
}

static unsigned count_sides(unsigned sides)
{
    return (sides & 1) + (sides >> 1 & 1) + (sides >> 2 & 1) + (sides >> 3);
}

/* The nearest pixel, if pixels lie on three or four sides. */
static reference_pixel close_gap(const gap *g)
{
    reference_pixel p = g->nearest;
    if (count_sides(g->sides_3) < 3 && count_sides(g->sides_4) < 4)
        return (reference_pixel){0};
    p.tag = tag_with_source(p.tag, least_source(REFERENCE_LEVELS_LIMIT, &p));
    return p;
}

static reference_pixel template_pixel(const reference_pyramid *pyramid, int i, int j)
{
    int reach = (int)pyramid->filter / 2;
    double u = centre_of(i, 0), v = centre_of(j, 0);
    const reference_pixel *own = &pyramid->levels[0].pulled[j * pyramid->levels[0].width + i];
    double own_z = INFINITY;
    meeting m;
    gap g = {.q = INFINITY};
    m.count = 0;
    for (int l = 0; l <= pyramid->level_count; l++)
        for (int y = -reach; y <= reach; y++)
            for (int x = -reach; x <= reach; x++) {
                int before = m.count;
                cover(pyramid, l, (i >> l) + x, (j >> l) + y, u, v, own, &m, &g);
                if (m.count > before && l == 0 && x == 0 && y == 0)
                    own_z = m.pixels[before].z_min;
            }
    if (m.count == 0)
        return close_gap(&g);
    reference_pixel front = *front_of(&m);
    for (int k = 0; k < m.count; k++) /* if they begin before the first ends, all meet */
        front.z_max = fmin(front.z_max, m.pixels[k].z_max);
    keep_surface(&m, &front);
    int source = REFERENCE_LEVELS_LIMIT;
    for (int k = 0; k < m.count; k++)
        source = least_source(source, &m.pixels[k]);
    reference_pixel out = reference_mean(m.pixels, m.weights, m.count, &front);
    out.radius = sqrt(square_radius(&m));
    out.tag = tag_with_source(front.tag, own_z <= front.z_max ? 0 : source);
    return out;
}

void reference_push(reference_pyramid *pyramid)
{
    reference_level *first = &pyramid->levels[0];
    if (pyramid->filter >= REFERENCE_TEMPLATE3) {
        for (int j = 0; j < first->height; j++)
            for (int i = 0; i < first->width; i++)
                first->finished[j * first->width + i] = template_pixel(pyramid, i, j);
        return;
    }
    reference_level *top = &pyramid->levels[pyramid->level_count];
    for (int i = 0; i < top->width * top->height; i++)
        top->finished[i] = top->pulled[i];
    for (int l = pyramid->level_count - 1; l >= 0; l--) {
        reference_level *level = &pyramid->levels[l];
        for (int j = 0; j < level->height; j++)
            for (int i = 0; i < level->width; i++)
                level->finished[j * level->width + i] = push_pixel(pyramid, l, i, j);
    }
}
