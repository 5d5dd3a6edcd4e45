/* Repairs a damaged chunk file. */
#include "formats/chunk/repair/repair.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/chunk/repair/damaged.h"
#include "formats/chunk/repair/repair_build.h"
#include "formats/chunk/repair/repair_write.h"
#include "formats/chunk/verify/verify.h"

#include <stdlib.h>

#define COPY_BYTES ((size_t)1 << 20)

static stp_status verify_path(const char *path, const stp_repair_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_file *file = NULL;
    STP_TRY(stp_chunk_file_open(&file, path, err));
    STP_TRY(stp_chunk_file_verify(file, params->pool, params->progress, err));
done:
    stp_chunk_file_close(&file);
    return status;
}

/* Verifies the output before it appears. A fault that is left was written so, and is no damage. */
static stp_status check_output(void *context, const char *path, stp_error *err)
{
    const stp_damaged *d = context;
    stp_error inner = {0};
    stp_status status = verify_path(path, d->params, &inner);
    if (status == STP_CANCELLED || status == STP_OUT_OF_MEMORY || status == STP_IO)
        return stp_error_set(err, status, "%s", inner.message);
    if (status != STP_OK)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: cannot be repaired: its checksums are right now, but it was "
                             "written wrong: %s",
                             d->path, inner.message);
    return STP_OK;
}

/* Writes the damaged file with its mends, byte by byte. */
static stp_status write_mended(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    uint8_t *bytes = NULL;
    const uint64_t size = d->header.file_bytes;
    STP_TRY(stp_alloc(&bytes, COPY_BYTES, 1, "copying", err));
    STP_TRY(stp_output_create(&output, d->params->output, d->params->force, err));
    for (uint64_t at = 0; at < size; at += COPY_BYTES) {
        size_t part = size - at < COPY_BYTES ? (size_t)(size - at) : COPY_BYTES;
        STP_TRY(stp_damaged_read(d, at, bytes, part, err));
        STP_TRY(stp_output_write(output, bytes, part, err));
        STP_TRY(stp_progress_update(d->params->progress, "write", at + part, size, err));
    }
    STP_TRY(stp_output_write_at(output, size, bytes, 0, err)); /* all, and no byte more */
    STP_TRY(check_output(d, stp_output_temporary_path(output), err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    free(bytes);
    return status;
}

static bool is_mended(const stp_damaged *d)
{
    for (uint32_t id = 0; id < d->header.chunk_count; id++)
        if (!d->known[id] || d->finest[id] != 0)
            return false;
    return !d->metadata_lost && !d->sections_lost && !d->header_told && d->entries_told == 0;
}

static stp_status write_rest(stp_damaged *d, stp_repair_result *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_repair_plan plan = {0};
    stp_error inner = {0};
    if (stp_output_check_input(d->params->output, d->path, &inner) != STP_OK)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: some of it is lost: give another output with -o, so that the "
                             "damaged file stays",
                             d->path);
    STP_TRY(stp_repair_plan_make(&plan, d, err));
    STP_TRY(stp_repair_build(&plan, err));
    STP_TRY(stp_repair_write(&plan, check_output, d, out, err));
done:
    stp_repair_plan_clear(&plan);
    return status;
}

/* Whether a failure has other causes than damage. */
static bool is_final(stp_status status)
{
    return status == STP_NOT_FOUND || status == STP_IO || status == STP_OUT_OF_MEMORY ||
           status == STP_CANCELLED;
}

stp_status stp_chunk_file_repair(const char *path, const stp_repair_params *params,
                                 stp_repair_result *out, stp_error *err)
{
    stp_damaged d = {.descriptor = -1};
    stp_repair_result result = {.whole = true};
    stp_error found = {0};
    stp_status status = verify_path(path, params, &found);
    if (is_final(status))
        return stp_error_set(err, status, "%s", found.message);
    result.sound = status == STP_OK;
    if (result.sound)
        goto done;
    STP_TRY(stp_damaged_open(&d, path, params, err));
    if (is_mended(&d) && d.mend_count == 0 && d.file_bytes == d.header.file_bytes) {
        status = stp_error_set(err, found.status,
                               "cannot be repaired: no checksum is wrong, so it was written so: %s",
                               found.message);
        goto done;
    }
    STP_TRY(is_mended(&d) ? write_mended(&d, err) : write_rest(&d, &result, err));
done:
    stp_damaged_close(&d);
    if (status == STP_OK)
        *out = result;
    return status;
}
