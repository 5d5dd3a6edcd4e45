/* Packs and unpacks zstd frames in memory. */
#include "formats/chunk/codec/zstd/zstd_frame.h"

#include "formats/chunk/layout.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* For contexts in the caller's memory, and to have literals coded although matches are not
 * searched. */
#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>
#include <zstd_errors.h>

/* How far the search for matches steps after it finds nothing; the step with the smaller result is
 * taken. The bytes are noise with a distribution: short matches are chance, cost more bits than
 * they save, and are slow to decode. */
static const int search_steps[] = {100, 1000};
#define SHORTEST_MATCH 7

static stp_status zstd_failed(size_t code, stp_error *err)
{
    return ZSTD_getErrorCode(code) == ZSTD_error_memory_allocation
               ? stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to code a payload")
               : stp_error_set(err, STP_INTERNAL, "zstd failed: %s", ZSTD_getErrorName(code));
}

/* Compresses into a buffer that has room for any result. */
static size_t compress(ZSTD_CCtx *context, int step, const uint8_t *bytes, const size_t *ends,
                       size_t end_count, ZSTD_outBuffer to)
{
    const struct {
        ZSTD_cParameter name;
        int value;
    } parameters[] = {{ZSTD_c_compressionLevel, 1},
                      {ZSTD_c_strategy, ZSTD_fast},
                      {ZSTD_c_minMatch, SHORTEST_MATCH},
                      {ZSTD_c_targetLength, step},
                      {ZSTD_c_literalCompressionMode, ZSTD_ps_enable}};
    size_t begin = 0;
    size_t left = ZSTD_CCtx_reset(context, ZSTD_reset_session_and_parameters);
    for (size_t i = 0; i < sizeof parameters / sizeof *parameters && !ZSTD_isError(left); i++)
        left = ZSTD_CCtx_setParameter(context, parameters[i].name, parameters[i].value);
    if (!ZSTD_isError(left))
        left = ZSTD_CCtx_setPledgedSrcSize(context, ends[end_count - 1]);
    for (size_t i = 0; i < end_count && !ZSTD_isError(left); i++) {
        ZSTD_inBuffer from = {bytes + begin, ends[i] - begin, 0};
        left = ZSTD_compressStream2(context, &to, &from,
                                    i + 1 < end_count ? ZSTD_e_flush : ZSTD_e_end);
        begin = ends[i];
    }
    return ZSTD_isError(left) ? left : to.pos;
}

stp_status stp_zstd_pack(const uint8_t *bytes, const size_t *ends, size_t end_count, stp_bytes *out,
                         stp_error *err)
{
    stp_status status = STP_OK;
    /* Room for the frame, and for a head of each flushed block. */
    size_t capacity = ZSTD_compressBound(ends[end_count - 1]) + 16 * end_count;
    uint8_t *buffer[2] = {malloc(capacity), malloc(capacity)};
    ZSTD_CCtx *context = ZSTD_createCCtx();
    size_t best = 0, best_bytes = SIZE_MAX;
    if (!buffer[0] || !buffer[1] || !context) {
        status = stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to code a payload");
        goto done;
    }
    for (size_t i = 0; i < 2; i++) {
        size_t size = compress(context, search_steps[i], bytes, ends, end_count,
                               (ZSTD_outBuffer){buffer[i], capacity, 0});
        if (ZSTD_isError(size)) {
            status = zstd_failed(size, err);
            goto done;
        }
        best = size < best_bytes ? i : best;
        best_bytes = size < best_bytes ? size : best_bytes;
    }
    STP_TRY(stp_bytes_append(out, buffer[best], best_bytes, err));
done:
    ZSTD_freeCCtx(context);
    free(buffer[0]);
    free(buffer[1]);
    return status;
}

size_t stp_zstd_workspace_bytes(void)
{
    return ZSTD_estimateDCtxSize();
}

void *stp_zstd_context(void *workspace)
{
    return ZSTD_initStaticDCtx(workspace, stp_zstd_workspace_bytes());
}

/* Whether bytes begin a frame. Frames of other kinds, zstd's own old ones included, do not count.
 */
static bool is_frame(const uint8_t *bytes, size_t size)
{
    return size >= 4 && stp_get_u32(bytes) == ZSTD_MAGICNUMBER;
}

stp_status stp_zstd_unpack(const uint8_t *frame, size_t size, uint8_t *out, size_t out_bytes,
                           void *context, stp_error *err)
{
    if (!is_frame(frame, size) || ZSTD_getFrameContentSize(frame, size) != out_bytes ||
        ZSTD_findFrameCompressedSize(frame, size) != size)
        return stp_error_set(err, STP_CORRUPT,
                             "%zu bytes are not one zstd frame that says it holds %zu", size,
                             out_bytes);
    size_t got = ZSTD_decompressDCtx(context, out, out_bytes, frame, size);
    if (ZSTD_isError(got) || got != out_bytes)
        return stp_error_set(err, STP_CORRUPT, "a zstd frame is damaged: %s",
                             ZSTD_isError(got) ? ZSTD_getErrorName(got) : "it is too short");
    return STP_OK;
}

size_t stp_zstd_frame_bytes(const uint8_t *bytes, size_t left, uint64_t *content_bytes)
{
    if (!is_frame(bytes, left))
        return 0;
    size_t size = ZSTD_findFrameCompressedSize(bytes, left);
    *content_bytes = ZSTD_getFrameContentSize(bytes, left);
    return ZSTD_isError(size) || *content_bytes >= ZSTD_CONTENTSIZE_ERROR ||
                   *content_bytes == ZSTD_CONTENTSIZE_UNKNOWN
               ? 0
               : size;
}
