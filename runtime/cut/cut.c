/* Selects the cut, tier by tier of the tree: descends to a block while its coarsest level (its
 * parent's samples) is too coarse. */
#include "runtime/cut/cut.h"

#include "base/memory.h"
#include "runtime/cut/cut_ask.h"

#include <stdlib.h>
#include <string.h>

/* A chunk with a block that is drawn or missing. complete: all blocks in sight of this chunk and of
 * those above are drawn. */
typedef struct stp_cut_visit {
    uint32_t chunk;
    bool complete;
    bool exact; /* its patches said which blocks below they need */
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

/* Notes that blocks with this bound are hidden. */
static stp_status add_occluded(stp_cut *cut, const stp_cut_params *params, const stp_block *b,
                               stp_error *err)
{
    stp_status status = stp_grow(&cut->occluded, &cut->occluded_capacity, cut->occluded_count + 1,
                                 sizeof *cut->occluded, "a list of hidden blocks", err);
    if (status == STP_OK)
        cut->occluded[cut->occluded_count++] =
            stp_cut_box(b, params->scene->entries[b->chunk].origin, params->eye);
    return status;
}

/* Adds a chunk to the next tier. */
static stp_status push(stp_cut *cut, stp_cut_visit visit, stp_error *err)
{
    stp_cut_tier *next = &cut->tiers[1];
    stp_status status = stp_grow(&next->visits, &next->capacity, next->count + 1,
                                 sizeof *next->visits, "a list of chunks", err);
    if (status == STP_OK)
        next->visits[next->count++] = visit;
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
    cut->draw_count = cut->miss_count = cut->passed_count = cut->occluded_count = 0;
    cut->tiers[1].count = 0;
    cut->link_count = cut->touched_count = 0;
    STP_TRY(stp_grow(&cut->blocks, &cut->block_capacity, block_count, sizeof *cut->blocks,
                     "a list of blocks", err));
    memset(cut->blocks + had, 0, (cut->block_capacity - had) * sizeof *cut->blocks);
    had = cut->reference_capacity;
    STP_TRY(stp_grow(&cut->references, &cut->reference_capacity, block_count,
                     sizeof *cut->references, "a list of blocks", err));
    if (had < cut->reference_capacity || ++cut->serial == 0) {
        memset(cut->references, 0, cut->reference_capacity * sizeof *cut->references);
        cut->serial = 1;
    }
    STP_TRY(stp_grow(&cut->answers, &cut->answer_capacity, block_count, sizeof *cut->answers,
                     "a list of blocks", err));
    STP_TRY(stp_grow(&cut->touched, &cut->touched_capacity, block_count, sizeof *cut->touched,
                     "a list of blocks", err));
done:
    return status;
}

/* ---- descending ---- */

/* Decides about a block by the answer. complete: of the parent's visit. */
static stp_status take_answer(stp_cut *cut, const stp_cut_params *params, bool complete,
                              uint32_t id, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cut_answer a = cut->answers[id];
    if (a.kind != STP_ANSWER_WANTED) {
        decide(cut, id, a.kind == STP_ANSWER_LEFT ? STP_CUT_LEFT : STP_CUT_HIDDEN, 0.0f);
        return a.kind == STP_ANSWER_OCCLUDED
                   ? add_occluded(cut, params, &params->scene->blocks[id], err)
                   : STP_OK;
    }
    if (a.missing)
        STP_TRY(add_miss(cut, (stp_miss){id, a.finest, a.gain}, err));
    if (!a.drawn || a.available >= STP_LEVEL_COUNT) {
        decide(cut, id, STP_CUT_LEFT, a.available == STP_CUT_NEVER ? 0.0f : fminf(a.limit, a.gain));
        return STP_OK;
    }
    bool whole = complete && params->frame->quality[0] <= 0.0f;
    decide(cut, id, whole ? STP_CUT_WHOLE : STP_CUT_LINKED, INFINITY);
    STP_TRY(
        add_draw(cut, (stp_draw){id, a.available > a.finest ? a.available : a.finest, false}, err));
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

/* Decides about all blocks of a child by their answers. */
static stp_status take_child(stp_cut *cut, const stp_cut_params *params, const stp_cut_child *child,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_scene_run run = stp_scene_blocks(params->scene, child->chunk);
    size_t draw_count = cut->draw_count;
    bool complete = child->complete, wanted = false;
    bool hidden = child->all == STP_ANSWER_HIDDEN || child->all == STP_ANSWER_OCCLUDED;
    for (uint32_t b = run.begin; b < run.end && hidden; b++)
        decide(cut, b, STP_CUT_HIDDEN, 0.0f);
    if (child->all == STP_ANSWER_OCCLUDED) {
        const stp_block whole =
            stp_block_of_entry(&params->scene->entries[child->chunk], child->chunk);
        return add_occluded(cut, params, &whole, err);
    }
    if (child->all != STP_ANSWER_WANTED)
        return STP_OK;
    for (uint32_t b = run.begin; b < run.end; b++)
        STP_TRY(take_answer(cut, params, complete, b, err));
    if (child->together)
        STP_TRY(withdraw(cut, run, draw_count, err));
    for (uint32_t b = run.begin; b < run.end; b++) {
        complete &= cut->blocks[b].state != STP_CUT_LEFT;
        wanted |= cut->blocks[b].limit > 0.0f;
    }
    if (wanted)
        STP_TRY(push(cut, (stp_cut_visit){child->chunk, complete, false}, err));
done:
    return status;
}

/* What the threads that ask need. */
typedef struct asking {
    stp_cut *cut;
    const stp_cut_params *params;
} asking;

static stp_status ask_visit(void *context, size_t index, unsigned worker, stp_error *err)
{
    const asking *a = context;
    stp_cut_visit *visit = &a->cut->tiers[0].visits[index];
    (void)worker;
    (void)err;
    visit->exact = a->params->scene->entries[visit->chunk].child_count > 0 &&
                   stp_cut_ask_patches(a->cut, a->params, visit->chunk);
    return STP_OK;
}

static stp_status ask_child(void *context, size_t index, unsigned worker, stp_error *err)
{
    const asking *a = context;
    (void)worker;
    (void)err;
    stp_cut_ask_child(a->cut, a->params, &a->cut->children[index]);
    return STP_OK;
}

/* Asks by all threads of the pool; without a pool, by this one. */
static stp_status ask_all(const stp_cut_params *params, size_t count, stp_pool_task *task,
                          asking *context, stp_error *err)
{
    stp_status status = STP_OK;
    if (params->pool != NULL)
        return stp_pool_run(params->pool, count, task, context, err);
    for (size_t i = 0; i < count && status == STP_OK; i++)
        status = task(context, i, 0, err);
    return status;
}

/* Lists the children of the tier's chunks. */
static stp_status list_children(stp_cut *cut, const stp_cut_params *params, stp_error *err)
{
    cut->child_count = 0;
    for (size_t i = 0; i < cut->tiers[0].count; i++) {
        const stp_cut_visit *visit = &cut->tiers[0].visits[i];
        const stp_chunk_entry *e = &params->scene->entries[visit->chunk];
        stp_status status =
            stp_grow(&cut->children, &cut->child_capacity, cut->child_count + e->child_count,
                     sizeof *cut->children, "a list of chunks", err);
        if (status != STP_OK)
            return status;
        for (uint32_t k = 0; k < e->child_count; k++)
            cut->children[cut->child_count++] = (stp_cut_child){.chunk = e->first_child + k,
                                                                .parent = visit->chunk,
                                                                .complete = visit->complete,
                                                                .exact = visit->exact};
    }
    return STP_OK;
}

/* Decides about the children of all chunks of a tier. Answers depend on the tiers above alone, so
 * the cut is the same for any number of threads. */
static stp_status visit_tier(stp_cut *cut, const stp_cut_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    asking context = {cut, params};
    STP_TRY(ask_all(params, cut->tiers[0].count, ask_visit, &context, err));
    STP_TRY(list_children(cut, params, err));
    STP_TRY(ask_all(params, cut->child_count, ask_child, &context, err));
    for (size_t i = 0; i < cut->child_count; i++)
        STP_TRY(take_child(cut, params, &cut->children[i], err));
done:
    return status;
}

/* Draws the blocks in sight of a root. */
static stp_status visit_root(stp_cut *cut, const stp_cut_params *params, uint32_t root,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_scene_run run = stp_scene_blocks(params->scene, root);
    for (uint32_t id = run.begin; id < run.end; id++) {
        const stp_block *b = &params->scene->blocks[id];
        stp_rule_bound bound = stp_cut_bound(b, params->scene->entries[root].origin, params->eye);
        float eye[3];
        if (!stp_rule_visible(params->frame, &bound, eye)) {
            decide(cut, id, STP_CUT_HIDDEN, 0.0f);
            continue;
        }
        stp_rule_sight sight = stp_rule_look(params->frame, &bound);
        decide(cut, id, STP_CUT_WHOLE, INFINITY);
        STP_TRY(
            add_draw(cut, (stp_draw){id, stp_cut_finest(params->frame, &sight, b), false}, err));
    }
    STP_TRY(push(cut, (stp_cut_visit){root, true, false}, err));
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
    STP_TRY(forget(cut, params->scene->block_count, err));
    for (size_t i = 0; i < params->scene->model_count; i++)
        if (!(params->hidden_models >> i & 1))
            STP_TRY(visit_root(cut, params, params->scene->models[i].first, err));
    while (cut->tiers[1].count > 0) {
        stp_cut_tier seen = cut->tiers[0];
        cut->tiers[0] = cut->tiers[1];
        cut->tiers[1] = seen;
        cut->tiers[1].count = 0;
        STP_TRY(visit_tier(cut, params, err));
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
    free(cut->occluded);
    free(cut->passed);
    free(cut->blocks);
    free(cut->touched);
    free(cut->references);
    free(cut->answers);
    free(cut->children);
    free(cut->tiers[0].visits);
    free(cut->tiers[1].visits);
    *cut = (stp_cut){0};
}
