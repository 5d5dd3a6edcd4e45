/* Finds the rows and columns of an E57 file's scans. */
#include "formats/scan/e57/e57_images.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

/* Most pixels of an image for each record. */
#define SPARSEST 4.0

/* The least and the greatest column, then row. */
typedef struct extent {
    double low[2], high[2];
} extent;

static stp_status find_extent(const stp_e57_scan *scan, stp_e57_vector *v, stp_e57_pages *pages,
                              extent *out, stp_error *err)
{
    stp_status status = STP_OK;
    const double *columns[2] = {v->columns[STP_E57_COLUMN], v->columns[STP_E57_ROW]};
    *out = (extent){{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    STP_TRY(stp_e57_vector_open(v, pages, scan, err));
    while (v->index < scan->record_count) {
        const uint64_t left = scan->record_count - v->index;
        const size_t part = left < STP_E57_BLOCK_POINTS ? (size_t)left : STP_E57_BLOCK_POINTS;
        STP_TRY(stp_e57_vector_read(v, part, err));
        for (int k = 0; k < 2; k++)
            for (size_t i = 0; i < part; i++) {
                out->low[k] = fmin(out->low[k], columns[k][i]);
                out->high[k] = fmax(out->high[k], columns[k][i]);
            }
    }
done:
    return status;
}

stp_status stp_e57_images_add(stp_e57_images *images, const stp_e57_scan *scan, uint64_t first,
                              uint16_t station, stp_e57_vector *vector, stp_e57_pages *pages,
                              stp_error *err)
{
    stp_status status = STP_OK;
    extent e;
    if (scan->record_count == 0 || !scan->fields[STP_E57_ROW].present ||
        !scan->fields[STP_E57_COLUMN].present)
        return STP_OK;
    STP_TRY(find_extent(scan, vector, pages, &e, err));
    const double columns = e.high[0] - e.low[0] + 1.0, rows = e.high[1] - e.low[1] + 1.0;
    if (!(columns * rows < (double)UINT32_MAX) ||
        columns * rows > SPARSEST * (double)scan->record_count)
        goto done;
    const size_t needed = (size_t)images->count + 1;
    STP_TRY(
        stp_grow(&images->list, &images->capacity, needed, sizeof *images->list, "images", err));
    STP_TRY(stp_grow(&images->first, &images->first_capacity, needed, sizeof *images->first,
                     "images", err));
    images->first[images->count][0] = e.low[0];
    images->first[images->count][1] = e.low[1];
    images->list[images->count++] = (stp_scan_image){.first = first,
                                                     .count = scan->record_count,
                                                     .columns = (uint32_t)columns,
                                                     .rows = (uint32_t)rows,
                                                     .station = station};
done:
    return status;
}

void stp_e57_images_tell(const stp_e57_images *images, const stp_e57_vector *vector,
                         uint16_t station, stp_point *points, size_t count)
{
    uint32_t k = 0;
    while (k < images->count && images->list[k].station != station)
        k++;
    for (size_t i = 0; i < count; i++) {
        points[i].pixel = STP_POINT_NO_PIXEL;
        if (k == images->count)
            continue;
        const double column = vector->columns[STP_E57_COLUMN][i] - images->first[k][0];
        const double row = vector->columns[STP_E57_ROW][i] - images->first[k][1];
        if (column == floor(column) && row == floor(row))
            points[i].pixel = (uint32_t)row * images->list[k].columns + (uint32_t)column;
    }
}

void stp_e57_images_clear(stp_e57_images *images)
{
    free(images->list);
    free(images->first);
    *images = (stp_e57_images){0};
}
