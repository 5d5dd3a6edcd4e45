/* Asks all patches of a block for their levels. */
#include "runtime/cut/need.h"

#include "runtime/cut/culling.h"

/* Bytes of a line of a processor's cache. */
#define LINE_BYTES 64

void stp_block_prefetch(const stp_resident *resident, bool next)
{
    const char *memory = next ? (const char *)resident->mirror.briefs : (const char *)resident;
    const size_t bytes = next ? resident->placement.patches.count * sizeof *resident->mirror.briefs
                              : sizeof *resident;
    for (size_t at = 0; at < bytes; at += LINE_BYTES)
        __builtin_prefetch(memory + at);
}

/* The patches of a block from `first` on that are looked at side by side. */
typedef struct group {
    stp_looks looks;
    stp_gpu_frame room; /* for the next */
    const stp_gpu_frame *openings;
    stp_gpu_chunk chunk;
    uint32_t first, count;
} group;

static void group_begin(group *g, const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                        const stp_resident *resident)
{
    g->chunk = stp_scene_record(scene, resident->block, 0, eye);
    g->openings = stp_culling_narrow(&g->room, frame, scene, resident->block, eye, NULL);
    g->first = g->count = 0;
}

/* Looks at the next patches of a block; false if there are none. */
static bool look_at_next(group *g, const stp_gpu_frame *frame, const stp_resident *resident)
{
    const uint32_t patches = resident->placement.patches.count;
    g->first += g->count;
    g->count = patches - g->first < STP_LOOKS_LIMIT ? patches - g->first : STP_LOOKS_LIMIT;
    if (g->count > 0)
        stp_patches_look(&g->looks, frame, g->openings, &g->chunk,
                         &resident->mirror.briefs[g->first], g->count);
    return g->count > 0;
}

/* Whether patch i of the group asks for no more than is there, as its brief alone tells: the patch
 * vertex does, or level 2. */
static bool asks_nothing(const group *g, const stp_resident *resident, uint32_t i)
{
    return g->looks.vertex[i] || (g->looks.quarters[i] &&
                                  resident->mirror.briefs[g->first + i].finest <= STP_NEED_HEADERS);
}

/* Fetches the records of the patches that may ask for something. */
static void prefetch_patches(const group *g, const stp_resident *resident)
{
    for (uint32_t i = 0; i < g->count; i++) {
        const stp_mirror_patch *patch = &resident->mirror.patches[g->first + i];
        if (!g->looks.visible[i] || asks_nothing(g, resident, i))
            continue;
        __builtin_prefetch(&patch->finest);
        __builtin_prefetch(&patch->quarter_error[1]);
    }
}

/* Whether an earlier picture hides patch i of the group. */
static bool is_hidden(const group *g, const stp_occlusion *occlusion, const stp_resident *resident,
                      uint32_t i)
{
    if (occlusion == NULL)
        return false;
    const stp_rule_bound b = stp_patch_bound(&resident->mirror.briefs[g->first + i], &g->chunk);
    return stp_occlusion_hides(occlusion, b.centre, b.radius);
}

/* The finest level that a patch in sight may ask for. It is left to the block below if none of its
 * levels does. */
static int finest_of(const stp_gpu_frame *frame, const stp_resident *resident, uint32_t patch,
                     const stp_rule_sight *sight, const stp_need_below *below)
{
    const uint32_t block = resident->mirror.briefs[patch].block;
    if (block == STP_BLOCK_NONE || stp_levels_do(frame, sight, &resident->mirror.patches[patch], 0))
        return 0;
    return below->level(below->context, block);
}

int stp_block_need(const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                   const stp_occlusion *occlusion, const stp_resident *resident, int estimate,
                   const stp_need_below *below, bool *lacks)
{
    const bool linked = (stp_scene_entry(scene, resident->block)->flags & STP_CHUNK_LINKED) != 0;
    int need = STP_NEED_HEADERS;
    group g;
    *lacks = false;
    group_begin(&g, scene, frame, eye, resident);
    while (look_at_next(&g, frame, resident)) {
        prefetch_patches(&g, resident);
        for (uint32_t i = 0; i < g.count; i++) {
            const stp_mirror_patch *patch = &resident->mirror.patches[g.first + i];
            if (!g.looks.visible[i] || asks_nothing(&g, resident, i) ||
                (need <= estimate && resident->mirror.briefs[g.first + i].finest <= estimate) ||
                is_hidden(&g, occlusion, resident, i))
                continue;
            const stp_rule_sight sight = stp_looks_sight(&g.looks, frame, i);
            const int finest = linked ? finest_of(frame, resident, g.first + i, &sight, below) : 0;
            if (finest >= STP_NEED_HEADERS)
                continue;
            const int asked =
                stp_level_asked_seen(frame, &sight, patch, finest > estimate ? finest : estimate);
            need = asked < need ? asked : need;
            *lacks |= asked < patch->finest;
        }
    }
    return need;
}

void stp_block_refer(const stp_scene *scene, const stp_gpu_frame *frame, stp_dvec3 eye,
                     const stp_occlusion *occlusion, const stp_resident *resident,
                     void (*refer)(void *context, uint32_t below, bool coarse), void *context)
{
    group g;
    group_begin(&g, scene, frame, eye, resident);
    while (look_at_next(&g, frame, resident)) {
        prefetch_patches(&g, resident);
        for (uint32_t i = 0; i < g.count; i++) {
            const uint32_t block = resident->mirror.briefs[g.first + i].block;
            if (block == STP_BLOCK_NONE || !g.looks.visible[i])
                continue;
            const bool hidden = is_hidden(&g, occlusion, resident, i);
            if (hidden && !occlusion->asks_only)
                continue;
            const stp_rule_sight sight = stp_looks_sight(&g.looks, frame, i);
            refer(context, block,
                  !hidden &&
                      !stp_levels_do(frame, &sight, &resident->mirror.patches[g.first + i], 0));
        }
    }
}
