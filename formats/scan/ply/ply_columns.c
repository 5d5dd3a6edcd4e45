/* Records of a PLY file into columns, one for each target. */
#include "formats/scan/ply/ply_columns.h"

#include "formats/scan/ply/ply_splats.h"

#include <math.h>
#include <string.h>

const stp_ply_property *stp_ply_target_property(const stp_ply *ply, stp_ply_target target)
{
    for (size_t i = 0; i < ply->vertex->property_count; i++) {
        const stp_ply_property *p = &ply->header.properties[ply->vertex->property_first + i];
        if (p->target == target)
            return p;
    }
    return NULL;
}

/* Records of one size: column by column, without a branch per value. */
static stp_status read_fixed(stp_ply *ply, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_ply_element *vertex = ply->vertex;
    const size_t bytes = count * vertex->stride;
    const unsigned char *data;
    size_t available;
    STP_TRY(stp_source_peek(&ply->source, bytes, &data, &available, err));
    if (available < bytes) {
        ply->cursor.index += available / vertex->stride;
        return stp_ply_cut(&ply->cursor, err);
    }
    for (size_t i = 0; i < vertex->property_count; i++) {
        const stp_ply_property *p = &ply->header.properties[vertex->property_first + i];
        if (p->target != STP_PLY_TARGET_COUNT)
            stp_ply_load_column(p->type, ply->cursor.encoding, data + p->offset, vertex->stride,
                                count, ply->columns[p->target]);
        if (p->extra > 0 && ply->numbers.columns)
            stp_ply_load_column(p->type, ply->cursor.encoding, data + p->offset, vertex->stride,
                                count, ply->numbers.columns[p->extra - 1]);
    }
    stp_source_consume(&ply->source, bytes);
    ply->cursor.index += count;
done:
    return status;
}

static stp_status read_record(stp_ply *ply, size_t row, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ply_cursor *cursor = &ply->cursor;
    STP_TRY(stp_ply_record_begin(cursor, err));
    for (size_t i = 0; i < ply->vertex->property_count; i++) {
        const stp_ply_property *p = &ply->header.properties[ply->vertex->property_first + i];
        const bool extra = p->extra > 0 && ply->numbers.columns;
        double value = 0.0;
        if (p->target == STP_PLY_TARGET_COUNT && !extra) {
            STP_TRY(stp_ply_skip_property(cursor, p, err));
            continue;
        }
        STP_TRY(stp_ply_next_value(cursor, p->type, &value, err));
        if (p->target != STP_PLY_TARGET_COUNT)
            ply->columns[p->target][row] = value;
        if (extra)
            ply->numbers.columns[p->extra - 1][row] = value;
    }
    STP_TRY(stp_ply_record_end(cursor, err));
done:
    return status;
}

/* Parts packed colours. */
static void part_colours(stp_ply *ply, bool floats, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const double value = ply->columns[STP_PLY_RED][i];
        const float number = (float)value;
        uint32_t bits = 0;
        if (floats)
            memcpy(&bits, &number, sizeof bits);
        else if (fabs(value) < 4294967296.0)
            bits = (uint32_t)(int64_t)value;
        for (unsigned k = 0; k < 3; k++)
            ply->columns[STP_PLY_RED + k][i] = bits >> (16u - 8u * k) & 255u;
    }
}

stp_status stp_ply_read_columns(stp_ply *ply, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_ply_property *red = stp_ply_target_property(ply, STP_PLY_RED);
    if (stp_ply_has_fixed_records(ply))
        STP_TRY(read_fixed(ply, count, err));
    else
        for (size_t row = 0; row < count; row++)
            STP_TRY(read_record(ply, row, err));
    if (ply->packed)
        stp_ply_splats_part(ply, ply->cursor.index - count, count);
    else if (red && stp_ply_is_packed(red)) /* as numbers only in ASCII */
        part_colours(ply, red->type == STP_PLY_FLOAT32, count);
done:
    return status;
}
