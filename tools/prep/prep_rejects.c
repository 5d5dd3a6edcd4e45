/* Lists rejected records in a CSV file. */
#include "tools/prep/prep_inputs.h"

#include <inttypes.h>
#include <stdio.h>

/* Writes a field of CSV: in quotes, quotes inside doubled. */
static stp_status write_quoted(stp_output *output, const char *text, stp_error *err)
{
    stp_status status = stp_output_write(output, "\"", 1, err);
    for (; *text && status == STP_OK; text++)
        status = stp_output_write(output, *text == '"' ? "\"\"" : text, *text == '"' ? 2 : 1, err);
    return status == STP_OK ? stp_output_write(output, "\"", 1, err) : status;
}

/* Goes to the file of a record. Places rise, except that outliers start again. */
static void seek_reject(prep_inputs *in, uint64_t place)
{
    if (place < in->reject_before)
        in->reject_file = in->reject_before = 0;
    while (place - in->reject_before >= in->files[in->reject_file].point_count)
        in->reject_before += in->files[in->reject_file++].point_count;
}

stp_status prep_inputs_reject(void *context, uint64_t place, stp_reject reason, stp_error *err)
{
    prep_inputs *in = context;
    stp_status status = STP_OK;
    char line[64];
    if (!in->rejects)
        return STP_OK;
    seek_reject(in, place);
    int length = snprintf(line, sizeof line, ",%" PRIu64 ",%s\n", place - in->reject_before,
                          stp_reject_name(reason));
    STP_TRY(write_quoted(in->rejects, in->paths[in->reject_file], err));
    STP_TRY(stp_output_write(in->rejects, line, (size_t)length, err));
done:
    return status;
}

stp_status prep_inputs_begin_rejects(prep_inputs *in, const char *path, bool force, stp_error *err)
{
    static const char head[] = "file,index,reason\n";
    stp_status status = stp_output_create(&in->rejects, path, force, err);
    return status == STP_OK ? stp_output_write(in->rejects, head, sizeof head - 1, err) : status;
}

stp_status prep_inputs_end_rejects(prep_inputs *in, stp_error *err)
{
    stp_status status = STP_OK;
    static const char reason[] = ",,unreadable\n";
    for (size_t i = 0; in->rejects && i < in->count; i++) {
        if (!in->facts[i].why)
            continue;
        STP_TRY(write_quoted(in->rejects, in->paths[i], err));
        STP_TRY(stp_output_write(in->rejects, reason, sizeof reason - 1, err));
    }
    return in->rejects ? stp_output_commit(&in->rejects, err) : STP_OK;
done:
    return status;
}
