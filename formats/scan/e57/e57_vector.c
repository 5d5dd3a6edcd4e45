/* Reads the points of an E57 scan as columns of numbers. */
#include "formats/scan/e57/e57_vector.h"

#include "base/memory.h"

#include <stdlib.h>
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

stp_status stp_e57_vector_create(stp_e57_vector *v, const stp_e57_document *document,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t most = 0;
    for (size_t i = 0; document->keeps_numbers && i < document->scan_count; i++)
        most = document->scans[i].extra_count > most ? document->scans[i].extra_count : most;
    v->document = document;
    v->section.packet_count = STP_E57_TARGET_COUNT + most;
    STP_TRY(stp_alloc(&v->lanes, most, sizeof *v->lanes, "attributes", err));
    STP_TRY(stp_alloc(&v->section.packets, v->section.packet_count, sizeof *v->section.packets,
                      "packets", err));
done:
    return status;
}

void stp_e57_vector_free(stp_e57_vector *v)
{
    free(v->lanes);
    free(v->section.packets);
    v->lanes = NULL;
    v->section.packets = NULL;
}

static void start(const stp_e57_vector *v, stp_e57_stream *stream, uint32_t number)
{
    stream->cursor = stp_e57_section_start(&v->section, number);
    stream->bit = 0;
    stream->staged = 0;
}

stp_status stp_e57_vector_open(stp_e57_vector *v, stp_e57_pages *pages, const stp_e57_scan *scan,
                               stp_error *err)
{
    stp_status status = STP_OK;
    v->scan = scan;
    v->index = 0;
    v->lane_count = 0;
    STP_TRY(stp_e57_section_open(&v->section, pages, scan, err));
    STP_TRY(check_count(v, err));
    for (int t = 0; t < STP_E57_TARGET_COUNT; t++)
        start(v, &v->streams[t], scan->fields[t].stream);
    for (uint32_t e = 0; v->document->keeps_numbers && e < scan->extra_count; e++) {
        const stp_e57_extra *extra = &v->document->extras[scan->extra_first + e];
        if (!extra->field.present)
            continue;
        v->lanes[v->lane_count].extra = extra;
        start(v, &v->lanes[v->lane_count++].stream, extra->field.stream);
    }
done:
    return status;
}

/* Notes how far a bytestream is to be moved on; a value may begin within a byte. */
static size_t list_skip(stp_e57_skip *out, const stp_e57_field *field, stp_e57_stream *stream,
                        uint64_t record)
{
    if (!field->present || field->bits == 0)
        return 0;
    *out = (stp_e57_skip){&stream->cursor, record * field->bits / 8};
    stream->bit = (uint32_t)(record * field->bits % 8);
    return 1;
}

/* Takes the byte that the next value begins within. */
static stp_status stage(stp_e57_vector *v, stp_e57_stream *stream, stp_error *err)
{
    return stream->bit > 0 ? stp_e57_section_take(&v->section, &stream->cursor, stream->bytes, 1,
                                                  &stream->staged, err)
                           : STP_OK;
}

stp_status stp_e57_vector_seek(stp_e57_vector *v, uint64_t record, stp_error *err)
{
    stp_status status = STP_OK;
    stp_e57_skip *skips = NULL;
    size_t count = 0;
    STP_TRY(stp_alloc(&skips, v->section.packet_count, sizeof *skips, "bytestreams", err));
    for (int t = 0; t < STP_E57_TARGET_COUNT; t++)
        count += list_skip(&skips[count], &v->scan->fields[t], &v->streams[t], record);
    for (uint32_t k = 0; k < v->lane_count; k++)
        count += list_skip(&skips[count], &v->lanes[k].extra->field, &v->lanes[k].stream, record);
    STP_TRY(stp_e57_section_skip(&v->section, skips, count, err));
    for (int t = 0; t < STP_E57_TARGET_COUNT; t++)
        STP_TRY(stage(v, &v->streams[t], err));
    for (uint32_t k = 0; k < v->lane_count; k++)
        STP_TRY(stage(v, &v->lanes[k].stream, err));
    v->index = record;
done:
    free(skips);
    return status;
}

