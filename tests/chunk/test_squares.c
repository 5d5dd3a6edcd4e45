/* Tests blocks of squares: samples come back whatever they are, at every level; what is no square
 * of the grid is coded as points; hostile bytes are refused or decoded, never followed; and each
 * allocation of decoding fails once. */
#include "formats/chunk/codec/square_map.h"
#include "formats/chunk/codec/square_normal.h"

#include "base/random.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/normal_grid.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define CODEC STP_CODEC_DRACO_BLOCKS
/* Squares of the test's block; they begin at square (3, 5). */
enum { ACROSS = 4, DOWN = 3, SQUARES = ACROSS * DOWN, FIRST_COLUMN = 24, FIRST_ROW = 40 };
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

/* A level one; tilted ones: one whose corner is no float, a short one, one that spreads. */
enum { RASTERS = 4, SPREADING = 3 };
static const stp_raster rasters[RASTERS] = {
    {.level = true, .axis = 2, .across = {{-17.0, 0.5}, {90.0, 0.0, -0.25}}},
    {.axis = 0, .across = {{11.1, 0.5, 0.125, -0.75}, {-5.0, -0.25, 0.5, 0.375}}},
    {.axis = 1, .across = {{3.0, -0.375, 0.25, 0.5}, {7.0, 0.25, 0.4375, -0.875}}},
    {.axis = 2,
     .across = {{5.0, 1.5, 0.125, -1.25, 0.03125, 0.0078125},
                {-9.0, 0.0, 1.25, -1.5, 0.0078125, 0.03125}}}};

/* What a test makes its samples of. */
typedef struct recipe {
    bool wild;   /* fields of all samples are random, but for places */
    bool holes;  /* every ninth sample is missing */
    bool tilted; /* squares are of two tilted grids, in turns; else of the level one */
    bool spread; /* of the one that spreads, and two patches have one square, half of it each */
    int octaves; /* exponents of patches differ by as many */
    uint64_t seed;
} recipe;

static bool is_missing(const recipe *r, uint32_t square, unsigned i)
{
    if (r->spread && stp_square_column(i) / 4 != square % 2)
        return true;
    return r->holes && (square * 64 + i) % 9 == 4;
}

static double height(double column, double row)
{
    return 3.0 * sin(column / 6.0) + 2.0 * cos(row / 5.0) + 0.2 * column;
}

static void fill_fields(const recipe *r, stp_sample *s, uint64_t i)
{
    const uint64_t random = stp_random_u64(r->seed, i);
    *s = (stp_sample){.radius = 80,
                      .flags = STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL,
                      .normal = {0, 8, 128},
                      .rgb = {100, 120, (uint8_t)(i % 7 + 90)}};
    if (!r->wild)
        return;
    memcpy(s, &random, sizeof random);
    memcpy(s->normal, &random, sizeof s->normal);
    s->rgb[1] = (uint8_t)(random >> 24);
    s->flags &= (uint8_t)~STP_SAMPLE_KIND_MASK;
}

static uint32_t raster_of_patch(const recipe *r, uint32_t p)
{
    return r->spread ? SPREADING : r->tilted ? 1 + p % 2 : 0;
}

/* A place of a grid at a height, in steps. */
static void find_place(const stp_raster *raster, double column, double row, double z, double steps,
                       double out[3])
{
    out[raster->axis] = z;
    for (unsigned k = 0; k < 2; k++) {
        const double *a = raster->across[k];
        out[(raster->axis + 1 + k) % 3] =
            (a[0] + column * a[1] + row * a[2]) * steps + (a[3] + column * a[4] + row * a[5]) * z;
    }
}

/* Puts a sample at a place of the grid. */
static void put(const recipe *r, const stp_raster *raster, const stp_patch *patch, double column,
                double row, stp_sample *s)
{
    const double steps = ldexp(1.0, -patch->exponent);
    const unsigned within =
        r->tilted || r->spread ? 0x3fff : 0xffff; /* so that the other axes fit, too */
    const double z =
        r->wild ? (double)patch->origin[raster->axis] + (s->position[raster->axis] & within)
                : nearbyint(height(column, row) * steps);
    double at[3];
    find_place(raster, column, row, z, steps, at);
    for (unsigned i = 0; i < 3; i++)
        s->position[i] = (uint16_t)(lrint(at[i]) - patch->origin[i]);
}

static void fill_patch(const recipe *r, stp_chunk *chunk, uint32_t p)
{
    stp_patch *patch = &chunk->patches[p];
    const uint32_t square = r->spread ? p / 2 * 2 : p;
    const uint32_t column = FIRST_COLUMN + square % ACROSS * 8;
    const uint32_t row = FIRST_ROW + square / ACROSS * 8;
    const stp_raster *raster = &rasters[raster_of_patch(r, p)];
    const double steps = ldexp(1.0, -patch->exponent);
    double middle[3];
    find_place(raster, column + 3.5, row + 3.5, 0.0, steps, middle);
    for (int i = 0; i < 3; i++)
        patch->origin[i] = (int32_t)floor(middle[i] - 20.0 * steps);
    uint32_t next = chunk->level_begin[0][p];
    for (unsigned i = 0; i < 64; i++) {
        if (is_missing(r, p, i))
            continue;
        stp_sample *s = &chunk->samples[0][next];
        fill_fields(r, s, next++);
        put(r, raster, patch, column + stp_square_column(i), row + stp_square_row(i), s);
    }
    for (int l = 1; l < STP_LEVEL_COUNT; l++)
        for (uint32_t i = chunk->level_begin[l][p]; i < chunk->level_begin[l][p + 1]; i++) {
            fill_fields(r, &chunk->samples[l][i], i + 9999u * (unsigned)l);
            put(r, raster, patch, column + 3.5, row + 3.5, &chunk->samples[l][i]);
        }
}

