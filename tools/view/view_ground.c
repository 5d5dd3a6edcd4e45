/* Finds the ground in the chunk tree. */
#include "tools/view/view_ground.h"

/* If samples of a chunk are this much finer than the reach, the chunk is fine enough. */
#define FINE_ENOUGH 0.5

/* State of one search. */
typedef struct search {
    view_ground *ground;
    const view_ground_params *params;
    unsigned reads_left;
    double height, below; /* of the best so far; higher than `below` is no ground */
    bool found;
} search;

static stp_chunk *find(search *s, uint32_t id)
{
    for (int i = 0; i < VIEW_GROUND_CHUNKS; i++) {
        view_ground_chunk *c = &s->ground->chunks[i];
        if (c->chunk != NULL && c->model == s->params->model && c->chunk->id == id) {
            c->used = s->ground->calls;
            return c->chunk;
        }
    }
    return NULL;
}

/* Gets a kept chunk or reads it now; NULL if neither is possible. */
static stp_chunk *get(search *s, uint32_t id)
{
    stp_chunk *chunk = find(s, id);
    view_ground_chunk *oldest = &s->ground->chunks[0];
    if (chunk != NULL || s->reads_left == 0)
        return chunk;
    for (int i = 1; i < VIEW_GROUND_CHUNKS; i++)
        if (s->ground->chunks[i].used < oldest->used)
            oldest = &s->ground->chunks[i];
    if (oldest->chunk != NULL && oldest->used == s->ground->calls)
        return NULL; /* all kept chunks are in use in this search */
    s->reads_left--;
    if (stp_chunk_file_read(s->params->model->file, id, 0, &chunk, NULL) != STP_OK)
        return NULL;
    stp_chunk_destroy(&oldest->chunk);
    *oldest = (view_ground_chunk){s->params->model, chunk, s->ground->calls};
    return chunk;
}

/* The squared distance of a position from the line down, and its height. */
static double from_line(const search *s, stp_dvec3 position, double *height)
{
    stp_dvec3 d = stp_dvec3_sub(position, s->params->position);
    double along = stp_dvec3_dot(d, s->params->up);
    *height = stp_dvec3_dot(position, s->params->up);
    return fmax(0.0, stp_dvec3_dot(d, d) - along * along);
}

static void scan(search *s, const stp_chunk *chunk, stp_dvec3 origin)
{
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            stp_dvec3 at = stp_sample_position(&chunk->samples[0][i], &chunk->patches[p]);
            double height = 0.0, reach = s->params->reach;
            if (from_line(s, stp_dvec3_add(origin, at), &height) > reach * reach)
                continue;
            if (height > s->below || (s->found && height <= s->height))
                continue;
            s->height = height;
            s->found = true;
        }
}

/* True if samples of the chunk may be near the line, judged by the ball around its box. */
static bool near_line(const search *s, const stp_chunk_entry *e)
{
    stp_dvec3 low = stp_dvec3_from_float(e->box_min), high = stp_dvec3_from_float(e->box_max);
    stp_dvec3 middle = stp_dvec3_add(e->origin, stp_dvec3_scale(stp_dvec3_add(low, high), 0.5));
    double radius = 0.5 * stp_dvec3_length(stp_dvec3_sub(high, low)) + s->params->reach;
    double height = 0.0;
    return from_line(s, middle, &height) <= radius * radius && height - radius <= s->below;
}

static void visit(search *s, uint32_t id, const stp_chunk *chunk)
{
    const stp_model *model = s->params->model;
    const stp_chunk_entry *e = &model->entries[id];
    bool fine = (double)e->radius_min <= FINE_ENOUGH * s->params->reach;
    bool covered = !fine && e->first_child != STP_CHUNK_NONE;
    for (uint32_t i = 0; covered && i < e->child_count; i++)
        covered = !near_line(s, &model->entries[e->first_child + i]) ||
                  get(s, e->first_child + i) != NULL;
    if (!covered) {
        scan(s, chunk, e->origin);
        return;
    }
    for (uint32_t i = 0; i < e->child_count; i++) {
        const stp_chunk *child = find(s, e->first_child + i);
        if (child != NULL && near_line(s, &model->entries[e->first_child + i]))
            visit(s, e->first_child + i, child);
    }
}

bool view_ground_find(view_ground *ground, const view_ground_params *params, double *height)
{
    search s = {.ground = ground,
                .params = params,
                .reads_left = 1,
                .below = stp_dvec3_dot(params->position, params->up)};
    ground->calls++;
    const stp_chunk *root = get(&s, 0);
    if (root == NULL)
        return false;
    visit(&s, 0, root);
    if (s.found)
        *height = s.height;
    return s.found;
}

void view_ground_forget(view_ground *ground, const stp_model *model)
{
    for (int i = 0; i < VIEW_GROUND_CHUNKS; i++)
        if (model == NULL || ground->chunks[i].model == model) {
            stp_chunk_destroy(&ground->chunks[i].chunk);
            ground->chunks[i] = (view_ground_chunk){0};
        }
}
