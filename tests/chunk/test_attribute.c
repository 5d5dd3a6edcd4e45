/* Tests attributes: numbers of every type come back, in fewer bytes where they are alike; hostile
 * bytes are refused; each level-0 sample's number is stored once. */
#include "formats/attribute/attribute_list.h"
#include "formats/chunk/attribute/attribute_codec.h"
#include "formats/chunk/attribute/attribute_json.h"
#include "formats/chunk/attribute/attribute_order.h"

#include "tests/fixtures/any_chunk.h"

#include <math.h>
#include <string.h>

#define COUNT 5000u

static uint64_t words[COUNT], back[COUNT], guesses[COUNT];

static uint64_t word_of(double value)
{
    uint64_t word;
    memcpy(&word, &value, sizeof word);
    return word;
}

/* Encodes and decodes `count` words. Returns the bytes they took. */
static size_t round_trip(stp_attribute_type type, const uint64_t *guess, uint32_t count)
{
    stp_bytes out = {0};
    stp_error err = {0};
    stp_steps steps;
    assert_int_equal(stp_attribute_steps(type, words, count, &steps, &err), STP_OK);
    assert_int_equal(stp_attribute_encode(type, words, guess, &steps, count, &out, &err), STP_OK);
    memset(back, 0xa5, sizeof back);
    assert_int_equal(stp_attribute_decode(type, out.data, out.size, guess, count, back, &err),
                     STP_OK);
    assert_memory_equal(words, back, count * sizeof *words);
    const size_t size = out.size;
    free(out.data);
    return size;
}

/* A packed number of any bits is a word and comes back. */
static uint64_t any_word(stp_attribute_type type, uint64_t bits)
{
    uint8_t packed[8];
    stp_attribute_put(type, bits, packed);
    return stp_attribute_get(type, packed);
}

static void test_names(void **state)
{
    static const stp_attribute_list list = {
        .count = 5,
        .items = {{.name = "return_number"},
                  {.name = "number_of_returns"},
                  {.name = "gps_time"},
                  {.name = "time"},
                  {.name = "scan_angle"}},
    };
    static const struct {
        const char *words;
        uint32_t index;
    } meant[] = {{"return_number", 0}, {"return", 0},    {"returns", 1},
                 {"time", 3},          {"gps-time", 2},  {"angle", 4},
                 {"-angle", 4},        {"number", 1},    {"n", 1},
                 {"e", UINT32_MAX},    {"", UINT32_MAX}, {"return_numbers", UINT32_MAX}};
    (void)state;
    for (size_t i = 0; i < sizeof meant / sizeof *meant; i++)
        assert_int_equal(stp_attribute_match(&list, meant[i].words), meant[i].index);
}

static void test_any_numbers(void **state)
{
    (void)state;
    for (int type = 0; type < STP_ATTRIBUTE_TYPE_COUNT; type++)
        for (uint32_t count = 0; count <= COUNT; count = count < 4 ? count + 1 : count * 5) {
            for (uint32_t i = 0; i < count; i++) {
                const uint64_t extremes[] = {0,           UINT64_MAX, INT64_MAX,  (uint64_t)1 << 63,
                                             0x7fff,      0x8000,     0x7fffffff, 0x80000000u,
                                             word_of(NAN)};
                const uint64_t bits = i % 3 ? stp_random_u64(7, i) : extremes[i / 3 % 9];
                words[i] = any_word((stp_attribute_type)type, bits);
                guesses[i] = stp_random_u64(9, i);
            }
            round_trip((stp_attribute_type)type, NULL, count);
            round_trip((stp_attribute_type)type, guesses, count);
        }
}

