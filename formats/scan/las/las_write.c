/* Writes points as a stream of LAS 1.4. */
#include "formats/scan/las/las_write.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/scan/las/las_bytes.h"
#include "formats/scan/las/las_header.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STP_LAS_RECORD_BYTES_MAX 36u
/* Bytes are collected in blocks, so that stp_output is called once per block, not per point. */
#define STP_LAS_BLOCK_RECORDS 1024u
/* Says that a coordinate system is WKT. The standard requires that for formats 6 and up, even if
 * there is no coordinate system. */
#define ENCODING_WKT 0x10u

struct stp_las_writer {
    stp_output *output;
    char *path;
    stp_las_writer_params params;
    const stp_las_format *format;
    unsigned point_format;
    uint64_t written;
    int32_t min[3], max[3]; /* in steps; min > max: no points */
    unsigned char block[STP_LAS_BLOCK_RECORDS * STP_LAS_RECORD_BYTES_MAX];
};

double stp_las_finest_step(double reach)
{
    /* Powers of ten up to 10^22 are exact doubles, so 1 divided by one of them is rounded only
     * once. */
    int exponent = (int)ceil(log10(reach / INT32_MAX));
    for (;; exponent++) {
        const double step = exponent < 0 ? 1.0 / pow(10.0, -exponent) : pow(10.0, exponent);
        if (reach / step < (double)INT32_MAX)
            return step;
    }
}

static void put_header(const stp_las_writer *w, unsigned char *h)
{
    static const char signature[4] = {'L', 'A', 'S', 'F'};
    static const char system_identifier[32] = "OTHER", generating_software[32] = "stipple";
    const double offset[3] = {w->params.offset.x, w->params.offset.y, w->params.offset.z};
    memset(h, 0, STP_LAS_HEADER_BYTES_1_4);
    memcpy(h, signature, sizeof signature);
    stp_las_put_u16(h + 6, ENCODING_WKT);
    h[24] = 1;
    h[25] = 4;
    memcpy(h + 26, system_identifier, sizeof system_identifier);
    memcpy(h + 58, generating_software, sizeof generating_software);
    stp_las_put_u16(h + 94, STP_LAS_HEADER_BYTES_1_4);
    stp_las_put_u32(h + 96, STP_LAS_HEADER_BYTES_1_4);
    h[104] = (unsigned char)w->point_format;
    stp_las_put_u16(h + 105, w->format->bytes);
    for (int axis = 0; axis < 3; axis++) {
        stp_las_put_double(h + 131 + 8 * axis, w->params.step);
        stp_las_put_double(h + 155 + 8 * axis, offset[axis]);
        if (w->written == 0)
            continue;
        stp_las_put_double(h + 179 + 16 * axis, w->max[axis] * w->params.step + offset[axis]);
        stp_las_put_double(h + 187 + 16 * axis, w->min[axis] * w->params.step + offset[axis]);
    }
    stp_las_put_u64(h + 247, w->written); /* the 32-bit count is 0 for formats 6 and up */
    stp_las_put_u64(h + 255, w->written); /* points with return number 1 */
}

stp_status stp_las_writer_create(stp_las_writer **out, const char *path,
                                 const stp_las_writer_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_las_writer *w = NULL;
    unsigned char header[STP_LAS_HEADER_BYTES_1_4];
    if (params->attributes & STP_POINT_HAS_NORMAL)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: LAS has no normals: write PLY, or no normals", path);
    if (!(params->step > 0.0) || !isfinite(params->step) || !stp_dvec3_finite(params->offset))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: a LAS file needs a positive step and a finite offset, not %g and "
                             "(%g, %g, %g)",
                             path, params->step, params->offset.x, params->offset.y,
                             params->offset.z);
    STP_TRY(stp_alloc(&w, 1, sizeof *w, "LAS writer", err));
    w->params = *params;
    w->point_format = params->attributes & STP_POINT_HAS_COLOUR ? 7 : 6;
    w->format = stp_las_format_get(w->point_format);
    for (int axis = 0; axis < 3; axis++) {
        w->min[axis] = INT32_MAX;
        w->max[axis] = INT32_MIN;
    }
    STP_TRY(stp_text_copy(&w->path, path, "path", err));
    STP_TRY(stp_output_create(&w->output, path, params->force, err));
    put_header(w, header);
    STP_TRY(stp_output_write(w->output, header, sizeof header, err));
    *out = w;
    w = NULL;
done:
    stp_las_writer_destroy(&w);
    return status;
}

static stp_status put_position(stp_las_writer *w, unsigned char *record, const stp_point *point,
                               stp_error *err)
{
    const double at[3] = {point->position.x, point->position.y, point->position.z};
    const double offset[3] = {w->params.offset.x, w->params.offset.y, w->params.offset.z};
    for (int axis = 0; axis < 3; axis++) {
        const double steps = nearbyint((at[axis] - offset[axis]) / w->params.step);
        if (!(steps >= INT32_MIN && steps <= INT32_MAX))
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "%s: %c = %.17g does not fit LAS integers of step %g from %.17g: "
                                 "take a coarser step or another offset",
                                 w->path, "xyz"[axis], at[axis], w -> params.step, offset[axis]);
        const int32_t value = (int32_t)steps;
        w->min[axis] = value < w->min[axis] ? value : w->min[axis];
        w->max[axis] = value > w->max[axis] ? value : w->max[axis];
        stp_las_put_u32(record + 4 * axis, (uint32_t)value);
    }
    return STP_OK;
}

static stp_status put_point(stp_las_writer *w, unsigned char *record, const stp_point *point,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t has = w->params.attributes;
    memset(record, 0, w->format->bytes);
    STP_TRY(put_position(w, record, point, err));
    if (has & STP_POINT_HAS_INTENSITY)
        stp_las_put_u16(record + 12, point->intensity);
    record[14] = 0x11; /* return 1 of 1 */
    if (has & STP_POINT_HAS_CLASS)
        record[16] = point->class_id;
    if (has & STP_POINT_HAS_STATION)
        stp_las_put_u16(record + 20, point->station);
    for (unsigned k = 0; k < 3 && (has & STP_POINT_HAS_COLOUR); k++)
        stp_las_put_u16(record + w->format->rgb + 2 * k, point->rgb[k]);
done:
    return status;
}

stp_status stp_las_writer_points(stp_las_writer *writer, const stp_point *points, size_t count,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    const size_t bytes = writer->format->bytes;
    while (count > 0) {
        const size_t part = count < STP_LAS_BLOCK_RECORDS ? count : STP_LAS_BLOCK_RECORDS;
        for (size_t i = 0; i < part; i++)
            STP_TRY(put_point(writer, writer->block + i * bytes, &points[i], err));
        STP_TRY(stp_output_write(writer->output, writer->block, part * bytes, err));
        writer->written += part;
        points += part;
        count -= part;
    }
done:
    return status;
}

stp_status stp_las_writer_finish(stp_las_writer **writer, stp_error *err)
{
    stp_status status = STP_OK;
    stp_las_writer *w = *writer;
    unsigned char header[STP_LAS_HEADER_BYTES_1_4];
    put_header(w, header);
    STP_TRY(stp_output_write_at(w->output, 0, header, sizeof header, err));
    STP_TRY(stp_output_commit(&w->output, err));
done:
    stp_las_writer_destroy(writer);
    return status;
}

void stp_las_writer_destroy(stp_las_writer **writer)
{
    stp_las_writer *w = *writer;
    if (!w)
        return;
    stp_output_destroy(&w->output);
    free(w->path);
    free(w);
    *writer = NULL;
}
