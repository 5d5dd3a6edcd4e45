/* Checks everything that a chunk file promises, chunk by chunk on all threads. */
#include "formats/chunk/verify/verify.h"

#include "base/memory.h"
#include "formats/chunk/measure/overhang.h"
#include "formats/chunk/outside.h"
#include "formats/chunk/repair/repair_note.h"
#include "formats/chunk/shelf.h"
#include "formats/chunk/verify/verify_blocks.h"
#include "formats/chunk/verify/verify_errors.h"
#include "formats/chunk/verify/verify_join.h"
#include "formats/chunk/verify/verify_joints.h"
#include "formats/chunk/verify/verify_numbers.h"
#include "formats/chunk/verify/verify_tree.h"

#include <inttypes.h>
#include <stdatomic.h>
#include <stdlib.h>

typedef struct verification {
    stp_chunk_file *file;
    const stp_chunk_file_info *info;
    stp_chunk_entry *entries;
    stp_shelf *shelf;
    stp_chunk_boxes boxes; /* by id */
    const stp_progress *progress;
    atomic_uint_fast64_t done_count;
    atomic_uint_fast64_t joints; /* of strips: 0 if all joints meet */
    stp_verify_numbers numbers;
} verification;

/* Chunks kept decoded for their neighbours. */
#define SHELF_ROOM 64

/* Where a fault is found. */
typedef struct place {
    const verification *v;
    const stp_chunk *chunk;
    const stp_chunk_entry *entry;
} place;

static stp_status fault(const place *at, uint32_t patch, const char *what, stp_error *err)
{
    const char *path = stp_chunk_file_path(at->v->file);
    if (patch == STP_CHUNK_NONE)
        return stp_error_set(err, STP_CORRUPT, "%s: chunk %" PRIu32 " at byte %" PRIu64 ": %s",
                             path, at->chunk->id, at->entry->offset, what);
    return stp_error_set(err, STP_CORRUPT,
                         "%s: chunk %" PRIu32 " at byte %" PRIu64 ": patch %" PRIu32 ": %s", path,
                         at->chunk->id, at->entry->offset, patch, what);
}

static stp_status add_surrounding(void *context, uint32_t id, stp_surroundings *out, stp_error *err)
{
    stp_status status = STP_OK;
    const place *at = context;
    const stp_chunk_entry *e = &at->v->entries[id];
    const stp_chunk *chunk = NULL;
    if (e->depth != at->entry->depth)
        return STP_OK;
    STP_TRY(stp_shelf_take(at->v->shelf, id, &chunk, err));
    status = stp_surroundings_add(out, &(stp_placed_chunk){chunk, e->origin, NULL}, err);
    stp_shelf_give(at->v->shelf, id);
done:
    return status;
}

/* Recomputes perpendicular and colour errors, cones and bounds of every patch; then tangential
 * errors, which depend on the patch's neighbours. */
static stp_status verify_errors(place *at, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk *chunk = at->chunk;
    const stp_placed_chunk middle = {chunk, at->entry->origin, NULL};
    const stp_surrounding_chunks chunks = {&at->v->boxes, add_surrounding, at};
    uint32_t refuted = STP_CHUNK_NONE;
    stp_surroundings around = {0};
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        const char *what = stp_verify_patch_errors(chunk, i);
        if (what)
            return fault(at, i, what, err);
    }
    STP_TRY(stp_surroundings_find(&around, &middle, chunk->id, &chunks, err));
    STP_TRY(stp_overhang_check(&refuted, chunk, &around, err));
    if (refuted != STP_CHUNK_NONE)
        status = fault(at, refuted,
                       "the tangential error of a merged sample exceeds the stored one", err);
done:
    stp_surroundings_clear(&around);
    return status;
}

/* ---- one patch ---- */

static bool in_box(stp_dvec3 p, const stp_dbox *box)
{
    return p.x >= box->min.x && p.x <= box->max.x && p.y >= box->min.y && p.y <= box->max.y &&
           p.z >= box->min.z && p.z <= box->max.z;
}

