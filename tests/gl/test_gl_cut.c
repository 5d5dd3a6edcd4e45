/* Tests the cut and the patches in sight on trees made by hand, with several blocks a chunk. For
 * any blocks that are there, missing or damaged, each part of the surface is drawn exactly once: by
 * a leaf's patch or by one patch above it. What is asked for makes the cut complete. */
#include "runtime/cut/need.h"
#include "tests/fixtures/made_scene.h"

enum { VIEWS = 200, TREES = 6 };

/* ---- views ---- */

static int available(const void *context, uint32_t block)
{
    return ((const made_scene *)context)->available[block];
}

static const stp_resident *resident(const void *context, uint32_t block)
{
    return &((const made_scene *)context)->cache.residents[block];
}

/* Whatever the number of threads, the cut must be the same: with patches that tell what is needed,
 * and without. */
static void check_threads(made_scene *s, stp_cut_params params, stp_pool *pool)
{
    static stp_cut cuts[2];
    for (int told = 0; told < 2; told++) {
        params.source.resident = told ? resident : NULL;
        for (int i = 0; i < 2; i++) {
            params.pool = i == 0 ? NULL : pool;
            check_ok(stp_cut_select(&cuts[i], &params, err));
        }
        assert_int_equal(cuts[0].draw_count, cuts[1].draw_count);
        assert_int_equal(cuts[0].miss_count, cuts[1].miss_count);
        assert_int_equal(cuts[0].passed_count, cuts[1].passed_count);
        assert_int_equal(cuts[0].link_count, cuts[1].link_count);
        for (size_t i = 0; i < cuts[0].draw_count; i++) {
            assert_int_equal(cuts[0].draws[i].block, cuts[1].draws[i].block);
            assert_int_equal(cuts[0].draws[i].finest, cuts[1].draws[i].finest);
        }
        for (size_t i = 0; i < cuts[0].miss_count; i++)
            assert_int_equal(cuts[0].misses[i].block, cuts[1].misses[i].block);
        for (uint32_t b = 0; b < s->scene.block_count; b++)
            assert_int_equal(cuts[0].blocks[b].state, cuts[1].blocks[b].state);
    }
    stp_cut_destroy(&cuts[0]);
    stp_cut_destroy(&cuts[1]);
}

typedef const stp_resident *patches_of(const void *context, uint32_t block);

/* of: NULL, or tells the patches that say which blocks they need. */
static void select_by(made_scene *s, patches_of *of)
{
    const stp_cut_params params = {.scene = &s->scene,
                                   .frame = &s->frame,
                                   .eye = s->eye,
                                   .source = {s, available, NULL, of, NULL, NULL}};
    if (s->cut.serial % 4 == 0)
        check_threads(s, params, s->threads);
    check_ok(stp_cut_select(&s->cut, &params, err));
    check_ok(stp_sight_begin(&s->sight, &s->cut, err));
    check_ok(stp_sight_look(&s->sight, &s->looked, s->cut.draws, s->cut.draw_count, err));
}

static void select_all(made_scene *s, stp_pool *pool)
{
    s->tiles = (stp_tiles){.width = SIZE,
                           .height = SIZE,
                           .columns = TILES,
                           .rows = TILES,
                           .count = TILES * TILES,
                           .marks = s->marks,
                           .workers = 1};
    s->looked = (stp_sight_params){.scene = &s->scene,
                                   .cache = &s->cache,
                                   .frame = &s->frame,
                                   .eye = s->eye,
                                   .pool = pool,
                                   .tiles = &s->tiles};
    select_by(s, NULL);
}

static void take_view(made_scene *s)
{
    stp_view view = check_view(SIZE, SIZE, 300.0, false);
    s->eye = (stp_dvec3){chance(s) * LENGTH, 0.0, exp(chance(s) * log(2000.0))};
    s->frame = stp_gpu_frame_from_view(&view);
    s->frame.quality[0] = chance(s) < 0.2 ? 0.0f : (float)exp2(3.0 * chance(s) - 1.0);
    s->frame.quality[1] = chance(s) < 0.5 ? INFINITY : s->frame.quality[0];
    s->frame.terms[1] = 1.0f;
}

