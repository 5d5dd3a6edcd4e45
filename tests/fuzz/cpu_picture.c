/* Draws a chunk file's picture on the CPU: model, cut, sight, levels, discs, pyramid. */
#include "tests/fuzz/cpu_picture.h"

#include "runtime/cut/culling.h"
#include "runtime/cut/sight.h"
#include "tests/fixtures/drawn_discs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define SIZE_PX 48
#define TILES (SIZE_PX / STP_TILE_PX)

/* Replaces the renderer's cache, which needs a GPU, by blocks read from the file. */
struct stp_block_cache {
    stp_resident *residents; /* by block; a damaged block has no patches */
    stp_chunk **chunks;      /* decoded blocks */
};

uint32_t stp_block_cache_slot(const stp_block_cache *cache, uint32_t block)
{
    (void)cache;
    return block;
}

const stp_resident *stp_block_cache_get(const stp_block_cache *cache, uint32_t slot)
{
    return &cache->residents[slot];
}

typedef struct picture {
    stp_model *model;
    stp_scene scene;
    stp_block_cache cache;
    stp_view view;
    stp_gpu_frame frame;
    stp_cut cut;
    stp_sight sight;
    reference_disc_list discs;
    reference_pyramid pyramid;
} picture;

static void require(bool truth, const char *what)
{
    if (!truth) {
        fprintf(stderr, "broken: %s\n", what);
        abort();
    }
}

static void *allocate(size_t count, size_t size)
{
    void *out = calloc(count, size);
    require(out != NULL, "there is memory");
    return out;
}

/* ---- blocks ---- */

static void read_block(picture *p, uint32_t id)
{
    stp_chunk *chunk = NULL;
    const stp_block *block = &p->model->blocks[id];
    uint32_t bytes = stp_block_payload_bytes(block, 0);
    uint8_t *payload = allocate(bytes + 1u, 1);
    stp_status status = stp_block_fetch(p->model->file, block, 0, bytes, payload, NULL);
    if (status == STP_OK)
        status = stp_block_decode(p->model->file, block, 0, payload, NULL, &chunk, NULL);
    free(payload);
    if (status != STP_OK)
        return;
    stp_resident *r = &p->cache.residents[id];
    p->cache.chunks[id] = chunk;
    r->placement.patches.count = chunk->patch_count;
    r->mirror.patches = allocate(chunk->patch_count, sizeof *r->mirror.patches);
    r->mirror.briefs = allocate(chunk->patch_count, sizeof *r->mirror.briefs);
    stp_mirror_patches_fill(r->mirror.patches, chunk, &r->placement, stp_scene_shapes(&p->scene));
    for (uint32_t i = 0; i < chunk->patch_count; i++)
        r->mirror.briefs[i] =
            stp_patch_brief_of(&p->scene, block->chunk, &r->mirror.patches[i], &chunk->patches[i]);
}

static void read_blocks(picture *p)
{
    p->cache.residents = allocate(p->scene.block_count, sizeof *p->cache.residents);
    p->cache.chunks = allocate(p->scene.block_count, sizeof *p->cache.chunks);
    for (uint32_t id = 0; id < p->scene.block_count; id++)
        read_block(p, id);
}

static void free_blocks(picture *p)
{
    for (uint32_t id = 0; p->cache.chunks != NULL && id < p->scene.block_count; id++) {
        stp_mirror_clear(&p->cache.residents[id].mirror);
        stp_chunk_destroy(&p->cache.chunks[id]);
    }
    free(p->cache.residents);
    free(p->cache.chunks);
}

/* ---- the cut ---- */

static int available(const void *context, uint32_t block)
{
    const picture *p = context;
    return p->cache.chunks[block] != NULL ? 0 : STP_CUT_NEVER;
}

