/* Tests that buffers take memory only where they are written: the Object Texture, the upload ring
 * and what the CPU keeps of patches, which have room for a whole model. */
#include "runtime/draw/road.h"
#include "runtime/stream/cache/patch_store.h"
#include "runtime/stream/upload_ring.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <unistd.h>

#define MIB (UINT64_C(1) << 20)
/* What a driver and malloc may take besides. */
#define SLACK_BYTES (8 * MIB)

/* Bytes of main memory that the process has now. */
static uint64_t resident_bytes(void)
{
    unsigned long pages = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%*u %lu", &pages), 1);
    fclose(file);
    return pages * (uint64_t)sysconf(_SC_PAGESIZE);
}

static void skip_without_pinned_memory(void)
{
    if (!epoxy_has_gl_extension("GL_AMD_pinned_memory")) {
        print_message("skipped: this OpenGL has no GL_AMD_pinned_memory\n");
        skip();
    }
}

static void memory_comes_when_written(void **state)
{
    (void)state;
    skip_without_pinned_memory();
    stp_lazy_buffer b;
    uint64_t before = resident_bytes(), word = UINT64_C(0x0123456789abcdef);
    assert_true(stp_lazy_buffer_create(&b, 64 * MIB, true));
    assert_true(resident_bytes() < before + SLACK_BYTES);
    glNamedBufferSubData(b.name, 63 * MIB, sizeof word, &word);
    glFinish();
    assert_memory_equal(b.memory + 63 * MIB, &word, sizeof word);
    memcpy(b.memory + MIB, &word, sizeof word);
    glCopyNamedBufferSubData(b.name, b.name, MIB, 2 * MIB, 2 * sizeof word);
    uint64_t copied[2] = {1, 1};
    glGetNamedBufferSubData(b.name, 2 * MIB, sizeof copied, copied);
    assert_true(copied[0] == word && copied[1] == 0);
    assert_int_equal(glGetError(), GL_NO_ERROR);
    stp_lazy_buffer_destroy(&b);
    assert_true(b.name == 0 && b.memory == NULL);
}

static void gpus_keep_their_own_memory(void **state)
{
    (void)state;
    stp_lazy_buffer b = {.name = 1};
    assert_false(stp_lazy_buffer_create(&b, MIB, false));
    assert_true(b.name == 0 && b.memory == NULL);
}

static void too_much_is_no_error(void **state)
{
    (void)state;
    stp_lazy_buffer b;
    assert_false(stp_lazy_buffer_create(&b, UINT64_C(1) << 60, true));
    assert_int_equal(glGetError(), GL_NO_ERROR);
}

/* The driver's pages hold what is copied into them, across their borders, and no others are needed.
 */
static void pages_hold_copies(void **state)
{
    (void)state;
    static const uint64_t places[] = {0, 4 * MIB - 8, 30 * MIB, 64 * MIB - 8};
    stp_lazy_buffer b;
    GLuint from;
    stp_lazy_buffer_create_pages(&b, 64 * MIB + 8);
    assert_int_equal(b.has_memory != NULL, epoxy_has_gl_extension("GL_ARB_sparse_buffer"));
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        uint64_t words[2] = {UINT64_C(0x0123456789abcdef) + i, ~i}, copied[2] = {0};
        glCreateBuffers(1, &from);
        glNamedBufferStorage(from, sizeof words, words, 0);
        stp_lazy_buffer_fill(&b, places[i], sizeof words);
        glCopyNamedBufferSubData(from, b.name, 0, (GLintptr)places[i], sizeof words);
        stp_lazy_buffer_read(&b, places[i], sizeof copied, copied);
        assert_memory_equal(copied, words, sizeof words);
        glDeleteBuffers(1, &from);
    }
    assert_true(b.has_memory == NULL || !b.has_memory[5]);
    assert_int_equal(glGetError(), GL_NO_ERROR);
    stp_lazy_buffer_destroy(&b);
    assert_true(b.name == 0 && b.has_memory == NULL);
}

static void stream_starts_without_memory(void **state)
{
    (void)state;
    skip_without_pinned_memory();
    stp_object_texture texture;
    stp_upload_ring ring;
    stp_patch_store patches;
    uint64_t before = resident_bytes();
    check_ok(stp_object_texture_create(&texture, 4000000, 100000, 1000, true, err));
    check_ok(stp_patch_store_create(&patches, 100000, err));
    check_ok(stp_upload_ring_create(&ring, 32 * MIB, true, err));
    assert_true(resident_bytes() < before + SLACK_BYTES);
    stp_upload_ring_destroy(&ring);
    stp_patch_store_destroy(&patches);
    stp_object_texture_destroy(&texture);
}

/* Neighbouring ranges meet, the last one ends in the region, and no array overlaps another. */
static void patches_lie_by_number(void **state)
{
    (void)state;
    stp_patch_store store;
    check_ok(stp_patch_store_create(&store, 100, err));
    const stp_mirror a = stp_patch_store_at(&store, (stp_range){0, 60});
    const stp_mirror b = stp_patch_store_at(&store, (stp_range){60, 40});
    assert_ptr_equal(a.briefs + 60, b.briefs);
    assert_ptr_equal(a.records + 60, b.records);
    assert_ptr_equal(a.patches + 60, b.patches);
    assert_int_equal((uintptr_t)b.briefs % sizeof *b.briefs, 0); /* a line of the cache each */
    assert_true((uint8_t *)(b.briefs + 40) <= (uint8_t *)a.records);
    assert_true((uint8_t *)(b.records + 40) <= (uint8_t *)a.patches);
    assert_ptr_equal(b.patches + 40, store.region + store.region_bytes);
    stp_patch_store_destroy(&store);
    assert_null(store.region);
}

