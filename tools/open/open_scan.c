/* Finds prepared scans and prepares others. */
#include "tools/open/open_scan.h"

#include "base/memory.h"
#include "base/temporary.h"
#include "formats/chunk/byte_source.h"
#include "formats/scan/detect.h"
#include "tools/open/open_cache.h"
#include "tools/prep/prep_inputs.h"
#include "tools/prep/prep_report.h"
#include "tools/prep/prep_run.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Whether a file begins as chunk files do. */
static bool is_model(const char *path)
{
    char magic[sizeof "STIPPLE"] = "";
    FILE *file = fopen(path, "rb");
    const bool found = file && fread(magic, sizeof magic, 1, file) == 1 &&
                       memcmp(magic, "STIPPLE", sizeof magic) == 0;
    if (file)
        fclose(file);
    return found;
}

stp_status open_scan_is(bool *out, const char *argument, stp_error *err)
{
    stp_scan_format format;
    struct stat facts;
    stp_error why = {0};
    const bool missing = stat(argument, &facts) != 0;
    *out = stp_is_address(argument) && prep_paths_is_scan(argument);
    if (stp_is_address(argument))
        return STP_OK;
    if (missing || !S_ISREG(facts.st_mode)) {
        *out = missing ? *argument == '@' || strpbrk(argument, "*?[") : S_ISDIR(facts.st_mode);
        return STP_OK;
    }
    if (is_model(argument))
        return STP_OK;
    const stp_status status = stp_scan_detect(&format, argument, &why);
    *out = status == STP_OK;
    if (status == STP_UNSUPPORTED || status == STP_EMPTY)
        return stp_error_set(err, status, "%s", why.message);
    if (status == STP_FORMAT)
        return stp_error_set(err, status, "%s; nor is it a stipple chunk file", why.message);
    return STP_OK;
}

/* Nobody foresees the name. */
stp_status open_scan_take_temporary(open_scan *scan, stp_error *err)
{
    stp_status status = STP_OK;
    const char *given = getenv("TMPDIR"), *folder = given && *given ? given : "/tmp";
    const size_t bytes = strlen(folder) + sizeof "/stipple";
    char *base = NULL;
    free(scan->folder);
    free(scan->path);
    scan->folder = scan->path = NULL;
    STP_TRY(stp_alloc(&base, bytes, 1, "a path", err));
    STP_TRY(stp_alloc(&scan->path, bytes + STP_TEMPORARY_BYTES, 1, "a path", err));
    snprintf(base, bytes, "%s/stipple", folder);
    if (!stp_temporary_name(scan->path, base))
        status = stp_error_set(err, STP_IO, "%s: no random name for a file", folder);
done:
    free(base);
    return status;
}

stp_status open_scan_give_up_keeping(open_scan *scan, const stp_error *why, stp_error *err)
{
    stp_status status = open_scan_take_temporary(scan, err);
    if (status == STP_OK && !scan->params.common->quiet)
        fprintf(stderr, "stipple %s: warning: %s: the model is made for this time alone, in %.*s\n",
                scan->params.command, why->message, (int)(strrchr(scan->path, '/') - scan->path),
                scan->path);
    return status;
}

/* Whether a scan is on a server, where nobody sees whether it changes. */
static bool has_address(const prep_paths *scans)
{
    bool found = false;
    for (size_t i = 0; i < scans->count; i++)
        found |= stp_is_address(scans->list[i]);
    return found;
}

static bool is_file(const char *path)
{
    struct stat facts;
    return stat(path, &facts) == 0 && S_ISREG(facts.st_mode);
}

stp_status open_scan_find(open_scan *out, const char *const *arguments, size_t count,
                          const open_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    open_scan scan = {.params = *params};
    for (size_t i = 0; i < count; i++)
        STP_TRY(prep_paths_add(&scan.scans, arguments[i], err));
    if (params->cache_bytes == 0 || has_address(&scan.scans)) {
        STP_TRY(open_scan_take_temporary(&scan, err));
    } else if (open_cache_folder(&scan.folder, params->cache_folder, &why) != STP_OK) {
        STP_TRY(open_scan_give_up_keeping(&scan, &why, err));
    } else {
        STP_TRY(open_cache_path(&scan.path, scan.folder, &scan.scans, params->attributes, err));
        scan.found = is_file(scan.path);
        if (!scan.found && open_cache_make(scan.folder, &why) != STP_OK)
            STP_TRY(open_scan_give_up_keeping(&scan, &why, err));
    }
    *out = scan;
    scan = (open_scan){0};
done:
    open_scan_clear(&scan);
    return status;
}

/* Runs prep's stages. *full: what failed was writing to the model's folder, perhaps. */
static stp_status run(open_scan *scan, bool *full, stp_error *err)
{
    stp_status status = STP_OK;
    const cli_common *common = scan->params.common;
    stp_pool *pool = NULL;
    stp_prep_source source = {0};
    stp_prep_stats stats = {0};
    stp_prep_params params = prep_run_defaults(common->quiet);
    prep_inputs in = {.paths = scan->scans.list,
                      .count = scan->scans.count,
                      .numbers = {.wanted = scan->params.attributes}};
    in.params.numbers = prep_numbers_wanted(&in.numbers);
    cli_progress_stage stages[STP_PREP_STAGE_COUNT];
    const stp_progress *progress = cli_progress(common);
    params.force =
        scan->folder != NULL; /* another process may have made the same model meanwhile */
    prep_run_expect(&params, false, stages);
    STP_TRY(prep_inputs_survey(&in, &source, err));
    STP_TRY(stp_pool_create(&pool, (unsigned)common->threads, err));
    in.params.pool = pool;
    if (stp_prep_size_of(&source, &params).grid)
        in.params.recompute_normals = true; /* a grid computes its own */
    status = stp_prep_run(scan->path, &source, &params, pool, progress, &stats, err);
    scan->partial = prep_inputs_unreadable(&in) > 0;
    *full = status == STP_IO && scan->folder;
done:
    prep_run_end();
    prep_report_unreadable(&in);
    if (status == STP_OK)
        prep_report_doubts(&stats, &in);
    stp_pool_destroy(&pool);
    prep_inputs_clear(&in);
    return status;
}

stp_status open_scan_prepare(open_scan *scan, stp_error *err)
{
    bool full = false;
    stp_error why = {0};
    stp_status status = run(scan, &full, &why);
    if (full) {
        status = open_scan_give_up_keeping(scan, &why, &why);
        status = status == STP_OK ? run(scan, &full, &why) : status;
    }
    return status == STP_OK ? status : stp_error_set(err, status, "%s", why.message);
}

void open_scan_opened(const open_scan *scan)
{
    if (!scan->folder || scan->partial) {
        (void)unlink(scan->path);
        return;
    }
    open_cache_use(scan->path);
    open_cache_trim(scan->folder, scan->params.cache_bytes);
}

void open_scan_clear(open_scan *scan)
{
    prep_paths_clear(&scan->scans);
    free(scan->folder);
    free(scan->path);
    *scan = (open_scan){0};
}
