/* The inputs of prep as a list of files: files, folders, patterns and lists of these. */
#ifndef STP_TOOLS_PREP_PREP_PATHS_H
#define STP_TOOLS_PREP_PREP_PATHS_H

#include "base/error.h"

#include <stddef.h>

/* Owned. Zero is none. */
typedef struct prep_paths {
    char **list;
    size_t count, capacity;
} prep_paths;

/* Adds what an argument stands for: a folder all files in it and below whose names end as scans'
 * do, by name; `@list.txt` what its lines stand for, those that are not absolute beside it (blank
 * lines and lines of # skipped); a pattern (* ? [) that is no file what it matches, by name; else
 * itself. Errors: NOT_FOUND (nothing matches, no scan in a folder), IO, OUT_OF_MEMORY. */
stp_status prep_paths_add(prep_paths *paths, const char *argument, stp_error *err);
void prep_paths_clear(prep_paths *paths);

#endif
