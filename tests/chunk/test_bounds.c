/* Tests perpendicular errors, level by level up the tree, against the original points. No disc
 * under a merged disc may reach farther over or under its plane than the stored error, and the
 * stored error is hardly larger than the true one. */
#include "base/sort.h"
#include "formats/chunk/measure/patch_bounds.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

typedef struct tree {
    stp_chunk_entry *entries;
    stp_chunk **chunks;
    uint32_t count;
} tree;

/* The plane of a merged sample, in the world; `off` is how far originals reach off it. */
typedef struct plane {
    stp_dvec3 at, normal;
    double off;
} plane;

static tree read_tree(stp_chunk_file *file)
{
    tree t = {.count = stp_chunk_file_get_info(file)->chunk_count};
    t.entries = calloc(t.count, sizeof *t.entries);
    t.chunks = calloc(t.count, sizeof *t.chunks);
    assert_non_null(t.entries);
    assert_non_null(t.chunks);
    for (uint32_t id = 0; id < t.count; id++) {
        check_ok(stp_chunk_file_entry(file, id, &t.entries[id], err));
        check_ok(stp_chunk_file_read(file, id, 0, &t.chunks[id], err));
    }
    return t;
}

static void clear_tree(tree *t)
{
    for (uint32_t id = 0; id < t->count; id++)
        stp_chunk_destroy(&t->chunks[id]);
    free(t->chunks);
    free(t->entries);
}

/* Adds the originals under the level-0 samples [first, last) of a patch. */
static void take_originals(const tree *t, uint32_t id, uint32_t patch, unsigned first,
                           unsigned last, plane *of)
{
    const stp_chunk *chunk = t->chunks[id];
    const stp_patch *p = &chunk->patches[patch];
    for (unsigned i = first; i < last; i++) {
        if (p->child != STP_PATCH_NO_CHILD) {
            uint32_t child = t->entries[id].first_child + p->child, below = p->first_below + i;
            take_originals(t, child, below, 0, t->chunks[child]->patches[below].counts[0], of);
            continue;
        }
        const stp_sample *s = &chunk->samples[0][chunk->level_begin[0][patch] + i];
        stp_disc disc = stp_disc_from_sample(s, p);
        stp_dvec3 centre = stp_dvec3_add(t->entries[id].origin, disc.centre);
        double height = stp_dvec3_dot(stp_dvec3_sub(centre, of->at), of->normal);
        double cosine = stp_dvec3_dot(disc.normal, of->normal);
        double tilt = disc.radius * sqrt(fmax(0.0, 1.0 - cosine * cosine));
        of->off = fmax(of->off, fabs(height) + tilt);
    }
}

/* How far originals reach off the planes of a quarter's discs; at level 3, off the plane of the
 * patch vertex. */
static double off_quarter(const tree *t, uint32_t id, uint32_t patch, int level, unsigned q)
{
    const stp_chunk *chunk = t->chunks[id];
    const stp_patch *p = &chunk->patches[patch];
    unsigned begin = level == 3 ? 0 : stp_quarter_begin(p->counts, level, q);
    unsigned end = level == 3 ? 1 : stp_quarter_begin(p->counts, level, q + 1);
    double off = 0.0;
    for (unsigned i = begin; i < end; i++) {
        const stp_sample *s = &chunk->samples[level][chunk->level_begin[level][patch] + i];
        stp_disc disc = stp_disc_from_sample(s, p);
        plane own = {stp_dvec3_add(t->entries[id].origin, disc.centre), disc.normal, 0.0};
        take_originals(t, id, patch, stp_covered_begin(p->counts, level, i, 0),
                       stp_covered_begin(p->counts, level, i + 1, 0), &own);
        off = fmax(off, own.off);
    }
    return off;
}

/* Writes stored over true error for every quarter of the chunks of one depth; returns how many. */
static size_t judge_depth(const tree *t, unsigned depth, double *ratios)
{
    size_t count = 0;
    for (uint32_t id = 0; id < t->count; id++)
        for (uint32_t k = 0; t->entries[id].depth == depth && k < t->chunks[id]->patch_count; k++)
            for (int level = 1; level < STP_LEVEL_COUNT; level++) {
                const stp_patch *p = &t->chunks[id]->patches[k];
                for (unsigned q = 0; q < (level == 3 ? 1 : p->counts[2]); q++) {
                    double stored = stp_error_held(stp_quarter_error(p, level, q), p);
                    double off = off_quarter(t, id, k, level, q);
                    assert_true(stored >= off);
                    if (off > 0.0)
                        ratios[count++] = stored / off;
                }
            }
    return count;
}

static void judge(const model_recipe *recipe, const char *name, bool noisy)
{
    stp_chunk_file *file = NULL;
    model_fixture_build("bounds.stipple", recipe);
    check_ok(stp_chunk_file_open(&file, "bounds.stipple", err));
    tree t = read_tree(file);
    unsigned depth = stp_chunk_file_get_info(file)->depth;
    double *ratios = calloc(recipe->point_count, sizeof *ratios);
    assert_non_null(ratios);
    assert_true(depth >= 2);
    for (unsigned d = 0; d < depth; d++) {
        size_t count = judge_depth(&t, d, ratios);
        assert_true(count > 20);
        stp_sort_doubles(ratios, count);
        print_message("%s, depth %u: %zu quarters, stored over true %.3f median, %.3f of 90 %%\n",
                      name, d, count, ratios[count / 2], ratios[count * 9 / 10]);
        if (!noisy || d + 1 == depth) /* noise adds up with every chunk on the way to the root */
            assert_true(ratios[count / 2] <= 1.5);
    }
    free(ratios);
    clear_tree(&t);
    stp_chunk_file_close(&file);
}

static void statue(void **state)
{
    (void)state;
    judge(&(model_recipe){.shape = GEN_STATUE, .point_count = 200000}, "statue", false);
}

static void bumpy_with_noise(void **state)
{
    (void)state;
    judge(&(model_recipe){.shape = GEN_BUMPY, .point_count = 200000, .noise_spacings = 0.2},
          "bumpy", true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(statue),
        cmocka_unit_test(bumpy_with_noise),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