static const char *check_sample(const place *at, const stp_patch *patch, const stp_sample *sample,
                                int level)
{
    const stp_chunk_entry *e = at->entry;
    stp_dvec3 p = stp_sample_position(sample, patch);
    stp_dbox box = {stp_dvec3_from_float(e->box_min), stp_dvec3_from_float(e->box_max)};
    double radius = stp_sample_radius(sample, patch);
    if (!in_box(p, &box))
        return "a sample lies outside the chunk's box";
    if (sample->radius > patch->radius[level])
        return "a sample's radius exceeds the patch's greatest of its level";
    if (radius < (double)e->radius_min || radius > (double)e->radius_max)
        return "a sample's radius lies outside the chunk's range";
    if (level == 0 && e->child_count == 0 &&
        !in_box(stp_dvec3_add(e->origin, p), &at->v->info->box))
        return "a point lies outside the file's box";
    if (level == 0 && !(patch->flags & STP_PATCH_TWO_SIDED) &&
        (~(unsigned)sample->flags & (STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL)))
        return "a sample's orientation is unknown in a patch that is not two-sided";
    if (level == 0 && patch->flags & STP_PATCH_CLOSED && !(sample->flags & STP_SAMPLE_CLOSED))
        return "a sample is not closed in a patch that is";
    return NULL;
}

/* A merged sample must be marked as outlier, or as closed, if and only if all samples it covers
 * are, and have the least of their fits. */
static bool marks_agree(const stp_chunk *chunk, uint32_t index)
{
    const uint8_t *counts = chunk->patches[index].counts;
    for (int l = 1; l < STP_LEVEL_COUNT; l++) {
        const stp_sample *coarse = chunk->samples[l] + chunk->level_begin[l][index];
        const stp_sample *finer = chunk->samples[l - 1] + chunk->level_begin[l - 1][index];
        for (unsigned j = 0, i = 0; j < counts[l]; j++) {
            unsigned mark = STP_SAMPLE_OUTLIER | STP_SAMPLE_CLOSED, fit = STP_FIT_GIVEN;
            for (; i < stp_level_children_begin(j + 1, counts[l], counts[l - 1]); i++) {
                mark &= finer[i].flags;
                fit = stp_sample_fit_least(&finer[i], fit);
            }
            if ((coarse[j].flags & (STP_SAMPLE_OUTLIER | STP_SAMPLE_CLOSED)) != mark ||
                stp_sample_fit_of(&coarse[j]) != fit)
                return false;
        }
    }
    return true;
}

static const char *check_samples(const place *at, uint32_t index)
{
    if (!marks_agree(at->chunk, index))
        return "a merged sample's mark as outlier or closed, or its fit, is not that of all it "
               "covers";
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        const uint32_t *begin = at->chunk->level_begin[l];
        for (uint32_t k = begin[index]; k < begin[index + 1]; k++) {
            const char *what =
                check_sample(at, &at->chunk->patches[index], &at->chunk->samples[l][k], l);
            if (what)
                return what;
        }
    }
    return NULL;
}

static const char *check_error_order(const place *at, const stp_patch *patch)
{
    const stp_chunk_entry *e = at->entry;
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        if (stp_error_decode(patch->error[l], patch->exponent) > (double)e->error[l] ||
            stp_error_decode(patch->tangential_error[l], patch->exponent) >
                (double)e->tangential_error[l] ||
            (float)patch->colour_error[l] > e->colour_error[l])
            return "an error exceeds the chunk's greatest of its level";
        if (l > 0 && patch->error[l] < patch->error[l - 1])
            return "its error shrinks towards the root";
    }
    return NULL;
}

