/* Encodes and decodes segments of codec 2: byte planes in zstd frames. */
#include "formats/chunk/codec/zstd/zstd_segment.h"

#include "base/memory.h"
#include "formats/chunk/codec/part.h"
#include "formats/chunk/codec/predict/families.h"
#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/codec/shares.h"
#include "formats/chunk/codec/zstd/zstd_frame.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/normal_grid.h"
#include "formats/chunk/sample/patch.h"

#include <stdlib.h>
#include <string.h>

#define SIZE_BYTES 4u
#define MASK_BYTES 4u
#define STEP_BYTES 1u /* in blocks: the step of the level's normals, behind the mask: */
/* the shift, and from this bit on the odd part */
#define ODD_BIT 4u
/* The least size of a block with tables of its own. The tables take as long to read as this many
 * bytes. */
#define BLOCK_BYTES_LEAST 8192u
#define BLOCK_BYTES_LEAST_SHORT 1024u /* in a block of a chunk, whose planes are short */
#define ENDS_LIMIT 256u
/* A part is stored raw if zstd makes it no smaller than this many eighths: then it costs no time.
 */
#define RAW_EIGHTHS 6u
#define RAW_BYTES_LEAST 512u
/* Parts of planes: first the elder slots of all planes, then the last slots of all planes. */
#define PARTS (2u * STP_FAMILY_PLANES)

/* Bytes of a level before its raw parts. */
static size_t level_head_bytes(const stp_chunk *chunk)
{
    return MASK_BYTES + (chunk->is_block ? STEP_BYTES : 0);
}

static size_t part_bytes(unsigned part, uint32_t families)
{
    return (size_t)families * (part < STP_FAMILY_PLANES ? STP_FAMILY_SLOTS - 1 : 1);
}

/* Where blocks end. */
typedef struct block_ends {
    size_t at[ENDS_LIMIT];
    size_t count, begin, least;
} block_ends;

static block_ends ends_begin(const stp_chunk *chunk)
{
    return (block_ends){.least = chunk->is_block ? BLOCK_BYTES_LEAST_SHORT : BLOCK_BYTES_LEAST};
}

static void ends_add(block_ends *e, size_t end, bool last)
{
    if (!last && (end - e->begin < e->least || e->count + 1 >= ENDS_LIMIT))
        return;
    e->at[e->count++] = end;
    e->begin = end;
}

/* ---- tables of patches and vertices ---- */

static unsigned patch_columns(bool linked)
{
    return linked ? STP_LINKED_PATCH_COLUMN_COUNT : STP_PATCH_COLUMN_COUNT;
}

/* Columns as two planes, of low and of high bytes of their folded cells. */
static void cells_to_planes(const stp_table *table, uint8_t *low, uint8_t *high)
{
    size_t count = (size_t)table->column_count * table->row_count;
    for (size_t i = 0; i < count; i++) {
        int cell = table->values[i];
        unsigned folded = (unsigned)cell << 1 ^ (unsigned)(cell >> 15);
        low[i] = (uint8_t)folded;
        high[i] = (uint8_t)(folded >> 8);
    }
}

static void planes_to_cells(const uint8_t *low, const uint8_t *high, const stp_table *table)
{
    size_t count = (size_t)table->column_count * table->row_count;
    for (size_t i = 0; i < count; i++) {
        unsigned folded = low[i] | (unsigned)high[i] << 8;
        table->values[i] = (int16_t)(folded >> 1 ^ (0u - (folded & 1u)));
    }
}

static stp_table table_at(void *memory, unsigned columns, uint32_t rows)
{
    return (stp_table){
        .values = memory, .stride = rows, .column_count = columns, .row_count = rows};
}

/* Cells of patches and patch vertices, whose tables follow each other. */
static size_t head_cells(uint32_t patch_count, bool linked)
{
    return (size_t)patch_count * (patch_columns(linked) + STP_SAMPLE_COLUMN_COUNT);
}

