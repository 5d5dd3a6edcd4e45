/* Tests what the writer of squares chooses, and that it saves bytes: normals that follow from those
 * of the parents, and ladders of heights that come in steps; ladders that are damaged are refused.
 */
#include "formats/chunk/codec/square/ladder.h"
#include "formats/chunk/codec/square/square_normal.h"
#include "formats/chunk/sample/normal_grid.h"
#include "tests/fixtures/square_recipe.h"

#define CHOICE_REACH 7u
#define CHOICE_LADDER 16u
#define CHOICE_LOOSE 32u
#define CHOICE_MORE 64u
/* Of a tight part of segment 0, before that: a mark, the number of rasters, and one that spreads.
 */
#define TIGHT_BEGIN (4u + 2u + 65u)
/* What lines may take: by rows they take 305, family by family 524. */
#define LINES_BYTES 400u
/* In the byte that follows then. */
#define CHOICE_ROWS 1u /* of level 0 */
#define CHOICE_BY_PARENTS 2u
#define CHOICE_SIDES 16u

/* Normals that are all alike follow from those of the parents, if heights do not tell them. */
static void test_parents(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(&(recipe){.wild = false}), *decoded = make_room(chunk, 0);
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        for (uint32_t i = 0; i < chunk->level_begin[l][SQUARES]; i++)
            chunk->samples[l][i].normal[0] = 1; /* so that they are on the finest grid */
    coded bytes = encode(chunk);
    assert_int_equal(decode(&bytes, decoded), STP_OK);
    assert_same(chunk, decoded);
    assert_int_equal(decoded->reach, STP_SQUARE_REACH_PARENTS);
    stp_chunk_destroy(&decoded);
    stp_chunk_destroy(&chunk);
    clear(&bytes);
}

/* The odds of parts of squares are known, those of colours by rows and of ladders, too. A part that
 * says otherwise is none. */
static void test_known_odds(void **state)
{
    (void)state;
    const recipe recipes[] = {{.wild = false}, {.spread = true, .stepped = true}};
    for (unsigned i = 0; i < 2; i++)
        for (int segment = 1; segment < STP_SEGMENT_COUNT; segment++) {
            stp_chunk *chunk = make_chunk(&recipes[i]), *decoded = make_room(chunk, 0);
            coded bytes = encode(chunk);
            uint8_t *begin = begin_of(&bytes, segment);
            uint8_t *states =
                begin + 1 + !!(*begin & CHOICE_MORE) + (*begin & CHOICE_LADDER ? 2 : 0);
            assert_int_equal(decode(&bytes, decoded), STP_OK);
            assert_same(chunk, decoded);
            assert_int_equal(states[3] >> 6, 0);
            states[3] |= 64u;
            assert_int_equal(decode(&bytes, decoded), STP_CORRUPT);
            stp_chunk_destroy(&decoded);
            stp_chunk_destroy(&chunk);
            clear(&bytes);
        }
}

/* Heights of a camera that come in steps take less than half of what others take; other squares,
 * and heights that do not come in steps, have no ladder. */
static void test_ladder(void **state)
{
    (void)state;
    const recipe recipes[] = {{.spread = true, .stepped = true},
                              {.spread = true, .stepped = true, .octaves = 5},
                              {.spread = true},
                              {.stepped = true}};
    size_t sizes[4];
    for (unsigned i = 0; i < 4; i++) {
        stp_chunk *chunk = make_chunk(&recipes[i]), *decoded = make_room(chunk, 0);
        coded bytes = encode(chunk);
        assert_int_equal(!!(*begin_of(&bytes, 2) & CHOICE_LADDER), i < 2);
        assert_int_equal(decode(&bytes, decoded), STP_OK);
        assert_same(chunk, decoded);
        sizes[i] = bytes.segment[2].size;
        stp_chunk_destroy(&decoded);
        stp_chunk_destroy(&chunk);
        clear(&bytes);
    }
    assert_in_range(sizes[0], 1, sizes[2] * 3 / 4);
}

/* Gives merged samples the means of the colours of level 0. */
static void merge_colours(stp_chunk *chunk)
{
    for (uint32_t p = 0; p < SQUARES; p++)
        for (int l = 1; l < STP_LEVEL_COUNT; l++)
            for (unsigned j = 0; j < chunk->patches[p].counts[l]; j++)
                for (unsigned k = 0; k < 3; k++) {
                    const stp_sample *finer = chunk->samples[l - 1] + chunk->level_begin[l - 1][p];
                    unsigned sum = 2;
                    for (unsigned i = 0; i < 4; i++)
                        sum += finer[4 * j + i].rgb[k];
                    chunk->samples[l][chunk->level_begin[l][p] + j].rgb[k] = (uint8_t)(sum / 4);
                }
}

