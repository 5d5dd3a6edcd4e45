/* Makes a coarse model of scans in a second, to be shown while prep makes the whole one.
 *
 * Some points of each scan, spread over all of it, go through prep. Where a format allows, the
 * reader seeks to them (stp_scan_seek): to single records, or to the beginnings of packed chunks.
 * It reads the first depths of an octree (EPT, COPC), and every n-th column and row of a grid,
 * whose draft is a grid, too. It reads other formats once and takes every n-th point. So the model
 * has the whole extent, never a part of it. Threads: the caller's, and those of the pool of prep.
 */
#ifndef STP_TOOLS_OPEN_OPEN_DRAFT_H
#define STP_TOOLS_OPEN_OPEN_DRAFT_H

#include "tools/cli/cli.h"
#include "tools/prep/prep_paths.h"

/* Scans with no more points than this, or with lines or triangles, have no draft. */
#define OPEN_DRAFT_WORTH 100000u

/* Writes a draft to path, which must be free. where: it has only points that fulfil this condition;
 * NULL: any. *made is false if a draft is not worth its time (OPEN_DRAFT_WORTH), or if no point
 * that was taken fulfils the condition; then nothing is written. Errors: those of prep. */
stp_status open_draft_make(bool *made, const prep_paths *scans, const char *path, const char *where,
                           const cli_common *common, stp_error *err);

#endif
