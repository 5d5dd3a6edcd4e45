/* Tests blocks of squares: samples come back whatever they are, at every level; what is no square
 * of the grid is coded as points; hostile bytes are refused or decoded, never followed; and each
 * allocation of decoding fails once. */
#include "formats/chunk/codec/square/coarse_patches.h"
#include "formats/chunk/codec/square/placed.h"
#include "formats/chunk/codec/square/square_normal.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/normal_grid.h"
#include "formats/chunk/sample/patch.h"
#include "tests/fixtures/square_recipe.h"

/* A tight part of squares begins with a u32; tilted rasters follow a count. */
enum { HEAD_BYTES = 4, LEVEL_BYTES = 40, COUNT_BYTES = 2, TILTED_BYTES = 49, SHORT_BYTES = 29 };

stp_status __real_stp_alloc(void *out, size_t count, size_t size, const char *what, stp_error *err);
stp_status __wrap_stp_alloc(void *out, size_t count, size_t size, const char *what, stp_error *err);

/* How many allocations succeed before one fails; negative: none fails. */
static int left = -1;

stp_status __wrap_stp_alloc(void *out, size_t count, size_t size, const char *what, stp_error *err)
{
    if (left >= 0 && left-- == 0)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for %s", what);
    return __real_stp_alloc(out, count, size, what, err);
}

static size_t size_of(const coded *c)
{
    return c->segment[0].size + c->segment[1].size + c->segment[2].size;
}

/* Encodes and decodes to each level. Returns whether the block was coded as squares. */
static bool round_trip(const recipe *r, const stp_chunk *chunk)
{
    coded bytes = encode(chunk);
    bool squares = false;
    for (int finest = 2; finest >= 0; finest--) {
        stp_chunk *decoded = make_room(chunk, finest);
        assert_int_equal(decode(&bytes, decoded), STP_OK);
        assert_same(chunk, decoded);
        squares = stp_chunk_is_squares(decoded);
        for (uint32_t p = 0; squares && p < SQUARES; p++) {
            const stp_square *s = &decoded->squares[p];
            assert_int_equal(s->row, FIRST_ROW / 8 + p / ACROSS);
            assert_memory_equal(&decoded->rasters[s->raster], &rasters[raster_of_patch(r, p)],
                                sizeof *rasters);
        }
        if (squares && finest == 0 && !r->wild && !r->tilted && !r->spread)
            assert_int_equal(decoded->reach, 2); /* else the writer chooses */
        stp_chunk_destroy(&decoded);
    }
    clear(&bytes);
    return squares;
}

static const recipe recipes[] = {{0},
                                 {.holes = true},
                                 {.holes = true, .octaves = 8},
                                 {.wild = true, .seed = 1},
                                 {.wild = true, .holes = true, .octaves = 1, .seed = 2},
                                 {.tilted = true},
                                 {.tilted = true, .holes = true, .octaves = 5},
                                 {.tilted = true, .wild = true, .octaves = 1, .seed = 3},
                                 {.spread = true},
                                 {.spread = true, .holes = true, .octaves = 5},
                                 {.spread = true, .wild = true, .octaves = 1, .seed = 4},
                                 {.spread = true, .holes = true, .stepped = true, .octaves = 5}};
#define RECIPE_COUNT (sizeof recipes / sizeof *recipes)

static void test_round_trip(void **state)
{
    (void)state;
    for (size_t i = 0; i < RECIPE_COUNT; i++) {
        stp_chunk *chunk = make_chunk(&recipes[i]);
        assert_true(round_trip(&recipes[i], chunk));
        stp_chunk_destroy(&chunk);
    }
}

/* Smooth heights take at most three quarters of what they take as points; with two rasters in a
 * small block four fifths, not counting the second raster. */
