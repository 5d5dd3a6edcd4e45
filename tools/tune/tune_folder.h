/* The folder of a report, which appears whole or not at all. It is written under another name
 * beside the final one, then renamed. With force an existing folder is replaced, but only if all
 * its files are a report's. Threads: the main thread only. */
#ifndef STP_TOOLS_TUNE_TUNE_FOLDER_H
#define STP_TOOLS_TUNE_TUNE_FOLDER_H

#include "base/error.h"

#include <stdbool.h>

typedef struct tune_folder tune_folder;

/* Call it before the work: checks that the folder can be made. Errors: EXISTS, IO. */
stp_status tune_folder_check(const char *path, bool force, stp_error *err);
/* Errors: EXISTS, IO, OUT_OF_MEMORY. */
stp_status tune_folder_create(tune_folder **out, const char *path, bool force, stp_error *err);
/* The path under which a file of the report is written; valid until the next call. name is one of
 * those that a report has: tune.csv, tune.json, index.html, *.svg. */
const char *tune_folder_file(tune_folder *folder, const char *name);
/* Makes the folder appear and destroys *folder. Errors: IO, EXISTS. */
stp_status tune_folder_commit(tune_folder **folder, stp_error *err);
/* Removes what was not committed. */
void tune_folder_destroy(tune_folder **folder);

#endif
