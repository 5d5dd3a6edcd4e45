/* Small valid chunk trees for tests: a bumpy height field cut into leaf chunks, and parents above.
 *
 * Everything lies on one lattice (exponent -7, chunk origins on whole steps), so that the samples
 * of a parent are exactly the patch vertices of its children. Deterministic. */
#ifndef STP_TESTS_CHUNK_FIXTURE_H
#define STP_TESTS_CHUNK_FIXTURE_H

#include "base/random.h"
#include "formats/chunk/chunk_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define FIXTURE_EXPONENT (-7)
#define FIXTURE_CHUNK_LIMIT 80
#define FIXTURE_METADATA "{\"sources\":[\"a height field\"],\"lambda\":1.7}"

static inline void fixture_require(int truth)
{
    if (!truth) {
        fprintf(stderr, "the test's own files cannot be made\n");
        abort();
    }
}

/* The program's temporary folder; empty until the first path is asked for. */
static char fixture_folder[64];

/* A path in the temporary folder; the last two stay valid. */
static inline const char *fixture_path(const char *name)
{
    static char path[2][256];
    static int turn;
    turn = !turn;
    if (!fixture_folder[0]) {
        snprintf(fixture_folder, sizeof fixture_folder, "/tmp/stipple-test-XXXXXX");
        fixture_require(mkdtemp(fixture_folder) != NULL);
    }
    snprintf(path[turn], sizeof path[turn], "%s/%s", fixture_folder, name);
    return path[turn];
}

/* A group's teardown. */
static inline int fixture_remove_folder(void **state)
{
    char command[300];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", fixture_folder);
    fixture_require(fixture_folder[0] && system(command) == 0);
    fixture_folder[0] = '\0';
    return 0;
}

static inline stp_sample fixture_merge(const stp_sample *s, unsigned count)
{
    stp_sample out = s[0];
    for (int i = 0; i < 3; i++) {
        unsigned position = 0;
        unsigned colour = 0;
        for (unsigned k = 0; k < count; k++) {
            position += s[k].position[i];
            colour += s[k].rgb[i];
        }
        out.position[i] = (uint16_t)(position / count);
        out.rgb[i] = (uint8_t)(colour / count);
    }
    for (unsigned k = 1; k < count; k++) {
        out.radius = s[k].radius > out.radius ? s[k].radius : out.radius;
        if (!(s[k].flags & STP_SAMPLE_OUTLIER))
            out.flags &= (uint8_t)~STP_SAMPLE_OUTLIER;
    }
    out.radius = (uint8_t)(out.radius + 16);
    return out;
}

#define FIXTURE_LEAF_ERROR 60
#define FIXTURE_ATTRIBUTES ((uint32_t)(STP_HAS_COLOUR | STP_HAS_INTENSITY | STP_HAS_OUTLIERS))

/* Coarser levels, bound, cone and errors (from `error` at level 0 on) of a patch whose level 0 is
 * there. */