/* Whether a block's patch is drawn by the block; by_block: the draws, by block, 0 for none. */
static bool draws(const made_scene *s, const size_t *by_block, int model, uint32_t chunk,
                  uint32_t patch)
{
    const made_model *m = &s->models[model];
    uint32_t block = m->first_block[chunk];
    while (patch - m->blocks[block].first_patch >= m->blocks[block].patch_count)
        block++;
    uint32_t number = s->scene.models[model].first_block + block;
    return by_block[number] > 0 &&
           stp_patch_in_sight(&s->sight, &s->looked, &s->cut.draws[by_block[number] - 1],
                              s->cache.residents[number].mirror.briefs,
                              patch - m->blocks[block].first_patch);
}

/* Checks that each unit of the line is drawn once if its middle is in the picture, and at most once
 * otherwise. Returns how many are drawn by leaves. */
static size_t check_once(const made_scene *s, size_t *in_picture)
{
    static size_t by_block[BLOCKS_LIMIT];
    size_t by_leaves = 0;
    memset(by_block, 0, sizeof by_block);
    for (size_t i = 0; i < s->cut.draw_count; i++)
        by_block[s->cut.draws[i].block] = i + 1;
    for (int model = 0; model < MODELS; model++)
        for (uint32_t at = 0; at < LENGTH; at++) {
            unsigned times = 0;
            uint32_t chunk = FIRST_LEAF + at / PATCHES, patch = at % PATCHES;
            const stp_rule_bound middle = {
                .centre = {(float)(at + 0.5 - s->eye.x), 0.0f, (float)-s->eye.z},
                .cone_cos = -1.0f};
            float eye[3];
            bool visible = stp_rule_visible(&s->frame, &middle, eye);
            by_leaves += visible && draws(s, by_block, model, chunk, patch);
            *in_picture += visible;
            for (; chunk != STP_CHUNK_NONE; chunk = s->models[model].entries[chunk].parent) {
                times += draws(s, by_block, model, chunk, patch);
                patch = s->models[model].above[chunk][patch];
            }
            if (times > 1 || (times == 0 && visible))
                fail_msg("unit %u of model %d is drawn %u times", at, model, times);
        }
    return by_leaves;
}

/* A missing block gains less than the missing blocks whose patches refer to it. */
static void check_order(const made_scene *s)
{
    static float gains[BLOCKS_LIMIT];
    memset(gains, 0, sizeof gains);
    for (size_t i = 0; i < s->cut.miss_count; i++)
        gains[s->cut.misses[i].block] = s->cut.misses[i].gain;
    for (uint32_t b = 0; b < s->scene.block_count; b++) {
        const stp_resident *r = &s->cache.residents[b];
        for (uint32_t p = 0; p < r->placement.patches.count; p++) {
            uint32_t below = r->mirror.briefs[p].block;
            if (below != STP_BLOCK_NONE && gains[b] > 0.0f && gains[below] > 0.0f &&
                s->available[b] >= STP_LEVEL_COUNT)
                assert_true(s->available[b] == STP_CUT_NEVER || gains[below] < gains[b]);
        }
    }
}

/* The finest level that the block's patches are drawn at, up to what is read with headers. */
static int finest_drawn(const made_scene *s, const stp_draw *draw)
{
    const stp_resident *r = &s->cache.residents[draw->block];
    const stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(&s->scene, draw, s->eye);
    int finest = STP_NEED_HEADERS;
    for (uint32_t p = 0; p < r->placement.patches.count; p++) {
        if (!stp_patch_in_sight(&s->sight, &s->looked, draw, r->mirror.briefs, p))
            continue;
        const stp_levels levels = stp_levels_choose(&s->frame, &chunk, &r->mirror.patches[p]);
        for (int q = 0; q < STP_PATCH_QUARTERS; q++)
            if (levels.of[q] != STP_LEVEL_SKIP && levels.of[q] < finest)
                finest = levels.of[q];
    }
    return finest;
}

