/* Expands the arguments of prep to a list of files: files, folders, patterns and lists. */
#ifndef STP_TOOLS_PREP_PREP_PATHS_H
#define STP_TOOLS_PREP_PREP_PATHS_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>

/* Most arguments of a command. */
#define PREP_PATHS_LIMIT 4096

/* The list is owned. Zero is empty. */
typedef struct prep_paths {
    char **list;
    size_t count, capacity;
} prep_paths;

/* Adds the files that an argument stands for:
 *   - a folder with an ept.json in it: that set, as one scan;
 *   - another folder: all files in it and below whose names end like a scan's, by name, and the
 *     sets of such folders;
 *   - an address (https://...): itself;
 *   - `@list.txt`: what its lines stand for, relative to the list's folder; blank lines, and lines
 *     that begin with #, are skipped;
 *   - a pattern (* ? [) that is no file: the files that match, by name;
 *   - anything else: the argument itself.
 * Errors: NOT_FOUND (nothing matches, no scan in a folder), IO, OUT_OF_MEMORY. */
stp_status prep_paths_add(prep_paths *paths, const char *argument, stp_error *err);
/* Whether the name of a file or an address is that of a scan that a folder may hold. */
bool prep_paths_is_scan(const char *name);
void prep_paths_clear(prep_paths *paths);

#endif