static inline void fixture_finish_patch(stp_chunk *chunk, uint32_t index, int error)
{
    stp_patch *patch = &chunk->patches[index];
    unsigned greatest = 0;
    uint16_t low[3] = {65535, 65535, 65535};
    uint16_t high[3] = {0, 0, 0};
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        stp_sample *s = chunk->samples[l] + chunk->level_begin[l][index];
        for (unsigned j = 0; l > 0 && j < patch->counts[l]; j++) {
            unsigned begin = stp_level_children_begin(j, patch->counts[l], patch->counts[l - 1]);
            unsigned end = stp_level_children_begin(j + 1, patch->counts[l], patch->counts[l - 1]);
            s[j] = fixture_merge(chunk->samples[l - 1] + chunk->level_begin[l - 1][index] + begin,
                                 end - begin);
        }
        for (unsigned j = 0; j < patch->counts[l]; j++) {
            patch->radius[l] = s[j].radius > patch->radius[l] ? s[j].radius : patch->radius[l];
            for (int i = 0; i < 3; i++) {
                low[i] = s[j].position[i] < low[i] ? s[j].position[i] : low[i];
                high[i] = s[j].position[i] > high[i] ? s[j].position[i] : high[i];
            }
        }
        greatest = patch->radius[l] > greatest ? patch->radius[l] : greatest;
        /* generous codes: these patches are no surface, but their bounds must hold */
        int bound = error > 215 ? error : 215;
        patch->error[l] = (uint8_t)(l ? bound + 2 * l : error);
        patch->tangential_error[l] = (uint8_t)(l ? 215 + 2 * l : 0);
        patch->colour_error[l] = (uint8_t)(l ? 255 : 0);
        for (unsigned q = 0; (l == 1 || l == 2) && q < patch->counts[2]; q++) {
            patch->quarter_error[l - 1][q] = patch->error[l];
            patch->quarter_tangential_error[l - 1][q] = patch->tangential_error[l];
        }
    }
    double reach = 0.0;
    for (int i = 0; i < 3; i++) {
        patch->bound_centre[i] = (uint16_t)((low[i] + high[i]) / 2);
        reach += (high[i] - low[i]) + 1.0;
    }
    reach = ldexp(reach, FIXTURE_EXPONENT) + stp_radius_decode((uint8_t)greatest, FIXTURE_EXPONENT);
    patch->bound_radius = stp_radius_encode(reach, FIXTURE_EXPONENT);
    stp_normal_encode((vec3s){{0.0f, 0.0f, 1.0f}}, patch->cone_axis);
    patch->cone_angle = stp_cone_angle_encode(M_PI);
}

/* Fills level_begin from total level-0 samples of equal patches of up to per_patch samples. */
static inline stp_chunk *fixture_allocate(const uint8_t *counts, uint32_t patch_count)
{
    stp_chunk *chunk = NULL;
    uint32_t total[STP_LEVEL_COUNT] = {0};
    for (uint32_t i = 0; i < patch_count; i++) {
        unsigned count = counts[i];
        for (int l = 0; l < STP_LEVEL_COUNT; l++) {
            total[l] += count;
            count = stp_level_count_above(count);
        }
    }
    fixture_require(stp_chunk_create(&chunk, patch_count, total, 0, NULL) == STP_OK);
    memset(total, 0, sizeof total);
    for (uint32_t i = 0; i < patch_count; i++) {
        unsigned count = counts[i];
        for (int l = 0; l < STP_LEVEL_COUNT; l++) {
            chunk->patches[i].counts[l] = (uint8_t)count;
            chunk->level_begin[l][i] = total[l];
            total[l] += count;
            count = stp_level_count_above(count);
        }
        chunk->patches[i].exponent = FIXTURE_EXPONENT;
        chunk->patches[i].child = STP_PATCH_NO_CHILD;
    }
    return chunk;
}

/* A leaf: patches side by side in x, 8 by 8 samples 32 steps apart at most. */
static inline stp_chunk *fixture_leaf(uint64_t seed, uint32_t patch_count, unsigned per_patch)
{
    uint8_t counts[1024] = {0};
    for (uint32_t i = 0; i < patch_count; i++)
        counts[i] = (uint8_t)(i + 1 < patch_count ? per_patch : (per_patch + 1) / 2);
    stp_chunk *chunk = fixture_allocate(counts, patch_count);
    uint64_t n = 0;
    for (uint32_t i = 0; i < patch_count; i++) {
        stp_patch *patch = &chunk->patches[i];
        patch->origin[0] = (int32_t)(256 * i);
        patch->origin[2] = -100;
        for (unsigned k = 0; k < counts[i]; k++) {
            stp_sample *s = &chunk->samples[0][chunk->level_begin[0][i] + k];
            unsigned jitter = (unsigned)(stp_random_u64(seed, n++) >> 32);
            float tilt = (float)(jitter % 100) * 0.004f - 0.2f;
            s->position[0] = (uint16_t)(32 * ((k & 1) | (k >> 1 & 2) | (k >> 2 & 4)) + jitter % 16);
            s->position[1] =
                (uint16_t)(32 * ((k >> 1 & 1) | (k >> 2 & 2) | (k >> 3 & 4)) + jitter / 16 % 16);
            s->position[2] = (uint16_t)(100 + jitter / 256 % 8);
            s->radius = (uint8_t)(1 + 16 * 5 + jitter / 4096 % 8);
            s->flags = STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL;
            if (k < 5) /* of a merged sample all, of the next one some */
                s->flags |= STP_SAMPLE_OUTLIER;
            stp_normal_encode(glms_vec3_normalize((vec3s){{tilt, 0.1f, 1.0f}}), s->normal);
            s->rgb[0] = (uint8_t)(100 + i + jitter / 65536 % 8);
            s->rgb[1] = (uint8_t)(80 + k + jitter / 65536 % 8);
            s->rgb[2] = (uint8_t)(60 + jitter / 65536 % 8);
            s->intensity = (uint8_t)(jitter >> 24);
            s->class_id = (uint8_t)(i % 3);
        }
        fixture_finish_patch(chunk, i, FIXTURE_LEAF_ERROR);
    }
    return chunk;
}