static void test_size(void **state)
{
    (void)state;
    for (int tilted = 0; tilted < 2; tilted++) {
        stp_chunk *chunk = make_chunk(&(recipe){.tilted = tilted});
        coded squares = encode(chunk);
        chunk->raster_count = 0;
        coded points = encode(chunk);
        const size_t second_raster = tilted ? SHORT_BYTES : 0;
        assert_in_range(size_of(&squares), 1,
                        size_of(&points) * (15 + (unsigned)tilted) / 20 + second_raster);
        clear(&squares);
        clear(&points);
        stp_chunk_destroy(&chunk);
    }
}

static void move_sample(stp_chunk *chunk)
{
    chunk->samples[0][70].position[0] += 300; /* a column is 512 steps */
}
static void swap_samples(stp_chunk *chunk)
{
    const stp_sample other = chunk->samples[0][70];
    chunk->samples[0][70] = chunk->samples[0][71];
    chunk->samples[0][71] = other;
}
static void move_raster(stp_chunk *chunk)
{
    chunk->raster_count = 1;
    chunk->rasters[0].across[0][0] += 100.0; /* the columns would be less than 0 */
}
static void double_square(stp_chunk *chunk)
{
    memcpy(&chunk->patches[1], &chunk->patches[0], sizeof *chunk->patches);
    memcpy(chunk->samples[0] + 64, chunk->samples[0], 64 * sizeof *chunk->samples[0]);
}
static void spread_lattices(stp_chunk *chunk)
{
    chunk->patches[3].exponent += 9;
    chunk->patches[3].origin[0] >>= 9;
    chunk->patches[3].origin[1] >>= 9;
    for (unsigned i = 192; i < 256; i++)
        chunk->samples[0][i].position[0] = (uint16_t)(chunk->samples[0][i].position[0] >> 9);
}

/* What is no square of the grid is coded as points, without loss. */
static void test_points(void **state)
{
    (void)state;
    void (*const changes[])(stp_chunk *) = {move_sample, swap_samples, move_raster, double_square,
                                            spread_lattices};
    for (size_t i = 0; i < sizeof changes / sizeof *changes; i++) {
        stp_chunk *chunk = make_chunk(&recipes[0]);
        changes[i](chunk);
        assert_false(round_trip(&recipes[0], chunk));
        stp_chunk_destroy(&chunk);
    }
}

static void test_hostile(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        stp_chunk *chunk = make_chunk(&(recipe){
            .holes = true, .tilted = kind == 1, .spread = kind >= 2, .stepped = kind == 3});
        damage(chunk);
        stp_chunk_destroy(&chunk);
    }
}

/* Where the part of a segment of one block begins; in segment 0, where its raster does. */
static uint8_t *part_of(coded *c, int s)
{
    return begin_of(c, s) + (s > 0 ? 0 : HEAD_BYTES);
}

static void assert_refused(coded *c, const stp_chunk *like, uint8_t *at, const void *bytes,
                           size_t size)
{
    uint8_t was[8];
    memcpy(was, at, size);
    memcpy(at, bytes, size);
    assert_int_equal(decode_changed(c, like), STP_CORRUPT);
    memcpy(at, was, size);
    assert_int_equal(decode_changed(c, like), STP_OK);
}

static void test_numbers(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(&recipes[0]);
    coded bytes = encode(chunk);
    const double numbers[] = {NAN, INFINITY, -1e16};
    const double zero = 0.0;
    const uint8_t far[4] = {0, 0, 0, 0x10};                /* 2^28 */
    const uint8_t choices[] = {128 + 16, 255, 1, 128 + 7}; /* 128: tight */
    for (unsigned i = 0; i < 4; i++)
        for (unsigned k = 0; k < 3; k++)
            assert_refused(&bytes, chunk, part_of(&bytes, 0) + 8 * i, &numbers[k], 8);
    assert_refused(&bytes, chunk, part_of(&bytes, 0) + 16, &zero, 8);
    assert_refused(&bytes, chunk, part_of(&bytes, 0) + 24, &zero, 8);
    assert_refused(&bytes, chunk, part_of(&bytes, 0) + 32, far, 4);
    assert_refused(&bytes, chunk, part_of(&bytes, 0) + 36, far, 4);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++)
        for (unsigned k = 0; k < (s > 0 ? 3 : 4); k++)
            assert_refused(&bytes, chunk, part_of(&bytes, s) + (s > 0 ? 0 : LEVEL_BYTES),
                           &choices[k], 1);
    clear(&bytes);
    stp_chunk_destroy(&chunk);
}

