/* Tests plants without memory: each allocation of growing a plant and of turning it into lines
 * fails once. The failure must be reported, leave the output as it was, and leak nothing (the
 * address sanitizer checks). */
#include "base/memory.h"
#include "tests/fixtures/plant_fixture.h"

stp_status __real_stp_alloc(void *out, size_t count, size_t size, const char *what, stp_error *err);
stp_status __wrap_stp_alloc(void *out, size_t count, size_t size, const char *what, stp_error *err);
stp_status __real_stp_grow(void *array, size_t *capacity, size_t needed, size_t size,
                           const char *what, stp_error *err);
stp_status __wrap_stp_grow(void *array, size_t *capacity, size_t needed, size_t size,
                           const char *what, stp_error *err);

/* How many allocations succeed before one fails; negative: it has failed. */
static int left;

static bool fails(void)
{
    return left-- == 0;
}

stp_status __wrap_stp_alloc(void *out, size_t count, size_t size, const char *what, stp_error *err)
{
    if (fails())
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for %s", what);
    return __real_stp_alloc(out, count, size, what, err);
}

stp_status __wrap_stp_grow(void *array, size_t *capacity, size_t needed, size_t size,
                           const char *what, stp_error *err)
{
    if (fails())
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for %s", what);
    return __real_stp_grow(array, capacity, needed, size, what, err);
}

static void test_growing(void **state)
{
    (void)state;
    stp_status status = STP_OUT_OF_MEMORY;
    int count = 0;
    for (; status != STP_OK; count++) {
        gen_tree tree = {.leaf_count = 77};
        left = count;
        status = gen_tree_grow(&tree, 1000, 1, NULL);
        if (status == STP_OK) {
            gen_tree_clear(&tree);
            continue;
        }
        assert_int_equal(status, STP_OUT_OF_MEMORY);
        assert_true(tree.leaf_count == 77 && tree.tubes == NULL);
    }
    assert_true(count > 5);
}

static void test_converting(void **state)
{
    (void)state;
    gen_tree tree;
    stp_status status = STP_OUT_OF_MEMORY;
    int count = 0;
    left = -1;
    check_ok(gen_tree_grow(&tree, 1000, 1, err));
    plant_mesh mesh = plant_mesh_of_tree(&tree);
    for (; status != STP_OK; count++) {
        stp_plant plant = {.report.tubes = 77};
        stp_error error = {0};
        left = count;
        status = stp_plant_convert(&plant, &mesh.mesh, NULL, &error);
        if (status == STP_OK) {
            stp_plant_clear(&plant);
            continue;
        }
        assert_int_equal(status, STP_OUT_OF_MEMORY);
        assert_non_null(strstr(error.message, "no memory for"));
        assert_true(plant.report.tubes == 77 && plant.rest == NULL);
    }
    assert_true(count > 25);
    plant_mesh_clear(&mesh);
    gen_tree_clear(&tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_growing),
        cmocka_unit_test(test_converting),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
