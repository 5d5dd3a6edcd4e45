/* Finds and reads the unused bytes among payloads. */
#include "formats/chunk/free_ranges.h"

#include "base/checked.h"
#include "base/memory.h"
#include "formats/chunk/chunk_reader.h"

#include <inttypes.h>
#include <stdlib.h>

static int compare_ranges(const void *a, const void *b)
{
    const stp_free_range *x = a, *y = b;
    return (x->offset > y->offset) - (x->offset < y->offset);
}

static stp_status add(stp_bytes *out, uint64_t begin, uint64_t end, stp_error *err)
{
    uint8_t record[STP_FREE_BYTES];
    if (end <= begin)
        return STP_OK;
    stp_put_u64(record, begin);
    stp_put_u64(record + 8, end - begin);
    return stp_bytes_append(out, record, sizeof record, err);
}

stp_status stp_free_ranges_find(const stp_chunk_entry *entries, uint32_t count, uint64_t begin,
                                uint64_t end, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_free_range *used = NULL;
    STP_TRY(stp_alloc(&used, count, sizeof *used, "payloads", err));
    for (uint32_t id = 0; id < count; id++)
        used[id] =
            (stp_free_range){entries[id].offset, entries[id].segment_end[STP_SEGMENT_COUNT - 1]};
    qsort(used, count, sizeof *used, compare_ranges);
    for (uint32_t i = 0; i < count; i++) {
        STP_TRY(add(out, begin, used[i].offset, err));
        if (used[i].offset + used[i].bytes > begin) /* else another payload is around it */
            begin = used[i].offset + used[i].bytes;
    }
    STP_TRY(add(out, begin, end, err));
done:
    free(used);
    return status;
}

/* Reads the section as it is. */
static stp_status load(const stp_chunk_file *file, const stp_section *section, uint8_t **out,
                       stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    const size_t size = (size_t)section->bytes;
    STP_TRY(stp_alloc(&bytes, size + 1, 1, "unused bytes", err));
    STP_TRY(stp_chunk_file_bytes(file, section->offset, bytes, size, false, err));
    if (stp_hash(bytes, size) != section->hash)
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: the checksum of the list of unused bytes at byte %" PRIu64
                               " does not match: the file is damaged; copy it again",
                               file->path, section->offset);
    if (status == STP_OK) {
        *out = bytes;
        bytes = NULL;
    }
done:
    free(bytes);
    return status;
}

stp_status stp_free_ranges_read(const stp_chunk_file *file, stp_free_range **out, size_t *count,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const stp_section *section = stp_header_section(&file->header, STP_SECTION_FREE);
    const uint64_t limit = stp_payloads_end(&file->header);
    stp_free_range *ranges = NULL;
    uint8_t *bytes = NULL;
    uint64_t at = stp_header_span(&file->header);
    *out = NULL;
    *count = 0;
    if (!section || section->bytes == 0)
        return STP_OK;
    const size_t found = (size_t)(section->bytes / STP_FREE_BYTES);
    STP_TRY(load(file, section, &bytes, err));
    STP_TRY(stp_alloc(&ranges, found, sizeof *ranges, "unused bytes", err));
    for (size_t i = 0; i < found; i++) {
        const uint8_t *record = bytes + i * STP_FREE_BYTES;
        ranges[i] = (stp_free_range){stp_get_u64(record), stp_get_u64(record + 8)};
        if (ranges[i].offset < at || ranges[i].bytes == 0 ||
            !stp_range_inside(ranges[i].offset, ranges[i].bytes, limit)) {
            status = stp_error_set(err, STP_CORRUPT,
                                   "%s: unused range %zu is empty, out of order or not among the "
                                   "payloads: the file was written wrong",
                                   file->path, i);
            goto done;
        }
        at = ranges[i].offset + ranges[i].bytes;
    }
    *out = ranges;
    *count = found;
    ranges = NULL;
done:
    free(ranges);
    free(bytes);
    return status;
}

stp_status stp_free_ranges_sum(const stp_chunk_file *file, uint64_t *bytes, stp_error *err)
{
    stp_free_range *ranges = NULL;
    size_t count = 0;
    uint64_t sum = 0;
    const stp_status status = stp_free_ranges_read(file, &ranges, &count, err);
    for (size_t i = 0; i < count; i++)
        sum += ranges[i].bytes;
    free(ranges);
    if (status == STP_OK)
        *bytes = sum;
    return status;
}
