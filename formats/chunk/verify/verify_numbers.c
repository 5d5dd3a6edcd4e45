/* Checks the attributes of a file. */
#include "formats/chunk/verify/verify_numbers.h"

#include "base/memory.h"
#include "formats/chunk/chunk_reader.h"

#include <inttypes.h>
#include <stdlib.h>

stp_status stp_verify_numbers_begin(stp_verify_numbers *out, stp_chunk_file *file,
                                    unsigned worker_count, stp_error *err)
{
    stp_status status = STP_OK;
    out->file = file;
    STP_TRY(
        stp_alloc(&out->readers, worker_count, sizeof(stp_attribute_file *), "attributes", err));
    out->worker_count = worker_count;
    for (unsigned i = 0; i < worker_count; i++)
        STP_TRY(stp_attribute_file_open(&out->readers[i], file, err));
done:
    return status;
}

stp_status stp_verify_numbers_chunk(stp_verify_numbers *v, const stp_chunk *chunk, unsigned worker,
                                    stp_error *err)
{
    stp_status status = STP_OK;
    stp_attribute_file *reader = v->readers[worker];
    const stp_attribute_list *list = stp_attribute_file_list(reader);
    const uint32_t count = chunk->level_begin[0][chunk->patch_count];
    uint64_t *words = NULL;
    if (list->count == 0)
        return STP_OK;
    STP_TRY(stp_alloc(&words, count, sizeof *words, "attributes", err));
    for (uint32_t a = 0; a < list->count; a++) {
        stp_attribute_row row;
        STP_TRY(stp_attribute_file_row(reader, a, chunk->id, &row, err));
        STP_TRY(stp_attribute_file_read(reader, a, chunk, 0, words, err));
        for (int k = 0; k < STP_LEVEL_COUNT; k++)
            atomic_fetch_add(&v->bytes, row.bytes[k]);
    }
done:
    free(words);
    return status;
}

stp_status stp_verify_numbers_end(const stp_verify_numbers *v, stp_error *err)
{
    const stp_section *data = stp_header_section(&v->file->header, STP_SECTION_NUMBERS);
    const uint64_t found = v->bytes;
    if (stp_attribute_file_list(v->readers[0])->count == 0 || found == data->bytes)
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: its attributes' parts have %" PRIu64 " bytes, their section %" PRIu64
                         ": prepare the model again",
                         v->file->path, found, data->bytes);
}

void stp_verify_numbers_clear(stp_verify_numbers *v)
{
    for (unsigned i = 0; v->readers && i < v->worker_count; i++)
        stp_attribute_file_close(&v->readers[i]);
    free(v->readers);
    v->readers = NULL;
}
