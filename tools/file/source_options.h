/* How commands read a model that may be on a web server. Ctrl-C ends a read that waits, and
 * messages of the cache are printed. Threads: the main thread only. */
#ifndef STP_TOOLS_FILE_SOURCE_OPTIONS_H
#define STP_TOOLS_FILE_SOURCE_OPTIONS_H

#include "formats/chunk/chunk_file.h"
#include "tools/cli/cli.h"

struct cJSON;

/* The default of --timeout, in seconds. */
#define SOURCE_TIMEOUT_S 60.0
/* The option --timeout. */
cli_option source_options_timeout(double *seconds);
/* cache: the folder of --cache. If it is NULL or cache_bytes is 0, there is no cache. timeout_s:
 * the total time to wait for a server that sends almost nothing; infinite: for ever. */
stp_byte_source_params source_options_params(const char *cache, uint64_t cache_bytes,
                                             double timeout_s);
/* Opens a chunk file. Errors: those of stp_chunk_file_open_at; of a scan it says how to prepare it.
 */
stp_status source_options_open(stp_chunk_file **out, const char *path,
                               const stp_byte_source_params *params, stp_error *err);
/* If a file could not be opened because it is no chunk file, but a scan: says so and how to prepare
 * it. Returns status. */
stp_status source_options_explain(stp_status status, const char *path, stp_error *err);
/* Warns on stderr if nothing is kept in the cache's folder. */
void source_options_warn(const cli_command *command, const cli_common *common,
                         stp_chunk_file *file);
/* Adds the object "source" to --stats: requests retries bytes cached_bytes cache_damaged damaged.
 */
void source_options_stats(struct cJSON *json, stp_chunk_file *file);

#endif
