/* Culls the patches of a cut: drawn by parent or child instead, outside the frustum, facing
 * away. */
#include "runtime/cut/sight.h"

#include "base/memory.h"
#include "formats/chunk/codec/square/square.h"
#include "runtime/cut/culling.h"
#include "runtime/cut/need.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct look {
    stp_sight *sight;
    const stp_sight_params *params;
    const stp_draw *draws;
    size_t *found[STP_SIGHT_COUNT]; /* by draw: how many items */
    float *radius_px;               /* by draw: the greatest of some draws */
    size_t *hidden;                 /* by draw: how many patches */
} look;

/* A patch in sight, and what is known of it. */
typedef struct seen_patch {
    const stp_draw *draw;
    const stp_resident *resident;
    uint32_t at; /* of the patches of the block */
} seen_patch;

/* Whether a patch is drawn at its finest level, also if its errors are `slack` times as small. */
static bool is_finest(const stp_sight_params *params, const seen_patch *seen, float slack)
{
    stp_gpu_frame frame = *params->frame;
    stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(params->scene, seen->draw, params->eye);
    frame.quality[0] *= slack;
    frame.quality[1] *= slack;
    stp_levels levels =
        stp_levels_choose(&frame, &chunk, &seen->resident->mirror.patches[seen->at]);
    bool finest = seen->draw->finest == 0;
    for (int q = 0; q < STP_PATCH_QUARTERS; q++)
        finest = finest && (levels.of[q] == 0 || (q > 0 && levels.of[q] == STP_LEVEL_SKIP));
    return finest;
}

/* The GPU rounds in its own way: it chooses level 0, too, if errors this much smaller do not
 * change that. */
#define ROUNDING_SLACK 1.25f

/* The state of the block that refines a patch. */
static size_t state_below(const stp_sight *s, const stp_patch_brief *brief)
{
    return brief->block == STP_BLOCK_NONE ? STP_CUT_LEFT : s->cut->blocks[brief->block].state;
}

/* The flags of the patches that refine a patch; state: of their block, linked. */
static bool *links_of(const stp_sight *s, size_t state, const stp_patch_brief *brief)
{
    return s->below + (state - STP_CUT_LINKED) + brief->first_below;
}

/* Whether a block in this state may draw a patch: a patch above, if there is one, leaves it to be
 * drawn. */
static bool is_left(const stp_sight *s, size_t state, uint32_t patch)
{
    return state < STP_CUT_LINKED || s->below[state - STP_CUT_LINKED + patch];
}

bool stp_patch_in_sight(const stp_sight *s, const stp_sight_params *params, const stp_draw *draw,
                        const stp_patch_brief *briefs, uint32_t patch)
{
    float eye[3];
    const stp_patch_brief *brief = &briefs[patch];
    stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(params->scene, draw, params->eye);
    stp_rule_bound bound = stp_patch_bound(brief, &chunk);
    size_t below = state_below(s, brief);
    bool refined = below >= STP_CUT_LINKED ? *links_of(s, below, brief) : below != STP_CUT_LEFT;
    return !refined && is_left(s, s->cut->blocks[draw->block].state, patch) &&
           stp_rule_visible(params->frame, &bound, eye) &&
           !stp_occlusion_hides(params->occlusion, bound.centre, bound.radius);
}

/* Whether a patch in sight is left to the linked block below, which is in this state. If so, marks
 * the links of the block's patches. */
static bool leave_below(const look *l, size_t state, const stp_draw *draw,
                        const stp_mirror_patch *patch, const stp_patch_brief *brief,
                        const stp_rule_sight *sight)
{
    if (stp_levels_do(l->params->frame, sight, patch, draw->finest))
        return false;
    memset(links_of(l->sight, state, brief), true, brief->below_count);
    return true;
}

/* The greatest projected radius of the samples that a patch may be drawn with, if its patch vertex
 * is too coarse: up to the rule's cap that of any level, be it resident or not, so that pictures do
 * not depend on that; if no level does, that of the finest one drawn. */
static float patch_radius_px(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                             const stp_mirror_patch *patch, int drawn)
{
    const int finest = patch->finest > drawn ? patch->finest : drawn;
    const bool does = stp_levels_do(frame, sight, patch, finest);
    const float cap = frame->quality[1] / sight->scale;
    float greatest = does ? 0.0f : patch->radius[finest];
    if (sight->scale < 0.0f)
        return INFINITY;
    for (int l = does ? 0 : finest + 1; l < STP_LEVEL_COUNT && frame->quality[0] > 0.0f; l++) {
        const float coarser = patch->radius[l] < cap ? patch->radius[l] : cap;
        greatest = coarser > greatest ? coarser : greatest;
    }
    return greatest * sight->scale;
}

