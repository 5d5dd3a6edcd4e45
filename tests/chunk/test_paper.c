/* Tests the codec of maps as their paper stores them: squares and normals are as they were, a
 * sample takes 48 bits for height and normal, angles are those of the normal, and what is damaged
 * is refused. */
#define CODEC STP_CODEC_PAPER
#include "formats/chunk/codec/paper.h"

#include "formats/chunk/layout.h"
#include "formats/chunk/sample/normal_grid.h"
#include "tests/fixtures/square_recipe.h"

/* Encodes and decodes to each level. Returns whether the block was coded as squares. */
static bool round_trip(const stp_chunk *chunk)
{
    coded bytes = encode(chunk);
    bool squares = false;
    for (int finest = 2; finest >= 0; finest--) {
        stp_chunk *decoded = make_room(chunk, finest);
        assert_int_equal(decode(&bytes, decoded), STP_OK);
        assert_same(chunk, decoded);
        squares = stp_chunk_is_squares(decoded);
        stp_chunk_destroy(&decoded);
    }
    clear(&bytes);
    return squares;
}

static void test_round_trip(void **state)
{
    (void)state;
    static const recipe recipes[] = {{0},
                                     {.holes = true, .octaves = 8},
                                     {.wild = true, .holes = true, .octaves = 1, .seed = 2},
                                     {.tilted = true, .holes = true},
                                     {.tilted = true, .wild = true, .octaves = 1, .seed = 3},
                                     {.spread = true, .wild = true, .seed = 4}};
    for (size_t i = 0; i < sizeof recipes / sizeof *recipes; i++) {
        stp_chunk *chunk = make_chunk(&recipes[i]);
        assert_true(round_trip(chunk));
        chunk->samples[0][70].position[0] += 700; /* 1.4 columns: it is a point */
        assert_false(round_trip(chunk));
        stp_chunk_destroy(&chunk);
    }
}

/* Samples that differ in height, normal and colour alone: 2 + 4 + 3 bytes each, and what all
 * share. */
static void test_size(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(&(recipe){.wild = true, .seed = 5});
    const uint32_t samples = chunk->level_begin[0][SQUARES];
    for (uint32_t i = 0; i < samples; i++) {
        stp_sample *s = &chunk->samples[0][i];
        s->radius = s->class_id = s->intensity = 7;
        s->rgb[0] = (uint8_t)i;
        s->flags = STP_SAMPLE_HAS_NORMAL;
    }
    coded bytes = encode(chunk);
    const size_t head = (size_t)(begin_of(&bytes, 2) - bytes.segment[2].data);
    assert_int_equal(bytes.segment[2].size - head, 2 + 9 * samples + 4 + 4);
    clear(&bytes);
    stp_chunk_destroy(&chunk);
}

/* The angles of a normal lead back to its code. Returns how far they are from its direction. */
static double check_normal(int32_t u, int32_t v)
{
    uint8_t code[3], back[3];
    uint16_t angles[2];
    stp_normal_codes_put((const int32_t[2]){u, v}, code);
    stp_paper_angles(code, angles);
    stp_paper_normal(angles, back);
    assert_memory_equal(code, back, sizeof code);
    const double turn = (angles[0] + 0.5) * 2.0 * M_PI / 65536.0;
    const double fall = (angles[1] + 0.5) * M_PI / 65536.0;
    const vec3s n = stp_normal_decode(code);
    return hypot(hypot(n.x - sin(fall) * cos(turn), n.y - sin(fall) * sin(turn)), n.z - cos(fall));
}

static void test_normals(void **state)
{
    (void)state;
    double most = 0.0;
    for (int32_t u = 0; u < 4096; u += u < 4 || u > 4090 ? 1 : 7)
        for (int32_t v = 0; v < 4096; v += v < 4 || v > 4090 ? 1 : 13)
            most = fmax(most, check_normal(u, v));
    for (int32_t k = 0; k < 4096; k++) /* where z = 0, and the axes */
        most = fmax(most, fmax(check_normal(k, (k + 2047) & 4095),
                               fmax(check_normal(k, 2047), check_normal(2048, k))));
    assert_true(most < 2.0 * M_PI / 65536.0);
}

static void test_hostile(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        stp_chunk *chunk =
            make_chunk(&(recipe){.holes = true, .tilted = kind == 1, .wild = kind == 2});
        damage(chunk);
        stp_chunk_destroy(&chunk);
    }
}

static stp_status decode_with(coded *c, const stp_chunk *like, uint8_t *at, uint16_t value)
{
    const uint16_t was = stp_get_u16(at);
    stp_put_u16(at, value);
    const stp_status status = decode_changed(c, like);
    stp_put_u16(at, was);
    return status;
}

/* Numbers that no writer writes: the kind of a block, fields beyond the last, samples that are
 * moved twice, that are not there, and more of them than there are bytes. */
static void test_numbers(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(&(recipe){.wild = true, .seed = 6});
    const uint32_t level = 1, samples = chunk->level_begin[level][SQUARES];
    coded bytes = encode(chunk);
    const stp_bytes *segment = &bytes.segment[1];
    uint8_t *kind = begin_of(&bytes, 0), *fields = begin_of(&bytes, 1);
    uint8_t *end = segment->data + segment->size, *count = fields + 2 + 10 * samples + 3;
    assert_int_equal(decode_changed(&bytes, chunk), STP_OK);
    assert_int_equal(stp_get_u16(fields), 0x19f); /* all vary but class, red, intensity */
    assert_int_equal(end - count, 4 + 6 * stp_get_u32(count));
    assert_in_range(stp_get_u32(count), 3, samples);
    assert_int_equal(decode_with(&bytes, chunk, kind, (uint16_t)(stp_get_u16(kind) | 3u)),
                     STP_CORRUPT);
    assert_int_equal(decode_with(&bytes, chunk, fields, 0x59f), STP_CORRUPT);
    assert_int_equal(decode_with(&bytes, chunk, count + 2, 0xffff), STP_CORRUPT);
    assert_int_equal(decode_with(&bytes, chunk, end - 6, stp_get_u16(end - 12)), STP_CORRUPT);
    assert_int_equal(decode_with(&bytes, chunk, end - 6, (uint16_t)samples), STP_CORRUPT);
    clear(&bytes);
    stp_chunk_destroy(&chunk);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip), cmocka_unit_test(test_size),
        cmocka_unit_test(test_normals),    cmocka_unit_test(test_hostile),
        cmocka_unit_test(test_numbers),
    };
    return cmocka_run_group_tests_name("maps of the paper", tests, NULL, NULL);
}