/* context: the level. */
static int level_above(const void *context, uint32_t block)
{
    (void)block;
    return *(const int *)context;
}

/* What a block needs. It lacks nothing if it is there; if only its headers are there of each patch,
 * it lacks whatever it needs. */
static int need_of(made_scene *s, const stp_draw *draw, const stp_need_below *below)
{
    const stp_resident *r = &s->cache.residents[draw->block];
    int need[2];
    bool lacks[2];
    for (int k = 0; k < 2; k++) {
        for (uint32_t p = 0; p < r->placement.patches.count; p++)
            r->mirror.patches[p].finest = k == 0 ? 0 : STP_NEED_HEADERS;
        need[k] =
            stp_block_need(&s->scene, &s->frame, s->eye, NULL, r, draw->finest, below, &lacks[k]);
    }
    for (uint32_t p = 0; p < r->placement.patches.count; p++)
        r->mirror.patches[p].finest = 0;
    assert_int_equal(need[0], need[1]);
    assert_false(lacks[0]);
    assert_int_equal(lacks[1], need[1] < STP_NEED_HEADERS);
    return need[0];
}

/* Whether patch p of a draw is in sight, and if so its levels; else all 0. */
static stp_levels levels_drawn(const made_scene *s, const stp_draw *draw, uint32_t p)
{
    const stp_mirror *mirror = &s->cache.residents[draw->block].mirror;
    const stp_gpu_chunk chunk = stp_gpu_chunk_from_draw(&s->scene, draw, s->eye);
    return stp_patch_in_sight(&s->sight, &s->looked, draw, mirror->briefs, p)
               ? stp_levels_choose(&s->frame, &chunk, &mirror->patches[p])
               : (stp_levels){0};
}

/* Draws no more of each block than it needs: the picture is that of blocks that are there as a
 * whole. */
static void check_drawn(made_scene *s, const stp_draw *needed)
{
    static stp_levels expected[BLOCKS_LIMIT][PATCHES];
    for (int k = 0; k < 2; k++) {
        const stp_draw *draws = k == 0 ? s->cut.draws : needed;
        check_ok(stp_sight_begin(&s->sight, &s->cut, err));
        check_ok(stp_sight_look(&s->sight, &s->looked, draws, s->cut.draw_count, err));
        for (size_t i = 0; i < s->cut.draw_count; i++)
            for (uint32_t p = 0; p < s->scene.blocks[draws[i].block].patch_count; p++) {
                const stp_levels levels = levels_drawn(s, &draws[i], p);
                if (k == 0)
                    expected[i][p] = levels;
                assert_memory_equal(&levels, &expected[i][p], sizeof levels);
            }
    }
}

/* All blocks are there, and patches say which blocks below they need. Each block is asked for no
 * coarser level than its patches are drawn at. Returns how many would be asked for a finer one if
 * the blocks below did not come. While those are on their way, a block is asked for just so much of
 * that as patches may ask for meanwhile. */
static size_t check_needs(made_scene *s)
{
    static const int levels[3] = {STP_NEED_HEADERS, 0, STP_NEED_MEANWHILE};
    static stp_draw needed[BLOCKS_LIMIT];
    size_t less = 0;
    if (s->frame.quality[0] <= 0.0f)
        return 0;
    select_by(s, resident);
    for (size_t i = 0; i < s->cut.draw_count; i++) {
        const stp_draw *draw = &s->cut.draws[i];
        int need[3];
        for (int k = 0; k < 3; k++)
            need[k] = need_of(s, draw, &(stp_need_below){level_above, &levels[k]});
        assert_true(need[1] <= need[0] && need[0] <= finest_drawn(s, draw));
        const int most = need[1] > STP_NEED_MEANWHILE ? need[1] : STP_NEED_MEANWHILE;
        assert_int_equal(need[2], need[0] < most ? need[0] : most);
        less += need[1] < need[0];
        needed[i] = *draw;
        needed[i].finest = need[0];
    }
    check_drawn(s, needed);
    return less;
}

/* ---- tests ---- */

