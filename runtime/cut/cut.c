/* Selects the cut: descends to a block while its coarsest level (its parent's samples) is too
 * coarse. */
#include "runtime/cut/cut.h"

#include "base/memory.h"
#include "runtime/cut/level_rule.h"
#include "runtime/cut/need.h"

#include <stdlib.h>
#include <string.h>

static stp_rule_bound block_bound(const stp_block *b, stp_dvec3 origin, stp_dvec3 eye)
{
    stp_ball ball = stp_block_ball(b, origin, eye);
    return (stp_rule_bound){
        .centre = {(float)ball.centre.x, (float)ball.centre.y, (float)ball.centre.z},
        .radius = (float)ball.radius,
        .cone_axis = {b->cone_axis.x, b->cone_axis.y, b->cone_axis.z},
        .cone_cos = b->cone_angle >= 3.14159f ? -1.0f : cosf(b->cone_angle),
        .two_sided = (b->flags & STP_PATCH_TWO_SIDED) != 0,
        .closed = (b->flags & STP_CHUNK_CLOSED) != 0,
    };
}

/* The greatest error of a level, pixels; infinite if nothing bounds the projection. */
static float level_error(const stp_rule_sight *sight, const stp_block *b, int level)
{
    if (sight->scale < 0.0f)
        return INFINITY;
    return stp_rule_error(sight->scale, sight->sin_alpha, b->error[level],
                          b->tangential_error[level]);
}

/* Whether a level is fine enough for every patch of the block. */
static bool level_does(const stp_gpu_frame *frame, const stp_rule_sight *sight, const stp_block *b,
                       int level, float threshold, float cap)
{
    return threshold > 0.0f && sight->scale >= 0.0f &&
           stp_rule_fits(level_error(sight, b, level), sight->scale * b->radius_max,
                         b->colour_error[level] / 255.0f, sight->error_weight, frame->terms[0],
                         threshold, cap);
}

/* A block is wanted if its coarsest level is too coarse: its parent shows no more of it. */
static bool is_wanted(const stp_gpu_frame *frame, const stp_rule_sight *sight, const stp_block *b,
                      bool was_drawn)
{
    float share = was_drawn ? STP_CUT_HYSTERESIS : 1.0f;
    return !level_does(frame, sight, b, STP_LEVEL_COUNT - 1, frame->quality[0] * share,
                       frame->quality[1] * share);
}

/* The finest level that any patch of the block can ask for. */
static int finest_needed(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                         const stp_block *b)
{
    for (int level = STP_LEVEL_COUNT - 2; level > 0; level--)
        if (level_does(frame, sight, b, level, frame->quality[0], frame->quality[1]))
            return level;
    return 0;
}

/* An error beyond this gains no more: the picture does not get worse. */
#define GAIN_ERROR_MOST_PX 256.0f
/* So that even a single point gains something. */
#define GAIN_LEAST 1e-30f

/* The improvement per byte read, as stp_miss.gain. bound: in sight, relative to the eye. */
static float gain_of(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                     const stp_rule_bound *bound, const stp_block *b, int finest)
{
    float screen = frame->viewport[0] * frame->viewport[1];
    float error = fminf(level_error(sight, b, STP_LEVEL_COUNT - 1), GAIN_ERROR_MOST_PX);
    float reach = bound->radius * sight->scale;
    float area = sight->scale < 0.0f ? screen : fminf(3.14159265f * reach * reach, screen);
    float gain = area * fmaxf(error, 1.0f) / (1.0f + (float)stp_block_payload_bytes(b, finest));
    return fmaxf(gain, GAIN_LEAST);
}

/* A chunk with a block that is drawn or missing. complete: all blocks in sight of this chunk and of
 * those above are drawn. */
typedef struct stp_cut_visit {
    uint32_t chunk;
    bool complete;
    bool exact; /* its patches said which blocks below they need (ask_patches) */
} stp_cut_visit;

static stp_status add_miss(stp_cut *cut, stp_miss miss, stp_error *err)
{
    stp_status status = stp_grow(&cut->misses, &cut->miss_capacity, cut->miss_count + 1,
                                 sizeof *cut->misses, "a list of missing blocks", err);
    if (status == STP_OK)
        cut->misses[cut->miss_count++] = miss;
    return status;
}

static stp_status add_draw(stp_cut *cut, stp_draw draw, stp_error *err)
{
    stp_status status = stp_grow(&cut->draws, &cut->draw_capacity, cut->draw_count + 1,
                                 sizeof *cut->draws, "a list of blocks", err);
    if (status == STP_OK)
        cut->draws[cut->draw_count++] = draw;
    return status;
}