static stp_status head_encode(const stp_chunk *chunk, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t rows = chunk->patch_count;
    unsigned columns = patch_columns(chunk->linked);
    size_t cells = head_cells(rows, chunk->linked);
    size_t begin = out->size;
    block_ends ends = ends_begin(chunk);
    int16_t *values = NULL;
    uint8_t *planes = NULL;
    STP_TRY(stp_alloc(&values, cells, sizeof *values, "a payload's table", err));
    STP_TRY(stp_alloc(&planes, 2 * cells, 1, "a payload's planes", err));
    stp_table patches = table_at(values, columns, rows);
    stp_table vertices = table_at(values + (size_t)columns * rows, STP_SAMPLE_COLUMN_COUNT, rows);
    stp_patches_encode(chunk->patches, &patches);
    stp_predict_vertices_encode(chunk, &vertices);
    stp_table both = table_at(values, columns + STP_SAMPLE_COLUMN_COUNT, rows);
    cells_to_planes(&both, planes, planes + cells);
    for (unsigned c = 1; c <= 2 * both.column_count; c++)
        ends_add(&ends, (size_t)c * rows, c == 2 * both.column_count);
    STP_TRY(stp_bytes_append(out, NULL, SIZE_BYTES, err));
    STP_TRY(stp_zstd_pack(planes, ends.at, ends.count, out, err));
    stp_put_u32(out->data + begin, (uint32_t)(out->size - begin - SIZE_BYTES));
done:
    free(values);
    free(planes);
    return status;
}

/* ---- scratch memory ---- */

static size_t aligned(size_t size)
{
    return (size + 15u) & ~(size_t)15u;
}

/* Where the working memory of families begins: behind zstd's. Planes or tables follow. */
static size_t lanes_offset(void)
{
    return aligned(stp_zstd_workspace_bytes());
}

static size_t planes_offset(void)
{
    return lanes_offset() + aligned(stp_families_scratch_bytes());
}

static uint8_t *planes_of(const stp_chunk_scratch *scratch)
{
    return (uint8_t *)scratch->memory + planes_offset();
}

static void *lanes_of(const stp_chunk_scratch *scratch)
{
    return (uint8_t *)scratch->memory + lanes_offset();
}

size_t stp_zstd_head_scratch_bytes(uint32_t patch_count, bool linked)
{
    size_t cells = head_cells(patch_count, linked);
    return planes_offset() + 2 * cells + cells * sizeof(int16_t);
}

static size_t scratch_bytes(const stp_chunk *chunk, int segment)
{
    size_t head = segment == 0 ? stp_zstd_head_scratch_bytes(chunk->patch_count, chunk->linked) : 0;
    size_t level = planes_offset() + stp_families_plane_bytes(chunk, stp_segment_finest(segment)) +
                   STP_FAMILY_SLACK;
    return head > level ? head : level;
}

/* ---- decoding ---- */

static stp_status unpack(const uint8_t *frame, size_t size, uint8_t *out, size_t out_bytes,
                         stp_chunk_scratch *scratch, stp_error *err)
{
    if (!scratch->context)
        scratch->context = stp_zstd_context(scratch->memory);
    if (!scratch->context)
        return stp_error_set(err, STP_INTERNAL, "zstd refuses the memory that it asked for");
    return stp_zstd_unpack(frame, size, out, out_bytes, scratch->context, err);
}

/* Counts what the head's frame holds: column by column, low bytes, then high bytes. */
static void count_head(stp_shares *shares, const uint8_t *planes, unsigned patch_column_count,
                       uint32_t rows, size_t frame)
{
    const unsigned columns = patch_column_count + STP_SAMPLE_COLUMN_COUNT;
    stp_share_costs costs = {{0}};
    for (unsigned i = 0; i < 2 * columns; i++) {
        const unsigned c = i % columns;
        stp_share_costs_add(&costs,
                            c < patch_column_count ? STP_SHARE_PATCHES
                                                   : stp_share_of_column(c - patch_column_count),
                            planes + (size_t)i * rows, rows);
    }
    shares->bytes[STP_SHARE_FRAME] += SIZE_BYTES;
    stp_shares_add_packed(shares, &costs, frame);
}

stp_status stp_zstd_patches_decode(const uint8_t *bytes, size_t size, stp_patch *patches,
                                   uint32_t patch_count, bool linked, stp_chunk_scratch *scratch,
                                   size_t *used, stp_error *err)
{
    size_t cells = head_cells(patch_count, linked);
    uint8_t *planes = planes_of(scratch);
    size_t frame = size < SIZE_BYTES ? 0 : stp_get_u32(bytes);
    if (size < SIZE_BYTES || frame > size - SIZE_BYTES)
        return stp_error_set(err, STP_CORRUPT, "its head does not fit into its %zu bytes", size);
    stp_status status = unpack(bytes + SIZE_BYTES, frame, planes, 2 * cells, scratch, err);
    if (status != STP_OK)
        return status;
    unsigned columns = patch_columns(linked);
    if (scratch->shares)
        count_head(scratch->shares, planes, columns, patch_count, frame);
    stp_table table = table_at(planes + 2 * cells, columns + STP_SAMPLE_COLUMN_COUNT, patch_count);
    planes_to_cells(planes, planes + cells, &table);
    table.column_count = columns;
    stp_patches_decode(patches, &table);
    *used = SIZE_BYTES + frame;
    return STP_OK;
}

