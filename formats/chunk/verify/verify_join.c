/* Compares the samples on both sides of the joint between a chunk and one of its children. */
#include "formats/chunk/verify/verify_join.h"

#include "base/memory.h"
#include "formats/chunk/layout.h"

#include <stdlib.h>
#include <string.h>

/* A sample freed from its lattice: where it is in the world, and the fields that must be equal. */
typedef struct joint {
    double position[3]; /* world */
    int32_t radius;     /* sixteenths of octaves over one world unit; INT32_MIN for none */
    uint8_t rest[9];    /* flags, normal, class, rgb, intensity */
    uint32_t patch;
    uint32_t linked; /* in a linked parent: the child's patch that first_below names */
    double error;    /* perpendicular error of its level: orders equal samples, is not compared as a
                        field */
} joint;

static joint joint_of(const stp_sample *s, const stp_patch *patch, stp_dvec3 origin)
{
    joint j;
    memset(&j, 0, sizeof j);
    stp_dvec3 p = stp_dvec3_add(origin, stp_sample_position(s, patch));
    j.position[0] = p.x;
    j.position[1] = p.y;
    j.position[2] = p.z;
    j.radius =
        s->radius == 0 ? INT32_MIN : s->radius + patch->exponent * STP_RADIUS_CODES_PER_OCTAVE;
    j.rest[0] = s->flags;
    memcpy(j.rest + 1, s->normal, 3);
    j.rest[4] = s->class_id;
    memcpy(j.rest + 5, s->rgb, 3);
    j.rest[8] = s->intensity;
    return j;
}

/* Order of samples; 0 if they are equal. */
static int compare(const joint *x, const joint *y)
{
    for (int i = 0; i < 3; i++)
        if (x->position[i] != y->position[i])
            return x->position[i] < y->position[i] ? -1 : 1;
    if (x->radius != y->radius)
        return x->radius < y->radius ? -1 : 1;
    return memcmp(x->rest, y->rest, sizeof x->rest);
}

/* Orders equal samples by error, so that the least of one side meets the least of the other. */
static int compare_order(const void *a, const void *b)
{
    const joint *x = a;
    const joint *y = b;
    int order = compare(x, y);
    return order ? order : x->error < y->error ? -1 : x->error > y->error;
}

static const char *difference(const joint *x, const joint *y)
{
    if (x->position[0] != y->position[0] || x->position[1] != y->position[1] ||
        x->position[2] != y->position[2])
        return "the position of a level-0 sample is no patch vertex of the child it stands for";
    if (x->radius != y->radius)
        return "the radius of a level-0 sample is not that of the child's patch vertex";
    return "flags, normal, class or colour of a level-0 sample are not those of the child's patch "
           "vertex";
}

static uint32_t collect(const stp_chunk *chunk, int level, int child, stp_dvec3 origin, joint *out)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        const stp_patch *patch = &chunk->patches[i];
        if (child >= 0 && patch->child != child)
            continue;
        for (uint32_t k = chunk->level_begin[level][i]; k < chunk->level_begin[level][i + 1]; k++) {
            out[count] = joint_of(&chunk->samples[level][k], patch, origin);
            out[count].error = stp_error_decode(patch->error[level], patch->exponent);
            out[count].linked = patch->first_below + k - chunk->level_begin[level][i];
            out[count++].patch = i;
        }
    }
    return count;
}

/* Finds the first patch above with a link that is wrong, or taken by another sample; STP_CHUNK_NONE
 * if there is none. */
static stp_status find_wrong_link(const joint *above, const joint *below, uint32_t count,
                                  uint32_t *patch, stp_error *err)
{
    bool *taken = NULL;
    stp_status status = stp_alloc(&taken, count, sizeof *taken, "samples to compare", err);
    *patch = STP_CHUNK_NONE;
    for (uint32_t i = 0; status == STP_OK && *patch == STP_CHUNK_NONE && i < count; i++) {
        uint32_t at = above[i].linked;
        if (at >= count || taken[at] || compare(&above[i], &below[at]) != 0)
            *patch = above[i].patch;
        else
            taken[at] = true;
    }
    free(taken);
    return status;
}

