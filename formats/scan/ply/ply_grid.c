/* Reads range images and cameras of PLY files. */
#include "formats/scan/ply/ply_grid.h"

#include "base/checked.h"
#include "base/memory.h"
#include "formats/scan/number.h"

#include <stdlib.h>
#include <string.h>

stp_status stp_ply_camera_read(stp_ply *ply, const stp_ply_element *element, stp_error *err)
{
    static const char *const names[6] = {"view_px", "view_py", "view_pz",
                                         "y_axisx", "y_axisy", "y_axisz"};
    stp_status status = STP_OK;
    stp_ply_cursor *cursor = &ply->cursor;
    double values[6] = {0.0};
    unsigned found = 0;
    cursor->element = element;
    cursor->index = 0;
    STP_TRY(stp_ply_record_begin(cursor, err));
    for (size_t i = 0; i < element->property_count; i++) {
        const stp_ply_property *p = &ply->header.properties[element->property_first + i];
        int n = 0;
        while (n < 6 && (p->is_list || strcmp(p->name, names[n]) != 0))
            n++;
        if (n == 6) {
            STP_TRY(stp_ply_skip_property(cursor, p, err));
            continue;
        }
        STP_TRY(stp_ply_next_value(cursor, p->type, &values[n], err));
        found |= 1u << n;
    }
    STP_TRY(stp_ply_record_end(cursor, err));
    ply->camera = (stp_dvec3){values[0], values[1], values[2]};
    ply->camera_up = (stp_dvec3){values[3], values[4], values[5]};
    ply->has_camera =
        found == 63u && stp_dvec3_finite(ply->camera) && stp_dvec3_finite(ply->camera_up);
done:
    return status;
}

/* Reads the vertex of the next pixel; UINT64_MAX if it has none. */
static stp_status read_pixel(stp_ply *ply, const stp_ply_element *element,
                             const stp_ply_property *list, uint64_t *vertex, stp_error *err)
{
    stp_status status = STP_OK;
    double number = -1.0, other;
    uint64_t length;
    STP_TRY(stp_ply_record_begin(&ply->cursor, err));
    for (size_t i = 0; i < element->property_count; i++) {
        const stp_ply_property *p = &ply->header.properties[element->property_first + i];
        if (p != list) {
            STP_TRY(stp_ply_skip_property(&ply->cursor, p, err));
            continue;
        }
        STP_TRY(stp_ply_next_length(&ply->cursor, p, &length, err));
        for (uint64_t k = 0; k < length; k++)
            STP_TRY(stp_ply_next_value(&ply->cursor, p->type, k == 0 ? &number : &other, err));
    }
    STP_TRY(stp_ply_record_end(&ply->cursor, err));
    *vertex = number >= 0.0 && number < (double)ply->vertex->count ? (uint64_t)number : UINT64_MAX;
done:
    return status;
}

static stp_status read_cells(stp_ply *ply, const stp_ply_element *element, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_ply_property *list = stp_ply_index_list(&ply->header, element);
    const uint64_t columns = ply->header.grid_size[0];
    const uint64_t stride = element->count / STP_PLY_GRID_CELLS + 1;
    stp_grid_cell *cells = NULL;
    uint32_t count = 0;
    STP_TRY(stp_alloc(&cells, (size_t)(element->count / stride) + 1, sizeof *cells, "a grid", err));
    for (const stp_ply_element *e = ply->vertex; e != element; e++)
        STP_TRY(stp_ply_skip_element(&ply->cursor, &ply->header, e, err));
    ply->cursor.element = element;
    ply->cursor.index = 0;
    for (uint64_t i = 0; i < element->count; i++) {
        uint64_t vertex;
        STP_TRY(read_pixel(ply, element, list, &vertex, err));
        if (i % stride == 0 && vertex != UINT64_MAX)
            cells[count++] =
                (stp_grid_cell){vertex, (uint32_t)(i % columns), (uint32_t)(i / columns)};
    }
    if (count == 0) /* a grid without cells would mean that the points' order is the grid */
        goto done;
    ply->grid = (stp_scan_grid){.columns = (uint32_t)columns,
                                .rows = (uint32_t)ply->header.grid_size[1],
                                .cells = cells,
                                .cell_count = count};
    ply->cells = cells;
    cells = NULL;
done:
    free(cells);
    return status;
}

stp_status stp_ply_grid_read(stp_ply *ply, stp_error *err)
{
    const stp_ply_element *element = stp_ply_header_find(&ply->header, "range_grid");
    const uint64_t *size = ply->header.grid_size;
    uint64_t pixels;
    if (!element || element < ply->vertex || size[0] == 0 || size[0] > UINT32_MAX ||
        size[1] > UINT32_MAX || !stp_mul_u64(size[0], size[1], &pixels) ||
        pixels != element->count || !stp_ply_index_list(&ply->header, element))
        return STP_OK;
    const stp_status status = read_cells(ply, element, err);
    stp_source_seek(&ply->source, ply->vertex_offset, ply->vertex_line);
    ply->cursor.element = ply->vertex;
    ply->cursor.index = 0;
    return status == STP_CORRUPT || status == STP_LIMIT ? STP_OK : status;
}
