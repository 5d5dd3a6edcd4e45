/* Tests known answers: the reader must find in the files of tests/known/files the samples, and the
 * numbers of attributes, that their texts list, and `verify` must find the files sound. With a path
 * as argument, the program prints such a text, as tests/known/read.py does; test_known_reader.sh
 * uses this. */
#include "formats/chunk/attribute/attribute_file.h"
#include "formats/chunk/chunk_file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void print_number(FILE *out, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        fprintf(out, "%02x", (unsigned)(value >> 8 * i & 255u));
}

static void print_bytes(FILE *out, const uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++)
        fprintf(out, "%02x", bytes[i]);
}

/* Prints the 64 bytes of SPEC.md's table, and first_below. */
static void print_patch(FILE *out, const stp_patch *patch, bool linked)
{
    fputs("patch ", out);
    for (int i = 0; i < 3; i++)
        print_number(out, (uint32_t)patch->origin[i], 4);
    print_number(out, (uint16_t)patch->exponent, 2);
    print_number(out, patch->child, 1);
    print_number(out, patch->cone_angle, 1);
    print_bytes(out, patch->counts, sizeof patch->counts);
    print_bytes(out, patch->error, sizeof patch->error);
    print_bytes(out, patch->tangential_error, sizeof patch->tangential_error);
    print_bytes(out, patch->colour_error, sizeof patch->colour_error);
    print_bytes(out, patch->radius, sizeof patch->radius);
    for (int i = 0; i < 3; i++)
        print_number(out, patch->bound_centre[i], 2);
    print_number(out, patch->bound_radius, 1);
    print_bytes(out, patch->cone_axis, sizeof patch->cone_axis);
    print_number(out, patch->flags, 1);
    print_number(out, 0, 1);
    for (int i = 0; i < 2; i++)
        print_bytes(out, patch->quarter_error[i], STP_PATCH_QUARTERS);
    for (int i = 0; i < 2; i++)
        print_bytes(out, patch->quarter_tangential_error[i], STP_PATCH_QUARTERS);
    if (linked)
        fprintf(out, " %u\n", patch->first_below);
    else
        fputs(" -\n", out);
}

static void print_sample(FILE *out, int level, const stp_sample *sample)
{
    fprintf(out, "%d ", level);
    for (int i = 0; i < 3; i++)
        print_number(out, sample->position[i], 2);
    print_number(out, sample->radius, 1);
    print_number(out, sample->flags, 1);
    print_bytes(out, sample->normal, sizeof sample->normal);
    print_number(out, sample->class_id, 1);
    print_bytes(out, sample->rgb, sizeof sample->rgb);
    print_number(out, sample->intensity, 1);
    fputc('\n', out);
}

static void print_chunk(FILE *out, const stp_chunk *chunk)
{
    fprintf(out, "chunk %u\n", chunk->id);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        print_patch(out, &chunk->patches[p], chunk->linked);
        for (int l = STP_LEVEL_COUNT - 1; l >= 0; l--)
            for (uint32_t i = chunk->level_begin[l][p]; i < chunk->level_begin[l][p + 1]; i++)
                print_sample(out, l, &chunk->samples[l][i]);
    }
}

static stp_status print_file(FILE *out, const char *path, stp_error *err)
{
    stp_chunk_file *file = NULL;
    stp_status status = stp_chunk_file_open(&file, path, err);
    if (status != STP_OK)
        return status;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    fprintf(out, "version %u.%u attributes %u chunks %u points %llu\n", info->version_major,
            info->version_minor, info->attributes, info->chunk_count,
            (unsigned long long)info->point_count);
    for (uint32_t id = 0; status == STP_OK && id < info->chunk_count; id++) {
        stp_chunk *chunk = NULL;
        status = stp_chunk_file_read(file, id, 0, &chunk, err);
        if (status == STP_OK)
            print_chunk(out, chunk);
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    return status;
}

/* Prints a line for each point of a leaf, as attributes.py does: its numbers as unsigned words of
 * their type. */
static void print_numbers(FILE *out, stp_chunk_file *file, stp_attribute_file *attributes,
                          uint32_t id)
{
    const stp_attribute_list *list = stp_attribute_file_list(attributes);
    stp_chunk *chunk = NULL;
    stp_error err = {0};
    assert_int_equal(stp_chunk_file_read(file, id, 0, &chunk, &err), STP_OK);
    const uint32_t count = chunk->level_begin[0][chunk->patch_count];
    uint64_t *words = calloc((size_t)list->count * count + 1, sizeof *words);
    assert_non_null(words);
    for (uint32_t a = 0; a < list->count; a++)
        if (stp_attribute_file_read(attributes, a, chunk, 0, words + (size_t)a * count, &err))
            fail_msg("chunk %u: %s", id, err.message);
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t a = 0; a < list->count; a++) {
            const uint64_t unused = 64 - 8 * stp_attribute_bytes(list->items[a].type);
            fprintf(out, "%llu%c",
                    (unsigned long long)(words[(size_t)a * count + i] << unused >> unused),
                    a + 1 < list->count ? ' ' : '\n');
        }
    free(words);
    stp_chunk_destroy(&chunk);
}

static void print_attributes(FILE *out, const char *path)
{
    stp_chunk_file *file = NULL;
    stp_attribute_file *attributes = NULL;
    stp_error err = {0};
    assert_int_equal(stp_chunk_file_open(&file, path, &err), STP_OK);
    assert_int_equal(stp_attribute_file_open(&attributes, file, &err), STP_OK);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        assert_int_equal(stp_chunk_file_entry(file, id, &entry, &err), STP_OK);
        if (entry.child_count == 0)
            print_numbers(out, file, attributes, id);
    }
    stp_attribute_file_close(&attributes);
    stp_chunk_file_close(&file);
}

