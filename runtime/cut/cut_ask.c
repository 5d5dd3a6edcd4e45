/* Answers what the cut asks about blocks: each answer depends on blocks above alone. */
#include "runtime/cut/cut_ask.h"

#include "runtime/cut/level_rule.h"
#include "runtime/cut/need.h"

stp_rule_bound stp_cut_bound(const stp_block *b, stp_dvec3 origin, stp_dvec3 eye)
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

stp_occluded stp_cut_box(const stp_block *b, stp_dvec3 origin, stp_dvec3 eye)
{
    stp_occluded box;
    const stp_dvec3 way = stp_dvec3_sub(origin, eye);
    const double offset[3] = {way.x, way.y, way.z};
    for (int i = 0; i < 3; i++) {
        box.low[i] = (float)(offset[i] + (double)b->box_min.raw[i]);
        box.high[i] = (float)(offset[i] + (double)b->box_max.raw[i]);
    }
    return box;
}

/* Whether an earlier picture hides a block. */
static bool is_occluded(const stp_cut_params *params, const stp_block *b)
{
    if (params->occlusion == NULL)
        return false;
    const stp_occluded box = stp_cut_box(b, params->scene->entries[b->chunk].origin, params->eye);
    return stp_occlusion_hides_box(params->occlusion, &box);
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

int stp_cut_finest(const stp_gpu_frame *frame, const stp_rule_sight *sight, const stp_block *b)
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

/* A block whose patches refer to others. */
typedef struct referring {
    stp_cut *cut;
    float limit; /* of the block */
} referring;

/* Chunks refer to blocks of their own children, so no two threads write to one place. */
static void refer(void *context, uint32_t below, bool coarse)
{
    const referring *from = context;
    stp_cut_reference *r = &from->cut->references[below];
    const uint32_t serial = from->cut->serial;
    r->seen = serial;
    if (!coarse)
        return;
    if (r->asked != serial)
        *r = (stp_cut_reference){serial, serial, INFINITY, false};
    r->limit = fminf(r->limit, from->limit);
    r->drawn |= from->limit == INFINITY;
}

bool stp_cut_ask_patches(stp_cut *cut, const stp_cut_params *params, uint32_t chunk)
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
            stp_block_refer(scene, params->frame, params->eye, params->occlusion, resident, refer,
                            &(referring){cut, cut->blocks[b].limit});
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

/* The answer about a block of a child of a chunk. exact: patches above were asked about each block.
 * together: all blocks of the child are wanted. */
static stp_cut_answer ask_block(const stp_cut *cut, const stp_cut_params *params,
                                const stp_cut_child *child, uint32_t id, bool exact, bool together)
{
    const stp_block *b = &params->scene->blocks[id];
    const stp_cut_reference *r = &cut->references[id];
    stp_cut_answer a = {
        .kind = STP_ANSWER_HIDDEN, .limit = r->limit, .drawn = r->drawn, .gain = INFINITY};
    if (exact && r->seen != cut->serial)
        return a;
    stp_rule_bound bound = stp_cut_bound(b, params->scene->entries[b->chunk].origin, params->eye);
    float eye[3];
    if (!stp_rule_visible(params->frame, &bound, eye))
        return a;
    const bool occluded = !together && is_occluded(params, b); /* together, all say the same */
    if (occluded && !params->occlusion->asks_only) {
        a.kind = STP_ANSWER_OCCLUDED;
        return a;
    }
    stp_rule_sight sight = stp_rule_look(params->frame, &bound);
    /* The bounds of patches above may be nearer to the eye than the block's: if they were asked,
     * they alone know. */
    bool wanted = together || (exact ? r->asked == cut->serial
                                     : is_wanted(params->frame, &sight, b,
                                                 was_drawn(params, (stp_scene_run){id, id + 1})));
    if (!wanted ||
        (!exact && !ask_above(cut, params->scene, child->parent, id, &a.limit, &a.drawn))) {
        /* together: all that is above and in sight is wanted, so nothing above is in sight */
        a.kind = together ? STP_ANSWER_HIDDEN : STP_ANSWER_LEFT;
        return a;
    }
    a.kind = STP_ANSWER_WANTED;
    a.finest = stp_cut_finest(params->frame, &sight, b);
    a.available = params->source.available(params->source.context, id);
    if (params->source.needed != NULL)
        a.finest = params->source.needed(params->source.context, id, a.finest, &a.missing);
    if (a.missing && a.available < a.finest)
        a.finest = a.available; /* gives up nothing that is there */
    a.missing |= a.available > a.finest;
    if (occluded && a.missing) {
        a.finest = a.available;
        a.missing = false;
    }
    if (a.missing)
        a.gain = fminf(gain_of(params->frame, &sight, &bound, b, a.finest), 0.99f * a.limit);
    return a;
}

/* Whether any of the blocks was asked for by a patch above. */
static bool is_asked(const stp_cut *cut, stp_scene_run run)
{
    uint32_t b = run.begin;
    while (b < run.end && cut->references[b].asked != cut->serial)
        b++;
    return b < run.end;
}

/* The answer about all blocks of a child, if they are out of sight or left to the parent; else
 * WANTED. exact: patches above were asked about each block. */
static stp_cut_answer_kind ask_at_once(const stp_cut *cut, const stp_cut_params *params,
                                       uint32_t child, bool exact)
{
    const stp_chunk_entry *e = &params->scene->entries[child];
    stp_scene_run run = stp_scene_blocks(params->scene, child);
    stp_block whole = stp_block_of_entry(e, child);
    stp_rule_bound bound = stp_cut_bound(&whole, e->origin, params->eye);
    float eye[3];
    bool visible = stp_rule_visible(params->frame, &bound, eye);
    if (visible && is_occluded(params, &whole) && !params->occlusion->asks_only)
        return STP_ANSWER_OCCLUDED;
    stp_rule_sight sight = stp_rule_look(params->frame, &bound);
    if (visible && (exact ? is_asked(cut, run)
                          : is_wanted(params->frame, &sight, &whole, was_drawn(params, run))))
        return STP_ANSWER_WANTED;
    return visible ? STP_ANSWER_LEFT : STP_ANSWER_HIDDEN;
}

/* Fetches what the next answers read, while this one is found: blocks lie apart in memory. left:
 * the blocks of the child that follow. */
static void prefetch(const stp_cut *cut, const stp_cut_params *params, stp_scene_run left,
                     bool exact)
{
    bool next = true;
    for (uint32_t b = left.begin; b < left.end; b++) {
        if (exact && cut->references[b].asked != cut->serial)
            continue;
        params->source.prefetch(params->source.context, b, next);
        if (!next)
            return;
        next = false;
    }
}

void stp_cut_ask_child(stp_cut *cut, const stp_cut_params *params, stp_cut_child *child)
{
    stp_scene_run run = stp_scene_blocks(params->scene, child->chunk);
    bool several = run.end - run.begin > 1;
    child->together = several && params->scene->undivided[child->chunk];
    bool exact = child->exact && !child->together;
    child->all = several ? ask_at_once(cut, params, child->chunk, exact) : STP_ANSWER_WANTED;
    for (uint32_t b = run.begin; b < run.end && child->all == STP_ANSWER_WANTED; b++) {
        if (params->source.prefetch != NULL && (!exact || cut->references[b].asked == cut->serial))
            prefetch(cut, params, (stp_scene_run){b + 1, run.end}, exact);
        cut->answers[b] = ask_block(cut, params, child, b, exact, child->together);
    }
}
