/* Tests corners of triangles that are told once: those that are equal are found, on any lattices,
 * and cost few bits; any blocks come back; hostile bytes are refused. */
#include "formats/chunk/codec/predict/corners.h"

#include "tests/fixtures/any_chunk.h"

#include <math.h>

/* Corners of the chunk are some of these, anywhere on the coarsest lattice of a patch. */
typedef struct vertex {
    int32_t at[3];
    stp_sample sample;
} vertex;

enum { COARSEST = 3, VERTICES = 400 };

static vertex vertex_of(uint64_t seed, uint64_t number)
{
    vertex out = {.sample = {.flags = STP_KIND_POLYGON << STP_SAMPLE_KIND_SHIFT}};
    for (unsigned i = 0; i < 3; i++) {
        out.at[i] =
            ((int32_t)(stp_random_u64(seed, 9 * number + i) % 1000) - 500) * (1 << COARSEST);
        out.sample.normal[i] = (uint8_t)stp_random_u64(seed, 9 * number + 3 + i);
        out.sample.rgb[i] = (uint8_t)stp_random_u64(seed, 9 * number + 6 + i);
    }
    out.sample.class_id = (uint8_t)(number % 3);
    out.sample.radius = number % 4 == 0 ? (uint8_t)(100 + number % 50) : 0; /* on lattice 0 */
    return out;
}

/* A block of patches of random samples, most of them triangles. *numbers: by level-0 sample its
 * vertex, -1 if it is of no triangle; to be freed. */
static stp_chunk *block_of(uint32_t patches, unsigned vertices, uint64_t seed, int32_t **numbers)
{
    stp_chunk *chunk = any_chunk(patches, 63, seed, 0);
    *numbers = calloc(chunk->level_begin[0][patches], sizeof **numbers);
    assert_non_null(*numbers);
    chunk->is_block = true;
    for (uint32_t p = 0; p < patches; p++) {
        stp_patch *patch = &chunk->patches[p];
        const bool triangles = patch->counts[0] % 3 == 0;
        if (triangles)
            patch->flags |= STP_PATCH_TRIANGLES;
        patch->exponent = (int16_t)(stp_random_u64(seed + 7, p) % (COARSEST + 1));
        for (int i = 0; i < 3; i++)
            patch->origin[i] = -((8192 + 17 * (int32_t)p) >> patch->exponent);
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            const uint64_t number = stp_random_u64(seed + 8, i) % vertices;
            const vertex v = vertex_of(seed, number);
            stp_sample *out = &chunk->samples[0][i];
            (*numbers)[i] = triangles ? (int32_t)number : -1;
            if (!triangles)
                continue;
            *out = v.sample;
            out->radius = (uint8_t)(v.sample.radius ? v.sample.radius - 16 * patch->exponent : 0);
            for (int k = 0; k < 3; k++)
                out->position[k] = (uint16_t)((v.at[k] >> patch->exponent) - patch->origin[k]);
        }
    }
    return chunk;
}

/* How many different vertices there are from sample `from` on, before sample `to`. */
static uint32_t different(const int32_t *numbers, uint32_t from, uint32_t to)
{
    bool seen[VERTICES] = {false};
    uint32_t count = 0;
    for (uint32_t i = from; i < to; i++)
        if (numbers[i] >= 0 && !seen[numbers[i]]) {
            seen[numbers[i]] = true;
            count++;
        }
    return count;
}

static void equal_corners_are_found(void **state)
{
    (void)state;
    for (unsigned vertices = 1; vertices <= VERTICES; vertices *= 20) {
        int32_t *numbers;
        stp_corners corners = {0};
        uint32_t recalled = 0;
        stp_chunk *chunk = block_of(30, vertices, vertices, &numbers);
        assert_true(stp_has_corners(chunk));
        assert_int_equal(stp_corners_find(chunk, &corners, NULL), STP_OK);
        assert_non_null(corners.of);
        for (uint32_t i = 0; i < chunk->level_begin[0][30]; i++) {
            const stp_corner *c = &corners.of[i];
            uint32_t last = i;
            while (last-- > 0 && numbers[last] != numbers[i])
                continue;
            if (numbers[i] < 0 || last == UINT32_MAX) {
                assert_int_equal(c->ago, 0);
                continue;
            }
            recalled++;
            assert_int_equal(c->sample, last);
            assert_in_range(last, chunk->level_begin[0][c->patch],
                            chunk->level_begin[0][c->patch + 1] - 1);
            assert_int_equal(c->ago, different(numbers, last, i));
        }
        assert_int_equal(recalled, corners.recalled[0] + corners.recalled[1]);
        stp_corners_clear(&corners);
        free(numbers);
        stp_chunk_destroy(&chunk);
    }
}

/* All comes back. Vertices are random: some 16 bytes each. A corner that is recalled costs what it
 * takes to tell one of them. */
