/* Reads and keeps numbers of attributes, chunk by chunk. */
#include "runtime/stream/numbers.h"

#include "base/memory.h"
#include "formats/chunk/attribute/attribute_encode.h"
#include "formats/chunk/attribute/attribute_order.h"

#include <stdlib.h>

/* The numbers of a chunk, packed: in the stored order, or by sample (is_by_sample). */
typedef struct kept_chunk {
    uint32_t id; /* STP_CHUNK_NONE: free */
    uint64_t used;
    uint8_t *packed[STP_LEVEL_COUNT]; /* by level; NULL: not read */
} kept_chunk;

struct stp_numbers {
    stp_chunk_file *file;
    stp_attribute_file *attributes;
    uint32_t index;
    uint64_t clock;
    kept_chunk kept[STP_NUMBERS_CHUNKS];
};

static const stp_attribute *attribute_of(const stp_numbers *n)
{
    return &stp_attribute_file_list(n->attributes)->items[n->index];
}

/* Whether numbers are kept by sample, since reading them takes all samples of the chunk. */
static bool is_by_sample(const stp_numbers *n)
{
    return attribute_of(n)->coarse != STP_COARSE_NOT;
}

stp_status stp_numbers_create(stp_numbers **out, stp_chunk_file *file,
                              stp_attribute_file *attributes, uint32_t index, stp_error *err)
{
    stp_numbers *n = NULL;
    stp_status status = stp_alloc(&n, 1, sizeof *n, "an attribute", err);
    if (status != STP_OK)
        return status;
    n->file = file;
    n->attributes = attributes;
    n->index = index;
    for (uint32_t i = 0; i < STP_NUMBERS_CHUNKS; i++)
        n->kept[i].id = STP_CHUNK_NONE;
    *out = n;
    return STP_OK;
}

static void forget(kept_chunk *kept)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        free(kept->packed[l]);
    *kept = (kept_chunk){.id = STP_CHUNK_NONE};
}

void stp_numbers_destroy(stp_numbers **numbers)
{
    for (uint32_t i = 0; *numbers && i < STP_NUMBERS_CHUNKS; i++)
        forget(&(*numbers)->kept[i]);
    free(*numbers);
    *numbers = NULL;
}

/* The place of a chunk: its own, or that of the chunk that was not used for longest. */
static kept_chunk *keep(stp_numbers *n, uint32_t id)
{
    kept_chunk *oldest = &n->kept[0];
    for (uint32_t i = 0; i < STP_NUMBERS_CHUNKS; i++) {
        kept_chunk *kept = &n->kept[i];
        if (kept->id == id) {
            kept->used = ++n->clock;
            return kept;
        }
        oldest = kept->used < oldest->used ? kept : oldest;
    }
    forget(oldest);
    oldest->id = id;
    oldest->used = ++n->clock;
    return oldest;
}

/* Numbers that a level of a block adds to those kept: as many as it has samples, or, in the stored
 * order, as it has samples more than the next coarser level. */
static uint32_t added(const stp_numbers *n, const stp_block *block, int level)
{
    const uint32_t own = block->sample_count[level];
    const uint32_t above =
        !is_by_sample(n) && level + 1 < STP_LEVEL_COUNT ? block->sample_count[level + 1] : 0;
    return own > above ? own - above : 0;
}

static stp_status read_by_sample(stp_numbers *n, uint32_t id, int level, uint32_t count,
                                 uint64_t *words, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    /* level 3 comes with level 2 */
    STP_TRY(stp_chunk_file_read(n->file, id, level < 2 ? level : 2, &chunk, err));
    if (chunk->level_begin[level][chunk->patch_count] != count)
        status = stp_error_set(err, STP_CORRUPT, "%s: chunk %u has %u samples, its blocks have %u",
                               stp_chunk_file_path(n->file), id,
                               chunk->level_begin[level][chunk->patch_count], count);
    else
        status = stp_attribute_file_read(n->attributes, n->index, chunk, level, words, err);
done:
    stp_chunk_destroy(&chunk);
    return status;
}

