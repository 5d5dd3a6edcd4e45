/* Planes of records in a zstd frame. */
#include "formats/chunk/block/packed_table.h"

#include "base/memory.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

/* Offsets in the head. */
enum { AT_KIND = 0, AT_COUNT = 4, AT_HASH = 8, HEAD_BYTES = 16 };
/* Higher levels win 2 % and take five times as long. */
#define LEVEL 12

static bool is_bomb(uint64_t bytes, size_t packed)
{
    return bytes / STP_PACKED_RATIO_MOST > packed;
}

/* Record by record to plane by plane, or back. */
static void turn(const uint8_t *from, size_t rows, size_t columns, uint8_t *to)
{
    for (size_t c = 0; c < columns; c++)
        for (size_t r = 0; r < rows; r++)
            to[c * rows + r] = from[r * columns + c];
}

stp_status stp_table_pack(const uint8_t *records, size_t count, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *planes = NULL;
    const size_t size = count * STP_BLOCK_BYTES, begin = out->size;
    const size_t most = HEAD_BYTES + ZSTD_compressBound(size);
    if (count < STP_PACKED_LEAST || count > UINT32_MAX >> STP_SECTION_COUNT_AT)
        return STP_OK;
    STP_TRY(stp_alloc(&planes, size + 1, 1, "the table of blocks", err));
    STP_TRY(stp_bytes_append(out, NULL, most, err));
    turn(records, count, STP_BLOCK_BYTES, planes);
    uint8_t *head = out->data + begin;
    const size_t packed = ZSTD_compress(head + HEAD_BYTES, most - HEAD_BYTES, planes, size, LEVEL);
    if (ZSTD_isError(packed)) {
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "the table of blocks: zstd failed: %s",
                               ZSTD_getErrorName(packed));
        goto done;
    }
    out->size = begin;
    if (is_bomb(size, HEAD_BYTES + packed))
        goto done;
    stp_put_u32(head + AT_KIND, STP_SECTION_PACKED_BLOCKS);
    stp_put_u32(head + AT_COUNT, (uint32_t)count);
    stp_put_u64(head + AT_HASH, stp_hash(head + HEAD_BYTES, packed));
    out->size = begin + HEAD_BYTES + packed;
done:
    free(planes);
    return status;
}

size_t stp_packed_table_bytes(const uint8_t *packed, size_t left, uint64_t count)
{
    if (left < HEAD_BYTES || stp_get_u32(packed + AT_KIND) != STP_SECTION_PACKED_BLOCKS ||
        stp_get_u32(packed + AT_COUNT) != count)
        return 0;
    const size_t size = ZSTD_findFrameCompressedSize(packed + HEAD_BYTES, left - HEAD_BYTES);
    if (ZSTD_isError(size) || stp_hash(packed + HEAD_BYTES, size) != stp_get_u64(packed + AT_HASH))
        return 0;
    return HEAD_BYTES + size;
}

stp_status stp_table_unpack(const uint8_t *packed, size_t size, uint64_t count, uint8_t **out,
                            stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *planes = NULL, *records = NULL;
    const uint64_t bytes = count * STP_BLOCK_BYTES;
    if (stp_packed_table_bytes(packed, size, count) != size || is_bomb(bytes, size))
        return stp_error_set(err, STP_CORRUPT,
                             "the table of blocks is not one of %" PRIu64 " records", count);
    STP_TRY(stp_alloc(&planes, (size_t)bytes + 1, 1, "the table of blocks", err));
    STP_TRY(stp_alloc(&records, (size_t)bytes + 1, 1, "the table of blocks", err));
    const size_t found =
        ZSTD_decompress(planes, (size_t)bytes, packed + HEAD_BYTES, size - HEAD_BYTES);
    if (ZSTD_isError(found) || found != bytes) {
        status = stp_error_set(err, STP_CORRUPT, "the table of blocks does not unpack");
        goto done;
    }
    turn(planes, STP_BLOCK_BYTES, (size_t)count, records);
    *out = records;
    records = NULL;
done:
    free(planes);
    free(records);
    return status;
}