/* Chooses the view that `render` begins with, or one from inside the model. */
static bool choose_view(picture *p, uint64_t choice)
{
    const stp_ball *ball = &p->model->ball;
    stp_camera camera =
        stp_model_camera(p->model, choice & 1u ? STP_HOME_FIRST : STP_HOME_WHOLE, SIZE_PX, SIZE_PX);
    if (choice & 2u)
        camera.height = ball->radius;
    if ((choice & 12u) == 12u) {
        camera.look = ball->centre;
        camera.eye =
            stp_dvec3_add(ball->centre, (stp_dvec3){0.1 * ball->radius, 0.1 * ball->radius, 0.0});
        camera.up = (stp_dvec3){0.0, 0.0, 1.0};
    }
    return stp_view_create(&p->view, &camera, ball, SIZE_PX, SIZE_PX, NULL) == STP_OK;
}

static void describe_frame(picture *p, uint64_t choice)
{
    static const float thresholds[] = {0.0f, 0.7f, 2.0f, 12.0f};
    static const stp_cull culls[] = {STP_CULL_AUTO, STP_CULL_NONE, STP_CULL_BACK, STP_CULL_AUTO};
    const stp_draw_params params = {.cull = culls[choice >> 6 & 3u]};
    const float threshold = thresholds[choice >> 4 & 3u];
    p->frame = stp_gpu_frame_from_view(&p->view);
    p->frame.quality[0] = threshold;
    p->frame.quality[1] = (float)STP_RADIUS_CAP_PX * fmaxf(1.0f, threshold * threshold);
    p->frame.terms[0] = STP_COLOUR_WEIGHT;
    p->frame.terms[1] = STP_SILHOUETTE_WEIGHT;
    stp_culling_place(&p->frame, &params, &p->view, &p->scene);
}

static void append_draw(picture *p, const stp_sight_params *looked, const stp_draw *draw,
                        bool splat)
{
    const stp_chunk_entry *entry = stp_scene_entry(&p->scene, draw->block);
    const stp_chunk *chunk = p->cache.chunks[draw->block];
    const stp_resident *r = &p->cache.residents[draw->block];
    const stp_gpu_chunk record = stp_gpu_chunk_from_draw(&p->scene, draw, p->view.eye);
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        if (!stp_patch_in_sight(&p->sight, looked, draw, r->mirror.briefs, i))
            continue;
        const drawn_patch drawn = {entry, chunk, i, &r->mirror.patches[i],
                                   stp_levels_choose(&p->frame, &record, &r->mirror.patches[i])};
        require(drawn_append(&drawn, &p->view, &p->frame, splat, &p->discs, NULL) == STP_OK,
                "discs have room");
    }
}

static void select_discs(picture *p, stp_pool *pool, bool splat)
{
    uint8_t marks[TILES * TILES] = {0};
    stp_tiles tiles = {.width = SIZE_PX,
                       .height = SIZE_PX,
                       .columns = TILES,
                       .rows = TILES,
                       .count = TILES * TILES,
                       .marks = marks,
                       .workers = 1};
    const stp_cut_params params = {.scene = &p->scene,
                                   .frame = &p->frame,
                                   .eye = p->view.eye,
                                   .source = {.context = p, .available = available}};
    const stp_sight_params looked = {.scene = &p->scene,
                                     .cache = &p->cache,
                                     .frame = &p->frame,
                                     .eye = p->view.eye,
                                     .pool = pool,
                                     .tiles = &tiles};
    require(stp_cut_select(&p->cut, &params, NULL) == STP_OK, "a cut is selected");
    require(stp_sight_begin(&p->sight, &p->cut, NULL) == STP_OK, "patches are looked at");
    require(stp_sight_look(&p->sight, &looked, p->cut.draws, p->cut.draw_count, NULL) == STP_OK,
            "patches are looked at");
    for (size_t i = 0; i < p->cut.draw_count; i++)
        append_draw(p, &looked, &p->cut.draws[i], splat);
}

/* ---- the picture ---- */

/* Projects the discs that are present for sure, or almost. */
static void project(picture *p)
{
    for (size_t i = 0; i < p->discs.count; i++)
        if (p->discs.items[i].presence != REFERENCE_MISSING)
            reference_project(&p->pyramid, &p->discs.items[i], 1);
}

