/* Opens scans wherever a model is drawn: finds them prepared in a cache (open_cache.h), or prepares
 * them as prep does without options.
 *
 * Use: open_scan_find; if the model is not there, open_scan_prepare; open the chunk file at `path`;
 * then open_scan_opened, which keeps the cache within its bound or removes a model that is not
 * kept. The open file stays readable. Threads: the main thread only. */
#ifndef STP_TOOLS_OPEN_OPEN_SCAN_H
#define STP_TOOLS_OPEN_OPEN_SCAN_H

#include "tools/cli/cli.h"
#include "tools/prep/prep_paths.h"

/* How many bytes of prepared scans are kept. */
#define OPEN_CACHE_BYTES (UINT64_C(16) << 30)

/* What the help of a command that draws says of scans. */
#define OPEN_SCAN_HELP                                                                             \
    "Instead of a model, give scans, whatever prep reads: they are prepared first, as prep does\n" \
    "without options, and several become one model. That model is kept in ~/.cache/stipple\n"      \
    "($XDG_CACHE_HOME), where it is found the next time, until the scans change. Of a scan that\n" \
    "is an address (https://...laz) nothing is kept."

typedef struct open_scan_params {
    const char *command;      /* for messages, "render" */
    const cli_common *common; /* threads; quiet: no progress, no warnings */
    const char *attributes;   /* that are kept (prep --attributes), borrowed; NULL: none */
    const char *cache_folder; /* NULL: the user's (open_cache_folder) */
    uint64_t cache_bytes;     /* 0: nothing is kept */
} open_scan_params;

/* Zero is empty. */
typedef struct open_scan {
    open_scan_params params;
    prep_paths scans;
    char *folder; /* of the cache; NULL: none */
    char *path;   /* of the model, whether it is there or not */
    bool found;   /* it is there */
    bool partial; /* it lacks scans that could not be read, so it is not kept */
} open_scan;

/* Whether an argument names scans and not a model: a folder, a pattern, a list (@list.txt), a file
 * of a format that prep reads, or an address whose name ends like a scan's. Errors: UNSUPPORTED (a
 * known format that prep does not read).
 */
stp_status open_scan_is(bool *out, const char *argument, stp_error *err);
/* Finds the place of the model. Models of addresses are not kept. If the cache cannot be used,
 * warns and takes a temporary place. Errors: those of prep_paths_add; OUT_OF_MEMORY. */
stp_status open_scan_find(open_scan *out, const char *const *arguments, size_t count,
                          const open_scan_params *params, stp_error *err);
/* Writes the model to its place, with progress on stderr. If the cache's disk is full, warns and
 * takes a temporary place. If some of several scans cannot be read, names them on stderr and does
 * not keep the model of the others. Errors: those of prep. */
stp_status open_scan_prepare(open_scan *scan, stp_error *err);
/* Takes a place in $TMPDIR, for a model that is not kept. Errors: IO, OUT_OF_MEMORY. */
stp_status open_scan_take_temporary(open_scan *scan, stp_error *err);
/* The same, after a warning why nothing can be kept in the cache. */
stp_status open_scan_give_up_keeping(open_scan *scan, const stp_error *why, stp_error *err);
/* Call it when the model is open. */
void open_scan_opened(const open_scan *scan);
void open_scan_clear(open_scan *scan);

#endif