/* Makes the path of a file in tests/known/files. */
static void known_path(char path[1024], const char *name, const char *ending)
{
    const char *source = getenv("STIPPLE_SOURCE");
    assert_non_null(source); /* the source folder, set by CTest */
    snprintf(path, 1024, "%s/tests/known/files/%s%s", source, name, ending);
}

static char *read_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    long size = ftell(file);
    assert_true(size > 0);
    rewind(file);
    char *text = malloc((size_t)size + 1);
    assert_non_null(text);
    assert_int_equal(fread(text, 1, (size_t)size, file), size);
    text[size] = 0;
    fclose(file);
    return text;
}

/* Compares line by line, so that a failure says which sample differs. */
static void expect_same_lines(const char *path, const char *found, const char *expected)
{
    for (unsigned line = 1; *found || *expected; line++) {
        size_t found_size = strcspn(found, "\n"), expected_size = strcspn(expected, "\n");
        if (found_size != expected_size || memcmp(found, expected, found_size) != 0)
            fail_msg("%s: line %u is '%.*s', expected '%.*s'", path, line, (int)found_size, found,
                     (int)expected_size, expected);
        found += found_size + (found[found_size] == '\n');
        expected += expected_size + (expected[expected_size] == '\n');
    }
}

static void check_answer(const char *name, const char *codec)
{
    char path[1024], answer[1024], ending[32], command[2200];
    char *found = NULL;
    size_t size = 0;
    stp_error err = {0};
    snprintf(ending, sizeof ending, "_%s.stipple", codec);
    known_path(path, name, ending);
    known_path(answer, name, ".samples");
    FILE *out = open_memstream(&found, &size);
    assert_non_null(out);
    stp_status status = print_file(out, path, &err);
    assert_int_equal(fclose(out), 0);
    if (status != STP_OK)
        fail_msg("%s: %s", path, err.message);
    char *expected = read_text(answer);
    expect_same_lines(path, found, expected);
    free(expected);
    free(found);
    snprintf(command, sizeof command, "'%s' verify '%s' --quiet", getenv("STIPPLE"), path);
    assert_int_equal(system(command), 0);
}

static void check_numbers(const char *name, const char *codec)
{
    char path[1024], answer[1024], ending[32], *found = NULL;
    size_t size = 0;
    snprintf(ending, sizeof ending, "_%s.stipple", codec);
    known_path(path, name, ending);
    known_path(answer, name, ".numbers");
    FILE *out = open_memstream(&found, &size);
    assert_non_null(out);
    print_attributes(out, path);
    assert_int_equal(fclose(out), 0);
    char *expected = read_text(answer);
    expect_same_lines(path, found, expected);
    free(expected);
    free(found);
}

static void check_codecs(const char *name)
{
    check_answer(name, "raw");
    check_answer(name, "draco");
    check_answer(name, "zstd");
}

static void test_version_1_0(void **state)
{
    (void)state;
    check_codecs("points_1_0");
}

static void test_version_1_1(void **state)
{
    (void)state;
    check_codecs("lines_1_1");
}

static void test_version_1_2(void **state)
{
    (void)state;
    check_codecs("fits_1_2");
}

static void test_version_2_0(void **state)
{
    (void)state;
    check_codecs("blocks_2_0");
    check_codecs("grid_2_0");
    check_codecs("odds_2_0");
    check_codecs("scale_2_0");
    check_codecs("middles_2_0");
    check_codecs("squares_2_0");
    check_codecs("maps_2_0");
    check_codecs("tight/points_2_0");
    check_codecs("tight/maps_2_0");
    check_codecs("tight/squares_2_0");
    check_codecs("tight/tilted_2_0");
    check_codecs("depth/2_0");
    check_codecs("records/2_0");
    check_codecs("short/maps_2_0");
    check_codecs("ladder/2_0");
    check_codecs("loose/2_0");
    check_codecs("states/2_0");
    check_codecs("rows/2_0");
    check_codecs("coarse/2_0");
    check_codecs("known/2_0");
    check_codecs("slanted/2_0");
    check_codecs("signed/2_0");
    check_codecs("known/level_2_0");
    check_codecs("known/depth_2_0");
    check_codecs("corners/2_0");
    check_codecs("sides/2_0");
    check_codecs("turns/2_0");
    check_codecs("painted/2_0");
    check_codecs("parents/2_0");
    check_codecs("strides/2_0");
    check_codecs("placed/level_2_0");
    check_codecs("placed/tilted_2_0");
    check_codecs("placed/depth_2_0");
    check_codecs("camera/depth_2_0");
    check_codecs("camera/turned_2_0");
    check_codecs("rounded/depth_2_0");
    check_codecs("rounded/tilted_2_0");
    check_codecs("steps/2_0");
    check_codecs("steps/loose_2_0");
    check_codecs("jumps/2_0");
    check_codecs("paper/2_0");
    check_answer("paper/2_0", "paper");
}

static void test_attributes(void **state)
{
    (void)state;
    check_codecs("attributes_2_0");
    check_numbers("attributes_2_0", "raw");
    check_numbers("attributes_2_0", "draco");
    check_numbers("attributes_2_0", "zstd");
}

static void test_version_2_1(void **state)
{
    (void)state;
    check_codecs("grown/2_1");
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_version_1_0), cmocka_unit_test(test_version_1_1),
        cmocka_unit_test(test_version_1_2), cmocka_unit_test(test_version_2_0),
        cmocka_unit_test(test_attributes),  cmocka_unit_test(test_version_2_1),
    };
    if (argc == 2) {
        stp_error err = {0};
        if (print_file(stdout, argv[1], &err) == STP_OK)
            return 0;
        fprintf(stderr, "%s\n", err.message);
        return 1;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
