/* The attributes of a PLY file: scalar properties of vertices that points have no field for. */
#include "base/memory.h"
#include "formats/attribute/attribute_list.h"
#include "formats/scan/ply/ply_columns.h"

#include <stdlib.h>
#include <string.h>

static const stp_attribute_type types[] = {
    [STP_PLY_INT8] = STP_ATTRIBUTE_I8,     [STP_PLY_UINT8] = STP_ATTRIBUTE_U8,
    [STP_PLY_INT16] = STP_ATTRIBUTE_I16,   [STP_PLY_UINT16] = STP_ATTRIBUTE_U16,
    [STP_PLY_INT32] = STP_ATTRIBUTE_I32,   [STP_PLY_UINT32] = STP_ATTRIBUTE_U32,
    [STP_PLY_INT64] = STP_ATTRIBUTE_F64,   [STP_PLY_UINT64] = STP_ATTRIBUTE_F64,
    [STP_PLY_FLOAT32] = STP_ATTRIBUTE_F32, [STP_PLY_FLOAT64] = STP_ATTRIBUTE_F64,
};

/* Whether a property is an attribute: nothing else uses it, or a sample holds it in 8 bits alone.
 */
static bool is_extra(const stp_ply_property *p)
{
    return !p->is_list && (p->target == STP_PLY_TARGET_COUNT ||
                           ((p->target == STP_PLY_INTENSITY || p->target == STP_PLY_CLASS) &&
                            p->type != STP_PLY_UINT8) ||
                           stp_ply_is_harmonic(p));
}

void stp_ply_numbers_find(stp_ply *ply)
{
    stp_ply_numbers *n = &ply->numbers;
    for (size_t i = 0; i < ply->vertex->property_count; i++) {
        stp_ply_property *p = &ply->header.properties[ply->vertex->property_first + i];
        if (is_extra(p) && stp_attribute_list_add(&n->list, p->name, types[p->type]))
            p->extra = n->list.count;
    }
}

stp_status stp_ply_numbers_keep(stp_ply *ply, stp_error *err)
{
    stp_ply_numbers *n = &ply->numbers;
    return n->list.count == 0
               ? STP_OK
               : stp_alloc(&n->columns, n->list.count, sizeof *n->columns, "attributes", err);
}

stp_status stp_ply_numbers_reserve(stp_ply *ply, size_t points, stp_error *err)
{
    stp_ply_numbers *n = &ply->numbers;
    return n->columns ? stp_grow(&n->packed, &n->capacity,
                                 points * stp_attribute_list_bytes(&n->list), 1, "attributes", err)
                      : STP_OK;
}

/* The word of a number that was read as a double: exact, since integers of more than 32 bits become
 * doubles. */
static uint64_t word_of(stp_attribute_type type, double value)
{
    uint64_t word;
    memcpy(&word, &value, sizeof word);
    return stp_attribute_convert(STP_ATTRIBUTE_F64, word, type);
}

void stp_ply_numbers_pack(stp_ply *ply, size_t first, size_t count)
{
    stp_ply_numbers *n = &ply->numbers;
    const size_t stride = stp_attribute_list_bytes(&n->list);
    uint8_t *to = n->packed + first * stride;
    for (uint32_t a = 0; a < n->list.count; a++) {
        const stp_attribute_type type = n->list.items[a].type;
        for (size_t i = 0; i < count; i++)
            stp_attribute_put(type, word_of(type, n->columns[a][i]), to + i * stride);
        to += stp_attribute_bytes(type);
    }
}

void stp_ply_numbers_clear(stp_ply_numbers *numbers)
{
    free(numbers->columns);
    free(numbers->packed);
    *numbers = (stp_ply_numbers){0};
}
