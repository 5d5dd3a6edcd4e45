/* Boxes of chunks: a search finds the same chunks in the same order as a look at every box. */
#include "formats/chunk/measure/chunk_boxes.h"

#include "base/random.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

/* A box at a random place. One in 50 is a hundred times larger than the others. */
static stp_dbox box_of(uint64_t seed, uint32_t i)
{
    const stp_dvec3 at = {stp_random_unit(seed, 3 * (uint64_t)i),
                          stp_random_unit(seed, 3 * (uint64_t)i + 1),
                          stp_random_unit(seed, 3 * (uint64_t)i + 2)};
    const double size = i % 50 == 7 ? 0.5 : 0.005;
    return (stp_dbox){at, stp_dvec3_add(at, (stp_dvec3){size, size, size})};
}

static void check_search(const stp_chunk_boxes *boxes, const stp_dbox *box)
{
    uint32_t found = stp_chunk_boxes_next(boxes, box, 0);
    for (uint32_t i = 0; i < boxes->count; i++) {
        if (i % 5 == 3) /* begins anywhere */
            assert_int_equal(stp_chunk_boxes_next(boxes, box, i), found);
        if (!stp_dbox_meet(&boxes->boxes[i], box))
            continue;
        assert_int_equal(found, i);
        found = stp_chunk_boxes_next(boxes, box, i + 1);
    }
    assert_int_equal(found, STP_CHUNK_NONE);
}

static void check(uint32_t count)
{
    const stp_dbox everywhere = {{-9.0, -9.0, -9.0}, {9.0, 9.0, 9.0}}, nowhere = stp_dbox_empty();
    stp_chunk_boxes boxes = {0};
    assert_int_equal(stp_chunk_boxes_create(&boxes, count, NULL), STP_OK);
    check_search(&boxes, &everywhere); /* all empty */
    for (uint32_t i = count; i-- > 0;) {
        stp_dbox box = box_of(1, i);
        stp_chunk_boxes_set(&boxes, i, &box);
    }
    for (uint32_t i = 0; i < count; i += 9) { /* some move, some become empty */
        stp_dbox box = i % 2 ? stp_dbox_empty() : box_of(2, i);
        stp_chunk_boxes_set(&boxes, i, &box);
    }
    check_search(&boxes, &everywhere);
    check_search(&boxes, &nowhere);
    for (uint32_t i = 0; i < 40; i++) {
        stp_dbox box = box_of(3, i);
        check_search(&boxes, &box);
    }
    for (uint32_t i = 0; i < count; i++)
        boxes.boxes[i] = box_of(4, i);
    stp_chunk_boxes_join(&boxes);
    for (uint32_t i = 0; i < 40; i++) {
        stp_dbox box = box_of(5, i);
        check_search(&boxes, &box);
    }
    stp_chunk_boxes_clear(&boxes);
    assert_null(boxes.boxes);
}

/* Around the number of boxes that one box above holds, and tiers of such. */
static void all_sizes(void **state)
{
    (void)state;
    const uint32_t counts[] = {0, 1, 2, 7, 8, 9, 63, 64, 65, 512, 513, 4097};
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++)
        check(counts[n]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(all_sizes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