/* The number of a field of whole numbers that begins at this bit. */
static inline int64_t integer_at(const stp_e57_field *field, const stp_e57_stream *stream,
                                 size_t position)
{
    const uint32_t bits = field->bits, shift = position % 8;
    const uint64_t mask = bits == 64 ? UINT64_MAX : ((uint64_t)1 << bits) - 1;
    const unsigned char *bytes = stream->bytes + position / 8;
    uint64_t raw;
    memcpy(&raw, bytes, sizeof raw);
    raw >>= shift;
    if (shift + bits > 64)
        raw |= (uint64_t)bytes[8] << (64 - shift);
    /* Add in two's complement, which works for any minimum. */
    return (int64_t)((uint64_t)field->minimum + (raw & mask));
}

static void unpack(const stp_e57_field *field, const stp_e57_stream *stream, size_t count,
                   double *out)
{
    if (field->type == STP_E57_DOUBLE) {
        memcpy(out, stream->bytes, count * sizeof *out);
        return;
    }
    for (size_t i = 0; field->type == STP_E57_FLOAT && i < count; i++) {
        float value;
        memcpy(&value, stream->bytes + i * sizeof value, sizeof value);
        out[i] = (double)value;
    }
    for (size_t i = 0; field->type == STP_E57_INTEGER && i < count; i++) {
        const int64_t value = integer_at(field, stream, stream->bit + i * field->bits);
        out[i] = (double)value * field->scale + field->offset;
    }
}

static void unpack_words(const stp_e57_field *field, const stp_e57_stream *stream, size_t count,
                         uint64_t *out)
{
    for (size_t i = 0; i < count; i++)
        out[i] = field->type == STP_E57_INTEGER
                     ? (uint64_t)integer_at(field, stream, stream->bit + i * field->bits)
                     : stp_attribute_get(field->type == STP_E57_FLOAT ? STP_ATTRIBUTE_F32
                                                                      : STP_ATTRIBUTE_F64,
                                         stream->bytes + i * field->bits / 8);
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

/* Reads the next values of a field into the column, else into the words. */
static stp_status read_field(stp_e57_vector *v, const stp_e57_field *field, stp_e57_stream *stream,
                             size_t count, double *column, uint64_t *words, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t bits = stream->bit + count * field->bits;
    const size_t needed = (bits + 7) / 8 - stream->staged;
    size_t got;
    STP_TRY(stp_e57_section_take(&v->section, &stream->cursor, stream->bytes + stream->staged,
                                 needed, &got, err));
    if (got < needed)
        return short_stream(v, ((stream->staged + got) * 8 - stream->bit) / field->bits, err);
    if (column)
        unpack(field, stream, count, column);
    else
        unpack_words(field, stream, count, words);
    stream->bit = bits % 8;
    stream->staged = stream->bit > 0 ? 1 : 0;
    if (stream->staged > 0)
        stream->bytes[0] = stream->bytes[bits / 8];
done:
    return status;
}

/* Checks that the bytestream does not go on after the last record: its points would be lost
 * silently. */
static stp_status check_rest(stp_e57_vector *v, const stp_e57_field *field, stp_e57_stream *stream,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const bool padded = field->type == STP_E57_INTEGER;
    const size_t most = field->bits / 8 + (padded ? PADDING_BYTES : 0);
    size_t got = 0;
    if (field->bits == 0)
        return STP_OK;
    STP_TRY(stp_e57_section_take(&v->section, &stream->cursor, NULL, most, &got, err));
    if (got == most)
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: the packets of the scan at byte %llu hold more than the %llu "
                               "points that it declares: the file is damaged; export it again",
                               v->section.pages->path, (unsigned long long)v->scan->file_offset,
                               (unsigned long long)v->scan->record_count);
done:
    return status;
}

stp_status stp_e57_vector_read(stp_e57_vector *v, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    const bool last = v->index + count == v->scan->record_count;
    for (int t = 0; t < STP_E57_TARGET_COUNT; t++)
        if (v->scan->fields[t].present)
            STP_TRY(read_field(v, &v->scan->fields[t], &v->streams[t], count, v->columns[t], NULL,
                               err));
    for (uint32_t k = 0; k < v->lane_count; k++)
        STP_TRY(read_field(v, &v->lanes[k].extra->field, &v->lanes[k].stream, count, NULL,
                           v->lanes[k].words, err));
    v->index += count;
    for (int t = 0; last && t < STP_E57_TARGET_COUNT; t++)
        if (v->scan->fields[t].present)
            STP_TRY(check_rest(v, &v->scan->fields[t], &v->streams[t], err));
    for (uint32_t k = 0; last && k < v->lane_count; k++)
        STP_TRY(check_rest(v, &v->lanes[k].extra->field, &v->lanes[k].stream, err));
done:
    return status;
}