static stp_chunk *make_chunk(const recipe *r)
{
    stp_chunk *chunk = NULL;
    uint8_t counts[SQUARES][STP_LEVEL_COUNT] = {{0}};
    uint32_t all[STP_LEVEL_COUNT] = {0};
    for (uint32_t p = 0; p < SQUARES; p++) {
        for (unsigned i = 0; i < 64; i++)
            counts[p][0] = (uint8_t)(counts[p][0] + !is_missing(r, p, i));
        for (int l = 0; l < STP_LEVEL_COUNT; l++) {
            if (l > 0)
                counts[p][l] = (uint8_t)stp_level_count_above(counts[p][l - 1]);
            all[l] += counts[p][l];
        }
    }
    assert_int_equal(stp_chunk_create(&chunk, SQUARES, all, 0, NULL), STP_OK);
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        for (uint32_t p = 0; p < SQUARES; p++)
            chunk->level_begin[l][p + 1] = chunk->level_begin[l][p] + counts[p][l];
    for (uint32_t p = 0; p < SQUARES; p++) {
        memcpy(chunk->patches[p].counts, counts[p], sizeof counts[p]);
        chunk->patches[p].child = STP_PATCH_NO_CHILD;
        chunk->patches[p].exponent = (int16_t)(-10 + (p == 5 ? r->octaves : 0));
        fill_patch(r, chunk, p);
    }
    chunk->reach = 2;
    chunk->raster_count = RASTERS;
    chunk->rasters = malloc(sizeof rasters);
    assert_non_null(chunk->rasters);
    memcpy(chunk->rasters, rasters, sizeof rasters);
    return chunk;
}

/* The segments of a chunk. */
typedef struct coded {
    stp_bytes segment[STP_SEGMENT_COUNT];
} coded;

static coded encode(const stp_chunk *chunk)
{
    coded out = {0};
    for (int s = 0; s < STP_SEGMENT_COUNT; s++)
        assert_int_equal(stp_segment_encode(chunk, s, CODEC, &out.segment[s], NULL), STP_OK);
    return out;
}

static size_t size_of(const coded *c)
{
    return c->segment[0].size + c->segment[1].size + c->segment[2].size;
}

static void clear(coded *c)
{
    for (int s = 0; s < STP_SEGMENT_COUNT; s++)
        free(c->segment[s].data);
}

/* Decodes the segments that hold the levels down to `finest`; `allocations` as `left`. */
static stp_status decode(const coded *c, const stp_chunk *like, int finest, int allocations,
                         stp_chunk **out)
{
    stp_chunk_scratch scratch = {0};
    stp_status status = STP_OK;
    uint32_t counts[STP_LEVEL_COUNT];
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        counts[l] = like->level_begin[l][SQUARES];
    assert_int_equal(stp_chunk_create(out, SQUARES, counts, finest, NULL), STP_OK);
    left = allocations;
    for (int s = 0; status == STP_OK && s < stp_segment_count(finest); s++) {
        /* A copy of its own, so that a read beyond its end is found. */
        uint8_t *bytes = malloc(c->segment[s].size);
        assert_non_null(bytes);
        memcpy(bytes, c->segment[s].data, c->segment[s].size);
        status = stp_segment_decode(bytes, c->segment[s].size, s, CODEC, 0, *out, &scratch, NULL);
        free(bytes);
    }
    left = -1;
    stp_chunk_scratch_free(&scratch);
    return status;
}

static void assert_same(const stp_chunk *a, const stp_chunk *b)
{
    assert_memory_equal(a->patches, b->patches, SQUARES * sizeof *a->patches);
    for (int l = b->finest_level; l < STP_LEVEL_COUNT; l++)
        assert_memory_equal(a->samples[l], b->samples[l],
                            a->level_begin[l][SQUARES] * sizeof *a->samples[l]);
}

