/* Reads attributes of a chunk file. */
#include "formats/chunk/attribute/attribute_file.h"

#include "base/memory.h"
#include "formats/chunk/attribute/attribute_codec.h"
#include "formats/chunk/attribute/attribute_encode.h"
#include "formats/chunk/attribute/attribute_json.h"
#include "formats/chunk/attribute/attribute_order.h"
#include "formats/chunk/chunk_reader.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

struct stp_attribute_file {
    stp_chunk_file *file;
    stp_attribute_list list;
    const stp_section *table, *data;
    uint32_t json_bytes;
    uint8_t *page;                       /* the page read last */
    uint32_t page_attribute, page_first; /* its first chunk; STP_CHUNK_NONE: none was read */
};

/* Reads bytes whose checksum is known; from a server, again if they are wrong. */
static stp_status read_checked(const stp_chunk_file *file, uint64_t offset, uint8_t *bytes,
                               size_t size, uint64_t hash, stp_error *err)
{
    stp_status status = STP_OK;
    for (int i = 0; i <= STP_FRESH_TRIES; i++) {
        STP_TRY(stp_chunk_file_bytes(file, offset, bytes, size, i > 0, err));
        if (stp_hash(bytes, size) == hash)
            return STP_OK;
        if (!stp_chunk_file_may_mend(file, STP_CORRUPT))
            break;
    }
    status = stp_error_set(err, STP_CORRUPT,
                           "%s: the checksum of attributes at byte %" PRIu64
                           " does not match: the file is damaged; copy it again",
                           file->path, offset);
done:
    return status;
}

static stp_status read_list(stp_attribute_file *a, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file *file = a->file;
    uint8_t head[STP_ATTRIBUTE_HEAD_BYTES];
    uint64_t hash = 0;
    uint8_t *json = NULL;
    stp_error inner = {0};
    if (a->table->bytes < sizeof head)
        return stp_error_set(err, STP_CORRUPT, "%s: the table of attributes is cut", file->path);
    STP_TRY(stp_chunk_file_bytes(file, a->table->offset, head, sizeof head, false, err));
    status = stp_attribute_head_read(head, &a->json_bytes, &hash, &inner);
    if (status == STP_OK && a->json_bytes > a->table->bytes - sizeof head)
        status = stp_error_set(&inner, STP_CORRUPT, "the list of attributes is cut");
    if (status == STP_OK) {
        STP_TRY(stp_alloc(&json, (size_t)a->json_bytes + 1, 1, "attributes", err));
        STP_TRY(read_checked(file, a->table->offset + sizeof head, json, a->json_bytes, hash, err));
        status = stp_attribute_list_read(&a->list, (const char *)json, a->json_bytes, &inner);
    }
    const uint64_t pages = stp_attribute_pages_bytes(file->info.chunk_count);
    if (status == STP_OK &&
        stp_attribute_pages_begin(a->json_bytes) + a->list.count * pages != a->table->bytes)
        status = stp_error_set(&inner, STP_CORRUPT, "the table of attributes has another size");
    if (status != STP_OK)
        status =
            stp_error_set(err, status, "%s: %s: copy the file again", file->path, inner.message);
done:
    free(json);
    return status;
}

stp_status stp_attribute_file_open(stp_attribute_file **out, stp_chunk_file *file, stp_error *err)
{
    stp_status status = STP_OK;
    stp_attribute_file *a = NULL;
    STP_TRY(stp_alloc(&a, 1, sizeof *a, "attributes", err));
    a->file = file;
    a->table = stp_header_section(&file->header, STP_SECTION_ATTRIBUTES);
    a->data = stp_header_section(&file->header, STP_SECTION_NUMBERS);
    a->page_first = STP_CHUNK_NONE;
    if (a->table && a->data)
        STP_TRY(read_list(a, err));
    *out = a;
    a = NULL;
done:
    stp_attribute_file_close(&a);
    return status;
}

const stp_attribute_list *stp_attribute_file_list(const stp_attribute_file *attributes)
{
    return &attributes->list;
}

void stp_attribute_file_close(stp_attribute_file **attributes)
{
    if (*attributes)
        free((*attributes)->page);
    free(*attributes);
    *attributes = NULL;
}

/* Reads the page that has a chunk's row, unless it is there. */
static stp_status load_page(stp_attribute_file *a, uint32_t index, uint32_t first, uint32_t rows,
                            bool again, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t pages_before = first / STP_ATTRIBUTE_PAGE_ROWS;
    const uint64_t at = stp_attribute_pages_begin(a->json_bytes) +
                        index * stp_attribute_pages_bytes(a->file->info.chunk_count) +
                        (uint64_t)pages_before * stp_attribute_page_bytes(STP_ATTRIBUTE_PAGE_ROWS);
    if (a->page && a->page_first == first && a->page_attribute == index && !again)
        return STP_OK;
    if (!a->page)
        STP_TRY(stp_alloc(&a->page, stp_attribute_page_bytes(STP_ATTRIBUTE_PAGE_ROWS), 1,
                          "attributes", err));
    a->page_first = STP_CHUNK_NONE;
    STP_TRY(stp_chunk_file_bytes(a->file, a->table->offset + at, a->page,
                                 stp_attribute_page_bytes(rows), again, err));
    a->page_first = first;
    a->page_attribute = index;
done:
    return status;
}