/* What scanners write takes little room: bytes a number are bounded. */
static void test_sizes(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < COUNT; i++)
        words[i] = 7;
    assert_true(round_trip(STP_ATTRIBUTE_U16, NULL, COUNT) < 24);
    for (uint32_t i = 0; i < COUNT; i++)
        words[i] = stp_random_unit(3, i) < 0.02;
    assert_true(round_trip(STP_ATTRIBUTE_U8, NULL, COUNT) < COUNT / 32);
    /* two passes of a scanner, a microsecond's decimals: the times jump between them */
    for (uint32_t i = 0; i < COUNT; i++) {
        const double begin = stp_random_unit(4, i) < 0.5 ? 245370.417706 : 246012.25;
        words[i] = word_of(nearbyint((begin + i * 1e-5) * 1e6) / 1e6);
    }
    assert_true(round_trip(STP_ATTRIBUTE_F64, NULL, COUNT) < COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        guesses[i] = 257 * (stp_random_u64(5, i) % 256);
        words[i] = (guesses[i] + stp_random_u64(6, i) % 16) & 0xffff;
    }
    assert_true(round_trip(STP_ATTRIBUTE_U16, guesses, COUNT) < COUNT * 3 / 4);
}

/* Pulses every 236.55 ticks of a clock, whose tick is 1467.4587 ulps; of each line of 90 pulses
 * and two flights some are left. In an order of places, not of time. */
static void make_pulses(uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t line = stp_random_u64(20, i / 3) % 400, pulse = stp_random_u64(21, i) % 90;
        const double ticks = nearbyint((double)(line * 1123 + pulse + i % 2 * 40000000) * 236.5511);
        words[i] = word_of(245379.25) + (uint64_t)nearbyint(ticks * 1467.4587);
    }
}

/* Times of a clock take as many bits as there are pulses to choose from, whatever its steps. */
static void test_steps(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_steps steps;
    make_pulses(COUNT);
    assert_int_equal(stp_attribute_steps(STP_ATTRIBUTE_F64, words, COUNT, &steps, &err), STP_OK);
    assert_int_equal(steps.count, 2);
    assert_true(fabs(steps.of[0] - 1467.4587) < 1e-4);
    assert_true(fabs(steps.of[1] - 236.5511) < 1e-4);
    assert_true(round_trip(STP_ATTRIBUTE_F64, NULL, COUNT) < COUNT * 7 / 2);
    for (uint32_t i = 0; i < COUNT; i++)
        words[i] = word_of(nearbyint((double)(stp_random_u64(22, i) % 20000) * 10.07) / 1e6);
    assert_true(round_trip(STP_ATTRIBUTE_F64, NULL, COUNT) < COUNT * 9 / 4);
}

/* Cut, lengthened and flipped parts are refused or decode to something, but never harm. */
static void try_hostile(stp_attribute_type type, uint32_t count)
{
    stp_bytes out = {0};
    stp_error err = {0};
    stp_steps steps;
    assert_int_equal(stp_attribute_steps(type, words, count, &steps, &err), STP_OK);
    assert_int_equal(stp_attribute_encode(type, words, NULL, &steps, count, &out, &err), STP_OK);
    for (size_t size = 0; size < out.size; size++)
        assert_int_equal(stp_attribute_decode(type, out.data, size, NULL, count, back, &err),
                         STP_CORRUPT);
    assert_int_equal(stp_attribute_decode(type, out.data, out.size, NULL, 0, back, &err),
                     STP_CORRUPT);
    for (size_t bit = 0; bit < 8 * out.size; bit++) {
        out.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
        (void)stp_attribute_decode(type, out.data, out.size, NULL, count, back, NULL);
        (void)stp_attribute_decode(STP_ATTRIBUTE_F32, out.data, out.size, NULL, count, back, NULL);
        out.data[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    free(out.data);
}

static void test_hostile(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 300; i++)
        words[i] = stp_random_u64(8, i) % 100000;
    try_hostile(STP_ATTRIBUTE_U32, 300);
    make_pulses(300);
    try_hostile(STP_ATTRIBUTE_F64, 300);
}

/* Steps that are none, too many of them, and multiples beyond 64 bits are refused. */
static void test_hostile_steps(void **state)
{
    (void)state;
    static const double wrong[] = {0.0, 0.5, -2.0, INFINITY, NAN, 0x1p41};
    stp_bytes out = {0};
    stp_error err = {0};
    stp_steps steps;
    make_pulses(COUNT);
    assert_int_equal(stp_attribute_steps(STP_ATTRIBUTE_F64, words, COUNT, &steps, &err), STP_OK);
    assert_int_equal(
        stp_attribute_encode(STP_ATTRIBUTE_F64, words, NULL, &steps, COUNT, &out, &err), STP_OK);
    assert_int_equal(out.data[0], 4); /* coded by steps: their number at byte 11, the first at 12 */
    uint8_t head[21];
    memcpy(head, out.data, sizeof head);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong + 3; i++) {
        if (i < sizeof wrong / sizeof *wrong)
            memcpy(out.data + 12, &wrong[i], 8);
        else if (i < sizeof wrong / sizeof *wrong + 2)
            out.data[11] = i % 2 ? 0 : 3;
        else
            out.data[20] = 5; /* pieces of a group */
        assert_int_equal(
            stp_attribute_decode(STP_ATTRIBUTE_F64, out.data, out.size, NULL, COUNT, back, &err),
            STP_CORRUPT);
        memcpy(out.data, head, sizeof head);
    }
    const int64_t parts[3] = {0, 0, INT64_MAX};
    int64_t sum;
    assert_false(stp_steps_join(&steps, parts, &sum));
    free(out.data);
}

