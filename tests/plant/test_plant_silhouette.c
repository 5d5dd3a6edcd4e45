/* Tests that lines look like the mesh that they came from: silhouettes of `gen tree` in 26
 * directions, of the whole tree, of its branches alone and of its leaves alone. */
#include "tests/fixtures/plant_silhouette.h"

enum { SIZE_PX = 600 };

typedef enum part { ALL, BRANCHES, LEAVES } part;

/* Keeps only the part's triangles in the mesh. */
static void keep_part(stp_mesh *mesh, const gen_tree *tree, part which)
{
    const size_t branches = tree->first_leaf_triangle;
    if (which == BRANCHES)
        mesh->triangle_count = branches;
    if (which != LEAVES)
        return;
    mesh->triangle_count -= branches;
    memmove(mesh->triangles, mesh->triangles + branches,
            (size_t)mesh->triangle_count * sizeof *mesh->triangles);
}

static void compare(part which, double area, double layers, double both)
{
    gen_tree tree;
    check_ok(gen_tree_grow(&tree, 6000, 2, err));
    plant_mesh mesh = plant_mesh_of_tree(&tree);
    keep_part(&mesh.mesh, &tree, which);
    stp_plant plant = plant_convert(&mesh.mesh, NULL);
    const silhouette_sum sum = silhouette_compare(&mesh.mesh, &plant, SIZE_PX);
    silhouette_check(&sum, area, layers, both);
    stp_plant_clear(&plant);
    plant_mesh_clear(&mesh);
    gen_tree_clear(&tree);
}

static void test_all(void **state)
{
    (void)state;
    compare(ALL, 0.01, 0.01, 0.97);
}

static void test_branches(void **state)
{
    (void)state;
    compare(BRANCHES, 0.01, 0.01, 0.97);
}

static void test_leaves(void **state)
{
    (void)state;
    compare(LEAVES, 0.01, 0.02, 0.97);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_all),
        cmocka_unit_test(test_branches),
        cmocka_unit_test(test_leaves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