/* The same of tilted rasters. */
static void test_tilted_numbers(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(&(recipe){.tilted = true});
    coded bytes = encode(chunk);
    uint8_t *first = part_of(&bytes, 0) + COUNT_BYTES, *second = first + TILTED_BYTES;
    const double numbers[] = {NAN, -1e16};
    const float floats[] = {NAN, INFINITY, 1e16f};
    const uint8_t axis = 8 + 3, counts[2] = {SQUARES, 0}, one[2] = {0}, far[4] = {0, 0, 0, 0x10};
    const uint8_t zeros[8] = {0};
    assert_int_equal(first[0], rasters[1].axis);
    assert_refused(&bytes, chunk, part_of(&bytes, 0), counts, 2); /* more rasters than patches */
    assert_refused(&bytes, chunk, part_of(&bytes, 0), one, 2);    /* squares of a raster beyond */
    assert_refused(&bytes, chunk, second, &axis, 1);
    for (unsigned k = 0; k < 2; k++)
        for (unsigned i = 0; i < 2; i++)
            assert_refused(&bytes, chunk, first + 1 + 20 * k, &numbers[i], 8);
    for (unsigned i = 0; i < 6; i++)
        for (unsigned k = 0; k < 3; k++)
            assert_refused(&bytes, chunk, first + 9 + 20 * (i / 3) + 4 * (i % 3), &floats[k], 4);
    assert_refused(&bytes, chunk, first + 9, zeros, 8); /* no area */
    assert_refused(&bytes, chunk, first + 41, far, 4);
    assert_refused(&bytes, chunk, first + 45, far, 4);
    clear(&bytes);
    stp_chunk_destroy(&chunk);
}

/* The same of one that spreads. */
static void test_spread_numbers(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(&(recipe){.spread = true});
    coded bytes = encode(chunk);
    uint8_t *raster = part_of(&bytes, 0) + COUNT_BYTES, *slopes = raster + TILTED_BYTES - 8;
    const float floats[] = {NAN, INFINITY, 1e16f};
    const uint8_t axes[] = {2, 7, 10},
                  far[4] = {0, 0, 0, 0x10}; /* 2: its slopes would be squares */
    uint8_t *kind = raster - COUNT_BYTES - HEAD_BYTES + 1;
    const uint8_t unknown = *kind | 2;
    assert_int_equal(*kind, 1); /* slopes stop */
    assert_refused(&bytes, chunk, kind, &unknown, 1);
    assert_int_equal(raster[0], 4 + 2);
    for (unsigned i = 0; i < 3; i++)
        assert_refused(&bytes, chunk, raster, &axes[i], 1);
    for (unsigned i = 0; i < 4; i++)
        for (unsigned k = 0; k < 3; k++)
            assert_refused(&bytes, chunk, slopes + 4 * i, &floats[k], 4);
    assert_refused(&bytes, chunk, slopes + 16, far, 4);
    assert_refused(&bytes, chunk, slopes + 20, far, 4);
    clear(&bytes);
    stp_chunk_destroy(&chunk);
}

/* Of a raster that spreads, patches may have one square, and lie farther apart. */
static void test_spread_squares(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(&(recipe){.spread = true});
    stp_square squares[SQUARES];
    stp_square_map map = {0};
    assert_true(stp_squares_find(chunk, squares));
    assert_int_equal(squares[0].column, squares[1].column);
    assert_int_equal(squares[0].samples ^ squares[1].samples, UINT64_MAX);
    const uint32_t most = (4 * SQUARES + 256) / 3, first = squares[0].column; /* three rows */
    squares[SQUARES - 1].column = first + most - 1;
    assert_int_equal(stp_square_map_create(chunk, squares, true, &map, NULL), STP_OK);
    stp_square_map_clear(&map);
    squares[SQUARES - 1].column = first + most;
    assert_int_equal(stp_square_map_create(chunk, squares, true, &map, NULL), STP_CORRUPT);
    stp_chunk_destroy(&chunk);
}