typedef struct fixture_tree {
    stp_chunk *chunks[FIXTURE_CHUNK_LIMIT];
    stp_chunk_entry entries[FIXTURE_CHUNK_LIMIT];
    uint32_t children[FIXTURE_CHUNK_LIMIT][8];
    uint32_t child_counts[FIXTURE_CHUNK_LIMIT];
    uint32_t count;
    uint32_t attributes_denied; /* of FIXTURE_ATTRIBUTES, which the file does not say it has */
    uint32_t attributes_more;   /* that it says it has beside them */
    stp_dbox box;
} fixture_tree;

static inline uint32_t fixture_add(fixture_tree *tree, stp_chunk *chunk, stp_dvec3 origin,
                                   uint64_t points_under)
{
    uint32_t handle = tree->count++;
    tree->chunks[handle] = chunk;
    tree->entries[handle].origin = origin;
    tree->entries[handle].points_under = points_under;
    return handle;
}

static inline uint32_t fixture_add_leaf(fixture_tree *tree, uint64_t seed, uint32_t patch_count,
                                        unsigned per_patch, stp_dvec3 origin)
{
    stp_chunk *chunk = fixture_leaf(seed, patch_count, per_patch);
    for (uint32_t i = 0; i < patch_count; i++)
        for (uint32_t k = chunk->level_begin[0][i]; k < chunk->level_begin[0][i + 1]; k++)
            stp_dbox_add(&tree->box,
                         stp_dvec3_add(origin, stp_sample_position(&chunk->samples[0][k],
                                                                   &chunk->patches[i])));
    return fixture_add(tree, chunk, origin, chunk->level_begin[0][patch_count]);
}

/* A parent of `count` chunks: up to 8 of a child's patch vertices make a patch. */
static inline uint32_t fixture_add_parent(fixture_tree *tree, const uint32_t *children,
                                          uint32_t count)
{
    uint8_t counts[1024] = {0};
    uint32_t patch_count = 0;
    uint64_t points = 0;
    stp_dvec3 origin = tree->entries[children[0]].origin;
    for (uint32_t c = 0; c < count; c++) {
        uint32_t left = tree->chunks[children[c]]->patch_count;
        points += tree->entries[children[c]].points_under;
        for (; left > 0; left -= counts[patch_count++])
            counts[patch_count] = (uint8_t)(left < 8 ? left : 8);
    }
    stp_chunk *chunk = fixture_allocate(counts, patch_count);
    uint32_t p = 0;
    chunk->linked = true;
    for (uint32_t c = 0; c < count; c++) {
        const stp_chunk *child = tree->chunks[children[c]];
        stp_dvec3 offset = stp_dvec3_scale(stp_dvec3_sub(tree->entries[children[c]].origin, origin),
                                           ldexp(1, -FIXTURE_EXPONENT));
        for (uint32_t from = 0; from < child->patch_count; p++) {
            stp_patch *patch = &chunk->patches[p];
            patch->child = (uint8_t)c;
            patch->first_below = (uint16_t)from;
            patch->origin[0] = (int32_t)offset.x + child->patches[from].origin[0];
            patch->origin[1] = (int32_t)offset.y;
            patch->origin[2] = (int32_t)offset.z - 100;
            for (uint32_t k = chunk->level_begin[0][p]; k < chunk->level_begin[0][p + 1]; k++) {
                int32_t shift = child->patches[from].origin[0] + (int32_t)offset.x;
                chunk->samples[0][k] = child->samples[3][from++];
                shift -= patch->origin[0];
                chunk->samples[0][k].position[0] =
                    (uint16_t)(chunk->samples[0][k].position[0] + shift);
            }
            fixture_finish_patch(chunk, p, child->patches[0].error[STP_LEVEL_COUNT - 1]);
        }
    }
    uint32_t handle = fixture_add(tree, chunk, origin, points);
    memcpy(tree->children[handle], children, count * sizeof *children);
    tree->child_counts[handle] = count;
    return handle;
}

