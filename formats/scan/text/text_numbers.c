/* The attributes of points in lines of text. */
#include "formats/scan/text/text_numbers.h"

#include "base/memory.h"
#include "formats/attribute/attribute_list.h"

#include <math.h>
#include <stdlib.h>

/* Whether the column's numbers are those that a sample has, as far as the lines were looked at. */
static bool is_byte(const stp_column_range *range)
{
    return range->whole && range->min >= 0.0 && range->max <= 255.0;
}

/* The name of a column's attribute; NULL: the column is none. */
static const char *name_of(const stp_columns *columns, uint32_t i, const stp_column_range *range,
                           bool byte_intensity)
{
    const stp_column column = (stp_column)columns->targets[i];
    const bool coarse = (column == STP_COLUMN_INTENSITY && !(byte_intensity && is_byte(range))) ||
                        (column == STP_COLUMN_CLASS && !is_byte(range));
    if (range->count == 0 || (column != STP_COLUMN_NONE && !coarse))
        return NULL;
    return columns->names[i][0] == '\0' && coarse ? stp_column_name(column) : columns->names[i];
}

void stp_text_numbers_find(stp_text_numbers *numbers, stp_columns *columns,
                           const stp_column_range *ranges, bool byte_intensity)
{
    for (uint32_t i = 0; i < columns->count; i++) {
        const char *name = name_of(columns, i, &ranges[i], byte_intensity);
        stp_attribute *a =
            name ? stp_attribute_list_add(&numbers->list, name, STP_ATTRIBUTE_F64) : NULL;
        columns->extras[i] = a ? (uint8_t)numbers->list.count : 0;
        if (a)
            a->has_missing = true;
    }
}

stp_status stp_text_numbers_begin(stp_text_numbers *numbers, size_t points, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t count = points * numbers->list.count;
    if (!numbers->keep)
        return STP_OK;
    STP_TRY(stp_grow(&numbers->packed, &numbers->capacity, count * sizeof(double), 1, "attributes",
                     err));
    for (size_t i = 0; i < count; i++) {
        const uint64_t missing = stp_attribute_missing(&numbers->list.items[0]);
        stp_attribute_put(STP_ATTRIBUTE_F64, missing, numbers->packed + i * sizeof(double));
    }
done:
    return status;
}

uint8_t *stp_text_numbers_at(const stp_text_numbers *numbers, size_t point)
{
    return numbers->packed ? numbers->packed + point * numbers->list.count * sizeof(double) : NULL;
}

void stp_text_numbers_clear(stp_text_numbers *numbers)
{
    free(numbers->packed);
    *numbers = (stp_text_numbers){0};
}
