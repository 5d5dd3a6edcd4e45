/* The attributes of what was clicked. */
#include "tools/view/view_values.h"

#include "base/memory.h"
#include "formats/chunk/attribute/attribute_file.h"
#include "runtime/cut/model.h"
#include "runtime/stream/chosen.h"

#include <stdlib.h>
#include <string.h>

/* Marks the samples of a whole chunk that the model does not draw. */
static stp_status mark(const stp_model *model, stp_chunk *chunk)
{
    const stp_block whole = stp_block_of_entry(&model->entries[chunk->id], chunk->id);
    const stp_numbers_block block = {&whole, 0, 1, chunk};
    return model->chosen ? stp_chosen_mark(model->chosen, &block, chunk, NULL) : STP_OK;
}

/* The level-0 sample of the chunk that is drawn and nearest to a position; UINT32_MAX if there is
 * none. chosen: samples may be marked as not drawn. */
static uint32_t nearest_sample(const stp_chunk *chunk, bool chosen, stp_dvec3 at)
{
    uint32_t best = UINT32_MAX;
    double least = INFINITY;
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            const stp_sample *s = &chunk->samples[0][i];
            const stp_dvec3 d = stp_dvec3_sub(stp_sample_position(s, &chunk->patches[p]), at);
            const double square = chosen && stp_sample_marked(s) ? INFINITY : stp_dvec3_dot(d, d);
            best = square < least ? i : best;
            least = fmin(least, square);
        }
    return best;
}

static stp_status read_values(view_values *out, stp_attribute_file *file, const stp_chunk *chunk,
                              uint32_t sample)
{
    stp_status status = STP_OK;
    const stp_attribute_list *list = stp_attribute_file_list(file);
    uint64_t *words = NULL;
    STP_TRY(stp_alloc(&words, chunk->level_begin[0][chunk->patch_count], sizeof *words,
                      "attributes", NULL));
    for (uint32_t a = 0; a < list->count; a++) {
        STP_TRY(stp_attribute_file_read(file, a, chunk, 0, words, NULL));
        memcpy(out->names[a], list->items[a].name, sizeof out->names[a]);
        out->values[a] = stp_attribute_value(&list->items[a], words[sample]);
    }
    out->count = list->count;
done:
    free(words);
    return status;
}

void view_values_find(view_values *out, const stp_model *model, const stp_pick *pick)
{
    stp_attribute_file *file = NULL;
    stp_chunk *chunk = NULL;
    out->count = 0;
    if (!pick->hit || pick->chunk >= model->info->chunk_count ||
        stp_attribute_file_open(&file, model->file, NULL) != STP_OK)
        return;
    if (stp_attribute_file_list(file)->count > 0 &&
        stp_chunk_file_read(model->file, pick->chunk, 0, &chunk, NULL) == STP_OK &&
        mark(model, chunk) == STP_OK) {
        const stp_dvec3 at = stp_dvec3_sub(pick->position, model->entries[pick->chunk].origin);
        const uint32_t sample = nearest_sample(chunk, model->chosen != NULL, at);
        if (sample != UINT32_MAX)
            (void)read_values(out, file, chunk, sample);
    }
    stp_chunk_destroy(&chunk);
    stp_attribute_file_close(&file);
}