/* Gives what is missing, the most wanted first, some at a time, until nothing is. */
static void complete(made_scene *s, stp_pool *pool)
{
    for (size_t rounds = 0; s->cut.miss_count > 0; rounds++) {
        size_t some = 1 + s->cut.miss_count / 4, seen = 0;
        assert_true(rounds < BLOCKS_LIMIT);
        check_order(s);
        for (size_t i = 0; i < some; i++)
            s->available[s->cut.misses[i].block] = s->cut.misses[i].finest;
        select_all(s, pool);
        check_once(s, &seen);
    }
}

/* Blocks come until nothing is missing; the cut is then that of a renderer that has them all. */
static void compare_complete(made_scene *s, stp_pool *pool)
{
    for (uint32_t b = 0; b < s->scene.block_count; b++)
        s->available[b] = STP_LEVEL_COUNT;
    select_all(s, pool);
    complete(s, pool);
    size_t count = s->cut.draw_count;
    stp_draw *drawn = calloc(count + 1, sizeof *drawn);
    assert_non_null(drawn);
    memcpy(drawn, s->cut.draws, count * sizeof *drawn);
    memset(s->available, 0, sizeof s->available);
    select_all(s, pool);
    assert_int_equal(s->cut.miss_count, 0);
    assert_int_equal(s->cut.draw_count, count);
    for (size_t i = 0; i < count; i++)
        assert_true(drawn[i].block == s->cut.draws[i].block &&
                    drawn[i].finest == s->cut.draws[i].finest);
    free(drawn);
}

static void judge(double unlinked, double cuts, uint64_t seed)
{
    stp_pool *pool = NULL;
    size_t seen = 0, by_leaves = 0, linked = 0, whole = 0, less = 0;
    made_scene *s = calloc(1, sizeof *s);
    assert_non_null(s);
    check_ok(stp_pool_create(&pool, 1, err));
    check_ok(stp_pool_create(&s->threads, 3, err));
    s->seed = seed;
    make_scene(s, unlinked, cuts);
    for (int v = 0; v < VIEWS; v++) {
        double there = sqrt(chance(s)), damaged = v % 2 == 0 ? 0.0 : 0.05;
        take_view(s);
        for (uint32_t b = 0; b < s->scene.block_count; b++)
            s->available[b] = chance(s) < damaged ? STP_CUT_NEVER
                              : chance(s) < there ? (int)any_below(s, 3)
                                                  : STP_LEVEL_COUNT;
        select_all(s, pool);
        by_leaves += check_once(s, &seen);
        check_order(s);
        for (size_t i = 0; i < s->cut.draw_count; i++)
            *(s->cut.blocks[s->cut.draws[i].block].state >= STP_CUT_LINKED ? &linked : &whole) += 1;
        compare_complete(s, pool);
        less += check_needs(s);
        size_t in_picture = 0, leaves = check_once(s, &in_picture);
        if (s->frame.quality[0] <= 0.0f)
            assert_int_equal(leaves, in_picture);
    }
    print_message("%u blocks: %zu units seen, %zu drawn by leaves, %zu draws linked, %zu whole\n",
                  s->scene.block_count, seen, by_leaves, linked, whole);
    assert_true(seen > 1000 && by_leaves > 100 && whole > 10);
    assert_true(unlinked > 0.0 || (linked > 100 && less > 100));
    stp_cut_destroy(&s->cut);
    stp_sight_destroy(&s->sight);
    stp_scene_destroy(&s->scene);
    stp_pool_destroy(&pool);
    stp_pool_destroy(&s->threads);
    free(s);
}

static void single_blocks(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < TREES; i++)
        judge(i < TREES / 2 ? 0.0 : 0.1, 0.0, i);
}

static void several_blocks(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < TREES; i++)
        judge(0.0, 0.2 + 0.8 * (double)i / TREES, 100 + i);
}

static void unlinked_chunks(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < TREES; i++)
        judge(i % 2 == 0 ? 0.03 : 0.3, 0.4, 200 + i);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(single_blocks),
        cmocka_unit_test(several_blocks),
        cmocka_unit_test(unlinked_chunks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