static stp_status push(stp_cut *cut, size_t *count, stp_cut_visit visit, stp_error *err)
{
    stp_status status = stp_grow(&cut->stack, &cut->stack_capacity, *count + 1, sizeof *cut->stack,
                                 "a stack of chunks", err);
    if (status == STP_OK)
        cut->stack[(*count)++] = visit;
    return status;
}

/* A cut decides about a block at most once, so there is room to note it. */
static void decide(stp_cut *cut, uint32_t block, size_t state, float limit)
{
    cut->touched[cut->touched_count++] = block;
    cut->blocks[block] = (stp_cut_block){state, limit};
}

/* Takes back all decisions, and makes room for the scene's blocks. */
static stp_status forget(stp_cut *cut, uint32_t block_count, stp_error *err)
{
    stp_status status = STP_OK;
    size_t had = cut->block_capacity;
    for (size_t i = 0; i < cut->touched_count; i++)
        cut->blocks[cut->touched[i]] = (stp_cut_block){0};
    cut->draw_count = cut->miss_count = cut->passed_count = 0;
    cut->link_count = cut->touched_count = 0;
    STP_TRY(stp_grow(&cut->blocks, &cut->block_capacity, block_count, sizeof *cut->blocks,
                     "a list of blocks", err));
    memset(cut->blocks + had, 0, (cut->block_capacity - had) * sizeof *cut->blocks);
    const size_t had_asked = cut->asked_capacity;
    had = cut->seen_capacity;
    STP_TRY(stp_grow(&cut->seen, &cut->seen_capacity, block_count, sizeof *cut->seen,
                     "a list of blocks", err));
    STP_TRY(stp_grow(&cut->asked, &cut->asked_capacity, block_count, sizeof *cut->asked,
                     "a list of blocks", err));
    if (had < cut->seen_capacity || had_asked < cut->asked_capacity || ++cut->serial == 0) {
        memset(cut->seen, 0, cut->seen_capacity * sizeof *cut->seen);
        memset(cut->asked, 0, cut->asked_capacity * sizeof *cut->asked);
        cut->serial = 1;
    }
    STP_TRY(stp_grow(&cut->touched, &cut->touched_capacity, block_count, sizeof *cut->touched,
                     "a list of blocks", err));
done:
    return status;
}

/* ---- descending ---- */

/* The part of a relative error that floats may add to a box. */
#define BOX_TOLERANCE 1e-6

/* Whether the boxes of two blocks touch. A block above another holds all that it stands for. */
static bool touches(const stp_scene *scene, uint32_t a, uint32_t b)
{
    stp_dvec3 origin[2] = {stp_scene_entry(scene, a)->origin, stp_scene_entry(scene, b)->origin};
    stp_dvec3 way = stp_dvec3_sub(origin[1], origin[0]);
    const stp_block *x = &scene->blocks[a], *y = &scene->blocks[b];
    for (int i = 0; i < 3; i++) {
        double step = i == 0 ? way.x : i == 1 ? way.y : way.z;
        double low = (double)y->box_min.raw[i] + step, high = (double)y->box_max.raw[i] + step;
        double slack = BOX_TOLERANCE * (fabs(low) + fabs(high) + fabs((double)x->box_min.raw[i]) +
                                        fabs((double)x->box_max.raw[i]));
        if (low > (double)x->box_max.raw[i] + slack || high < (double)x->box_min.raw[i] - slack)
            return false;
    }
    return true;
}

/* What the blocks above a block say: whether any is wanted, the least of their limits, and whether
 * any is drawn. Which patches refer to a block is known only once the blocks above are there; until
 * then, whichever touch it may. */
static bool ask_above(const stp_cut *cut, const stp_scene *scene, uint32_t parent, uint32_t block,
                      float *limit, bool *drawn)
{
    bool wanted = false;
    stp_scene_run run = stp_scene_blocks(scene, parent);
    *limit = INFINITY;
    *drawn = false;
    for (uint32_t a = run.begin; a < run.end; a++) {
        float at = cut->blocks[a].limit;
        if (at <= 0.0f || (run.end - run.begin > 1 && !touches(scene, a, block)))
            continue;
        wanted = true;
        *limit = fminf(*limit, at);
        *drawn |= at == INFINITY;
    }
    return wanted;
}

static void refer(void *context, uint32_t below, bool coarse)
{
    stp_cut *cut = context;
    cut->seen[below] = cut->serial;
    if (coarse)
        cut->asked[below] = cut->serial;
}

/* Lets the patches of a chunk's wanted blocks say which blocks below they need. False if they
 * cannot: some block is not resident, or patches name no blocks. */