stp_status stp_attribute_file_row(stp_attribute_file *a, uint32_t index, uint32_t id,
                                  stp_attribute_row *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_error inner = {0};
    const uint32_t first = id - id % STP_ATTRIBUTE_PAGE_ROWS;
    const uint32_t left = a->file->info.chunk_count - first;
    const uint32_t rows = left < STP_ATTRIBUTE_PAGE_ROWS ? left : STP_ATTRIBUTE_PAGE_ROWS;
    for (int i = 0; i <= STP_FRESH_TRIES; i++) {
        STP_TRY(load_page(a, index, first, rows, i > 0, err));
        status = stp_attribute_row_read(a->page, rows, id - first, a->data->bytes, out, &inner);
        if (status == STP_OK || !stp_chunk_file_may_mend(a->file, status))
            break;
    }
    if (status != STP_OK)
        status = stp_error_set(err, status, "%s: chunk %" PRIu32 ": %s: copy the file again",
                               a->file->path, id, inner.message);
done:
    return status;
}

stp_status stp_attribute_file_parts(stp_attribute_file *a, const stp_attribute_row *row,
                                    uint8_t *bytes, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t at = a->data->offset + row->offset;
    for (int k = 0; k < STP_LEVEL_COUNT; k++) {
        STP_TRY(read_checked(a->file, at, bytes, row->bytes[k], row->hash[k], err));
        bytes += row->bytes[k];
        at += row->bytes[k];
    }
done:
    return status;
}

/* ---- numbers ---- */

/* One chunk's numbers, level by level from the coarsest. */
typedef struct walk {
    const stp_attribute *attribute;
    const stp_chunk *chunk;
    uint64_t *above, *words, *stored, *guesses; /* of the level above, of this level; its part */
} walk;

/* Goes through the samples of a level: either a sample takes its parent's number, or the next that
 * is stored. fill: sets words; else sets guesses. Returns the number of stored ones. */
static uint32_t walk_level(const walk *w, int level, bool fill)
{
    const stp_chunk *chunk = w->chunk;
    uint32_t place = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        const uint32_t first = chunk->level_begin[level][p];
        const stp_sample *samples = chunk->samples[level] + first;
        uint8_t borrowers[STP_PATCH_SAMPLES];
        stp_attribute_borrowers(patch, samples, level, borrowers);
        for (unsigned i = 0; i < patch->counts[level]; i++) {
            const bool stored = borrowers[i] == STP_NOT_BORROWED;
            if (fill)
                w->words[first + i] =
                    stored ? w->stored[place]
                           : w->above[chunk->level_begin[level + 1][p] + borrowers[i]];
            else if (stored)
                w->guesses[place] = stp_attribute_guess(w->attribute, &samples[i]);
            place += stored;
        }
    }
    return place;
}

static stp_status walk_create(walk *w, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&w->above, count, sizeof *w->above, "attributes", err));
    STP_TRY(stp_alloc(&w->words, count, sizeof *w->words, "attributes", err));
    STP_TRY(stp_alloc(&w->stored, count, sizeof *w->stored, "attributes", err));
    STP_TRY(stp_alloc(&w->guesses, count, sizeof *w->guesses, "attributes", err));
done:
    return status;
}

static void walk_clear(walk *w)
{
    free(w->above);
    free(w->words);
    free(w->stored);
    free(w->guesses);
}

stp_status stp_attribute_file_part(stp_attribute_file *a, uint32_t index, uint32_t id, int level,
                                   const uint64_t *guesses, uint32_t count, uint64_t *words,
                                   stp_error *err)
{
    stp_status status = STP_OK;
    const stp_attribute *attribute = &a->list.items[index];
    stp_attribute_row row;
    uint8_t *part = NULL;
    stp_error inner = {0};
    const int k = STP_LEVEL_COUNT - 1 - level;
    STP_TRY(stp_attribute_file_row(a, index, id, &row, err));
    uint64_t at = a->data->offset + row.offset;
    for (int before = 0; before < k; before++)
        at += row.bytes[before];
    STP_TRY(stp_alloc(&part, (size_t)row.bytes[k] + 1, 1, "attributes", err));
    STP_TRY(read_checked(a->file, at, part, row.bytes[k], row.hash[k], err));
    status = stp_attribute_decode(attribute->type, part, row.bytes[k],
                                  attribute->coarse == STP_COARSE_NOT ? NULL : guesses, count,
                                  words, &inner);
    if (status != STP_OK)
        status = stp_error_set(err, status, "%s: chunk %" PRIu32 ": %s: %s", a->file->path, id,
                               attribute->name, inner.message);
done:
    free(part);
    return status;
}

stp_status stp_attribute_file_read(stp_attribute_file *a, uint32_t index, const stp_chunk *chunk,
                                   int level, uint64_t *words, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = chunk->level_begin[level][chunk->patch_count];
    walk w = {.attribute = &a->list.items[index], .chunk = chunk};
    if (w.attribute->derived) {
        for (uint32_t i = 0; i < count; i++)
            words[i] = stp_attribute_guess(w.attribute, &chunk->samples[level][i]);
        return STP_OK;
    }
    STP_TRY(walk_create(&w, count, err));
    for (int l = STP_LEVEL_COUNT - 1; l >= level; l--) {
        uint64_t *swap = w.above;
        const uint32_t stored = walk_level(&w, l, false);
        STP_TRY(stp_attribute_file_part(a, index, chunk->id, l, w.guesses, stored, w.stored, err));
        w.above = w.words;
        w.words = swap;
        (void)walk_level(&w, l, true);
    }
    memcpy(words, w.words, count * sizeof *words);
done:
    walk_clear(&w);
    return status;
}
