/* Encodes the numbers of all attributes of a chunk. */
#include "formats/chunk/attribute/attribute_encode.h"

#include "base/memory.h"
#include "formats/chunk/attribute/attribute_codec.h"

#include <stdlib.h>

uint64_t stp_attribute_guess(const stp_attribute *attribute, const stp_sample *sample)
{
    unsigned bits = 0;
    if (attribute->coarse == STP_COARSE_INTENSITY)
        bits = sample->intensity;
    else if (attribute->coarse != STP_COARSE_NOT)
        bits = sample->rgb[attribute->coarse - STP_COARSE_RED];
    return (uint64_t)(bits * attribute->coarse_scale + 0.5);
}

/* Takes one attribute out of packed points. */
static void unpack(const stp_attribute_numbers *n, const stp_attribute *attribute, size_t at,
                   size_t stride, uint64_t *words, uint64_t *guesses)
{
    const uint32_t count = n->ends[STP_LEVEL_COUNT - 1];
    for (uint32_t i = 0; i < count; i++)
        words[i] = stp_attribute_get(attribute->type, n->packed + i * stride + at);
    for (uint32_t i = 0; attribute->coarse != STP_COARSE_NOT && i < count; i++)
        guesses[i] = stp_attribute_guess(attribute, &n->holders[i]);
}

stp_status stp_attribute_numbers_encode(const stp_attribute_list *list,
                                        const stp_attribute_numbers *numbers, stp_bytes *out,
                                        stp_attribute_row *rows, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = numbers->ends[STP_LEVEL_COUNT - 1];
    const size_t stride = stp_attribute_list_bytes(list);
    size_t next = 0;
    uint64_t *words = NULL, *guesses = NULL;
    STP_TRY(stp_alloc(&words, count, sizeof *words, "attributes", err));
    STP_TRY(stp_alloc(&guesses, count, sizeof *guesses, "attributes", err));
    for (uint32_t a = 0; a < list->count; a++) {
        const stp_attribute *attribute = &list->items[a];
        const bool guessed = attribute->coarse != STP_COARSE_NOT;
        const size_t at = next;
        stp_steps steps;
        next += stp_attribute_bytes(attribute->type);
        rows[a] = (stp_attribute_row){.offset = out->size};
        if (attribute->derived)
            continue;
        unpack(numbers, attribute, at, stride, words, guesses);
        STP_TRY(stp_attribute_steps(attribute->type, words, count, &steps, err));
        for (int k = 0; k < STP_LEVEL_COUNT; k++) {
            const uint32_t first = k ? numbers->ends[k - 1] : 0;
            const size_t begin = out->size;
            STP_TRY(stp_attribute_encode(attribute->type, words + first,
                                         guessed ? guesses + first : NULL, &steps,
                                         numbers->ends[k] - first, out, err));
            rows[a].bytes[k] = (uint32_t)(out->size - begin);
            rows[a].hash[k] = stp_hash(out->data ? out->data + begin : NULL, out->size - begin);
        }
    }
done:
    free(words);
    free(guesses);
    return status;
}