static const stp_raster *raster_of(const stp_resident *r, uint32_t patch)
{
    return &r->mirror.rasters[r->mirror.squares[patch].raster];
}

/* Cosine of a slope of 4 to 1, the steepest that square_list.glsl believes a tangent plane. */
#define STEEP_COSINE 0.2425f
/* Steps steeper than 8 to 1 are cliffs. Beside points, squares steeper than this leave gaps. */
#define STEEPEST_SLOPE 7.0f
/* Noise makes steps steeper, by some 2.5 times what heights are off level 1. */
#define STEP_ERRORS 2.5f

/* How far heights lie off level 1 of a patch, in sides of a cell, if its normal has this z. */
static float roughness(const stp_raster *raster, const stp_mirror_patch *patch, float up)
{
    const double *a = raster->across[0], *b = raster->across[1];
    const double column = a[1] * a[1] + b[1] * b[1], row = a[2] * a[2] + b[2] * b[2];
    float error = 0.0f;
    for (int q = 0; q < STP_PATCH_QUARTERS; q++)
        error = fmaxf(error, patch->quarter_error[1][0][q]);
    return error / (up * sqrtf((float)fmin(column, row)));
}

/* Whether a square of heights may fall so steeply that its triangles would leave pixels open: they
 * take a step beyond twice what tangent planes tell for a cliff. Discs close there. */
static bool is_steep(const stp_raster *raster, const stp_mirror_patch *patch)
{
    const float up = fabsf(patch->cone_axis[2]), spread = patch->cone_cos;
    const float sines = (1.0f - up * up) * (1.0f - spread * spread);
    const float cosine = up * spread - sqrtf(fmaxf(0.0f, sines)); /* of the steepest slope */
    if (!stp_raster_is_upright(raster) || cosine >= STEEP_COSINE)
        return false;
    return !(cosine > 0.0f) ||
           sqrtf(1.0f - cosine * cosine) / cosine + STEP_ERRORS * roughness(raster, patch, up) >
               STEEPEST_SLOPE;
}

/* Whether a patch in sight is a square of a grid or a map, and its samples are so wide that they
 * are drawn as a square. */
static bool is_wide_square(const look *l, const stp_draw *draw, const stp_resident *r, uint32_t at,
                           const stp_rule_sight *sight)
{
    if (!r->mirror.squares || draw->finest != 0)
        return false;
    /* From within its bound as wide as any, but not as infinity, if no square is wide. */
    const stp_mirror_patch *patch = &r->mirror.patches[at];
    const float radius_px = sight->scale < 0.0f ? FLT_MAX : sight->scale * patch->radius[0];
    const float grids_px = l->params->grids_px;
    if (!(radius_px > (stp_raster_is_map(raster_of(r, at)) ? l->params->maps_px : grids_px)) ||
        (grids_px > 0.0f && is_steep(raster_of(r, at), patch)))
        return false;
    return is_finest(l->params, &(seen_patch){.draw = draw, .resident = r, .at = at}, 1.0f);
}

/* The greatest projected radius of the pixels of a square (shape.glsl, map.glsl). */
static float square_radius_px(const stp_resident *r, uint32_t patch, const stp_rule_sight *sight)
{
    if (stp_raster_is_upright(raster_of(r, patch)))
        return 0.0f;
    return sight->scale < 0.0f ? INFINITY : sight->scale * r->mirror.patches[patch].radius[0];
}

/* Draws of the same depth in the tree; their parents come in the tier before. */
typedef struct tier {
    const look *look;
    const size_t *draws;
    size_t count;
} tier;

/* A thread takes so many draws at a time: what they write shares lines of the cache. */
#define DRAWS_AT_ONCE 32

/* Whether any sample of the levels from `finest` on is drawn. */
static bool has_any(const stp_patch_brief *brief, int finest)
{
    const unsigned levels = (1u << STP_LEVEL_COUNT) - (1u << finest);
    return (brief->empty & levels) != levels;
}

/* A draw that is being looked at. */
typedef struct glance {
    const look *look;
    const stp_draw *draw;
    const stp_resident *resident;
    size_t index, state;             /* of the draw, of its block */
    uint32_t *next[STP_SIGHT_COUNT]; /* item of the draw */
    unsigned worker;
    stp_gpu_chunk chunk;
    stp_looks looks; /* of the patches from `first` on */
    uint32_t first;
    bool marked;       /* the tiles of these patches are */
    float greatest_px; /* so far */
    size_t hidden;
} glance;