/* Types that hold two others hold their extremes, and one number more if some are missing. */
static void test_join(void **state)
{
    (void)state;
    for (int a = 0; a < STP_ATTRIBUTE_TYPE_COUNT; a++)
        for (int b = 0; b < STP_ATTRIBUTE_TYPE_COUNT; b++)
            for (int missing = 0; missing < 2; missing++) {
                const stp_attribute_type to =
                    stp_attribute_join((stp_attribute_type)a, (stp_attribute_type)b, missing != 0);
                const int from[2] = {a, b};
                for (int k = 0; k < 2; k++)
                    for (int e = 0; e < 2; e++) {
                        const stp_attribute_type own = (stp_attribute_type)from[k];
                        const stp_attribute plain = {.type = own, .scale = 1.0};
                        const stp_attribute wide = {.type = to, .scale = 1.0};
                        const uint64_t word = any_word(own, e ? UINT64_MAX : (uint64_t)1 << 63);
                        const double value = stp_attribute_value(&plain, word);
                        const uint64_t moved = stp_attribute_convert(own, word, to);
                        if (isnan(value))
                            continue;
                        assert_true(stp_attribute_value(&wide, moved) == value);
                        if (missing && !stp_attribute_is_float(to))
                            assert_true((int64_t)moved != stp_attribute_spare(to));
                    }
            }
}

static void test_json(void **state)
{
    (void)state;
    stp_attribute_list list = {.count = 2}, read;
    stp_error err = {0};
    char *text = NULL;
    list.items[0] = (stp_attribute){.name = "gps_time", .type = STP_ATTRIBUTE_F64, .scale = 1.0};
    list.items[1] = (stp_attribute){.name = "scan angle",
                                    .type = STP_ATTRIBUTE_I16,
                                    .scale = 0.006,
                                    .offset = -1.5,
                                    .has_missing = true,
                                    .missing = INT64_MAX};
    assert_int_equal(stp_attribute_list_write(&list, &text, &err), STP_OK);
    assert_int_equal(stp_attribute_list_read(&read, text, strlen(text), &err), STP_OK);
    assert_int_equal(read.count, 2);
    for (uint32_t i = 0; i < 2; i++) {
        assert_string_equal(read.items[i].name, list.items[i].name);
        assert_int_equal(read.items[i].type, list.items[i].type);
        assert_true(read.items[i].scale == list.items[i].scale);
        assert_true(read.items[i].offset == list.items[i].offset);
        assert_int_equal(read.items[i].missing, list.items[i].missing);
    }
    free(text);
    static const char *const wrong[] = {
        "",
        "{}",
        "[1]",
        "[{}]",
        "[{\"name\":\"a\"}]",
        "[{\"name\":\"a\",\"type\":\"u7\"}]",
        "[{\"name\":\"\",\"type\":\"u8\"}]",
        "[{\"name\":\"a\\u0007\",\"type\":\"u8\"}]",
        "[{\"name\":\"a\",\"type\":\"u8\",\"scale\":0}]",
        "[{\"name\":\"a\",\"type\":\"u8\",\"scale\":\"1\"}]",
        "[{\"name\":\"a\",\"type\":\"u8\",\"missing\":5}]",
        "[{\"name\":\"a\",\"type\":\"u8\",\"coarse\":\"x\"}]",
        "[{\"name\":\"a\",\"type\":\"u8\"},{\"name\":\"a\",\"type\":\"u8\"}]"};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(stp_attribute_list_read(&read, wrong[i], strlen(wrong[i]), &err),
                         STP_CORRUPT);
}

