/* Tables of integer columns. */
#include "formats/chunk/codec/table/table.h"

#include "base/memory.h"
#include "formats/chunk/sample/normal_grid.h"

stp_status stp_table_create(stp_table *table, unsigned column_count, uint32_t row_count,
                            stp_error *err)
{
    table->stride = row_count;
    table->column_count = column_count;
    table->row_count = row_count;
    return stp_alloc(&table->values, (size_t)column_count * row_count, sizeof *table->values,
                     "a payload's table", err);
}

uint64_t stp_table_constants(const stp_table *table)
{
    uint64_t mask = 0;
    for (unsigned c = 0; c < table->column_count; c++) {
        const int16_t *column = stp_table_column(table, c);
        uint32_t r = 1;
        while (r < table->row_count && column[r] == column[0])
            r++;
        if (r == table->row_count)
            mask |= (uint64_t)1 << c;
    }
    return mask;
}

stp_status stp_table_check_shift(const stp_table *table, stp_error *err)
{
    const unsigned most = stp_normal_shift_most(table->normal_odd);
    return table->normal_shift <= most
               ? STP_OK
               : stp_error_set(err, STP_CORRUPT,
                               "a table's normals are shifted by %u bits, at most %u",
                               table->normal_shift, most);
}