/* Appends an item to those found for the draw. */
static void add(glance *g, stp_sight_kind kind, uint32_t item)
{
    *g->next[kind]++ = item;
}

static void add_patch(glance *g, uint32_t at)
{
    const uint32_t item = g->resident->placement.patches.begin + at;
    const stp_patch_brief *brief = &g->resident->mirror.briefs[at];
    add(g, STP_SIGHT_PATCHES, item);
    if (brief->shape == STP_PATCH_STRIP)
        add(g, STP_SIGHT_STRIPS, item);
    else if (brief->shape == STP_PATCH_TRIANGLES)
        add(g, STP_SIGHT_TRIANGLES, item);
}

/* Marks the tiles that patch i of the group may cover. vertex: only its patch vertex is drawn. */
static void mark_patch(const glance *g, uint32_t i, bool vertex)
{
    const stp_sight_params *params = g->look->params;
    const stp_gpu_frame *frame = params->frame;
    const stp_mirror *mirror = &g->resident->mirror;
    const uint32_t at = g->first + i;
    const bool spots = !vertex && mirror->briefs[at].has_spots &&
                       is_finest(params, &(seen_patch){g->draw, g->resident, at}, ROUNDING_SLACK);
    if (!spots) {
        if (!g->marked)
            stp_tiles_mark(params->tiles, g->worker, g->looks.window[0][i], g->looks.window[1][i],
                           g->looks.reach_px[i]);
        return;
    }
    const stp_mirror_patch *patch = &mirror->patches[at];
    const stp_spot *first = mirror->spots + patch->spots - 1;
    const float reach =
        stp_frame_stretch(frame) * stp_spot_reach(patch->bound_radius, patch->radius[0]);
    for (unsigned s = 0; s < patch->count[0]; s++) {
        const float *const axes[3] = {frame->axis_right, frame->axis_up, frame->axis_back};
        float offset[3], eye[3];
        stp_spot_offset(&first[s], patch->bound_radius, offset);
        for (int k = 0; k < 3; k++)
            eye[k] = g->looks.eye[k][i] + axes[k][0] * offset[0] + axes[k][1] * offset[1] +
                     axes[k][2] * offset[2];
        const stp_window_disc disc = stp_ball_window_disc(frame, eye, reach);
        stp_tiles_mark(params->tiles, g->worker, disc.centre[0], disc.centre[1], disc.reach);
    }
}

/* Whether all tiles that patches in sight of the group may cover are marked: so it is mostly, since
 * neighbours cover the same tiles. */
static bool is_marked(const glance *g, uint32_t count)
{
    const stp_looks *looks = &g->looks;
    float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}, all = 0.0f;
    for (int k = 0; k < 2; k++)
        for (uint32_t i = 0; i < count; i++) {
            /* NOLINTNEXTLINE(clang-analyzer-core.*): stp_patches_look has set them */
            const float from = looks->window[k][i] - looks->reach_px[i];
            const float to = looks->window[k][i] + looks->reach_px[i];
            low[k] = looks->visible[i] && from < low[k] ? from : low[k];
            high[k] = looks->visible[i] && to > high[k] ? to : high[k];
            all += looks->visible[i] ? to - from : 0.0f;
        }
    return isfinite(all) && /* else nothing bounds some patch */
           stp_tiles_marked(g->look->params->tiles, g->worker, low, high);
}

/* Whether patch i of the group, whose vertex is too coarse, is drawn as level 2 for sure, and as
 * points. */
static bool is_in_quarters(const glance *g, uint32_t i)
{
    const stp_patch_brief *brief = &g->resident->mirror.briefs[g->first + i];
    const int resident = brief->finest > g->draw->finest ? brief->finest : g->draw->finest;
    return g->look->params->quarters && brief->shape == 0 &&
           (resident == 2 || (resident < 2 && g->looks.quarters[i]));
}