/* Finds the first patch above that is linked to a two-sided patch and is not two-sided itself, or
 * that is closed and linked to a patch that is not. */
static uint32_t find_wrong_side(const stp_chunk *parent, uint32_t child_index,
                                const stp_chunk *child)
{
    for (uint32_t p = 0; p < parent->patch_count; p++) {
        const stp_patch *patch = &parent->patches[p];
        for (unsigned i = 0; patch->child == child_index && i < patch->counts[0]; i++) {
            unsigned below = child->patches[patch->first_below + i].flags, above = patch->flags;
            if ((below & ~above & STP_PATCH_TWO_SIDED) || (above & ~below & STP_PATCH_CLOSED))
                return p;
        }
    }
    return STP_CHUNK_NONE;
}

/* Where the block ends that holds a patch of a chunk. */
static uint32_t first_end_after(const stp_chunk *chunk, uint32_t patch)
{
    uint32_t low = 0, high = chunk->block_count - 1;
    while (low < high) {
        const uint32_t middle = low + (high - low) / 2;
        if (chunk->block_ends[middle] > patch)
            high = middle;
        else
            low = middle + 1;
    }
    return chunk->block_ends[low];
}

/* The first patch of the parent that stands for patches of two blocks of the child. If the parent
 * is not linked, any patch may. */
static uint32_t find_cut(const stp_chunk *parent, uint32_t child_index, const stp_chunk *child)
{
    for (uint32_t p = 0; p < parent->patch_count; p++) {
        const stp_patch *patch = &parent->patches[p];
        const uint32_t begin = patch->first_below, end = begin + patch->counts[0];
        if (patch->child != child_index)
            continue;
        if (!parent->linked || first_end_after(child, begin) < end)
            return p;
    }
    return STP_CHUNK_NONE;
}

stp_status stp_verify_join(const stp_chunk *parent, const stp_chunk_entry *parent_entry,
                           uint32_t child_index, const stp_chunk *child,
                           const stp_chunk_entry *child_entry, const char **fault, uint32_t *patch,
                           stp_error *err)
{
    stp_status status = STP_OK;
    joint *above = NULL;
    joint *below = NULL;
    *fault = NULL;
    *patch = STP_CHUNK_NONE;
    STP_TRY(stp_alloc(&above, parent->level_begin[0][parent->patch_count], sizeof *above,
                      "samples to compare", err));
    STP_TRY(stp_alloc(&below, child->patch_count, sizeof *below, "samples to compare", err));
    uint32_t above_count = collect(parent, 0, (int)child_index, parent_entry->origin, above);
    uint32_t below_count = collect(child, STP_LEVEL_COUNT - 1, -1, child_entry->origin, below);
    uint32_t wrong_link = STP_CHUNK_NONE;
    if (parent->linked && above_count == below_count)
        STP_TRY(find_wrong_link(above, below, above_count, &wrong_link, err));
    qsort(above, above_count, sizeof *above, compare_order);
    qsort(below, below_count, sizeof *below, compare_order);
    if (above_count != below_count)
        *fault =
            "its patches for a child have another number of samples than the child has patches";
    for (uint32_t i = 0; !*fault && i < above_count; i++) {
        if (compare(&above[i], &below[i]) != 0)
            *fault = difference(&above[i], &below[i]);
        /* Codes of different exponents differ by less than this after rounding. */
        else if (below[i].error > above[i].error * (1.0 + 1e-6))
            *fault = "its error at level 0 is less than that of the child's patch vertices";
        if (*fault)
            *patch = above[i].patch;
    }
    if (!*fault && wrong_link != STP_CHUNK_NONE) {
        *fault = "it is linked to other patches of the child than those whose vertices it has";
        *patch = wrong_link;
    }
    if (!*fault && child->block_count > 1) {
        *patch = find_cut(parent, child_index, child);
        if (*patch != STP_CHUNK_NONE)
            *fault = "it stands for patches of two blocks of the child";
    }
    if (!*fault && parent->linked) {
        *patch = find_wrong_side(parent, child_index, child);
        if (*patch != STP_CHUNK_NONE)
            *fault =
                "it is not two-sided though a patch of the child that it stands for is, or closed "
                "though one is not";
    }
done:
    free(above);
    free(below);
    return status;
}