/* The patch's bound must lie inside the chunk's box, and its cone inside the chunk's cone. */
static const char *check_bound(const place *at, const stp_patch *patch)
{
    const stp_chunk_entry *e = at->entry;
    stp_sample centre = {
        .position = {patch->bound_centre[0], patch->bound_centre[1], patch->bound_centre[2]}};
    stp_dvec3 c = stp_sample_position(&centre, patch);
    double r = stp_radius_decode(patch->bound_radius, patch->exponent);
    stp_dbox box = {stp_dvec3_from_float(e->box_min), stp_dvec3_from_float(e->box_max)};
    if (!in_box((stp_dvec3){c.x - r, c.y - r, c.z - r}, &box) ||
        !in_box((stp_dvec3){c.x + r, c.y + r, c.z + r}, &box))
        return "its bound reaches outside the chunk's box";
    stp_dvec3 axis = stp_dvec3_normalize(stp_dvec3_from_float(e->cone_axis));
    stp_dvec3 own = stp_dvec3_normalize(stp_dvec3_from_float(stp_normal_decode(patch->cone_axis)));
    double off = atan2(stp_dvec3_length(stp_dvec3_cross(axis, own)), stp_dvec3_dot(axis, own));
    double reach = fmin(off + stp_cone_angle_decode(patch->cone_angle), M_PI);
    /* cone_angle is a rounded float; M_PI itself rounds up. */
    if (reach > (double)e->cone_angle + 1e-6)
        return "its normal cone reaches outside the chunk's";
    return NULL;
}

/* ---- one chunk ---- */

static stp_status check_patches(const place *at, stp_error *err)
{
    for (uint32_t i = 0; i < at->chunk->patch_count; i++) {
        const stp_patch *patch = &at->chunk->patches[i];
        const char *what = check_error_order(at, patch);
        if (!what)
            what = check_bound(at, patch);
        if (!what)
            what = check_samples(at, i);
        if (what)
            return fault(at, i, what, err);
    }
    return STP_OK;
}

/* A block holds the bounds of its patches, as the entry does those of the chunk. */
static stp_status check_blocks(const place *at, stp_error *err)
{
    stp_status status = STP_OK;
    stp_block *blocks = NULL;
    STP_TRY(stp_verify_blocks(at->v->file, at->chunk, at->entry, &blocks, err));
    for (uint32_t b = 0; b < at->entry->block_count; b++) {
        stp_chunk_entry entry = *at->entry;
        stp_block_describe(&blocks[b], &entry);
        const place in_block = {at->v, at->chunk, &entry};
        for (uint32_t i = 0; i < blocks[b].patch_count; i++) {
            const uint32_t patch = blocks[b].first_patch + i;
            const char *what = check_error_order(&in_block, &at->chunk->patches[patch]);
            if (!what)
                what = check_bound(&in_block, &at->chunk->patches[patch]);
            if (!what)
                what = stp_block_fault(&blocks[b], &at->chunk->patches[patch]);
            if (what) {
                status = fault(at, patch, what, err);
                goto done;
            }
        }
    }
done:
    free(blocks);
    return status;
}

/* The level-0 samples of the patches that name a child must be the child's level 3. */
static stp_status check_children(const place *at, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *child = NULL;
    for (uint32_t c = 0; c < at->entry->child_count; c++) {
        uint32_t id = at->entry->first_child + c;
        uint32_t patch = STP_CHUNK_NONE;
        STP_TRY(stp_chunk_file_read(at->v->file, id, 2, &child, err));
        const char *what = NULL;
        STP_TRY(stp_verify_join(at->chunk, at->entry, c, child, &at->v->entries[id], &what, &patch,
                                err));
        if (what) {
            status = fault(at, patch, what, err);
            goto done;
        }
        stp_chunk_destroy(&child);
    }
done:
    stp_chunk_destroy(&child);
    return status;
}

