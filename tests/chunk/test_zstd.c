/* Tests codec 2: families of any samples come back, and false frames and levels are refused. */
#include "formats/chunk/codec/families.h"

#include "base/random.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/codec/zstd_frame.h"
#include "formats/chunk/layout.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Makes a chunk of patches of any size. kind: random bits, all samples equal, or all at an
 * extreme. */
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
            patch->origin[i] = (int32_t)((uint32_t)(r >> (8 * i)) * (kind == 0 ? 1u : 7919u));
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
    for (int l = 0; l < STP_LEVEL_COUNT; l++) /* the kinds of samples that a surface has */
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
        uint8_t *exact = malloc(bytes.size); /* so that a sanitizer sees reads behind the end */
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

/* Frames that are cut, extended, of another size, or no frames. */
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
    assert_int_equal(stp_bytes_append(&frame, NULL, one, &err), STP_OK);
    memcpy(frame.data + one, frame.data, one); /* two frames */
    assert_int_equal(stp_zstd_unpack(frame.data, frame.size, out, sizeof out, context, &err),
                     STP_CORRUPT);
    stp_put_u32(frame.data, 0x184D2A50u); /* a frame to be skipped */
    assert_int_equal(stp_zstd_unpack(frame.data, one, out, sizeof out, context, &err), STP_CORRUPT);
    free(frame.data);
    free(workspace);
}

/* Segments with a changed byte, cut or extended: the result must be an error or other samples,
 * never harm. */
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
            size_t within = i % 2 ? size : size < 40 ? size : 40; /* more often in heads, masks */
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
                         STP_OK); /* so that the next segment has the levels that it needs */
        free(bytes.data);
    }
    stp_chunk_scratch_free(&scratch);
    stp_chunk_destroy(&chunk);
    stp_chunk_destroy(&back);
}

/* A payload as version 1.1 wrote it: it must stay readable. It holds the samples of make_chunk(2,
 * 9, 7, 0). */