static bool ask_patches(stp_cut *cut, const stp_cut_params *params, uint32_t chunk)
{
    const stp_scene *scene = params->scene;
    const stp_scene_run run = stp_scene_blocks(scene, chunk);
    if (params->source.resident == NULL || !(scene->entries[chunk].flags & STP_CHUNK_LINKED))
        return false;
    for (uint32_t b = run.begin; b < run.end; b++) {
        if (cut->blocks[b].limit <= 0.0f)
            continue;
        const stp_resident *resident = params->source.resident(params->source.context, b);
        if (resident == NULL && params->source.needed == NULL)
            return false;
        if (resident != NULL)
            stp_block_refer(scene, params->frame, params->eye, resident, refer, cut);
    }
    return true;
}

static bool was_drawn(const stp_cut_params *params, stp_scene_run run)
{
    const stp_cut_source *source = &params->source;
    bool drawn = false;
    for (uint32_t b = run.begin; source->was_drawn != NULL && !drawn && b < run.end; b++)
        drawn = source->was_drawn(source->context, b);
    return drawn;
}

/* Decides about a block of a child of a chunk. together: all blocks of the child are wanted. */
static stp_status visit_block(stp_cut *cut, const stp_cut_params *params, stp_cut_visit parent,
                              uint32_t id, bool together, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_block *b = &params->scene->blocks[id];
    stp_rule_bound bound = block_bound(b, params->scene->entries[b->chunk].origin, params->eye);
    float eye[3], limit, gain = INFINITY;
    bool drawn;
    const bool exact = parent.exact && !together;
    if (!stp_rule_visible(params->frame, &bound, eye) || (exact && cut->seen[id] != cut->serial)) {
        decide(cut, id, STP_CUT_HIDDEN, 0.0f);
        return STP_OK;
    }
    stp_rule_sight sight = stp_rule_look(params->frame, &bound);
    /* The bounds of patches above may be nearer to the eye than the block's: if they were asked,
     * they alone know. */
    bool wanted = together || (exact ? cut->asked[id] == cut->serial
                                     : is_wanted(params->frame, &sight, b,
                                                 was_drawn(params, (stp_scene_run){id, id + 1})));
    if (!wanted || !ask_above(cut, params->scene, parent.chunk, id, &limit, &drawn)) {
        /* together: all that is above and in sight is wanted, so nothing above is in sight */
        decide(cut, id, together ? STP_CUT_HIDDEN : STP_CUT_LEFT, 0.0f);
        return STP_OK;
    }
    int finest = finest_needed(params->frame, &sight, b);
    int available = params->source.available(params->source.context, id);
    if (params->source.needed != NULL)
        finest = params->source.needed(params->source.context, id, finest);
    if (available > finest) {
        gain = fminf(gain_of(params->frame, &sight, &bound, b, finest), 0.99f * limit);
        STP_TRY(add_miss(cut, (stp_miss){id, finest, gain}, err));
    }
    if (!drawn || available >= STP_LEVEL_COUNT) {
        limit = available == STP_CUT_NEVER ? 0.0f : fminf(limit, gain);
        decide(cut, id, STP_CUT_LEFT, limit);
        return STP_OK;
    }
    bool whole = parent.complete && params->frame->quality[0] <= 0.0f;
    decide(cut, id, whole ? STP_CUT_WHOLE : STP_CUT_LINKED, INFINITY);
    STP_TRY(add_draw(cut, (stp_draw){id, available > finest ? available : finest, false}, err));
done:
    return status;
}

/* Takes back the draws of a chunk that is drawn as a whole or not at all, if a block in sight is
 * missing; what is resident of it is kept. Below it, nothing gains more than its missing blocks. */
static stp_status withdraw(stp_cut *cut, stp_scene_run run, size_t draw_count, stp_error *err)
{
    stp_status status = STP_OK;
    float least = INFINITY;
    bool missing = false;
    for (uint32_t b = run.begin; b < run.end; b++) {
        missing |= cut->blocks[b].state == STP_CUT_LEFT;
        if (cut->blocks[b].state != STP_CUT_HIDDEN)
            least = fminf(least, cut->blocks[b].limit);
    }
    if (!missing)
        return STP_OK;
    cut->draw_count = draw_count;
    STP_TRY(stp_grow(&cut->passed, &cut->passed_capacity, cut->passed_count + (run.end - run.begin),
                     sizeof *cut->passed, "a list of blocks", err));
    for (uint32_t b = run.begin; b < run.end; b++) {
        cut->passed[cut->passed_count++] = b; /* those that are resident wait for the others */
        bool hidden = cut->blocks[b].state == STP_CUT_HIDDEN;
        cut->blocks[b] = (stp_cut_block){STP_CUT_LEFT, hidden ? 0.0f : least};
    }
done:
    return status;
}