/* Colours that slowly change from sample to sample, and noise. */
static void fill_colours(stp_chunk *chunk, unsigned noise)
{
    for (uint32_t p = 0; p < SQUARES; p++)
        for (uint32_t i = 0; i < 64; i++) {
            const uint32_t column = p % ACROSS * 8 + stp_square_column(i);
            const uint32_t row = p / ACROSS * 8 + stp_square_row(i);
            const uint64_t random = noise ? stp_random_u64(p, i) % noise : 0;
            for (unsigned k = 0; k < 3; k++)
                chunk->samples[0][chunk->level_begin[0][p] + i].rgb[k] =
                    (uint8_t)(50 * k + column + row / 2 + random);
        }
    merge_colours(chunk);
}

/* Smooth colours of merged samples are loose; noise is not. */
static void test_loose(void **state)
{
    (void)state;
    for (unsigned noise = 0; noise <= 40; noise += 40) {
        stp_chunk *chunk = make_chunk(&(recipe){.wild = false}), *decoded = make_room(chunk, 0);
        fill_colours(chunk, noise);
        coded bytes = encode(chunk);
        assert_int_equal(!!(*begin_of(&bytes, 1) & CHOICE_LOOSE), noise == 0);
        assert_int_equal(decode(&bytes, decoded), STP_OK);
        assert_same(chunk, decoded);
        stp_chunk_destroy(&decoded);
        stp_chunk_destroy(&chunk);
        clear(&bytes);
    }
}

/* Whether colours of level 0 are coded by rows. */
static bool has_rows(const coded *bytes)
{
    const uint8_t *choice = begin_of(bytes, 2);
    return choice[0] & CHOICE_MORE && choice[1] & CHOICE_ROWS;
}

static bool are_by_parents(const coded *bytes)
{
    const uint8_t *choice = begin_of(bytes, 2);
    return choice[0] & CHOICE_MORE && choice[1] & CHOICE_BY_PARENTS;
}

/* Colours that vary are coded by rows, on all kinds of rasters, and come back; some by parents. */
static void test_rows(void **state)
{
    (void)state;
    bool any = false;
    const recipe recipes[] = {
        {.octaves = 0}, {.spread = true}, {.wild = true}, {.tilted = true, .swapped = true}};
    for (unsigned i = 0; i < 4; i++)
        for (unsigned k = 0; k < 3; k++) {
            stp_chunk *chunk = make_chunk(&recipes[i]), *decoded = make_room(chunk, 0);
            static const unsigned noise[] = {0, 4, 90};
            if (!recipes[i].wild)
                fill_colours(chunk, noise[k]);
            coded bytes = encode(chunk);
            assert_int_equal(has_rows(&bytes), recipes[i].wild || k < 2); /* not if noise */
            any = any || are_by_parents(&bytes);
            assert_int_equal(decode(&bytes, decoded), STP_OK);
            assert_same(chunk, decoded);
            stp_chunk_destroy(&decoded);
            stp_chunk_destroy(&chunk);
            clear(&bytes);
        }
    assert_true(any);
    stp_chunk *chunk = make_chunk(&recipes[1]);
    fill_colours(chunk, 20);
    damage(chunk);
    stp_chunk_destroy(&chunk);
}

/* Lines from left to right: what is above tells nothing of a row, and what is to the left all, as
 * is learned. Equal colours are not coded by rows. */
static void test_learned(void **state)
{
    (void)state;
    size_t sizes[2];
    for (unsigned lines = 0; lines < 2; lines++) {
        stp_chunk *chunk = make_chunk(&(recipe){.wild = false}), *decoded = make_room(chunk, 0);
        for (uint32_t i = 0; i < chunk->level_begin[0][SQUARES]; i++) {
            const uint32_t row = i / 64 / ACROSS * 8 + stp_square_row(i % 64);
            memset(chunk->samples[0][i].rgb, lines ? (int)(stp_random_u64(3, row) % 256) : 99, 3);
        }
        merge_colours(chunk);
        coded bytes = encode(chunk);
        assert_int_equal(has_rows(&bytes), lines);
        assert_false(are_by_parents(&bytes));
        assert_int_equal(decode(&bytes, decoded), STP_OK);
        assert_same(chunk, decoded);
        sizes[lines] = bytes.segment[2].size;
        stp_chunk_destroy(&decoded);
        stp_chunk_destroy(&chunk);
        clear(&bytes);
    }
    print_message("lines take %zu bytes more\n", sizes[1] - sizes[0]);
    assert_in_range(sizes[1] - sizes[0], 1, LINES_BYTES);
}