static const uint8_t known_segments[] = {
    0x84, 0x00, 0x00, 0x00, 0x28, 0xb5, 0x2f, 0xfd, 0x20, 0xe4, 0xdd, 0x03, 0x00, 0x42, 0xce, 0x1d,
    0x27, 0x90, 0x55, 0xcd, 0x01, 0xe0, 0x29, 0x13, 0x75, 0x68, 0xbd, 0xa9, 0xae, 0xdc, 0xe4, 0x39,
    0xe9, 0xbb, 0x2a, 0x90, 0x95, 0xc3, 0x69, 0x90, 0xc9, 0x44, 0x8d, 0x05, 0xe3, 0x9d, 0x77, 0xbb,
    0x81, 0x0d, 0xcc, 0x0d, 0xaf, 0x9a, 0xdc, 0x29, 0x16, 0x4c, 0x62, 0xd0, 0x60, 0xfc, 0x1f, 0x0c,
    0x91, 0xe2, 0x2f, 0x20, 0x9a, 0xf4, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x9f, 0xd9,
    0x4c, 0xcf, 0x1a, 0xc8, 0xdc, 0xf4, 0x2a, 0xa9, 0x41, 0x4e, 0x83, 0x5d, 0x00, 0xae, 0x82, 0x09,
    0x26, 0x22, 0x90, 0xf0, 0x04, 0x1c, 0xbc, 0x87, 0x23, 0x61, 0x81, 0x50, 0x51, 0x04, 0xd4, 0xce,
    0xf5, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0x7f, 0x8b, 0xb6, 0x90, 0x55, 0xc9, 0xdc, 0xf4,
    0x38, 0x90, 0xcc, 0x51, 0x2e, 0xea, 0x13, 0x00, 0x00, 0x00, 0x00, 0x00, 0x28, 0xb5, 0x2f, 0xfd,
    0x20, 0x80, 0x45, 0x01, 0x00, 0x14, 0x02, 0x00, 0x4a, 0x6d, 0x44, 0x79, 0xab, 0x32, 0x41, 0x40,
    0x19, 0xcf, 0xa9, 0x40, 0xdd, 0xec, 0x92, 0x68, 0xe7, 0xd3, 0xaf, 0x04, 0x5f, 0x25, 0x4c, 0x51,
    0x91, 0x64, 0xe5, 0xc4, 0xe7, 0xd7, 0xcd, 0x07, 0x01, 0x00, 0xcc, 0xe4, 0x84, 0x00, 0x00, 0x00,
    0x00, 0x28, 0xb5, 0x2f, 0xfd, 0x20, 0x80, 0x2d, 0x03, 0x00, 0x02, 0x48, 0x18, 0x23, 0xa0, 0x6d,
    0x33, 0x5f, 0xb9, 0xf7, 0x04, 0x2a, 0xc4, 0xdd, 0x22, 0x8d, 0xbb, 0xa5, 0x78, 0xde, 0xdd, 0x8c,
    0x38, 0x1f, 0x29, 0x27, 0x23, 0x9f, 0x98, 0x24, 0x01, 0x31, 0x90, 0x58, 0x27, 0xb6, 0x84, 0x95,
    0x29, 0x83, 0x50, 0x61, 0x83, 0x70, 0x9a, 0xc8, 0x15, 0x28, 0x35, 0xb6, 0xcc, 0xa1, 0x83, 0x40,
    0x8d, 0x18, 0x0a, 0x0e, 0xc0, 0x52, 0xa5, 0x3c, 0x17, 0x50, 0x86, 0x91, 0xde, 0xc0, 0xfd, 0x47,
    0x78, 0x4b, 0xf2, 0xde, 0xe6, 0x13, 0xd8, 0x77, 0xda, 0x2f, 0x4e, 0x8f, 0xb9, 0x7e, 0x42, 0x79,
    0x93, 0xe3, 0x45, 0x82, 0xcf, 0xba, 0xff, 0x3e, 0x6f, 0x55, 0xfe, 0xe3, 0x35, 0x2f, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x28, 0xb5, 0x2f, 0xfd, 0x60, 0x00, 0x00, 0x01, 0x08, 0x00, 0x3b, 0xbb, 0xfd,
    0x7e, 0x1b, 0xb4, 0x2e, 0x4e, 0x00, 0x9c, 0x27, 0x68, 0xb1, 0x76, 0xc0, 0x84, 0x3e, 0x79, 0xbd,
    0x8c, 0x00, 0x3d, 0x7d, 0x85, 0x0e, 0xd5, 0x43, 0x72, 0x2a, 0x36, 0x39, 0xb3, 0x00, 0xf7, 0x63,
    0xcd, 0xec, 0xee, 0x59, 0xc1, 0xdc, 0xa6, 0x5a, 0x18, 0x00, 0x7e, 0x45, 0xab, 0x7b, 0x7b, 0x65,
    0xc5, 0x1d, 0x03, 0xa6, 0x28, 0x00, 0x5a, 0xd1, 0x56, 0x4b, 0xb0, 0x7a, 0xa5, 0x8b, 0xe4, 0xe5,
    0x14, 0x00, 0xb3, 0xf6, 0x1c, 0x0d, 0x55, 0xa0, 0x55, 0x42, 0xcd, 0x63, 0x4c, 0x00, 0xb4, 0x82,
    0xc4, 0x5f, 0x06, 0x96, 0xe8, 0x39, 0x4c, 0xb0, 0xb9, 0x00, 0x2a, 0x4f, 0x75, 0xaf, 0x32, 0x25,
    0x83, 0x3c, 0x32, 0x91, 0x5e, 0x00, 0x9d, 0x79, 0x72, 0xc8, 0xce, 0x55, 0x48, 0xa0, 0x0d, 0xb3,
    0x98, 0x00, 0x4d, 0x74, 0x33, 0x18, 0x27, 0x61, 0x25, 0x8b, 0x9e, 0x4b, 0x80, 0x00, 0xd1, 0x4c,
    0x38, 0xa4, 0xfd, 0xcf, 0x36, 0x5d, 0xda, 0xce, 0xca, 0x00, 0x47, 0xdf, 0x35, 0x1f, 0xea, 0x68,
    0x21, 0x2e, 0x67, 0x4a, 0x19, 0x00, 0x85, 0xb3, 0xed, 0xe2, 0x57, 0xd8, 0x33, 0x09, 0xbf, 0x0d,
    0xd2, 0x00, 0x7f, 0xf7, 0xa3, 0x38, 0xe4, 0xc1, 0x5c, 0xa4, 0x93, 0xae, 0x13, 0x00, 0x07, 0x92,
    0x8e, 0x79, 0xfd, 0xf3, 0x03, 0x6d, 0xe1, 0x02, 0x4b, 0x00, 0xd8, 0x9e, 0x31, 0x6e, 0x89, 0xc7,
    0xbc, 0xb5, 0x73, 0x82, 0x04, 0xff, 0xdb, 0xf7, 0xd9, 0x1c, 0x21, 0x28, 0xe9, 0xfc, 0xab, 0xf1,
    0x48, 0xdb, 0x3c, 0xae, 0x74, 0x82, 0x05, 0xa5, 0x12, 0xbb, 0x55, 0x22, 0x60, 0x62, 0xf4, 0xa7,
    0xac, 0x6b, 0xe5, 0x6e, 0x90, 0x16, 0xdf, 0x34, 0x99, 0xa5, 0xb9, 0x44, 0x73, 0x2d, 0x2b, 0x6c,
    0x99, 0xb7, 0x43, 0xb0, 0xd6, 0x13, 0x36, 0x04, 0xf1, 0xc9, 0xc4, 0xee, 0xbb,
};
static const uint16_t known_ends[STP_SEGMENT_COUNT] = {189, 303, 573};

static void test_known_answer(void **state)
{
    (void)state;
    stp_chunk_scratch scratch = {0};
    stp_chunk *chunk = make_chunk(2, 9, 7, 0);
    stp_chunk *back = empty_like(chunk);
    size_t begin = 0;
    assert_int_equal(sizeof known_segments, known_ends[STP_SEGMENT_COUNT - 1]);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        assert_int_equal(stp_segment_decode(known_segments + begin, known_ends[s] - begin, s,
                                            STP_CODEC_ZSTD, 0, back, &scratch, NULL),
                         STP_OK);
        begin = known_ends[s];
    }
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        assert_memory_equal(chunk->samples[l], back->samples[l],
                            chunk->level_begin[l][chunk->patch_count] * sizeof(stp_sample));
    stp_chunk_scratch_free(&scratch);
    stp_chunk_destroy(&chunk);
    stp_chunk_destroy(&back);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_samples), cmocka_unit_test(test_frames),
        cmocka_unit_test(test_hostile_segments), cmocka_unit_test(test_known_answer)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
