/* A report's folder, which appears whole or not at all: written under another name beside it, then
 * renamed. An existing one is replaced with force, and only if all in it is a report's.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_TUNE_TUNE_FOLDER_H
#define STP_TOOLS_TUNE_TUNE_FOLDER_H

#include "base/error.h"

#include <stdbool.h>

typedef struct tune_folder tune_folder;

/* Before the work: whether the folder could be made. Errors: EXISTS, IO. */
stp_status tune_folder_check(const char *path, bool force, stp_error *err);
/* Errors: EXISTS, IO, OUT_OF_MEMORY. */
stp_status tune_folder_create(tune_folder **out, const char *path, bool force, stp_error *err);
/* The name under which one of its files is to be written; valid until the next call. It is one of
 * those that a report has: tune.csv, tune.json, index.html, *.svg. */
const char *tune_folder_file(tune_folder *folder, const char *name);
/* Makes it appear and destroys it. Errors: IO, EXISTS. */
stp_status tune_folder_commit(tune_folder **folder, stp_error *err);
/* Removes what was not committed. */
void tune_folder_destroy(tune_folder **folder);

#endif