/* Moves the origin of each patch along the heights, so that it is a multiple of nothing. */
static void move_origins(stp_chunk *chunk, const recipe *r)
{
    for (uint32_t p = 0; p < SQUARES; p++) {
        const unsigned axis = rasters[raster_of_patch(r, p)].axis;
        chunk->patches[p].origin[axis] -= (int32_t)p + 1;
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            for (uint32_t i = chunk->level_begin[l][p]; i < chunk->level_begin[l][p + 1]; i++)
                chunk->samples[l][i].position[axis] =
                    (uint16_t)(chunk->samples[l][i].position[axis] + p + 1);
    }
}

/* Rounds the heights of merged samples to multiples of 2^steps on the finest lattice. */
static void round_heights(stp_chunk *chunk, const recipe *r, unsigned steps)
{
    for (int l = 1; l < STP_LEVEL_COUNT - 1; l++)
        for (uint32_t p = 0; p < SQUARES; p++) {
            const stp_patch *patch = &chunk->patches[p];
            const unsigned axis = rasters[raster_of_patch(r, p)].axis;
            const unsigned coarser = (unsigned)(patch->exponent + 10);
            const uint32_t most = steps > coarser ? (1u << (steps - coarser)) - 1u : 0u;
            for (uint32_t i = chunk->level_begin[l][p]; i < chunk->level_begin[l][p + 1]; i++) {
                uint16_t *position = &chunk->samples[l][i].position[axis];
                const uint32_t height = (uint32_t)patch->origin[axis] + *position + 32u * i;
                *position = (uint16_t)((height & ~most) - (uint32_t)patch->origin[axis]);
            }
        }
}

static stp_chunk *make_stepped(const recipe *r, unsigned steps)
{
    stp_chunk *chunk = make_chunk(r);
    move_origins(chunk, r);
    round_heights(chunk, r, steps);
    return chunk;
}

/* Heights of merged samples that are multiples of a step come back, and take fewer bytes. */
static void test_steps(void **state)
{
    (void)state;
    const recipe recipes[] = {{.octaves = 0}, {.spread = true}, {.tilted = true, .octaves = 3}};
    for (unsigned i = 0; i < 3; i++) {
        size_t sizes[2];
        for (unsigned steps = 0; steps < 10; steps += 5) {
            stp_chunk *chunk = make_stepped(&recipes[i], steps), *decoded = make_room(chunk, 0);
            stp_chunk *same = make_stepped(&recipes[i], steps);
            coded bytes = encode(chunk);
            const uint8_t *choice = begin_of(&bytes, 1);
            assert_int_equal(choice[0] & CHOICE_MORE && choice[1] % 16 >= 5, steps > 0);
            assert_int_equal(decode(&bytes, decoded), STP_OK);
            assert_same(same, decoded);
            sizes[steps > 0] = bytes.segment[1].size;
            damage(chunk);
            stp_chunk_destroy(&same);
            stp_chunk_destroy(&decoded);
            stp_chunk_destroy(&chunk);
            clear(&bytes);
        }
        assert_in_range(sizes[1], 1, sizes[0] * 19 / 20);
    }
}

/* Turns normals around one that lies on a side of their grid, and faces a camera. side: lets half
 * of those that lie there have the greater of their codes. */
static void fill_normals(stp_chunk *chunk, bool greater)
{
    enum { BITS = 7, TOP = 1 << BITS };
    for (int l = 0; l < STP_LEVEL_COUNT - 1; l++)
        for (uint32_t i = 0; i < chunk->level_begin[l][SQUARES]; i++) {
            int32_t uv[2] = {40 + (int32_t)(i % 3), TOP - 1 + (int32_t)(stp_random_u64(7, i) % 3)};
            stp_square_fold(uv, TOP);
            stp_normal_side(uv, TOP);
            if (greater && i % 2 && (uv[1] == 0 || uv[1] == TOP))
                uv[0] = TOP - uv[0];
            for (int k = 0; k < 2; k++)
                uv[k] = stp_normal_grid_code(uv[k], STP_NORMAL_BITS - BITS);
            stp_normal_codes_put(uv, chunk->samples[l][i].normal);
        }
}