static stp_status verify_chunk(void *context, size_t index, unsigned worker, stp_error *err)
{
    verification *v = context;
    stp_status status = STP_OK;
    const stp_chunk *chunk = NULL;
    STP_TRY(stp_shelf_take(v->shelf, (uint32_t)index, &chunk, err));
    place at = {v, chunk, &v->entries[index]};
    STP_TRY(check_patches(&at, err));
    STP_TRY(check_blocks(&at, err));
    STP_TRY(check_children(&at, err));
    STP_TRY(verify_errors(&at, err));
    STP_TRY(stp_verify_numbers_chunk(&v->numbers, chunk, worker, err));
    atomic_fetch_add(&v->joints, stp_verify_joints(chunk, at.entry->origin));
    uint64_t done_count = atomic_fetch_add(&v->done_count, 1) + 1;
    STP_TRY(stp_progress_update(v->progress, "verify", done_count, v->info->chunk_count, err));
done:
    if (chunk)
        stp_shelf_give(v->shelf, (uint32_t)index);
    return status;
}

/* Checks the metadata that runtime reads and that opening the file did not check. */
static stp_status check_closed(const stp_chunk_file *file, stp_error *err)
{
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    stp_outside outside = {0};
    stp_status status = stp_outside_read(&outside, info->metadata_json, info->metadata_bytes, err);
    stp_outside_clear(&outside);
    return status;
}

/* As many samples must stand in for lost points as the metadata says. */
static stp_status check_stand_ins(const verification *v, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_repair_sum sum = stp_repair_note_sum(v->info->metadata_json);
    bool *marks = NULL;
    uint64_t count = 0;
    if (sum.repairs == 0)
        return STP_OK;
    STP_TRY(stp_alloc(&marks, v->info->chunk_count, sizeof *marks, "chunks", err));
    stp_repair_note_stand_ins(v->info->metadata_json, marks, v->info->chunk_count);
    for (uint32_t id = 0; id < v->info->chunk_count; id++)
        if (marks[id] && v->entries[id].child_count == 0)
            count += v->entries[id].sample_count[0];
    if ((double)count != sum.stand_ins)
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: its metadata says that %.0f samples stand in for lost points, "
                               "and the chunks it names have %" PRIu64,
                               stp_chunk_file_path(v->file), sum.stand_ins, count);
done:
    free(marks);
    return status;
}

/* All strips must meet where they continue. In a repaired file the other strip may be lost. */
static stp_status check_joints(const verification *v, stp_error *err)
{
    if (v->joints == 0 || stp_repair_note_sum(v->info->metadata_json).repairs > 0)
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: a strip is said to continue another one, but does not begin where "
                         "one ends that is continued: prepare the model again",
                         stp_chunk_file_path(v->file));
}

stp_status stp_chunk_file_verify(stp_chunk_file *file, stp_pool *pool, const stp_progress *progress,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    verification v = {.file = file, .info = stp_chunk_file_get_info(file), .progress = progress};
    STP_TRY(check_closed(file, err));
    STP_TRY(stp_verify_tree(file, &v.entries, err));
    STP_TRY(stp_verify_sections(file, v.entries, err));
    STP_TRY(check_stand_ins(&v, err));
    STP_TRY(stp_verify_numbers_begin(&v.numbers, file, stp_pool_thread_count(pool), err));
    STP_TRY(stp_chunk_boxes_create(&v.boxes, v.info->chunk_count, err));
    for (uint32_t id = 0; id < v.info->chunk_count; id++)
        v.boxes.boxes[id] = stp_chunk_entry_box(&v.entries[id]);
    stp_chunk_boxes_join(&v.boxes);
    STP_TRY(stp_shelf_create(&v.shelf, file, SHELF_ROOM, err));
    STP_TRY(stp_pool_run(pool, v.info->chunk_count, verify_chunk, &v, err));
    STP_TRY(check_joints(&v, err));
    STP_TRY(stp_verify_numbers_end(&v.numbers, err));
done:
    stp_verify_numbers_clear(&v.numbers);
    stp_shelf_destroy(&v.shelf);
    stp_chunk_boxes_clear(&v.boxes);
    free(v.entries);
    return status;
}
