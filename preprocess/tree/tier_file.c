/* Writes payloads into the file of another process. */
#include "preprocess/tree/tier_file.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/chunk/chunk_file.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

stp_status stp_tier_file_open(stp_tier_file *out, const stp_chunk_writer *writer, stp_ranks *ranks,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const char *path = writer ? stp_chunk_writer_next(writer, &out->end) : "";
    uint64_t bytes = strlen(path) + 1;
    out->ranks = ranks;
    out->descriptor = -1;
    STP_TRY(stp_ranks_broadcast(ranks, 0, &out->end, sizeof out->end, err));
    STP_TRY(stp_ranks_broadcast(ranks, 0, &bytes, sizeof bytes, err));
    STP_TRY(stp_alloc(&out->path, bytes, 1, "a path", err));
    memcpy(out->path, path, strlen(path));
    STP_TRY(stp_ranks_broadcast(ranks, 0, out->path, bytes, err));
    if (!writer)
        STP_TRY(stp_file_join(out->path, &out->descriptor, err));
done:
    return status;
}

stp_status stp_tier_file_write(stp_tier_file *file, stp_tier_chunk *tier, uint32_t count,
                               stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = file->ranks;
    uint32_t *sizes = NULL;
    const stp_rank_part own = stp_ranks_own(ranks, count);
    STP_TRY(stp_alloc(&sizes, count, sizeof *sizes, "chunks", err));
    for (uint64_t i = own.begin; i < own.end; i++)
        sizes[i] = tier[i].entry.segment_end[STP_SEGMENT_COUNT - 1];
    STP_TRY(stp_ranks_share(ranks, sizes, count, sizeof *sizes, err));
    for (uint32_t i = 0; i < count; file->end += sizes[i++]) {
        if (ranks->self == 0 || i < own.begin || i >= own.end)
            continue;
        STP_TRY(stp_file_write_at(file->descriptor, file->path, file->end, tier[i].payload,
                                  sizes[i], err));
        stp_spill_free(spill, tier[i].payload);
        tier[i].payload = NULL;
        stp_spill_relieve(spill);
    }
done:
    free(sizes);
    return status;
}

stp_status stp_tier_file_sync(stp_tier_file *file, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t waits = 0;
    const int descriptor = file->descriptor;
    file->descriptor = -1;
    if (descriptor >= 0)
        STP_TRY(stp_file_close(descriptor, file->path, err));
    STP_TRY(stp_ranks_sum(file->ranks, &waits, 1, err));
done:
    return status;
}

void stp_tier_file_close(stp_tier_file *file)
{
    if (file->path && file->descriptor >= 0)
        close(file->descriptor);
    free(file->path);
    *file = (stp_tier_file){0};
}