static void blocks_come_back(void **state)
{
    (void)state;
    stp_chunk_scratch scratch = {0};
    for (unsigned vertices = 1; vertices <= VERTICES; vertices *= 20) {
        int32_t *numbers;
        stp_chunk *chunk = block_of(30, vertices, 100 + vertices, &numbers);
        any_chunk_round_trip(chunk, STP_CODEC_DRACO, &scratch);
        stp_bytes bytes = {0};
        uint32_t corners = 0, others = 0, told = different(numbers, 0, chunk->level_begin[0][30]);
        for (uint32_t i = 0; i < chunk->level_begin[0][30]; i++) {
            corners += numbers[i] >= 0;
            others += numbers[i] < 0;
        }
        assert_int_equal(stp_segment_encode(chunk, 2, STP_CODEC_DRACO, &bytes, NULL), STP_OK);
        const double most = 18.5 * (others + told) + corners * (3.0 + log2(vertices)) / 8.0;
        print_message("%u vertices: %zu bytes, at most %.0f\n", vertices, bytes.size, most);
        assert_true((double)bytes.size < most);
        free(bytes.data);
        free(numbers);
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_scratch_free(&scratch);
}

/* ---- hostile ---- */

/* The finest segment after the others, from memory of its own. */
static stp_status decoded(const stp_chunk *chunk, const stp_bytes *bytes, size_t size)
{
    stp_chunk *out = any_chunk_empty_like(chunk);
    stp_chunk_scratch scratch = {0};
    uint8_t *exact = malloc(size + 1); /* so that a sanitizer sees reads behind the end */
    assert_non_null(exact);
    memcpy(exact + 1, bytes->data, size);
    memcpy(out->patches, chunk->patches, chunk->patch_count * sizeof *chunk->patches);
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        const uint32_t *begin = chunk->level_begin[l];
        memcpy(out->level_begin[l], begin, (chunk->patch_count + 1) * sizeof *begin);
        if (l > 0)
            memcpy(out->samples[l], chunk->samples[l],
                   begin[chunk->patch_count] * sizeof(stp_sample));
    }
    const stp_status status =
        stp_segment_decode(exact + 1, size, 2, STP_CODEC_DRACO, 0, out, &scratch, NULL);
    stp_chunk_scratch_free(&scratch);
    free(exact);
    stp_chunk_destroy(&out);
    return status;
}

static void damage_is_refused(void **state)
{
    (void)state;
    int32_t *numbers;
    stp_bytes bytes = {0};
    stp_chunk *chunk = block_of(6, 20, 5, &numbers);
    assert_int_equal(stp_segment_encode(chunk, 2, STP_CODEC_DRACO, &bytes, NULL), STP_OK);
    assert_int_equal(decoded(chunk, &bytes, bytes.size), STP_OK);
    for (size_t cut = 0; cut < bytes.size; cut++)
        assert_int_equal(decoded(chunk, &bytes, cut), STP_CORRUPT);
    for (size_t bit = 0; bit < 8 * bytes.size; bit++) {
        bytes.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        (void)decoded(chunk, &bytes, bytes.size);
        bytes.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    free(bytes.data);
    free(numbers);
    stp_chunk_destroy(&chunk);
}

static void corners_must_have_been_told(void **state)
{
    (void)state;
    static const uint32_t agos[] = {1, 15, 16, 17, 65535, 65550};
    int32_t *numbers;
    stp_chunk *chunk = block_of(2, VERTICES, 3, &numbers);
    chunk->patches[0].flags |= STP_PATCH_TRIANGLES;
    for (size_t i = 0; i < sizeof agos / sizeof *agos; i++) {
        stp_corners corners = {0}, back = {0};
        stp_symbol_writer w = {0};
        stp_symbol_reader r;
        stp_bytes bytes = {0};
        stp_error err = {0};
        corners.of = calloc(chunk->level_begin[0][2], sizeof *corners.of);
        assert_non_null(corners.of);
        corners.of[0].ago = agos[i];
        assert_int_equal(stp_corners_put(chunk, &corners, 0, &w, NULL), STP_OK);
        assert_int_equal(stp_symbols_write(&w, &bytes, NULL), STP_OK);
        assert_int_equal(stp_symbols_begin(&r, bytes.data, bytes.size, NULL), STP_OK);
        assert_int_equal(stp_corners_get(&r, 0, chunk, &back, &err), STP_CORRUPT);
        assert_non_null(strstr(err.message, "never told"));
        stp_corners_clear(&corners);
        stp_corners_clear(&back);
        free(w.items);
        free(bytes.data);
    }
    free(numbers);
    stp_chunk_destroy(&chunk);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(equal_corners_are_found),
        cmocka_unit_test(blocks_come_back),
        cmocka_unit_test(damage_is_refused),
        cmocka_unit_test(corners_must_have_been_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
