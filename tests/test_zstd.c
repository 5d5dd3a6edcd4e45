/* Codec 2: families of any samples there and back, frames and levels that are not what they say. */
#include "formats/chunk/families.h"

#include "base/random.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/segment.h"
#include "formats/chunk/zstd_frame.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* A chunk of patches of any size with any samples: all bits random, all equal, or all at an end. */
static stp_chunk *make_chunk(uint32_t patch_count, unsigned most, uint64_t seed, int kind)
{
    uint32_t counts[STP_LEVEL_COUNT] = {0};
    uint8_t sizes[64];
    stp_chunk *chunk = NULL;
    for (uint32_t p = 0; p < patch_count; p++) {
        unsigned count = 1 + (unsigned)(stp_random_u64(seed, p) % most);
        sizes[p] = (uint8_t)count;
        for (int l = 0; l < STP_LEVEL_COUNT; l++, count = stp_level_count_above(count))
            counts[l] += count;
    }
    assert_int_equal(stp_chunk_create(&chunk, patch_count, counts, 0, NULL), STP_OK);
    for (uint32_t p = 0; p < patch_count; p++) {
        stp_patch *patch = &chunk->patches[p];
        uint64_t r = stp_random_u64(seed + 1, p);
        patch->child = STP_PATCH_NO_CHILD;
        patch->flags = STP_PATCH_TWO_SIDED;
        patch->exponent = (int16_t)((int)(r % 401) - 200);
        memcpy(patch->cone_axis, &r, 3);
        for (int i = 0; i < 3; i++)
            patch->origin[i] = (int32_t)(r >> (8 * i)) * (kind == 0 ? 1 : 7919);
        patch->counts[0] = sizes[p];
        for (int l = 0; l + 1 < STP_LEVEL_COUNT; l++)
            patch->counts[l + 1] = (uint8_t)stp_level_count_above(patch->counts[l]);
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            chunk->level_begin[l][p + 1] = chunk->level_begin[l][p] + patch->counts[l];
    }
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        for (size_t i = 0; i < counts[l] * sizeof(stp_sample) / 8; i++) {
            uint64_t value = stp_random_u64(seed + 2 + (uint64_t)l, i);
            value = kind == 0 ? value : kind == 1 ? UINT64_MAX : 0;
            memcpy((uint8_t *)chunk->samples[l] + 8 * i, &value, 8);
        }
    for (int l = 0; l < STP_LEVEL_COUNT; l++) /* the kinds that a surface has */
        for (uint32_t i = 0; i < counts[l]; i++)
            chunk->samples[l][i].flags &= (uint8_t)~STP_SAMPLE_KIND_MASK;
    return chunk;
}

static stp_chunk *empty_like(const stp_chunk *chunk)
{
    stp_chunk *out = NULL;
    uint32_t counts[STP_LEVEL_COUNT];
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        counts[l] = chunk->level_begin[l][chunk->patch_count];
    assert_int_equal(stp_chunk_create(&out, chunk->patch_count, counts, 0, NULL), STP_OK);
    return out;
}

static void round_trip(const stp_chunk *chunk, stp_chunk_scratch *scratch)
{
    stp_chunk *back = empty_like(chunk);
    stp_error err = {0};
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        stp_bytes bytes = {0};
        assert_int_equal(stp_segment_encode(chunk, s, STP_CODEC_ZSTD, &bytes, &err), STP_OK);
        uint8_t *exact = malloc(bytes.size); /* so that a sanitizer sees what is read behind it */
        assert_non_null(exact);
        memcpy(exact, bytes.data, bytes.size);
        assert_int_equal(
            stp_segment_decode(exact, bytes.size, s, STP_CODEC_ZSTD, 0, back, scratch, &err),
            STP_OK);
        free(exact);
        free(bytes.data);
    }
    assert_memory_equal(chunk->patches, back->patches, chunk->patch_count * sizeof *chunk->patches);
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        assert_memory_equal(chunk->samples[l], back->samples[l],
                            chunk->level_begin[l][chunk->patch_count] * sizeof(stp_sample));
    stp_chunk_destroy(&back);
}