/* Whether any of the blocks was asked for by a patch above. */
static bool is_asked(const stp_cut *cut, stp_scene_run run)
{
    uint32_t b = run.begin;
    while (b < run.end && cut->asked[b] != cut->serial)
        b++;
    return b < run.end;
}

/* Whether all blocks of a child are out of sight, or left to the parent. Then they are decided.
 * exact: patches above were asked about each block. */
static bool decide_at_once(stp_cut *cut, const stp_cut_params *params, uint32_t child, bool exact)
{
    const stp_chunk_entry *e = &params->scene->entries[child];
    stp_scene_run run = stp_scene_blocks(params->scene, child);
    stp_block whole = stp_block_of_entry(e, child);
    stp_rule_bound bound = block_bound(&whole, e->origin, params->eye);
    float eye[3];
    bool visible = stp_rule_visible(params->frame, &bound, eye);
    stp_rule_sight sight = stp_rule_look(params->frame, &bound);
    if (visible && (exact ? is_asked(cut, run)
                          : is_wanted(params->frame, &sight, &whole, was_drawn(params, run))))
        return false;
    for (uint32_t b = run.begin; b < run.end && !visible; b++)
        decide(cut, b, STP_CUT_HIDDEN, 0.0f);
    return true;
}

/* Decides about all blocks of a child. */
static stp_status visit_child(stp_cut *cut, const stp_cut_params *params, stp_cut_visit parent,
                              uint32_t child, size_t *stack_count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_scene_run run = stp_scene_blocks(params->scene, child);
    size_t draw_count = cut->draw_count;
    bool several = run.end - run.begin > 1, together = several && params->scene->undivided[child];
    if (several && decide_at_once(cut, params, child, parent.exact && !together))
        return STP_OK;
    for (uint32_t b = run.begin; b < run.end; b++)
        STP_TRY(visit_block(cut, params, parent, b, together, err));
    if (together)
        STP_TRY(withdraw(cut, run, draw_count, err));
    stp_cut_visit visit = {child, parent.complete, false};
    bool wanted = false;
    for (uint32_t b = run.begin; b < run.end; b++) {
        visit.complete &= cut->blocks[b].state != STP_CUT_LEFT;
        wanted |= cut->blocks[b].limit > 0.0f;
    }
    if (wanted)
        STP_TRY(push(cut, stack_count, visit, err));
done:
    return status;
}

static stp_status visit_children(stp_cut *cut, const stp_cut_params *params, stp_cut_visit visit,
                                 size_t *stack_count, stp_error *err)
{
    const stp_chunk_entry *e = &params->scene->entries[visit.chunk];
    visit.exact = e->child_count > 0 && ask_patches(cut, params, visit.chunk);
    for (uint32_t k = 0; k < e->child_count; k++) {
        stp_status status = visit_child(cut, params, visit, e->first_child + k, stack_count, err);
        if (status != STP_OK)
            return status;
    }
    return STP_OK;
}

/* Draws the blocks in sight of a root. */
static stp_status visit_root(stp_cut *cut, const stp_cut_params *params, uint32_t root,
                             size_t *stack_count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_scene_run run = stp_scene_blocks(params->scene, root);
    for (uint32_t id = run.begin; id < run.end; id++) {
        const stp_block *b = &params->scene->blocks[id];
        stp_rule_bound bound = block_bound(b, params->scene->entries[root].origin, params->eye);
        float eye[3];
        if (!stp_rule_visible(params->frame, &bound, eye)) {
            decide(cut, id, STP_CUT_HIDDEN, 0.0f);
            continue;
        }
        stp_rule_sight sight = stp_rule_look(params->frame, &bound);
        decide(cut, id, STP_CUT_WHOLE, INFINITY);
        STP_TRY(add_draw(cut, (stp_draw){id, finest_needed(params->frame, &sight, b), false}, err));
    }
    STP_TRY(push(cut, stack_count, (stp_cut_visit){root, true, false}, err));
done:
    return status;
}

/* ---- what the draws leave to each other ---- */

static int compare_draws(const void *a, const void *b)
{
    uint32_t x = ((const stp_draw *)a)->block, y = ((const stp_draw *)b)->block;
    return (x > y) - (x < y);
}

static int compare_misses(const void *a, const void *b)
{
    const stp_miss *x = a, *y = b;
    if (x->gain != y->gain)
        return x->gain < y->gain ? 1 : -1;
    return (x->block > y->block) - (x->block < y->block);
}