static void vertices_decode(stp_chunk *chunk, stp_chunk_scratch *scratch)
{
    uint32_t rows = chunk->patch_count;
    size_t cells = head_cells(rows, chunk->linked);
    int16_t *values = (int16_t *)(void *)(planes_of(scratch) + 2 * cells);
    stp_table vertices = table_at(values + (size_t)patch_columns(chunk->linked) * rows,
                                  STP_SAMPLE_COLUMN_COUNT, rows);
    stp_predict_vertices_decode(chunk, &vertices);
}

/* Bytes of the parts in the mask. */
static size_t masked_bytes(uint32_t mask, uint32_t families)
{
    size_t bytes = 0;
    for (unsigned i = 0; i < PARTS; i++)
        bytes += mask >> i & 1u ? part_bytes(i, families) : 0;
    return bytes;
}

/* Counts what a level holds behind its head. mask: of raw parts; frame: bytes of the frame of the
 * other parts. */
static void count_level(stp_shares *shares, const uint8_t *const parts[PARTS], uint32_t mask,
                        uint32_t families, size_t frame)
{
    stp_share_costs costs = {{0}};
    for (unsigned i = 0; i < PARTS; i++) {
        const stp_share share = stp_share_of_plane(i % STP_FAMILY_PLANES);
        if (mask >> i & 1u)
            shares->bytes[share] += part_bytes(i, families);
        else
            stp_share_costs_add(&costs, share, parts[i], part_bytes(i, families));
    }
    stp_shares_add_packed(shares, &costs, frame);
}

/* False: there is no such step. */
static bool take_step(unsigned byte, unsigned *step)
{
    const unsigned shift = byte & ((1u << ODD_BIT) - 1), odd = byte >> ODD_BIT;
    if (odd > STP_NORMAL_ODD_MOST || shift > stp_normal_shift_most(odd))
        return false;
    *step = stp_normal_step(shift, odd);
    return true;
}

static stp_status level_decode(const uint8_t *bytes, size_t size, int level, stp_chunk *chunk,
                               stp_chunk_scratch *scratch, stp_error *err)
{
    uint32_t families = stp_families_count(chunk, level);
    const uint8_t *parts[PARTS];
    uint8_t *planes = planes_of(scratch);
    const size_t head = level_head_bytes(chunk);
    uint32_t mask = size < head ? 0 : stp_get_u32(bytes);
    size_t raw = masked_bytes(mask, families);
    size_t packed = masked_bytes(~mask, families);
    if (size < head || raw > size - head)
        return stp_error_set(err, STP_CORRUPT, "level %d does not fit into its %zu bytes", level,
                             size);
    unsigned step = 1;
    if (chunk->is_block && !take_step(bytes[MASK_BYTES], &step))
        return stp_error_set(err, STP_CORRUPT, "normals of level %d have steps of kind %u", level,
                             bytes[MASK_BYTES]);
    const uint8_t *frame = bytes + head + raw;
    size_t frame_bytes = size - head - raw;
    if (packed == 0 && frame_bytes != 0)
        return stp_error_set(err, STP_CORRUPT, "%zu bytes of level %d are left over", frame_bytes,
                             level);
    if (packed > 0) {
        stp_status status = unpack(frame, frame_bytes, planes, packed, scratch, err);
        if (status != STP_OK)
            return status;
    }
    /* Raw parts go behind the others: lanes may be read behind the end of each part. */
    memcpy(planes + packed, bytes + head, raw);
    const uint8_t *next_raw = planes + packed;
    const uint8_t *next = planes;
    for (unsigned i = 0; i < PARTS; i++) {
        const uint8_t **from = mask >> i & 1u ? &next_raw : &next;
        parts[i] = *from;
        *from += part_bytes(i, families);
    }
    if (scratch->shares) {
        scratch->shares->bytes[STP_SHARE_FRAME] += head;
        count_level(scratch->shares, parts, mask, families, frame_bytes);
    }
    stp_families_decode(chunk, level, step, parts, lanes_of(scratch));
    return STP_OK;
}

/* ---- encoding levels ---- */