static void test_any_samples(void **state)
{
    (void)state;
    stp_chunk_scratch scratch = {0};
    for (uint64_t seed = 0; seed < 60; seed++) {
        stp_chunk *chunk = make_chunk(1 + (uint32_t)(seed * 7 % 64), 1 + (unsigned)(seed * 11 % 64),
                                      seed, (int)(seed % 3));
        round_trip(chunk, &scratch);
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_scratch_free(&scratch);
}

/* A frame that is cut, extended, of another size, or no frame. */
static void test_frames(void **state)
{
    (void)state;
    uint8_t content[5000], out[5000];
    const size_t ends[] = {1000, 1001, 5000};
    stp_bytes frame = {0};
    stp_error err = {0};
    void *workspace = malloc(stp_zstd_workspace_bytes());
    void *context = stp_zstd_context(workspace);
    assert_non_null(context);
    for (size_t i = 0; i < sizeof content; i++)
        content[i] = (uint8_t)(stp_random_u64(9, i) % (1 + i / 100));
    assert_int_equal(stp_zstd_pack(content, ends, 3, &frame, &err), STP_OK);
    assert_int_equal(stp_zstd_unpack(frame.data, frame.size, out, sizeof out, context, &err),
                     STP_OK);
    assert_memory_equal(content, out, sizeof out);
    for (size_t cut = 0; cut < frame.size; cut++)
        assert_int_equal(stp_zstd_unpack(frame.data, cut, out, sizeof out, context, &err),
                         STP_CORRUPT);
    assert_int_equal(stp_zstd_unpack(frame.data, frame.size, out, sizeof out - 1, context, &err),
                     STP_CORRUPT);
    size_t one = frame.size;
    assert_int_equal(stp_bytes_append(&frame, frame.data, one, &err), STP_OK); /* two frames */
    assert_int_equal(stp_zstd_unpack(frame.data, frame.size, out, sizeof out, context, &err),
                     STP_CORRUPT);
    stp_put_u32(frame.data, 0x184D2A50u); /* one to be skipped */
    assert_int_equal(stp_zstd_unpack(frame.data, one, out, sizeof out, context, &err), STP_CORRUPT);
    free(frame.data);
    free(workspace);
}

/* Segments with any byte changed, cut or extended: an error or other samples, never harm. */
static void test_hostile_segments(void **state)
{
    (void)state;
    stp_chunk_scratch scratch = {0};
    stp_chunk *chunk = make_chunk(40, 64, 5, 0);
    stp_chunk *back = empty_like(chunk);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        stp_bytes bytes = {0};
        assert_int_equal(stp_segment_encode(chunk, s, STP_CODEC_ZSTD, &bytes, NULL), STP_OK);
        for (uint64_t i = 0; i < 2000; i++) {
            size_t size = i % 4 == 0 ? stp_random_u64(i, 1) % bytes.size : bytes.size;
            uint8_t *copy = malloc(size + 1);
            assert_non_null(copy);
            memcpy(copy, bytes.data, size);
            size_t within = i % 2 ? size : size < 40 ? size : 40; /* heads and masks more often */
            if (within > 0)
                copy[stp_random_u64(i, 2) % within] = (uint8_t)stp_random_u64(i, 3);
            (void)stp_segment_decode(copy, size, s, STP_CODEC_ZSTD, 0, back, &scratch, NULL);
            free(copy);
        }
        assert_int_equal(stp_bytes_append(&bytes, "x", 1, NULL), STP_OK);
        assert_int_equal(
            stp_segment_decode(bytes.data, bytes.size, s, STP_CODEC_ZSTD, 0, back, &scratch, NULL),
            STP_CORRUPT);
        assert_int_equal(stp_segment_decode(bytes.data, bytes.size - 1, s, STP_CODEC_ZSTD, 0, back,
                                            &scratch, NULL),
                         STP_OK); /* so that the next segment has what it needs */
        free(bytes.data);
    }
    stp_chunk_scratch_free(&scratch);
    stp_chunk_destroy(&chunk);
    stp_chunk_destroy(&back);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_any_samples),
                                       cmocka_unit_test(test_frames),
                                       cmocka_unit_test(test_hostile_segments)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