/* Thrice as many pieces as may be copied and not free yet, without a fence in between. */
static void pieces_beyond_the_limit_wait(void **state)
{
    (void)state;
    enum { PIECES = 3 * STP_UPLOAD_COPIED_LIMIT };
    stp_upload_ring ring;
    check_ok(stp_upload_ring_create(&ring, PIECES * (uint64_t)STP_UPLOAD_UNIT_BYTES,
                                    stp_road_is_software(), err));
    for (int i = 0; i < PIECES; i++) {
        stp_range piece;
        stp_status status;
        assert_true(stp_upload_ring_take(&ring, 1, &piece, &status, NULL));
        stp_upload_ring_copied(&ring, piece);
        assert_true(ring.copied_count <= STP_UPLOAD_COPIED_LIMIT);
        assert_true(ring.fence_count <= STP_UPLOAD_FENCES_LIMIT);
    }
    stp_upload_ring_fence(&ring);
    while (stp_upload_ring_wait(&ring))
        ;
    assert_int_equal(ring.copied_count, 0);
    stp_upload_ring_destroy(&ring);
}

/* Blocks of 5000 samples, as many as a model of 4 million points has. */
static void software_rings_are_small(void **state)
{
    (void)state;
    static stp_block blocks[1000];
    stp_scene scene = {.blocks = blocks, .block_count = 1000, .chunk_count = 20};
    stp_budget gpu, software, least;
    stp_budget_limits limits = {.texels = STP_NAME_SAMPLE, .decoders = 2};
    for (int i = 0; i < 1000; i++)
        blocks[i] = (stp_block){.patch_count = 80, .sample_count = {4000, 800, 200}};
    check_ok(stp_budget_plan(&gpu, &scene, &limits, err));
    limits.software = true;
    check_ok(stp_budget_plan(&software, &scene, &limits, err));
    limits.gpu_bytes = 4 * MIB;
    check_ok(stp_budget_plan(&least, &scene, &limits, err));
    assert_true(gpu.ring_bytes == 32 * MIB);
    assert_true(software.ring_bytes == 8 * MIB);
    assert_true(least.ring_bytes == 4 * MIB / 16 && least.gpu_bytes <= 4 * MIB);
}

/* A GPU of much memory still has a greatest texture: a larger model is drawn from what fits. */
static void textures_bound_the_budget(void **state)
{
    (void)state;
    static stp_block blocks[1000];
    stp_scene scene = {.blocks = blocks, .block_count = 1000, .chunk_count = 20};
    stp_budget of_samples, of_patches;
    stp_budget_limits limits = {.gpu_bytes = 1024 * MIB, .texels = 1 << 20, .decoders = 2};
    for (int i = 0; i < 1000; i++)
        blocks[i] = (stp_block){.patch_count = 80, .sample_count = {4000, 800, 200}};
    check_ok(stp_budget_plan(&of_samples, &scene, &limits, err));
    assert_in_range(of_samples.texel_capacity, limits.texels / 2, limits.texels);
    for (int i = 0; i < 1000; i++)
        blocks[i] = (stp_block){.patch_count = 800, .sample_count = {800, 800, 800}};
    check_ok(stp_budget_plan(&of_patches, &scene, &limits, err));
    const uint32_t texels = of_patches.patch_capacity * STP_OBJECT_TEXTURE_PATCH_TEXELS;
    assert_in_range(texels, limits.texels / 2, limits.texels);
    /* Names of samples tell only so many patches apart. */
    limits = (stp_budget_limits){1 << 20, 1 << 20, STP_NAME_SAMPLE, 2, false};
    limits.gpu_bytes *= MIB;
    limits.cpu_bytes *= MIB;
    for (int i = 0; i < 1000; i++)
        blocks[i] = (stp_block){.patch_count = 8000, .sample_count = {8000, 8000, 8000}};
    check_ok(stp_budget_plan(&of_patches, &scene, &limits, err));
    assert_in_range(of_patches.patch_capacity, STP_NAMED_PATCHES_LIMIT / 2,
                    STP_NAMED_PATCHES_LIMIT);
}

/* Renderers ask for such memory if, and only if, the driver draws on the CPU. */
static void renderers_ask_for_it(void **state)
{
    (void)state;
    gl_fixture f;
    model_fixture_build("lazy.stipple", &(model_recipe){.shape = GEN_BUMPY, .point_count = 3000});
    gl_fixture_open(&f, "lazy.stipple", NULL);
    bool lazy = stp_block_cache_texture(stp_renderer_inspect(f.renderer).cache)->samples.memory;
    assert_int_equal(lazy,
                     stp_road_is_software() && epoxy_has_gl_extension("GL_AMD_pinned_memory"));
    gl_fixture_close(&f);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_comes_when_written),
        cmocka_unit_test(gpus_keep_their_own_memory),
        cmocka_unit_test(too_much_is_no_error),
        cmocka_unit_test(patches_lie_by_number),
        cmocka_unit_test(stream_starts_without_memory),
        cmocka_unit_test(software_rings_are_small),
        cmocka_unit_test(textures_bound_the_budget),
        cmocka_unit_test(renderers_ask_for_it),
        cmocka_unit_test(pages_hold_copies),
        cmocka_unit_test(pieces_beyond_the_limit_wait),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}