/* Encodes and decodes to each level. Returns whether the block was coded as squares. */
static bool round_trip(const recipe *r, const stp_chunk *chunk)
{
    coded bytes = encode(chunk);
    bool squares = false;
    for (int finest = 2; finest >= 0; finest--) {
        stp_chunk *decoded = NULL;
        assert_int_equal(decode(&bytes, chunk, finest, -1, &decoded), STP_OK);
        assert_same(chunk, decoded);
        squares = stp_chunk_is_squares(decoded);
        for (uint32_t p = 0; squares && p < SQUARES; p++) {
            const stp_square *s = &decoded->squares[p];
            assert_int_equal(s->row, FIRST_ROW / 8 + p / ACROSS);
            assert_memory_equal(&decoded->rasters[s->raster], &rasters[raster_of_patch(r, p)],
                                sizeof *rasters);
        }
        if (squares && finest == 0 && !r->spread) /* else the writer chooses */
            assert_int_equal(decoded->reach, 2);
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
                                 {.spread = true, .wild = true, .octaves = 1, .seed = 4}};
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

static stp_status decode_changed(const coded *c, const stp_chunk *like)
{
    stp_chunk *decoded = NULL;
    const stp_status status = decode(c, like, 0, -1, &decoded);
    stp_chunk_destroy(&decoded);
    return status;
}

/* Any byte changed: refused or decoded. Cut anywhere: refused. */
static void test_hostile(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        stp_chunk *chunk =
            make_chunk(&(recipe){.holes = true, .tilted = kind == 1, .spread = kind == 2});
        coded bytes = encode(chunk);
        for (int s = 0; s < STP_SEGMENT_COUNT; s++)
            for (size_t i = 0; i < bytes.segment[s].size; i++) {
                uint8_t *at = bytes.segment[s].data + i;
                const uint8_t was = *at;
                *at ^= (uint8_t)(1u << i % 8);
                const stp_status status = decode_changed(&bytes, chunk);
                assert_true(status == STP_OK || status == STP_CORRUPT);
                *at = was;
            }
        for (int s = 0; s < STP_SEGMENT_COUNT; s++)
            for (size_t size = 1, whole = bytes.segment[s].size; size < whole; size += 3) {
                bytes.segment[s].size = size;
                assert_int_equal(decode_changed(&bytes, chunk), STP_CORRUPT);
                bytes.segment[s].size = whole;
            }
        clear(&bytes);
        stp_chunk_destroy(&chunk);
    }
}

/* Where the part of a segment of one block begins; in segment 0, where its raster does. */
static uint8_t *part_of(coded *c, int s)
{
    stp_block_row row;
    const stp_bytes bytes = c->segment[s];
    assert_int_equal(stp_block_rows_read(bytes.data, bytes.size, s, &row, 1, NULL), STP_OK);
    return bytes.data + row.begin + (s > 0 ? 0 : HEAD_BYTES);
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
    const uint8_t choices[] = {128 + 6, 128 + 16, 255, 1}; /* 128: tight */
    for (unsigned i = 0; i < 4; i++)
        for (unsigned k = 0; k < 3; k++)
            assert_refused(&bytes, chunk, part_of(&bytes, 0) + 8 * i, &numbers[k], 8);
    assert_refused(&bytes, chunk, part_of(&bytes, 0) + 16, &zero, 8);
    assert_refused(&bytes, chunk, part_of(&bytes, 0) + 24, &zero, 8);
    assert_refused(&bytes, chunk, part_of(&bytes, 0) + 32, far, 4);
    assert_refused(&bytes, chunk, part_of(&bytes, 0) + 36, far, 4);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++)
        for (unsigned k = 0; k < 4; k++)
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
    assert_int_equal(stp_square_map_create(chunk, squares, &map, NULL), STP_OK);
    stp_square_map_clear(&map);
    squares[SQUARES - 1].column = first + most;
    assert_int_equal(stp_square_map_create(chunk, squares, &map, NULL), STP_CORRUPT);
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
            stp_square_unfold(back, (const int32_t[2]){u, v}, TOP);
            assert_true(back[0] == u && back[1] == v);
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
    assert_int_equal(stp_square_map_create(chunk, squares, &map, NULL), STP_OK);
    stp_square_map_clear(&map);
    squares[2].column += 300; /* a rectangle of 304 x 3 squares for 12 */
    assert_int_equal(stp_square_map_create(chunk, squares, &map, NULL), STP_CORRUPT);
    squares[2].column -= 301; /* the square of patch 1 */
    assert_int_equal(stp_square_map_create(chunk, squares, &map, NULL), STP_CORRUPT);
    squares[2].column++;
    squares[2].samples &= squares[2].samples - 1;
    assert_int_equal(stp_squares_encode(chunk, squares, &bytes, &table, NULL), STP_OK);
    assert_int_equal(stp_squares_decode(&table, chunk, &first, decoded, NULL), STP_CORRUPT);
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
        stp_chunk *decoded = NULL;
        status = decode(&bytes, chunk, 0, count, &decoded);
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
        cmocka_unit_test(test_round_trip),     cmocka_unit_test(test_size),
        cmocka_unit_test(test_points),         cmocka_unit_test(test_hostile),
        cmocka_unit_test(test_numbers),        cmocka_unit_test(test_squares),
        cmocka_unit_test(test_tilted_numbers), cmocka_unit_test(test_memory),
        cmocka_unit_test(test_spread_numbers), cmocka_unit_test(test_spread_squares),
        cmocka_unit_test(test_fold),           cmocka_unit_test(test_fold_directions),
    };
    return cmocka_run_group_tests_name("squares of a grid", tests, NULL, NULL);
}
