/* Adds inputs to a model. */
#include "tools/prep/prep_append.h"

#include "base/memory.h"
#include "tools/prep/prep_report.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>

/* The first system that the model's sources tell, or NULL. */
static const char *system_of(const cJSON *metadata)
{
    const cJSON *source = NULL;
    cJSON_ArrayForEach(source, cJSON_GetObjectItemCaseSensitive(metadata, "sources"))
    {
        const char *wkt = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(source, "wkt"));
        if (wkt)
            return wkt;
    }
    return NULL;
}

stp_status prep_append_begin(prep_system *system, const char *model, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_file *file = NULL;
    cJSON *metadata = NULL;
    if (stp_is_address(model))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s is on a server: points can be added to files only", model);
    STP_TRY(stp_chunk_file_open(&file, model, err));
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    if (system_of(metadata))
        STP_TRY(stp_text_copy(&system->target, system_of(metadata), "a coordinate system", err));
done:
    cJSON_Delete(metadata);
    stp_chunk_file_close(&file);
    return status;
}

void prep_append_print(const stp_append_result *r, const stp_prep_stats *stats,
                       const prep_inputs *inputs)
{
    prep_report_points(stats, inputs);
    fprintf(stderr,
            "the model had %" PRIu64 " points and has %" PRIu64 ", in %" PRIu64 " bytes; %" PRIu32
            " of %" PRIu32 " leaves were touched\n",
            r->points_before, r->points_after, stats->tree.file_bytes, r->touched_leaves,
            r->leaf_count);
    fprintf(stderr, "%" PRIu32 " chunks stay, %" PRIu32 " are new", r->kept_chunks, r->new_chunks);
    if (r->raised_chunks > 0)
        fprintf(stderr, ", of which %" PRIu32 " only changed their errors", r->raised_chunks);
    fprintf(stderr, "\n");
    if (r->unused_bytes > 0)
        fprintf(stderr,
                "%" PRIu64 " bytes of the file are unused: stipple convert leaves them out\n",
                r->unused_bytes);
    if (r->closed_lost)
        fprintf(stderr,
                "the model was proven closed, and is drawn with its backs now: only prep of "
                "all inputs at once proves it again\n");
    prep_report_stages(stats);
}