/* Squares of one sample each: a map takes 4400 bytes for each, so a block may have only so many. */
static void test_many_squares(void **state)
{
    (void)state;
    enum { SIDE = 129, MANY = SIDE * SIDE, MOST = 16384 + 256 };
    const uint32_t counts[STP_LEVEL_COUNT] = {MANY, MANY, MANY, MANY};
    static stp_square squares[MANY];
    stp_square_map map = {0};
    stp_chunk *chunk = NULL;
    assert_int_equal(stp_chunk_create(&chunk, MANY, counts, 0, NULL), STP_OK);
    chunk->rasters = malloc(sizeof *rasters);
    assert_non_null(chunk->rasters);
    memcpy(chunk->rasters, rasters, sizeof *rasters);
    chunk->raster_count = 1;
    for (uint32_t p = 0; p < MANY; p++) {
        memset(chunk->patches[p].counts, 1, sizeof chunk->patches[p].counts);
        squares[p] = (stp_square){.samples = 1, .column = p % SIDE, .row = p / SIDE};
    }
    stp_patches_place(chunk);
    assert_in_range(MANY, MOST + 1, MOST + SIDE);
    assert_int_equal(stp_square_map_create(chunk, squares, true, &map, NULL), STP_CORRUPT);
    chunk->patch_count = MANY - SIDE;
    assert_int_equal(stp_square_map_create(chunk, squares, true, &map, NULL), STP_OK);
    stp_square_map_clear(&map);
    stp_chunk_destroy(&chunk);
}

/* Places fold to the same place as often as they lie beyond a side, and unfold to where they were.
 */
static void test_fold(void **state)
{
    (void)state;
    enum { TOP = 8 };
    for (int32_t v = -TOP; v <= 2 * TOP; v++)
        for (int32_t u = -TOP; u <= 2 * TOP; u++) {
            int32_t place[2] = {u, v};
            stp_square_fold(place, TOP);
            assert_in_range(place[0], 0, TOP);
            assert_in_range(place[1], 0, TOP);
            int32_t back[2] = {place[0], place[1]};
            stp_square_unfold(back, (const int32_t[2]){u, v}, TOP, false, 0);
            assert_true(back[0] == u && back[1] == v);
            stp_normal_side(place, TOP); /* also if it stands for two places on a side */
            stp_square_unfold(place, (const int32_t[2]){u, v}, TOP, true, 0);
            assert_true(place[0] == u && place[1] == v);
        }
}

/* Normals on both sides of a fold are next to each other. */
static void test_fold_directions(void **state)
{
    (void)state;
    const unsigned shift = 4;
    const int32_t top = 4096 >> shift;
    for (int32_t v = 0; v <= top; v++) {
        int32_t beyond[2] = {-1, v}, inside[2] = {1, v};
        double way = 0.0;
        vec3s normal[2];
        int32_t *both[2] = {beyond, inside};
        stp_square_fold(beyond, top);
        for (int i = 0; i < 2; i++) {
            uint8_t bytes[3];
            const int32_t code[2] = {stp_normal_grid_code(both[i][0], shift),
                                     stp_normal_grid_code(both[i][1], shift)};
            stp_normal_codes_put(code, bytes);
            normal[i] = stp_normal_decode(bytes);
        }
        for (int i = 0; i < 3; i++)
            way += pow((double)normal[0].raw[i] - (double)normal[1].raw[i], 2.0);
        assert_true(sqrt(way) < 3.0 * stp_normal_grid_angle(STP_NORMAL_BITS - shift));
    }
}

/* Origins follow from squares, but for heights, and come back. Vertices of recipes with missing
 * samples are not where these are. */