/* Reads the numbers of a level of a chunk, unless they are there. */
static stp_status load(stp_numbers *n, kept_chunk *kept, int level, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_attribute_type type = attribute_of(n)->type;
    const size_t bytes = stp_attribute_bytes(type);
    uint64_t *words = NULL;
    uint8_t *packed = NULL;
    if (kept->packed[level])
        return STP_OK;
    STP_TRY(stp_alloc(&words, (size_t)count + 1, sizeof *words, "attributes", err));
    STP_TRY(stp_alloc(&packed, (size_t)count + 1, bytes, "attributes", err));
    if (is_by_sample(n))
        STP_TRY(read_by_sample(n, kept->id, level, count, words, err));
    else
        STP_TRY(stp_attribute_file_part(n->attributes, n->index, kept->id, level, NULL, count,
                                        words, err));
    for (uint32_t i = 0; i < count; i++)
        stp_attribute_put(type, words[i], packed + i * bytes);
    kept->packed[level] = packed;
    packed = NULL;
done:
    free(words);
    free(packed);
    return status;
}

/* Spreads the stored numbers over a level: a sample takes its parent's or the next. */
static void spread(stp_attribute_type type, const stp_chunk *chunk, int level, const uint8_t *next,
                   const uint64_t *above, uint64_t *words)
{
    const size_t bytes = stp_attribute_bytes(type);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        const uint32_t first = chunk->level_begin[level][p];
        const stp_sample *samples = chunk->samples[level] + first;
        uint8_t borrowers[STP_PATCH_SAMPLES];
        stp_attribute_borrowers(patch, samples, level, borrowers);
        for (unsigned i = 0; i < patch->counts[level]; i++) {
            const bool stored = borrowers[i] == STP_NOT_BORROWED;
            words[first + i] = stored ? stp_attribute_get(type, next)
                                      : above[chunk->level_begin[level + 1][p] + borrowers[i]];
            next += stored ? bytes : 0;
        }
    }
}

stp_status stp_numbers_words_create(stp_numbers_words *out, const stp_numbers_block *block,
                                    stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk *chunk = block->chunk;
    const size_t most = chunk->level_begin[chunk->finest_level][chunk->patch_count];
    STP_TRY(stp_alloc(&out->own, most + 1, sizeof *out->own, "attributes", err));
    STP_TRY(stp_alloc(&out->above, most + 1, sizeof *out->above, "attributes", err));
done:
    return status;
}

void stp_numbers_words_free(stp_numbers_words *words)
{
    free(words->own);
    free(words->above);
    *words = (stp_numbers_words){0};
}

stp_status stp_numbers_read(stp_numbers *n, const stp_numbers_block *b, int level,
                            stp_numbers_words *w, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *const words = w->above, *const above = w->own;
    *w = (stp_numbers_words){words, above};
    const stp_attribute_type type = attribute_of(n)->type;
    const size_t bytes = stp_attribute_bytes(type);
    const uint32_t count = b->chunk->level_begin[level][b->chunk->patch_count];
    uint64_t before = 0, all = 0;
    if (attribute_of(n)->derived) {
        for (uint32_t i = 0; i < count; i++)
            words[i] = stp_attribute_guess(attribute_of(n), &b->chunk->samples[level][i]);
        return STP_OK;
    }
    for (uint32_t i = 0; i < b->count; i++) {
        before += i < b->index ? added(n, &b->blocks[i], level) : 0;
        all += added(n, &b->blocks[i], level);
    }
    if (all > STP_CHUNK_SAMPLES_LIMIT)
        return stp_error_set(err, STP_CORRUPT, "chunk %u: its blocks have too many samples",
                             b->blocks[b->index].chunk);
    kept_chunk *kept = keep(n, b->blocks[b->index].chunk);
    STP_TRY(load(n, kept, level, (uint32_t)all, err));
    const uint8_t *packed = kept->packed[level] + before * bytes;
    if (!is_by_sample(n))
        spread(type, b->chunk, level, packed, above, words);
    else
        for (uint32_t i = 0; i < count; i++)
            words[i] = stp_attribute_get(type, packed + i * bytes);
done:
    return status;
}
