/* What is being written: files and folders that lie beside the final name until they are whole.
 *
 * Such a name, PATH.0123456789abcdef.part, cannot be foreseen, so nobody can have put anything
 * there. As long as its process lives the file or folder is locked, and it bears a mark, an
 * extended attribute: what has the mark and no lock was left by a killed run and may be swept.
 * Where a file system has no attributes, name and lock tell. Threads: any. */
#ifndef STP_BASE_TEMPORARY_H
#define STP_BASE_TEMPORARY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Most bytes that a temporary name is longer than the path, its end included. */
#define STP_TEMPORARY_BYTES 32

/* A new temporary name for path: strlen(path) + STP_TEMPORARY_BYTES bytes. False with errno set if
 * there are no random numbers. */
bool stp_temporary_name(char *out, const char *path);
/* Locks and marks what has, or is about to have, a temporary name. False if a sweep looks at it
 * just now. A file system without locks or attributes is no failure. */
bool stp_temporary_mark(int descriptor);
/* Takes the mark away when the final name is given. */
void stp_temporary_unmark(int descriptor);

/* Removes an entry of the folder; false if it stays. */
typedef bool stp_temporary_remove(int folder, const char *name);
/* Removes what killed runs left for path: folders or files. Returns how many; *bytes, where it is
 * not NULL: how much, of files. */
uint64_t stp_temporary_sweep(const char *path, bool folders, stp_temporary_remove *remove,
                             uint64_t *bytes);

#endif