static void test_placed(void **state)
{
    (void)state;
    const recipe all[] = {{0}, {.tilted = true}, {.octaves = 3}, {.holes = true, .spread = true}};
    for (unsigned i = 0; i < 4; i++) {
        stp_chunk *chunk = make_chunk(&all[i]);
        stp_square squares[SQUARES];
        stp_square_map map = {0};
        stp_table table = {0};
        stp_patch was[SQUARES];
        for (uint32_t p = 0; p < SQUARES; p++)
            memcpy(chunk->patches[p].bound_centre, chunk->samples[3][p].position,
                   sizeof chunk->patches[p].bound_centre);
        memcpy(was, chunk->patches, sizeof was);
        assert_true(stp_squares_find(chunk, squares));
        assert_int_equal(stp_square_map_create(chunk, squares, false, &map, NULL), STP_OK);
        assert_int_equal(stp_table_create(&table, STP_PATCH_COLUMN_COUNT, SQUARES, NULL), STP_OK);
        stp_placed_encode(chunk, &map, &table);
        for (uint32_t p = 0; p < SQUARES; p++)
            for (unsigned column = 1; column < 5 && !all[i].holes; column += 2)
                assert_in_range(stp_table_column(&table, column)[p] + 1, 0, 2);
        for (uint32_t p = 0; p < SQUARES; p++)
            memset(chunk->patches[p].origin, 0, sizeof chunk->patches[p].origin);
        stp_placed_decode(chunk, &map, &table);
        assert_memory_equal(chunk->patches, was, sizeof was);
        free(table.values);
        stp_square_map_clear(&map);
        stp_chunk_destroy(&chunk);
    }
}

/* Rounded errors, and axes on a grid, come back; cells count their steps. */
static void test_shifts(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 16; i++) {
        const unsigned errors = i % 4, axes = i < 12 ? i : STP_NORMAL_SHIFT_MOST;
        stp_chunk *chunk = make_chunk(&recipes[0]);
        stp_patch was[SQUARES];
        stp_table table = {.tight = true};
        stp_patch_shifts shifts = {0};
        for (uint32_t p = 0; p < SQUARES; p++) {
            stp_patch *patch = &chunk->patches[p];
            const int32_t uv[2] = {stp_normal_grid_code(1 + (int32_t)p % 2, axes),
                                   stp_normal_grid_code(4095 >> axes, axes)};
            stp_normal_codes_put(uv, patch->cone_axis);
            for (int l = 1; l < 4; l++) {
                patch->error[l] = (uint8_t)((9 + p) << errors);
                patch->tangential_error[l] = (uint8_t)((11 - p % 2) << errors);
            }
            patch->error[0] = 3;
            memset(patch->quarter_error, patch->error[1], sizeof patch->quarter_error);
            memset(patch->quarter_tangential_error, patch->tangential_error[1],
                   sizeof patch->quarter_tangential_error);
        }
        memcpy(was, chunk->patches, sizeof was);
        assert_int_equal(stp_table_create(&table, STP_PATCH_COLUMN_COUNT, SQUARES, NULL), STP_OK);
        stp_patches_encode(chunk->patches, &table);
        const stp_patch_shifts found = stp_patch_shifts_find(chunk);
        stp_patch_shifts_encode(&found, chunk, &table);
        assert_int_equal(stp_table_column(&table, 14)[1], 1);
        assert_int_equal(stp_table_column(&table, 24)[1], -1);
        assert_int_equal(abs(stp_table_column(&table, 43)[1]), 1);
        const uint32_t bits = stp_patch_shifts_bits(&found);
        assert_int_equal(bits, errors | axes << 2);
        assert_int_equal(stp_patch_shifts_take(bits, &shifts, NULL), STP_OK);
        stp_patch_shifts_decode(&shifts, &table);
        stp_patches_decode(chunk->patches, &table);
        for (uint32_t p = 0; p < SQUARES; p++) {
            const stp_patch *patch = &chunk->patches[p];
            assert_memory_equal(patch->cone_axis, was[p].cone_axis, sizeof patch->cone_axis);
            assert_memory_equal(patch->error, was[p].error, sizeof patch->error);
            assert_memory_equal(patch->quarter_tangential_error, was[p].quarter_tangential_error,
                                sizeof patch->quarter_tangential_error);
        }
        free(table.values);
        stp_chunk_destroy(&chunk);
    }
    stp_patch_shifts none;
    assert_int_equal(stp_patch_shifts_take((STP_NORMAL_SHIFT_MOST + 1) << 2, &none, NULL),
                     STP_CORRUPT);
}

