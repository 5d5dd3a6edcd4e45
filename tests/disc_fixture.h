/* Chunk files of a few discs given one by one: each a patch of its own, and a class of its own, so
 * that any of them can be drawn alone. Failures end the test. */
#ifndef STP_TESTS_DISC_FIXTURE_H
#define STP_TESTS_DISC_FIXTURE_H

#include "tests/chunk_fixture.h"
#include "tests/support/check.h"

#include <stdbool.h>

/* As given, and once written as the file has it. */
typedef struct fixture_disc {
    stp_dvec3 position;
    stp_dvec3 normal; /* zero: unknown */
    double radius;
    bool oriented;
    stp_sample_kind kind;
} fixture_disc;

/* Steps of 1/4096 unit, or as fine as codes of radii reach. */
static inline int fixture_disc_exponent(double radius)
{
    int exponent = -12;
    while (ldexp(1.0, exponent + 15) < radius)
        exponent++;
    return exponent;
}

static inline stp_sample fixture_disc_sample(const fixture_disc *disc, int exponent, uint8_t class)
{
    bool known = stp_dvec3_length(disc->normal) > 0.0;
    stp_sample s = {.radius = stp_radius_encode(disc->radius, exponent),
                    .class_id = class,
                    .rgb = {255, 255, 255},
                    .intensity = 255};
    s.flags = (uint8_t)((disc->oriented ? STP_SAMPLE_ORIENTED : 0u) |
                        (known ? STP_SAMPLE_HAS_NORMAL : 0u) |
                        (unsigned)disc->kind << STP_SAMPLE_KIND_SHIFT);
    stp_normal_encode(
        (vec3s){{(float)disc->normal.x, (float)disc->normal.y, (float)disc->normal.z}}, s.normal);
    return s;
}

static inline void fixture_disc_put(stp_chunk *chunk, uint32_t i, fixture_disc *disc)
{
    stp_patch *patch = &chunk->patches[i];
    int exponent = fixture_disc_exponent(disc->radius);
    stp_sample sample = fixture_disc_sample(disc, exponent, (uint8_t)i);
    patch->exponent = (int16_t)exponent;
    patch->origin[0] = (int32_t)lround(ldexp(disc->position.x, -exponent));
    patch->origin[1] = (int32_t)lround(ldexp(disc->position.y, -exponent));
    patch->origin[2] = (int32_t)lround(ldexp(disc->position.z, -exponent));
    patch->flags = STP_PATCH_TWO_SIDED;
    patch->bound_radius = sample.radius;
    patch->cone_angle = stp_cone_angle_encode(M_PI);
    stp_normal_encode((vec3s){{0.0f, 0.0f, 1.0f}}, patch->cone_axis);
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        chunk->samples[l][chunk->level_begin[l][i]] = sample;
        patch->radius[l] = sample.radius;
    }
    disc->position = stp_sample_position(&sample, patch);
    disc->radius = stp_sample_radius(&sample, patch);
    if (stp_dvec3_length(disc->normal) > 0.0)
        disc->normal = stp_dvec3_from_float(stp_normal_decode(sample.normal));
}

/* Writes up to 256 discs, number i of class i, and makes them what was written. */
static inline void fixture_discs_write(fixture_disc *discs, uint32_t count, const char *path)
{
    uint8_t counts[256];
    fixture_tree tree = {.box = stp_dbox_empty()};
    memset(counts, 1, sizeof counts);
    stp_chunk *chunk = fixture_allocate(counts, count);
    for (uint32_t i = 0; i < count; i++) {
        fixture_disc_put(chunk, i, &discs[i]);
        stp_dbox_add(&tree.box, discs[i].position);
        if (discs[i].kind == STP_KIND_RIBBON || discs[i].kind == STP_KIND_TUBE)
            tree.attributes_more = STP_HAS_LINES;
    }
    fixture_add(&tree, chunk, (stp_dvec3){0.0, 0.0, 0.0}, count);
    check_ok(fixture_write(&tree, path, STP_CODEC_RAW, err));
    fixture_destroy(&tree);
}

#endif