/* The index of the first draw whose block number is >= block. */
static size_t find_draw(const stp_cut *cut, uint32_t block)
{
    size_t low = 0, high = cut->draw_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (cut->draws[middle].block < block)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Links the draws below a chunk to the chunk's own; those further below are linked already. A
 * block is not linked, and draws all of its patches, if one below its chunk does. True if so. */
static bool link_below(stp_cut *cut, const stp_scene *scene, uint32_t chunk)
{
    stp_scene_run below = stp_scene_blocks_below(scene, chunk);
    bool linked = (scene->entries[chunk].flags & STP_CHUNK_LINKED) != 0, has_whole = false;
    for (size_t i = find_draw(cut, below.begin);
         i < cut->draw_count && cut->draws[i].block < below.end; i++) {
        const stp_draw *draw = &cut->draws[i];
        size_t *state = &cut->blocks[draw->block].state;
        if (*state == STP_CUT_WHOLE)
            continue;
        has_whole |= !linked || draw->has_whole;
        *state = STP_CUT_WHOLE;
        if (!linked || draw->has_whole)
            continue;
        *state = STP_CUT_LINKED + cut->link_count;
        cut->link_count += scene->blocks[draw->block].patch_count;
    }
    return has_whole;
}

/* Links all draws, from the leaves up. */
static void link_draws(stp_cut *cut, const stp_scene *scene)
{
    for (size_t end = cut->draw_count, begin; end > 0; end = begin) {
        uint32_t chunk = scene->blocks[cut->draws[end - 1].block].chunk;
        bool has_whole = link_below(cut, scene, chunk);
        for (begin = end; begin > 0 && scene->blocks[cut->draws[begin - 1].block].chunk == chunk;
             begin--)
            cut->draws[begin - 1].has_whole = has_whole;
    }
}

/* Whether each block below a chunk is out of sight or draws all of its patches. */
static bool passes(const stp_cut *cut, const stp_scene *scene, uint32_t chunk)
{
    stp_scene_run below = stp_scene_blocks_below(scene, chunk);
    bool all = below.begin < below.end;
    for (uint32_t b = below.begin; b < below.end && all; b++)
        all = cut->blocks[b].state == STP_CUT_HIDDEN || cut->blocks[b].state == STP_CUT_WHOLE;
    return all;
}

/* Moves the blocks that have nothing left to draw from draws to passed. */
static stp_status take_passed(stp_cut *cut, const stp_scene *scene, stp_error *err)
{
    stp_status status = STP_OK;
    size_t kept = 0;
    uint32_t last = STP_CHUNK_NONE;
    bool passed = false;
    for (size_t i = 0; i < cut->draw_count; i++) {
        const stp_draw *draw = &cut->draws[i];
        uint32_t chunk = scene->blocks[draw->block].chunk;
        passed = chunk == last ? passed : passes(cut, scene, chunk);
        last = chunk;
        if (!passed) {
            cut->draws[kept++] = *draw;
            continue;
        }
        STP_TRY(stp_grow(&cut->passed, &cut->passed_capacity, cut->passed_count + 1,
                         sizeof *cut->passed, "a list of blocks", err));
        cut->passed[cut->passed_count++] = draw->block;
    }
    cut->draw_count = kept;
done:
    return status;
}

stp_status stp_cut_select(stp_cut *cut, const stp_cut_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    size_t stack_count = 0;
    STP_TRY(forget(cut, params->scene->block_count, err));
    for (size_t i = 0; i < params->scene->model_count; i++)
        if (!(params->hidden_models >> i & 1))
            STP_TRY(visit_root(cut, params, params->scene->models[i].first, &stack_count, err));
    while (stack_count > 0) {
        stp_cut_visit visit = cut->stack[--stack_count];
        STP_TRY(visit_children(cut, params, visit, &stack_count, err));
    }
    if (cut->draw_count > 0)
        qsort(cut->draws, cut->draw_count, sizeof *cut->draws, compare_draws);
    if (cut->miss_count > 0)
        qsort(cut->misses, cut->miss_count, sizeof *cut->misses, compare_misses);
    link_draws(cut, params->scene);
    STP_TRY(take_passed(cut, params->scene, err));
done:
    return status;
}

void stp_cut_destroy(stp_cut *cut)
{
    free(cut->draws);
    free(cut->misses);
    free(cut->passed);
    free(cut->blocks);
    free(cut->touched);
    free(cut->seen);
    free(cut->asked);
    free(cut->stack);
    *cut = (stp_cut){0};
}
