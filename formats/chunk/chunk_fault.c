/* Compares a chunk with its directory entry and the file's attributes. */
#include "formats/chunk/chunk_fault.h"

static const char *patch_fault(const stp_patch *patch, const stp_chunk_entry *e, uint32_t has)
{
    if ((patch->flags & STP_PATCH_STRIP && !(has & STP_HAS_LINES)) ||
        (patch->flags & STP_PATCH_TRIANGLES && !(has & STP_HAS_TRIANGLES)))
        return "it is a strip or triangles in a file that says it has none";
    if ((patch->child == STP_PATCH_NO_CHILD) != (e->child_count == 0))
        return "it names a child in a leaf, or none in a chunk with children";
    if (patch->flags & STP_PATCH_TWO_SIDED && !(e->flags & STP_PATCH_TWO_SIDED))
        return "it is two-sided and its chunk is not";
    if (e->flags & STP_CHUNK_CLOSED && !(patch->flags & STP_PATCH_CLOSED))
        return "its chunk is closed and it is not";
    return NULL;
}

static const char *flags_fault(unsigned flags, uint32_t has)
{
    if (flags & STP_SAMPLE_CLOSED && !(has & STP_HAS_CLOSED))
        return "a sample is closed in a file that says it has no closed surface";
    if (flags & STP_SAMPLE_FIT_MASK && !(has & STP_HAS_FITS))
        return "a sample says how its normal was found in a file that says none does";
    if (flags & STP_SAMPLE_OUTLIER && !(has & STP_HAS_OUTLIERS))
        return "a sample is marked as an outlier in a file that says it has no marks";
    return NULL;
}

const char *stp_chunk_fault(const stp_chunk *chunk, const stp_chunk_entry *entry,
                            uint32_t attributes, uint32_t *patch)
{
    uint64_t children = 0;
    unsigned flags = 0;
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        const char *what = patch_fault(&chunk->patches[i], entry, attributes);
        *patch = i;
        if (what)
            return what;
        if (chunk->patches[i].child != STP_PATCH_NO_CHILD)
            children |= (uint64_t)1 << chunk->patches[i].child;
    }
    *patch = STP_CHUNK_NONE;
    for (uint32_t c = 0; chunk->patch_count == entry->patch_count && c < entry->child_count; c++)
        if (!(children >> c & 1u))
            return "no patch stands for one of its children";
    for (int l = chunk->finest_level; l < STP_LEVEL_COUNT; l++)
        for (uint32_t k = 0; k < chunk->level_begin[l][chunk->patch_count]; k++)
            flags |= chunk->samples[l][k].flags;
    return flags_fault(flags, attributes);
}
