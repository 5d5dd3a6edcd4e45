/* Marks samples by a condition. */
#include "runtime/stream/chosen.h"

#include "base/memory.h"
#include "formats/chunk/attribute/sample_fields.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

struct stp_chosen {
    stp_chunk_file *file;
    stp_attribute_file *attributes;
    stp_condition condition;
    double intensity_step;
    pthread_mutex_t lock; /* guards the numbers and reading; innermost but for the file's own */
    stp_numbers *numbers[STP_WHERE_NAMES]; /* by name of the condition; NULL: a sample's field */
};

static stp_status make_condition(stp_chosen *c, const char *text, stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    stp_where where;
    const stp_attribute_list *list = stp_attribute_file_list(c->attributes);
    const stp_chunk_file_info *info = stp_chunk_file_get_info(c->file);
    STP_TRY(stp_where_parse(&where, text, err));
    status = stp_condition_make(&c->condition, &where, stp_sample_fields(info), list, &why);
    if (status != STP_OK)
        return stp_error_set(err, status, "%s: %s", stp_chunk_file_path(c->file), why.message);
    for (unsigned i = 0; i < where.name_count; i++) {
        const stp_attribute *attribute = c->condition.sources[i].attribute;
        if (attribute)
            STP_TRY(stp_numbers_create(&c->numbers[i], c->file, c->attributes,
                                       (uint32_t)(attribute - list->items), err));
    }
done:
    return status;
}

stp_status stp_chosen_create(stp_chosen **out, stp_chunk_file *file, const char *condition,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_chosen *c = NULL;
    STP_TRY(stp_alloc(&c, 1, sizeof *c, "a condition", err));
    pthread_mutex_init(&c->lock, NULL);
    c->file = file;
    c->intensity_step = stp_sample_intensity_step(stp_chunk_file_get_info(file));
    STP_TRY(stp_attribute_file_open(&c->attributes, file, err));
    STP_TRY(make_condition(c, condition, err));
    *out = c;
    c = NULL;
done:
    stp_chosen_destroy(&c);
    return status;
}

void stp_chosen_destroy(stp_chosen **chosen)
{
    stp_chosen *c = *chosen;
    if (!c)
        return;
    for (unsigned i = 0; i < STP_WHERE_NAMES; i++)
        stp_numbers_destroy(&c->numbers[i]);
    stp_attribute_file_close(&c->attributes);
    pthread_mutex_destroy(&c->lock);
    free(c);
    *chosen = NULL;
}

static stp_status read_level(stp_chosen *c, const stp_numbers_block *block, int level,
                             stp_numbers_words *words, stp_error *err)
{
    stp_status status = STP_OK;
    pthread_mutex_lock(&c->lock);
    for (unsigned i = 0; i < STP_WHERE_NAMES; i++)
        if (c->numbers[i])
            STP_TRY(stp_numbers_read(c->numbers[i], block, level, &words[i], err));
done:
    pthread_mutex_unlock(&c->lock);
    return status;
}

static void mark(stp_sample *s, bool marked)
{
    if (marked)
        s->flags = (uint8_t)((s->flags | STP_SAMPLE_CLOSED) & ~STP_SAMPLE_HAS_NORMAL);
    else if (stp_sample_marked(s)) /* a file that breaks the rule of these flags */
        s->flags = (uint8_t)(s->flags & ~STP_SAMPLE_CLOSED);
}

/* words: by name of the condition; empty for a sample's field. */
static void mark_level(const stp_chosen *c, const stp_numbers_words *words, stp_chunk *chunk,
                       stp_dvec3 origin, int level)
{
    const stp_condition *condition = &c->condition;
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[level][p]; i < chunk->level_begin[level][p + 1]; i++) {
            double fields[STP_FIELD_COUNT], values[STP_WHERE_NAMES];
            stp_sample *s = &chunk->samples[level][i];
            const stp_dvec3 at = stp_sample_position(s, &chunk->patches[p]);
            stp_sample_values(s, stp_dvec3_add(origin, at), c->intensity_step, fields);
            for (unsigned n = 0; n < condition->where.name_count; n++)
                values[n] = c->numbers[n] ? stp_attribute_value(condition->sources[n].attribute,
                                                                words[n].own[i])
                                          : fields[condition->sources[n].field];
            mark(s, !stp_where_holds(&condition->where, values));
        }
}

stp_status stp_chosen_mark(stp_chosen *c, const stp_numbers_block *block, stp_chunk *chunk,
                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_numbers_words words[STP_WHERE_NAMES] = {{0}};
    stp_chunk_entry entry;
    STP_TRY(stp_chunk_file_entry(c->file, block->blocks[block->index].chunk, &entry, err));
    for (unsigned i = 0; i < STP_WHERE_NAMES; i++)
        if (c->numbers[i])
            STP_TRY(stp_numbers_words_create(&words[i], block, err));
    for (int level = STP_LEVEL_COUNT - 1; level >= chunk->finest_level; level--) {
        STP_TRY(read_level(c, block, level, words, err));
        mark_level(c, words, chunk, entry.origin, level);
    }
done:
    for (unsigned i = 0; i < STP_WHERE_NAMES; i++)
        stp_numbers_words_free(&words[i]);
    return status;
}

unsigned stp_chosen_empty(const stp_chunk *chunk, uint32_t patch)
{
    unsigned out = 0;
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        bool empty = true;
        if (l >= chunk->finest_level)
            for (uint32_t i = chunk->level_begin[l][patch]; i < chunk->level_begin[l][patch + 1];
                 i++)
                empty &= stp_sample_marked(&chunk->samples[l][i]);
        out |= (unsigned)empty << l;
    }
    return out;
}