/* Lists patch i of the group if it is in sight. */
static void list_patch(glance *g, uint32_t i)
{
    const look *l = g->look;
    const stp_sight_params *params = l->params;
    const stp_resident *r = g->resident;
    const uint32_t at = g->first + i;
    const stp_patch_brief *brief = &r->mirror.briefs[at];
    const size_t below = state_below(l->sight, brief);
    /* NOLINTNEXTLINE(clang-analyzer-core.uninitialized.Branch): stp_patches_look has set it */
    if (!g->looks.visible[i] || !is_left(l->sight, g->state, at) ||
        (below < STP_CUT_LINKED && below != STP_CUT_LEFT))
        return;
    if (params->occlusion != NULL) {
        const stp_rule_bound bound = stp_patch_bound(brief, &g->chunk);
        if (stp_occlusion_hides(params->occlusion, bound.centre, bound.radius)) {
            g->hidden++;
            return;
        }
    }
    const stp_rule_sight sight = stp_looks_sight(&g->looks, params->frame, i);
    if (below >= STP_CUT_LINKED &&
        leave_below(l, below, g->draw, &r->mirror.patches[at], brief, &sight))
        return;
    float radius_px = brief->vertex_radius * sight.scale;
    const bool vertex = params->vertices && g->looks.vertex[i];
    mark_patch(g, i, vertex);
    if (!has_any(brief, vertex ? STP_LEVEL_COUNT - 1 : g->draw->finest))
        return;
    if (vertex) {
        add(g, STP_SIGHT_VERTICES,
            stp_name_of(r->placement.patches.begin + at, STP_LEVEL_COUNT - 1, 0));
    } else if (is_wide_square(l, g->draw, r, at, &sight)) {
        add(g, STP_SIGHT_SQUARES, r->placement.patches.begin + at);
        radius_px = square_radius_px(r, at, &sight);
    } else {
        if (is_in_quarters(g, i))
            add(g, STP_SIGHT_QUARTERS,
                stp_name_of(r->placement.patches.begin + at, 2, 0) |
                    ((brief->below_count + 15u) / 16u - 1u) << STP_NAME_BITS);
        else
            add_patch(g, at);
        /* else no level reaches farther: the patch's record need not be read */
        if (!brief->vertex_greatest || !(sight.scale >= 0.0f && radius_px <= g->greatest_px))
            radius_px =
                patch_radius_px(params->frame, &sight, &r->mirror.patches[at], g->draw->finest);
    }
    g->greatest_px = radius_px > g->greatest_px ? radius_px : g->greatest_px;
}

static const stp_resident *resident_of(const look *l, size_t index)
{
    const stp_block_cache *cache = l->params->cache;
    return stp_block_cache_get(cache, stp_block_cache_slot(cache, l->draws[index].block));
}

/* greatest_px: of the draws before. */
static void look_at_draw(const look *l, size_t index, unsigned worker, float greatest_px)
{
    const stp_sight_params *params = l->params;
    const stp_draw *draw = &l->draws[index];
    const stp_resident *r = resident_of(l, index);
    const uint32_t count = r->placement.patches.count;
    stp_gpu_frame room;
    const stp_gpu_frame *openings = stp_culling_narrow(
        &room, params->frame, params->scene, draw->block, params->eye, l->sight->openings[index]);
    glance g;
    g.look = l;
    g.draw = draw;
    g.resident = r;
    g.index = index;
    g.state = l->sight->cut->blocks[draw->block].state;
    g.worker = worker;
    g.chunk = stp_gpu_chunk_from_draw(params->scene, draw, params->eye);
    g.greatest_px = greatest_px;
    g.hidden = 0;
    for (int i = 0; i < STP_SIGHT_COUNT; i++)
        g.next[i] = l->sight->lists[i].items + l->sight->lists[i].begin[index];
    for (g.first = 0; g.first < count; g.first += STP_LOOKS_LIMIT) {
        const uint32_t some = count - g.first < STP_LOOKS_LIMIT ? count - g.first : STP_LOOKS_LIMIT;
        stp_patches_look(&g.looks, params->frame, openings, &g.chunk, &r->mirror.briefs[g.first],
                         some);
        g.marked = is_marked(&g, some);
        for (uint32_t i = 0; i < some; i++)
            list_patch(&g, i);
    }
    for (int i = 0; i < STP_SIGHT_COUNT; i++)
        l->found[i][index] =
            (size_t)(g.next[i] - l->sight->lists[i].items) - l->sight->lists[i].begin[index];
    l->radius_px[index] = g.greatest_px;
    l->hidden[index] = g.hidden;
}

static stp_status look_at_draws(void *context, size_t task, unsigned worker, stp_error *err)
{
    const tier *t = context;
    const size_t end =
        DRAWS_AT_ONCE * (task + 1) < t->count ? DRAWS_AT_ONCE * (task + 1) : t->count;
    (void)err;
    const look *l = t->look;
    float greatest_px = 0.0f;
    for (size_t at = DRAWS_AT_ONCE * task; at < end; at++) {
        for (size_t ahead = at + 1; ahead <= at + 2 && ahead < end; ahead++)
            stp_block_prefetch(resident_of(l, t->draws[ahead]), ahead == at + 1);
        look_at_draw(l, t->draws[at], worker, greatest_px);
        greatest_px = l->radius_px[t->draws[at]];
    }
    return STP_OK;
}