/* Samples of an unsound file may lie farther away than floats can square. Their colours mean
 * nothing then. */
static void require_finite(const reference_pixel *pixels, int count, bool sound)
{
    for (int i = 0; i < count; i++) {
        const reference_pixel *pixel = &pixels[i];
        if (pixel->tag == 0)
            continue;
        require(isfinite(pixel->z_min) && isfinite(pixel->z_max), "a pixel's depths are finite");
        require(isfinite(pixel->radius) && isfinite(pixel->dx) && isfinite(pixel->dy),
                "a pixel's place and radius are finite");
        require(stp_dvec3_finite(pixel->normal), "a pixel's normal is finite");
        for (int k = 0; k < 3; k++)
            require(!sound || (pixel->rgb[k] >= -1e-9 && pixel->rgb[k] <= 1.0 + 1e-9),
                    "a pixel's colour is within 0 to 1");
    }
}

static void reconstruct(picture *p, reference_filter filter, bool sound)
{
    int levels = reference_level_count(p->sight.radius_px, SIZE_PX, SIZE_PX);
    require(reference_create(&p->pyramid, &p->view, filter, levels, NULL) == STP_OK,
            "a pyramid has room");
    if (filter == REFERENCE_SPLAT) {
        require(reference_splat(&p->pyramid, p->discs.items, p->discs.count, NULL) == STP_OK,
                "splats have room");
    } else {
        project(p);
        reference_pull(&p->pyramid);
        reference_push(&p->pyramid);
    }
    for (int l = 0; l <= (filter == REFERENCE_SPLAT ? 0 : levels); l++) {
        const reference_level *level = &p->pyramid.levels[l];
        require_finite(level->pulled, level->width * level->height, sound);
        require_finite(level->finished, level->width * level->height, sound);
    }
}

static void require_finite_picture(const picture *p, reference_shade shade, bool sound)
{
    static double rgba[4 * SIZE_PX * SIZE_PX];
    reference_shade_picture(&p->pyramid, shade, rgba);
    for (int i = 0; i < 4 * SIZE_PX * SIZE_PX; i++)
        require(!sound || (rgba[i] >= 0.0 && rgba[i] <= 1.0), "a colour is within 0 to 1");
}

static bool has_root(const picture *p)
{
    bool all = true;
    for (uint32_t i = 0; i < p->scene.first_block[1]; i++)
        all &= p->cache.chunks[i] != NULL;
    return all;
}

void cpu_picture_draw(const char *path, uint64_t choice, bool sound, stp_pool *pool)
{
    static const reference_filter filters[] = {REFERENCE_GAUSS, REFERENCE_BOX, REFERENCE_GAUSS,
                                               REFERENCE_SPLAT};
    picture p = {0};
    stp_status status = stp_model_open(&p.model, path, NULL);
    require(status == STP_OK || !sound, "a sound file is opened for drawing");
    if (status != STP_OK)
        return;
    const stp_model *models[] = {p.model};
    require(stp_scene_create(&p.scene, models, 1, NULL) == STP_OK, "a scene has room");
    read_blocks(&p);
    bool seen = choose_view(&p, choice);
    require(seen || !sound, "a sound file has a view");
    if (seen && has_root(&p)) { /* without its root no file is drawn */
        const reference_filter filter = filters[choice >> 8 & 3u];
        describe_frame(&p, choice);
        select_discs(&p, pool, filter == REFERENCE_SPLAT);
        reconstruct(&p, filter, sound);
        require_finite_picture(&p, (reference_shade)((choice >> 10) % (REFERENCE_DEPTH + 1)),
                               sound);
    }
    reference_destroy(&p.pyramid);
    reference_disc_list_clear(&p.discs);
    stp_sight_destroy(&p.sight);
    stp_cut_destroy(&p.cut);
    free_blocks(&p);
    stp_scene_destroy(&p.scene);
    stp_model_close(&p.model);
}
