/* Shows an attribute in place of intensities. */
#include "runtime/stream/shown.h"

#include "base/memory.h"
#include "formats/chunk/attribute/attribute_file.h"
#include "formats/chunk/attribute/attribute_order.h"
#include "runtime/colour_range.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The numbers of a chunk, as bytes in the stored order. */
typedef struct kept_chunk {
    uint32_t id; /* STP_CHUNK_NONE: free */
    uint64_t used;
    uint8_t *bytes[STP_LEVEL_COUNT]; /* by level; NULL: not read */
} kept_chunk;

struct stp_shown {
    stp_attribute_file *file;
    uint32_t index;
    double low, scale;    /* byte = (value - low) * scale */
    pthread_mutex_t lock; /* guards all below and reading; innermost but for the file's own */
    uint64_t clock;
    kept_chunk kept[STP_SHOWN_CHUNKS];
};

static const stp_attribute *attribute_of(const stp_shown *s)
{
    return &stp_attribute_file_list(s->file)->items[s->index];
}

static stp_status find(stp_shown *s, const stp_chunk_file *file, const char *name, stp_error *err)
{
    const stp_attribute_list *list = stp_attribute_file_list(s->file);
    char names[640] = "";
    s->index = stp_attribute_match(list, name);
    for (uint32_t i = 0, at = 0; i < list->count && at < sizeof names - 64; i++)
        at += (uint32_t)snprintf(names + at, sizeof names - at, "%s%s", i ? ", " : "",
                                 list->items[i].name);
    if (s->index == UINT32_MAX)
        return stp_error_set(
            err, STP_NOT_FOUND, "%s has no attribute \"%s\"%s%s%s", stp_chunk_file_path(file), name,
            list->count > 0 ? ": it has " : ": prep --attributes keeps them", names, "");
    if (list->items[s->index].coarse != STP_COARSE_NOT)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "\"%s\" is in the samples themselves: show rgb or intensity",
                             list->items[s->index].name);
    return STP_OK;
}

/* The 2nd and 98th percentile of the root's values. */
static stp_status measure(stp_shown *s, stp_chunk_file *file, double range[2], stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *root = NULL;
    uint64_t *words = NULL;
    double *values = NULL;
    uint32_t count = 0;
    STP_TRY(stp_chunk_file_read(file, 0, 0, &root, err));
    const uint32_t samples = root->level_begin[0][root->patch_count];
    STP_TRY(stp_alloc(&words, samples, sizeof *words, "values", err));
    STP_TRY(stp_alloc(&values, samples, sizeof *values, "values", err));
    STP_TRY(stp_attribute_file_read(s->file, s->index, root, 0, words, err));
    for (uint32_t i = 0; i < samples; i++) {
        const double value = stp_attribute_value(attribute_of(s), words[i]);
        if (isfinite(value))
            values[count++] = value;
    }
    stp_colour_range_of(values, count, range);
done:
    free(values);
    free(words);
    stp_chunk_destroy(&root);
    return status;
}

stp_status stp_shown_create(stp_shown **out, stp_chunk_file *file, const char *name,
                            double range[2], stp_error *err)
{
    stp_status status = STP_OK;
    stp_shown *s = NULL;
    STP_TRY(stp_alloc(&s, 1, sizeof *s, "an attribute", err));
    pthread_mutex_init(&s->lock, NULL);
    for (uint32_t i = 0; i < STP_SHOWN_CHUNKS; i++)
        s->kept[i].id = STP_CHUNK_NONE;
    STP_TRY(stp_attribute_file_open(&s->file, file, err));
    STP_TRY(find(s, file, name, err));
    if (!(range[0] < range[1]))
        STP_TRY(measure(s, file, range, err));
    s->low = range[0];
    s->scale = range[1] > range[0] ? 255.0 / (range[1] - range[0]) : 0.0;
    *out = s;
    s = NULL;
done:
    stp_shown_destroy(&s);
    return status;
}

const char *stp_shown_name(const stp_shown *s, double range[2])
{
    range[0] = s->low;
    range[1] = s->scale > 0.0 ? s->low + 255.0 / s->scale : s->low;
    return attribute_of(s)->name;
}

static void forget(kept_chunk *kept)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        free(kept->bytes[l]);
    *kept = (kept_chunk){.id = STP_CHUNK_NONE};
}

