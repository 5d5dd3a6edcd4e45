/* Options for models on web servers. */
#include "tools/file/source_options.h"

#include "formats/scan/detect.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>

static bool is_interrupted(void *context)
{
    (void)context;
    return cli_interrupted();
}

cli_option source_options_timeout(double *seconds)
{
    return (cli_option){
        "--timeout", 0,
        CLI_SECONDS, seconds,
        "S",         "seconds to wait in total for an almost silent server (60; view: no limit)",
        NULL};
}

stp_byte_source_params source_options_params(const char *cache, uint64_t cache_bytes,
                                             double timeout_s)
{
    const double patience_ms = fmin(fmax(timeout_s, 0.001) * 1e3, 1e9);
    return (stp_byte_source_params){.cache_folder = cache_bytes > 0 ? cache : NULL,
                                    .cache_bytes = cache_bytes,
                                    .patience_ms = (unsigned)patience_ms,
                                    .cancelled = is_interrupted};
}

stp_status source_options_explain(stp_status status, const char *path, stp_error *err)
{
    stp_scan_format format;
    if (status != STP_FORMAT || stp_scan_detect(&format, path, NULL) != STP_OK)
        return status;
    return stp_error_set(err, status,
                         "%s is a scan (%s), not a chunk file: make one with `stipple prep %s -o "
                         "M.stipple` and open that",
                         path, stp_scan_format_name(format), path);
}

stp_status source_options_open(stp_chunk_file **out, const char *path,
                               const stp_byte_source_params *params, stp_error *err)
{
    return source_options_explain(stp_chunk_file_open_at(out, path, params, err), path, err);
}

void source_options_warn(const cli_command *command, const cli_common *common, stp_chunk_file *file)
{
    stp_error note;
    if (!common->quiet && stp_byte_source_note(stp_chunk_file_source(file), &note))
        fprintf(stderr, "stipple %s: warning: %s\n", command->name, note.message);
}

void source_options_stats(struct cJSON *json, stp_chunk_file *file)
{
    stp_byte_source_stats stats;
    cJSON *source = cJSON_AddObjectToObject(json, "source");
    stp_byte_source_get_stats(stp_chunk_file_source(file), &stats);
    cJSON_AddNumberToObject(source, "requests", (double)stats.requests);
    cJSON_AddNumberToObject(source, "retries", (double)stats.retries);
    cJSON_AddNumberToObject(source, "bytes", (double)stats.bytes);
    cJSON_AddNumberToObject(source, "cached_bytes", (double)stats.cached_bytes);
    cJSON_AddNumberToObject(source, "cache_damaged", (double)stats.cache_damaged);
    cJSON_AddNumberToObject(source, "damaged", (double)stats.damaged);
}