/* Normals around the side of their grid take fewer bytes if each has one code. */
static void test_sides(void **state)
{
    (void)state;
    size_t sizes[2];
    for (unsigned greater = 0; greater < 2; greater++) {
        stp_chunk *chunk = make_chunk(&(recipe){.spread = true}), *decoded = make_room(chunk, 0);
        fill_normals(chunk, greater);
        coded bytes = encode(chunk);
        const uint8_t *choice = begin_of(&bytes, 2);
        assert_int_equal(choice[0] & CHOICE_MORE && choice[1] & CHOICE_SIDES, !greater);
        assert_int_equal(decode(&bytes, decoded), STP_OK);
        assert_same(chunk, decoded);
        sizes[greater] = bytes.segment[2].size;
        stp_chunk_destroy(&decoded);
        stp_chunk_destroy(&chunk);
        clear(&bytes);
    }
    assert_in_range(sizes[0], 1, sizes[1] * 19 / 20);
}

/* Gives levels 1 and 0 of a camera's image one normal, on a grid of 8 bits, but those that are off
 * by whole strides, 2^stride places. If one is not, no level says strides. */
static void fill_strides(stp_chunk *chunk, bool whole)
{
    enum { SHIFT = 4 };
    for (int l = 0; l < 2; l++)
        for (uint32_t i = 0; i < chunk->level_begin[l][SQUARES]; i++) {
            const int32_t by = (int32_t)((l == 0) * (1u << stp_square_stride(l, SHIFT)));
            const uint64_t random = stp_random_u64(11, i);
            const bool far = i % 5 == 2, off = i == 40 && !whole;
            int32_t uv[2] = {101 + off, 91};
            for (int k = 0; k < 2 && far; k++)
                uv[k] += by * (int32_t)(random >> 8 * k & 3u) - by;
            for (int k = 0; k < 2; k++)
                uv[k] = stp_normal_grid_code(uv[k], SHIFT);
            stp_normal_codes_put(uv, chunk->samples[l][i].normal);
        }
}

/* Normals that are whole strides off what is expected take fewer bytes. Level 2 has no strides. */
static void test_strides(void **state)
{
    (void)state;
    size_t sizes[2];
    for (unsigned whole = 0; whole < 2; whole++) {
        stp_chunk *chunk = make_chunk(&(recipe){.spread = true}), *decoded = make_room(chunk, 0);
        fill_strides(chunk, whole);
        coded bytes = encode(chunk);
        assert_int_equal((*begin_of(&bytes, 2) & CHOICE_REACH) == STP_SQUARE_REACH_STRIDES, whole);
        assert_int_equal(decode(&bytes, decoded), STP_OK);
        assert_same(chunk, decoded);
        sizes[whole] = bytes.segment[2].size;
        damage(chunk);
        uint8_t *coarsest = begin_of(&bytes, 0) + TIGHT_BEGIN;
        assert_int_equal(*coarsest >> 7, 1);
        *coarsest |= CHOICE_REACH;
        assert_int_equal(decode(&bytes, decoded), STP_CORRUPT);
        stp_chunk_destroy(&decoded);
        stp_chunk_destroy(&chunk);
        clear(&bytes);
    }
    print_message("strides: %zu bytes, else %zu\n", sizes[1], sizes[0]);
    assert_in_range(sizes[1], 1, sizes[0] * 19 / 20);
}

/* Radii that are on a coarse grid take fewer bytes; those that are on none come back, too. */
static void test_radii(void **state)
{
    (void)state;
    size_t sizes[2];
    for (unsigned coarse = 0; coarse < 2; coarse++) {
        stp_chunk *chunk = make_chunk(&(recipe){.octaves = 3}), *decoded = make_room(chunk, 0);
        for (int l = 0; l < STP_LEVEL_COUNT - 1; l++)
            for (uint32_t i = 0; i < chunk->level_begin[l][SQUARES]; i++)
                chunk->samples[l][i].radius =
                    (uint8_t)(81 + 4 * (stp_random_u64(9, i) % 30) - (i == 40 && !coarse));
        coded bytes = encode(chunk);
        const uint8_t *choice = begin_of(&bytes, 2);
        assert_int_equal(choice[0] & CHOICE_MORE ? choice[1] >> 5 : 0, 2 * coarse);
        assert_int_equal(decode(&bytes, decoded), STP_OK);
        assert_same(chunk, decoded);
        sizes[coarse] = bytes.segment[2].size;
        stp_chunk_destroy(&decoded);
        stp_chunk_destroy(&chunk);
        clear(&bytes);
    }
    assert_in_range(sizes[1], 1, sizes[0] * 19 / 20);
}

