/* The folder in which prepared scans are kept: KEY.stipple, where the key is a hash of what the
 * model was made of: the scans' paths, sizes and times, and the state of prep.
 *
 * The time of last use is a file's access time, which open_cache_use sets. Other files are left
 * alone. Several processes may share the folder: names appear whole, and a file that is removed
 * while somebody reads it stays readable to the end. Threads: any. */
#ifndef STP_TOOLS_OPEN_OPEN_CACHE_H
#define STP_TOOLS_OPEN_OPEN_CACHE_H

#include "tools/prep/prep_paths.h"

#include <stdint.h>

/* The folder: `given`, or if that is NULL $XDG_CACHE_HOME/stipple, or ~/.cache/stipple. *out is
 * owned by the caller. Errors: IO (the user has no such folder), OUT_OF_MEMORY. */
stp_status open_cache_folder(char **out, const char *given, stp_error *err);
/* Makes the folder if it is missing. Errors: IO (nothing can be written to it), OUT_OF_MEMORY. */
stp_status open_cache_make(const char *folder, stp_error *err);
/* Where in the folder the model of these scans with these attributes (NULL: none) lies, if it is
 * there. *out is owned by the caller.
 * Errors: OUT_OF_MEMORY. */
stp_status open_cache_path(char **out, const char *folder, const prep_paths *scans,
                           const char *attributes, stp_error *err);
/* Notes that the model was used now. */
void open_cache_use(const char *path);
/* Removes the models that were not used for longest, until the others have at most so many bytes;
 * and what killed runs left. */
void open_cache_trim(const char *folder, uint64_t bytes);

#endif