/* As a chunk of which nobody knows what is below its patches. */
static inline void fixture_unlink(stp_chunk *chunk)
{
    chunk->linked = false;
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        chunk->patches[p].first_below = 0;
}

static inline void fixture_destroy(fixture_tree *tree)
{
    for (uint32_t i = 0; i < tree->count; i++)
        stp_chunk_destroy(&tree->chunks[i]);
}

/* Encodes, appends and finishes; the root is the last chunk added. */
static inline stp_status fixture_write(fixture_tree *tree, const char *path, stp_codec codec,
                                       stp_error *err)
{
    stp_chunk_writer *writer = NULL;
    const uint32_t *children[FIXTURE_CHUNK_LIMIT];
    stp_chunk_writer_params params = {
        .force = true,
        .codec = codec,
        .attributes = (FIXTURE_ATTRIBUTES & ~tree->attributes_denied) | tree->attributes_more,
        .orientation = STP_ORIENTATION_FILE,
        .lambda = 1.7};
    uint64_t bytes = 0;
    stp_status status = stp_chunk_writer_create(&writer, path, &params, err);
    for (uint32_t h = 0; status == STP_OK && h < tree->count; h++) {
        void *payload = NULL;
        uint32_t handle = 0;
        children[h] = tree->children[h];
        status = stp_chunk_encode(tree->chunks[h], codec, &payload, &tree->entries[h], err);
        if (status == STP_OK)
            status = stp_chunk_writer_append(writer, payload, &tree->entries[h], &handle, err);
        free(payload);
    }
    if (status == STP_OK)
        return stp_chunk_writer_finish(&writer, tree->count - 1, children, tree->child_counts,
                                       &tree->box, FIXTURE_METADATA, &bytes, err);
    stp_chunk_writer_destroy(&writer);
    return status;
}

/* Two inner chunks of two leaves each, and a root: chunks in the order leaves, inner, root. */
static inline void fixture_tree_of_seven(fixture_tree *tree, uint32_t patch_count,
                                         unsigned per_patch)
{
    uint32_t inner[2];
    memset(tree, 0, sizeof *tree);
    tree->box = stp_dbox_empty();
    for (uint32_t i = 0; i < 2; i++) {
        uint32_t leaf[2];
        for (uint32_t k = 0; k < 2; k++) {
            stp_dvec3 origin = {500000.0 + 40.0 * (2 * i + k), 4500000.0, 100.0};
            leaf[k] = fixture_add_leaf(tree, 10 * i + k, patch_count, per_patch, origin);
        }
        inner[i] = fixture_add_parent(tree, leaf, 2);
    }
    fixture_add_parent(tree, inner, 2);
}

/* One leaf chunk that is the whole file. */
static inline void fixture_single(fixture_tree *tree, uint32_t patch_count, unsigned per_patch)
{
    memset(tree, 0, sizeof *tree);
    tree->box = stp_dbox_empty();
    fixture_add_leaf(tree, 1, patch_count, per_patch, (stp_dvec3){0.0, 0.0, 0.0});
}

static inline uint8_t *fixture_read_file(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    fixture_require(file != NULL);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    uint8_t *bytes = malloc(*size + 1);
    fixture_require(bytes != NULL);
    fixture_require(fread(bytes, 1, *size, file) == *size);
    fclose(file);
    return bytes;
}

static inline void fixture_write_file(const char *path, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    fixture_require(file != NULL);
    fixture_require(fwrite(bytes, 1, size, file) == size);
    fclose(file);
}

#endif