/* Each level-0 sample is in the order once; a level's part has those that no coarser level has; and
 * each sample's lender lies under it. */
static void test_order(void **state)
{
    (void)state;
    stp_chunk *chunk = any_chunk(60, STP_PATCH_SAMPLES, 11, 0);
    stp_attribute_order order = {0};
    stp_error err = {0};
    uint32_t seen[60 * STP_PATCH_SAMPLES] = {0};
    assert_int_equal(stp_attribute_order_make(&order, chunk, &err), STP_OK);
    for (int k = 0; k < STP_LEVEL_COUNT; k++) {
        const int level = STP_LEVEL_COUNT - 1 - k;
        assert_int_equal(order.ends[k], chunk->level_begin[level][chunk->patch_count]);
        for (uint32_t i = k ? order.ends[k - 1] : 0; i < order.ends[k]; i++)
            seen[order.places[i]]++;
    }
    for (uint32_t i = 0; i < chunk->level_begin[0][chunk->patch_count]; i++)
        assert_int_equal(seen[i], 1);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        const stp_sample *samples[STP_LEVEL_COUNT];
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            samples[l] = chunk->samples[l] + chunk->level_begin[l][p];
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            for (unsigned i = 0; i < patch->counts[l]; i++) {
                const unsigned lender = stp_attribute_lender(patch, samples, l, i);
                assert_true(lender >= stp_covered_begin(patch->counts, l, i, 0));
                assert_true(lender < stp_covered_begin(patch->counts, l, i + 1, 0));
            }
        assert_int_equal(order.of_vertex[p],
                         chunk->level_begin[0][p] + stp_attribute_lender(patch, samples, 3, 0));
    }
    stp_attribute_order_clear(&order);
    stp_chunk_destroy(&chunk);
}

/* Names that are none; a source whose own numbers are missing joins one without. */
static void test_union(void **state)
{
    (void)state;
    static const char *const none[] = {"", "x", "y", "z", "a\n", "\xc3\xa9", "a"};
    stp_attribute_list plain = {0}, missing = {0};
    stp_attribute_union all = {0};
    assert_non_null(stp_attribute_list_add(&plain, "a", STP_ATTRIBUTE_U8));
    for (size_t i = 0; i < sizeof none / sizeof *none; i++)
        assert_null(stp_attribute_list_add(&plain, none[i], STP_ATTRIBUTE_U8));
    stp_attribute *own = stp_attribute_list_add(&missing, "a", STP_ATTRIBUTE_U8);
    own->has_missing = true;
    own->missing = 255;
    assert_true(stp_attribute_union_add(&all, &missing));
    assert_true(stp_attribute_union_add(&all, &missing));
    assert_int_equal(all.list.items[0].type, STP_ATTRIBUTE_U8);
    assert_true(stp_attribute_union_add(&all, &plain)); /* its 255 is a number */
    const stp_attribute *a = &all.list.items[0];
    assert_int_equal(a->type, STP_ATTRIBUTE_U16);
    assert_int_equal(stp_attribute_union_word(a, own, 255), 65535);
    assert_int_equal(stp_attribute_union_word(a, own, 254), 254);
    assert_int_equal(stp_attribute_union_word(a, &plain.items[0], 255), 255);
    assert_true(isnan(stp_attribute_value(a, 65535)));
    stp_attribute_union turned = {0};
    assert_true(stp_attribute_union_add(&turned, &plain));
    assert_true(stp_attribute_union_add(&turned, &missing));
    assert_true(turned.list.items[0].has_missing);
    assert_int_equal(turned.list.items[0].type, STP_ATTRIBUTE_U16);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_names), cmocka_unit_test(test_any_numbers),
        cmocka_unit_test(test_sizes), cmocka_unit_test(test_hostile),
        cmocka_unit_test(test_steps), cmocka_unit_test(test_hostile_steps),
        cmocka_unit_test(test_join),  cmocka_unit_test(test_json),
        cmocka_unit_test(test_order), cmocka_unit_test(test_union),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
