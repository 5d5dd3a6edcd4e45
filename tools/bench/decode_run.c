/* Decodes chunk by chunk, first with one file's codec, then with the other's. */
#include "tools/bench/decode_run.h"

#include "base/clock.h"
#include "base/memory.h"
#include "formats/chunk/chunk_file.h"
#include "tools/bench/median.h"

#include <stdlib.h>

#define CHUNKS_LIMIT 64u

typedef struct contestant {
    stp_chunk_file *file;
    uint8_t *payload[CHUNKS_LIMIT];
    stp_chunk_scratch scratch;
} contestant;

static stp_status take_payloads(contestant *c, uint32_t step, uint32_t count, uint64_t *points,
                                stp_error *err)
{
    stp_status status = STP_OK;
    *points = 0;
    for (uint32_t i = 0; i < count; i++) {
        stp_chunk_entry entry;
        STP_TRY(stp_chunk_file_entry(c->file, i * step, &entry, err));
        uint32_t size = stp_chunk_payload_bytes(&entry, 0);
        STP_TRY(stp_alloc(&c->payload[i], (size_t)size + 1, 1, "payload", err));
        STP_TRY(stp_chunk_file_fetch(c->file, i * step, 0, size, c->payload[i], err));
        *points += entry.sample_count[0];
    }
done:
    return status;
}

static stp_status decode_one(contestant *c, uint32_t id, uint32_t i, double *seconds,
                             stp_error *err)
{
    stp_chunk *chunk = NULL;
    double begun = stp_clock_seconds();
    stp_status status =
        stp_chunk_file_decode(c->file, id, 0, c->payload[i], &c->scratch, &chunk, err);
    stp_chunk_recycle(&chunk, &c->scratch);
    *seconds += stp_clock_seconds() - begun;
    return status;
}

static stp_status run_rounds(contestant c[2], uint32_t step, uint32_t count, unsigned rounds,
                             uint64_t points, decode_run_result *out, stp_error *err)
{
    stp_status status = STP_OK;
    double *seconds[2] = {NULL, NULL}, *ratio = NULL;
    STP_TRY(stp_alloc(&seconds[0], rounds, sizeof **seconds, "rounds", err));
    STP_TRY(stp_alloc(&seconds[1], rounds, sizeof **seconds, "rounds", err));
    STP_TRY(stp_alloc(&ratio, rounds, sizeof *ratio, "rounds", err));
    for (unsigned r = 0; r < rounds; r++) {
        for (uint32_t i = 0; i < count; i++)
            for (int k = 0; k < 2; k++)
                STP_TRY(decode_one(&c[k], i * step, i, &seconds[k][r], err));
        ratio[r] = seconds[0][r] / seconds[1][r];
    }
    for (int k = 0; k < 2; k++)
        out->points_per_s[k] = (double)points / bench_median(seconds[k], rounds);
    out->ratio[1] = bench_median(ratio, rounds); /* bench_median also sorts */
    out->ratio[0] = ratio[0];
    out->ratio[2] = ratio[rounds - 1];
done:
    free(seconds[0]);
    free(seconds[1]);
    free(ratio);
    return status;
}

stp_status decode_run(const char *const paths[2], unsigned rounds, decode_run_result *out,
                      stp_error *err)
{
    stp_status status = STP_OK;
    contestant c[2] = {{.file = NULL}, {.file = NULL}};
    uint64_t points[2] = {0};
    decode_run_result result = {.chunks = 0};
    for (int k = 0; k < 2; k++) {
        STP_TRY(stp_chunk_file_open(&c[k].file, paths[k], err));
        const stp_chunk_file_info *info = stp_chunk_file_get_info(c[k].file);
        uint32_t step = (info->chunk_count - 1) / CHUNKS_LIMIT + 1;
        result.chunks = (info->chunk_count - 1) / step + 1;
        result.file_bytes[k] = info->file_bytes;
        STP_TRY(take_payloads(&c[k], step, result.chunks, &points[k], err));
    }
    uint32_t count = stp_chunk_file_get_info(c[0].file)->chunk_count;
    if (points[0] != points[1] || count != stp_chunk_file_get_info(c[1].file)->chunk_count) {
        status = stp_error_set(err, STP_INVALID_ARGUMENT, "%s and %s are not one model", paths[0],
                               paths[1]);
        goto done;
    }
    STP_TRY(run_rounds(c, (count - 1) / CHUNKS_LIMIT + 1, result.chunks, rounds, points[0], &result,
                       err));
    *out = result;
done:
    for (int k = 0; k < 2; k++) {
        for (uint32_t i = 0; i < CHUNKS_LIMIT; i++)
            free(c[k].payload[i]);
        stp_chunk_scratch_free(&c[k].scratch);
        stp_chunk_file_close(&c[k].file);
    }
    return status;
}