/* Sets *raw if zstd does not make the part small enough. */
static stp_status tell_raw(const uint8_t *part, size_t size, bool *raw, stp_error *err)
{
    stp_bytes packed = {0};
    stp_status status = stp_zstd_pack(part, &size, 1, &packed, err);
    *raw = size >= RAW_BYTES_LEAST && 8 * packed.size > RAW_EIGHTHS * size;
    free(packed.data);
    return status;
}

static stp_status append_parts(uint8_t *const parts[PARTS], uint32_t families, unsigned step,
                               const stp_chunk *chunk, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t mask = 0;
    size_t begin = out->size, packed = 0;
    block_ends ends = ends_begin(chunk);
    uint8_t *rest = NULL;
    STP_TRY(stp_bytes_append(out, NULL, level_head_bytes(chunk), err));
    if (chunk->is_block)
        out->data[begin + MASK_BYTES] = (uint8_t)step;
    STP_TRY(stp_alloc(&rest, STP_FAMILY_PLANES * STP_FAMILY_SLOTS, families, "planes", err));
    for (unsigned i = 0; i < PARTS; i++) {
        size_t size = part_bytes(i, families);
        bool raw = false;
        STP_TRY(tell_raw(parts[i], size, &raw, err));
        if (raw) {
            mask |= 1u << i;
            STP_TRY(stp_bytes_append(out, parts[i], size, err));
            continue;
        }
        memcpy(rest + packed, parts[i], size);
        packed += size;
        ends_add(&ends, packed, false);
    }
    if (packed > 0) {
        if (ends.begin < packed)
            ends_add(&ends, packed, true);
        STP_TRY(stp_zstd_pack(rest, ends.at, ends.count, out, err));
    }
    stp_put_u32(out->data + begin, mask);
done:
    free(rest);
    return status;
}

static stp_status level_encode(const stp_chunk *chunk, int level, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t families = stp_families_count(chunk, level);
    const unsigned shift = stp_level_normal_shift(chunk, level);
    const unsigned odd = stp_level_normal_odd(chunk, level);
    uint8_t *planes = NULL;
    void *lanes = NULL;
    uint8_t *parts[PARTS];
    size_t at = 0;
    STP_TRY(stp_alloc(&planes, stp_families_plane_bytes(chunk, level), 1, "planes", err));
    STP_TRY(stp_alloc(&lanes, stp_families_scratch_bytes(), 1, "planes", err));
    for (unsigned i = 0; i < PARTS; i++) {
        parts[i] = planes + at;
        at += part_bytes(i, families);
    }
    stp_families_encode(chunk, level, stp_normal_step(shift, odd), parts, lanes);
    STP_TRY(append_parts(parts, families, shift | odd << ODD_BIT, chunk, out, err));
done:
    free(planes);
    free(lanes);
    return status;
}

/* ---- parts ---- */

stp_status stp_zstd_part_encode(const stp_chunk *chunk, int segment, stp_bytes *out, stp_error *err)
{
    const stp_status status = segment == 0 ? head_encode(chunk, out, err) : STP_OK;
    return status == STP_OK ? level_encode(chunk, stp_segment_finest(segment), out, err) : status;
}

stp_status stp_zstd_part_decode(const uint8_t *bytes, size_t size, int segment,
                                uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                                stp_error *err)
{
    stp_status status = STP_OK;
    size_t used = 0;
    STP_TRY(stp_chunk_scratch_reserve(scratch, scratch_bytes(chunk, segment), err));
    if (segment == 0) {
        STP_TRY(stp_zstd_patches_decode(bytes, size, chunk->patches, chunk->patch_count,
                                        chunk->linked, scratch, &used, err));
        STP_TRY(stp_patches_take(chunk, child_count, err));
        vertices_decode(chunk, scratch);
    }
    STP_TRY(
        level_decode(bytes + used, size - used, stp_segment_finest(segment), chunk, scratch, err));
done:
    return status;
}

/* ---- for a payload without its entry ---- */

size_t stp_zstd_level_bytes(const uint8_t *bytes, size_t left, uint32_t families)
{
    uint64_t content = 0;
    if (left < MASK_BYTES)
        return 0;
    uint32_t mask = stp_get_u32(bytes);
    size_t raw = MASK_BYTES + masked_bytes(mask, families);
    size_t packed = masked_bytes(~mask, families);
    if (raw > left)
        return 0;
    if (packed == 0)
        return raw;
    size_t frame = stp_zstd_frame_bytes(bytes + raw, left - raw, &content);
    return frame != 0 && content == packed ? raw + frame : 0;
}