void stp_shown_destroy(stp_shown **shown)
{
    stp_shown *s = *shown;
    if (!s)
        return;
    for (uint32_t i = 0; i < STP_SHOWN_CHUNKS; i++)
        forget(&s->kept[i]);
    stp_attribute_file_close(&s->file);
    pthread_mutex_destroy(&s->lock);
    free(s);
    *shown = NULL;
}

/* The place of a chunk: its own, or that of the chunk that was not used for longest. */
static kept_chunk *keep(stp_shown *s, uint32_t id)
{
    kept_chunk *oldest = &s->kept[0];
    for (uint32_t i = 0; i < STP_SHOWN_CHUNKS; i++) {
        kept_chunk *kept = &s->kept[i];
        if (kept->id == id) {
            kept->used = ++s->clock;
            return kept;
        }
        oldest = kept->used < oldest->used ? kept : oldest;
    }
    forget(oldest);
    oldest->id = id;
    oldest->used = ++s->clock;
    return oldest;
}

/* Numbers that a level of a block adds: as many as it has samples more than the next coarser one.
 */
static uint32_t added(const stp_block *block, int level)
{
    const uint32_t own = block->sample_count[level];
    const uint32_t above = level + 1 < STP_LEVEL_COUNT ? block->sample_count[level + 1] : 0;
    return own > above ? own - above : 0;
}

/* Reads what a level of a chunk adds, unless it is there. */
static stp_status load(stp_shown *s, kept_chunk *kept, int level, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *words = NULL;
    uint8_t *bytes = NULL;
    if (kept->bytes[level])
        return STP_OK;
    STP_TRY(stp_alloc(&words, count, sizeof *words, "attributes", err));
    STP_TRY(stp_alloc(&bytes, (size_t)count + 1, 1, "attributes", err));
    STP_TRY(stp_attribute_file_part(s->file, s->index, kept->id, level, NULL, count, words, err));
    for (uint32_t i = 0; i < count; i++) {
        const double value = stp_attribute_value(attribute_of(s), words[i]);
        const double byte = isnan(value) ? 0.0 : (value - s->low) * s->scale;
        bytes[i] = (uint8_t)lrint(fmin(fmax(byte, 0.0), 255.0));
    }
    kept->bytes[level] = bytes;
    bytes = NULL;
done:
    free(words);
    free(bytes);
    return status;
}

/* Spreads the numbers over a level: a sample takes its parent's or the next. */
static void spread(stp_chunk *chunk, int level, const uint8_t *next)
{
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        stp_sample *samples = chunk->samples[level] + chunk->level_begin[level][p];
        if (level == STP_LEVEL_COUNT - 1) {
            for (unsigned i = 0; i < patch->counts[level]; i++)
                samples[i].intensity = *next++;
            continue;
        }
        const stp_sample *above = chunk->samples[level + 1] + chunk->level_begin[level + 1][p];
        const unsigned parents = patch->counts[level + 1], count = patch->counts[level];
        for (unsigned j = 0; j < parents; j++) {
            const unsigned begin = stp_level_children_begin(j, parents, count);
            const unsigned end = stp_level_children_begin(j + 1, parents, count);
            const unsigned lender = stp_attribute_borrowed(samples, begin, end);
            for (unsigned i = begin; i < end; i++)
                samples[i].intensity = i == lender ? above[j].intensity : *next++;
        }
    }
}

stp_status stp_shown_fill(stp_shown *s, const stp_block *blocks, uint32_t index,
                          uint32_t block_count, stp_chunk *block, stp_error *err)
{
    stp_status status = STP_OK;
    pthread_mutex_lock(&s->lock);
    kept_chunk *kept = keep(s, blocks[index].chunk);
    for (int level = STP_LEVEL_COUNT - 1; level >= block->finest_level; level--) {
        uint64_t before = 0, all = 0;
        for (uint32_t b = 0; b < block_count; b++) {
            before += b < index ? added(&blocks[b], level) : 0;
            all += added(&blocks[b], level);
        }
        if (all > STP_CHUNK_SAMPLES_LIMIT) {
            status = stp_error_set(err, STP_CORRUPT, "chunk %u: its blocks have too many samples",
                                   blocks[index].chunk);
            goto done;
        }
        STP_TRY(load(s, kept, level, (uint32_t)all, err));
        spread(block, level, kept->bytes[level] + before);
    }
done:
    pthread_mutex_unlock(&s->lock);
    return status;
}