/* Squares that contradict the patches or each other. */
static void test_squares(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(&recipes[0]);
    stp_square squares[SQUARES], decoded[SQUARES];
    stp_square_map map = {0};
    stp_bytes bytes = {0};
    stp_table table = {0};
    stp_square first = {.column = FIRST_COLUMN / 8, .row = FIRST_ROW / 8};
    assert_true(stp_squares_find(chunk, squares));
    assert_int_equal(stp_square_map_create(chunk, squares, true, &map, NULL), STP_OK);
    stp_square_map_clear(&map);
    squares[2].column += 300; /* a rectangle of 304 x 3 squares for 12 */
    assert_int_equal(stp_square_map_create(chunk, squares, true, &map, NULL), STP_CORRUPT);
    squares[2].column -= 301; /* the square of patch 1 */
    assert_int_equal(stp_square_map_create(chunk, squares, true, &map, NULL), STP_CORRUPT);
    squares[2].column++;
    squares[2].samples &= squares[2].samples - 1;
    assert_int_equal(stp_squares_encode(chunk, squares, &bytes, &table, NULL), STP_OK);
    assert_int_equal(stp_squares_decode(&table, chunk, &first, decoded, NULL), STP_OK);
    chunk->squares = decoded;
    assert_int_equal(stp_squares_check(chunk, NULL), STP_CORRUPT);
    decoded[2].samples |= decoded[2].samples + 1;
    assert_int_equal(stp_squares_check(chunk, NULL), STP_OK);
    chunk->squares = NULL;
    for (int i = 0; i < 2; i++) /* not the bytes between fields */
        assert_true(decoded[i].samples == squares[i].samples && decoded[i].raster == 0 &&
                    decoded[i].column == squares[i].column && decoded[i].row == squares[i].row);
    free(bytes.data);
    free(table.values);
    stp_chunk_destroy(&chunk);
}

/* Lack of memory anywhere in the decoding of two blocks is an error, and nothing is lost. */
static void test_memory(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(&(recipe){.holes = true, .tilted = true});
    chunk->block_ends = calloc(2, sizeof *chunk->block_ends);
    assert_non_null(chunk->block_ends);
    chunk->block_count = 2;
    chunk->block_ends[0] = SQUARES / 2;
    chunk->block_ends[1] = SQUARES;
    coded bytes = encode(chunk);
    stp_status status = STP_OUT_OF_MEMORY;
    int count = 0;
    for (; status == STP_OUT_OF_MEMORY; count++) {
        stp_chunk *decoded = make_room(chunk, 0);
        left = count;
        status = decode(&bytes, decoded);
        left = -1;
        stp_chunk_destroy(&decoded);
    }
    assert_int_equal(status, STP_OK);
    assert_true(count > 20);
    clear(&bytes);
    stp_chunk_destroy(&chunk);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),      cmocka_unit_test(test_size),
        cmocka_unit_test(test_points),          cmocka_unit_test(test_hostile),
        cmocka_unit_test(test_numbers),         cmocka_unit_test(test_squares),
        cmocka_unit_test(test_tilted_numbers),  cmocka_unit_test(test_memory),
        cmocka_unit_test(test_spread_numbers),  cmocka_unit_test(test_spread_squares),
        cmocka_unit_test(test_many_squares),    cmocka_unit_test(test_placed),
        cmocka_unit_test(test_shifts),          cmocka_unit_test(test_fold),
        cmocka_unit_test(test_fold_directions),
    };
    return cmocka_run_group_tests_name("squares of a grid", tests, NULL, NULL);
}
