/* Reads the points of an E57 scan as columns of numbers. */
#include "formats/scan/e57/e57_vector.h"

#include <string.h>

/* Writers pad whole numbers of few bits to a word. More bytes than that are more values. */
#define PADDING_BYTES 8u

static stp_status check_count(const stp_e57_vector *v, stp_error *err)
{
    const stp_e57_scan *scan = v->scan;
    const uint64_t bytes = v->section.end - v->section.first;
    if (scan->record_bits == 0 && scan->record_count > 1)
        return stp_error_set(err, STP_LIMIT,
                             "%s: a scan of %llu points that are all the same one: export it as "
                             "one point",
                             v->section.pages->path, (unsigned long long)scan->record_count);
    /* No overflow: a section is smaller than its file, and file sizes have at most 63 bits. */
    if (scan->record_bits == 0 || scan->record_count <= bytes * 8 / scan->record_bits)
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: a scan declares %llu points, but the %llu bytes from byte %llu on "
                         "hold at most %llu: the file is damaged; copy or export it again",
                         v->section.pages->path, (unsigned long long)scan->record_count,
                         (unsigned long long)bytes,
                         (unsigned long long)stp_e57_physical(v->section.first),
                         (unsigned long long)(bytes * 8 / scan->record_bits));
}

stp_status stp_e57_vector_open(stp_e57_vector *v, stp_e57_pages *pages, const stp_e57_scan *scan,
                               stp_error *err)
{
    stp_status status = STP_OK;
    v->scan = scan;
    v->index = 0;
    STP_TRY(stp_e57_section_open(&v->section, pages, scan, err));
    STP_TRY(check_count(v, err));
    for (int t = 0; t < STP_E57_TARGET_COUNT; t++) {
        stp_e57_stream *stream = &v->streams[t];
        stream->cursor = stp_e57_section_start(&v->section, scan->fields[t].stream);
        stream->bit = 0;
        stream->staged = 0;
    }
done:
    return status;
}

static void unpack_integers(const stp_e57_field *field, const stp_e57_stream *stream, size_t count,
                            double *out)
{
    const uint32_t bits = field->bits;
    const uint64_t mask = bits == 64 ? UINT64_MAX : ((uint64_t)1 << bits) - 1;
    size_t position = stream->bit;
    for (size_t i = 0; i < count; i++, position += bits) {
        const unsigned char *bytes = stream->bytes + position / 8;
        const uint32_t shift = position % 8;
        uint64_t raw;
        memcpy(&raw, bytes, sizeof raw);
        raw >>= shift;
        if (shift + bits > 64)
            raw |= (uint64_t)bytes[8] << (64 - shift);
        /* Add in two's complement, which works for any minimum. */
        const int64_t value = (int64_t)((uint64_t)field->minimum + (raw & mask));
        out[i] = (double)value * field->scale + field->offset;
    }
}

static void unpack(const stp_e57_field *field, const stp_e57_stream *stream, size_t count,
                   double *out)
{
    if (field->type == STP_E57_DOUBLE) {
        memcpy(out, stream->bytes, count * sizeof *out);
    } else if (field->type == STP_E57_FLOAT) {
        for (size_t i = 0; i < count; i++) {
            float value;
            memcpy(&value, stream->bytes + i * sizeof value, sizeof value);
            out[i] = (double)value;
        }
    } else {
        unpack_integers(field, stream, count, out);
    }
}

static stp_status short_stream(const stp_e57_vector *v, uint64_t whole, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: the packets of the scan at byte %llu end after %llu of its %llu "
                         "points: the file is damaged; copy or export it again",
                         v->section.pages->path, (unsigned long long)v->scan->file_offset,
                         (unsigned long long)(v->index + whole),
                         (unsigned long long)v->scan->record_count);
}

static stp_status read_field(stp_e57_vector *v, int target, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_e57_field *field = &v->scan->fields[target];
    stp_e57_stream *stream = &v->streams[target];
    const size_t bits = stream->bit + count * field->bits;
    const size_t needed = (bits + 7) / 8 - stream->staged;
    size_t got;
    STP_TRY(stp_e57_section_take(&v->section, &stream->cursor, stream->bytes + stream->staged,
                                 needed, &got, err));
    if (got < needed)
        return short_stream(v, ((stream->staged + got) * 8 - stream->bit) / field->bits, err);
    unpack(field, stream, count, v->columns[target]);
    stream->bit = bits % 8;
    stream->staged = stream->bit > 0 ? 1 : 0;
    if (stream->staged > 0)
        stream->bytes[0] = stream->bytes[bits / 8];
done:
    return status;
}

/* Checks that no bytestream goes on after the last record: its points would be lost silently. */
static stp_status check_rest(stp_e57_vector *v, stp_error *err)
{
    stp_status status = STP_OK;
    for (int t = 0; t < STP_E57_TARGET_COUNT; t++) {
        const stp_e57_field *field = &v->scan->fields[t];
        const bool padded = field->type == STP_E57_INTEGER;
        const size_t most = field->bits / 8 + (padded ? PADDING_BYTES : 0);
        size_t got = 0;
        if (!field->present || field->bits == 0)
            continue;
        STP_TRY(stp_e57_section_take(&v->section, &v->streams[t].cursor, NULL, most, &got, err));
        if (got == most)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: the packets of the scan at byte %llu hold more than the %llu "
                                 "points that it declares: the file is damaged; export it again",
                                 v->section.pages->path, (unsigned long long)v->scan->file_offset,
                                 (unsigned long long)v->scan->record_count);
    }
done:
    return status;
}

stp_status stp_e57_vector_read(stp_e57_vector *v, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    for (int t = 0; t < STP_E57_TARGET_COUNT; t++)
        if (v->scan->fields[t].present)
            STP_TRY(read_field(v, t, count, err));
    v->index += count;
    if (v->index == v->scan->record_count)
        STP_TRY(check_rest(v, err));
done:
    return status;
}