/* Looks at one tier after the other; all threads share a tier. */
static stp_status look_at_tiers(const look *l, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    size_t *draws = NULL, looked = 0;
    STP_TRY(stp_alloc(&draws, count + 1, sizeof *draws, "a list of blocks", err));
    for (unsigned depth = 0; looked < count; depth++) {
        size_t found = 0;
        for (size_t i = 0; i < count; i++)
            if (stp_scene_entry(l->params->scene, l->draws[i].block)->depth == depth)
                draws[found++] = i;
        STP_TRY(stp_pool_run(l->params->pool, (found + DRAWS_AT_ONCE - 1) / DRAWS_AT_ONCE,
                             look_at_draws, &(tier){l, draws, found}, err));
        looked += found;
    }
done:
    free(draws);
    return status;
}

/* Makes room for the most items that each draw can have. */
static stp_status reserve(stp_sight_list *list, const stp_sight_params *params,
                          const stp_draw *draws, size_t count, bool used, stp_error *err)
{
    stp_status status = STP_OK;
    size_t most = 0;
    STP_TRY(stp_grow(&list->begin, &list->begin_capacity, count + 1, sizeof *list->begin,
                     "a list of patches", err));
    for (size_t i = 0; i < count; i++) {
        list->begin[i] = most;
        most += used ? params->scene->blocks[draws[i].block].patch_count : 0;
    }
    STP_TRY(stp_grow(&list->items, &list->item_capacity, most + 1, sizeof *list->items,
                     "a list of patches", err));
done:
    return status;
}

/* Moves the items of all draws together. */
static void close_gaps(stp_sight_list *list, const size_t *found, size_t count)
{
    size_t end = 0;
    for (size_t i = 0; i < count; i++) {
        memmove(list->items + end, list->items + list->begin[i], found[i] * sizeof *list->items);
        list->begin[i] = end;
        end += found[i];
    }
    list->begin[count] = end;
}

stp_status stp_sight_begin(stp_sight *s, const stp_cut *cut, stp_error *err)
{
    stp_status status = stp_grow(&s->below, &s->below_capacity, cut->link_count + 1,
                                 sizeof *s->below, "a list of patches", err);
    s->cut = cut;
    if (status == STP_OK)
        memset(s->below, false, cut->link_count * sizeof *s->below);
    return status;
}

stp_status stp_sight_look(stp_sight *s, const stp_sight_params *params, const stp_draw *draws,
                          size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    size_t *found = NULL;
    look l = {.sight = s, .params = params, .draws = draws};
    unsigned shapes = stp_scene_shapes(params->scene);
    const bool used[STP_SIGHT_COUNT] = {true,
                                        params->vertices,
                                        params->quarters,
                                        (shapes & STP_PATCH_STRIP) != 0,
                                        (shapes & STP_PATCH_TRIANGLES) != 0,
                                        fminf(params->grids_px, params->maps_px) < INFINITY};
    STP_TRY(stp_alloc(&found, STP_SIGHT_COUNT * count + 1, sizeof *found, "lists of patches", err));
    for (int i = 0; i < STP_SIGHT_COUNT; i++) {
        l.found[i] = found + (size_t)i * count;
        STP_TRY(reserve(&s->lists[i], params, draws, count, used[i], err));
    }
    STP_TRY(stp_grow(&s->openings, &s->opening_capacity, count + 1, sizeof *s->openings,
                     "lists of patches", err));
    STP_TRY(stp_alloc(&l.radius_px, count + 1, sizeof *l.radius_px, "lists of patches", err));
    STP_TRY(stp_alloc(&l.hidden, count + 1, sizeof *l.hidden, "lists of patches", err));
    STP_TRY(look_at_tiers(&l, count, err));
    s->radius_px = 0.0f;
    s->hidden = 0;
    for (size_t i = 0; i < count; i++) {
        s->radius_px = fmaxf(s->radius_px, l.radius_px[i]);
        s->hidden += l.hidden[i];
    }
    for (int i = 0; i < STP_SIGHT_COUNT; i++)
        close_gaps(&s->lists[i], l.found[i], count);
done:
    free(l.radius_px);
    free(l.hidden);
    free(found);
    return status;
}

void stp_sight_destroy(stp_sight *s)
{
    for (int i = 0; i < STP_SIGHT_COUNT; i++) {
        free(s->lists[i].items);
        free(s->lists[i].begin);
    }
    free(s->below);
    free(s->openings);
    *s = (stp_sight){0};
}
