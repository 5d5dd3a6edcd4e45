/* Shows an attribute in place of intensities. */
#include "runtime/stream/shown.h"

#include "base/memory.h"
#include "formats/chunk/attribute/attribute_file.h"
#include "runtime/colour_range.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

struct stp_shown {
    stp_attribute_file *file;
    uint32_t index;
    double low, scale;    /* byte = (value - low) * scale */
    pthread_mutex_t lock; /* guards the numbers and reading; innermost but for the file's own */
    stp_numbers *numbers;
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
    STP_TRY(stp_attribute_file_open(&s->file, file, err));
    STP_TRY(find(s, file, name, err));
    STP_TRY(stp_numbers_create(&s->numbers, file, s->file, s->index, err));
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

void stp_shown_destroy(stp_shown **shown)
{
    stp_shown *s = *shown;
    if (!s)
        return;
    stp_numbers_destroy(&s->numbers);
    stp_attribute_file_close(&s->file);
    pthread_mutex_destroy(&s->lock);
    free(s);
    *shown = NULL;
}

static uint8_t byte_of(const stp_shown *s, uint64_t word)
{
    const double value = stp_attribute_value(attribute_of(s), word);
    const double byte = isnan(value) ? 0.0 : (value - s->low) * s->scale;
    return (uint8_t)lrint(fmin(fmax(byte, 0.0), 255.0));
}

stp_status stp_shown_fill(stp_shown *s, const stp_numbers_block *block, stp_chunk *chunk,
                          stp_error *err)
{
    stp_status status = STP_OK;
    stp_numbers_words words = {0};
    pthread_mutex_lock(&s->lock);
    STP_TRY(stp_numbers_words_create(&words, block, err));
    for (int level = STP_LEVEL_COUNT - 1; level >= chunk->finest_level; level--) {
        STP_TRY(stp_numbers_read(s->numbers, block, level, &words, err));
        for (uint32_t i = 0; i < chunk->level_begin[level][chunk->patch_count]; i++)
            chunk->samples[level][i].intensity = byte_of(s, words.own[i]);
    }
done:
    pthread_mutex_unlock(&s->lock);
    stp_numbers_words_free(&words);
    return status;
}