static void assert_refused(const coded *c, const stp_chunk *like)
{
    stp_chunk *decoded = make_room(like, 0);
    assert_int_equal(decode(c, decoded), STP_CORRUPT);
    stp_chunk_destroy(&decoded);
}

/* A ladder may not belong to a merged level, nor to tables that are not tight, nor end early. */
static void test_damaged(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(&(recipe){.spread = true, .stepped = true});
    coded bytes = encode(chunk);
    *begin_of(&bytes, 1) |= CHOICE_LADDER;
    assert_refused(&bytes, chunk);
    *begin_of(&bytes, 1) ^= CHOICE_LADDER;
    *begin_of(&bytes, 2) &= 127;
    assert_refused(&bytes, chunk);
    *begin_of(&bytes, 2) |= 128;
    const size_t size = bytes.segment[2].size;
    bytes.segment[2].size = (size_t)(begin_of(&bytes, 2) - bytes.segment[2].data) + 2;
    assert_refused(&bytes, chunk);
    bytes.segment[2].size = size;
    clear(&bytes);
    stp_chunk_destroy(&chunk);
}

/* The other byte: no steps at level 0, where colours by rows are neither loose nor follow; no end
 * before it. */
static void test_damaged_more(void **state)
{
    (void)state;
    const recipe r = {.spread = true};
    stp_chunk *chunk = make_chunk(&r);
    fill_normals(chunk, false);
    round_heights(chunk, &r, 5);
    coded bytes = encode(chunk);
    for (int s = 1; s < STP_SEGMENT_COUNT; s++) {
        uint8_t *choice = begin_of(&bytes, s);
        assert_true(choice[0] & CHOICE_MORE && choice[1] & CHOICE_SIDES);
        for (unsigned bit = 0; bit < 4 && s == 2; bit++) {
            choice[1] ^= (uint8_t)(1u << bit);
            assert_refused(&bytes, chunk);
            choice[1] ^= (uint8_t)(1u << bit);
        }
        for (unsigned bit = 3; bit < 6 && s == 2; bit += 2) { /* follow, loose */
            choice[0] ^= (uint8_t)(1u << bit);
            assert_refused(&bytes, chunk);
            choice[0] ^= (uint8_t)(1u << bit);
        }
        const size_t size = bytes.segment[s].size;
        bytes.segment[s].size = (size_t)(choice - bytes.segment[s].data) + 1;
        assert_refused(&bytes, chunk);
        bytes.segment[s].size = size;
    }
    clear(&bytes);
    stp_chunk_destroy(&chunk);
}

/* Rungs come back, however far apart they are; those that do not grow are refused. */
static void test_rungs(void **state)
{
    (void)state;
    int32_t heights[] = {-1000000000, -40000, -39999, 7, 40000, 90000, 1000000000};
    const uint32_t count = sizeof heights / sizeof *heights;
    const stp_ladder ladder = {heights, count};
    stp_ladder back = {0};
    stp_table table;
    assert_int_equal(stp_ladder_table(count, &table, NULL), STP_OK);
    stp_ladder_encode(&ladder, &table);
    assert_int_equal(stp_ladder_decode(&table, &back, NULL), STP_OK);
    assert_int_equal(back.count, count);
    assert_memory_equal(back.rungs, heights, sizeof heights);
    free(back.rungs);
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(stp_ladder_nearest(&ladder, heights[i]), i);
        assert_int_equal(stp_ladder_nearest(&ladder, heights[i] + 0.5), i);
    }
    assert_int_equal(stp_ladder_nearest(&ladder, -39999.25), 2);
    assert_int_equal(stp_ladder_nearest(&ladder, -INFINITY), 0);
    assert_int_equal(stp_ladder_nearest(&ladder, INFINITY), count - 1);
    heights[3] = heights[2];
    stp_ladder_encode(&ladder, &table);
    assert_int_equal(stp_ladder_decode(&table, &back, NULL), STP_CORRUPT);
    free(table.values);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_parents),      cmocka_unit_test(test_known_odds),
        cmocka_unit_test(test_ladder),       cmocka_unit_test(test_loose),
        cmocka_unit_test(test_steps),        cmocka_unit_test(test_sides),
        cmocka_unit_test(test_radii),        cmocka_unit_test(test_damaged),
        cmocka_unit_test(test_damaged_more), cmocka_unit_test(test_rungs),
        cmocka_unit_test(test_rows),         cmocka_unit_test(test_learned),
        cmocka_unit_test(test_strides),
    };
    return cmocka_run_group_tests_name("choices of squares", tests, NULL, NULL);
}
