/* Files and folders that are being written: they lie beside the final name until they are whole.
 *
 * A temporary name is PATH.0123456789abcdef.part with random digits. Nobody can foresee it, so
 * nobody can have put anything there. The process holds a lock on the file or folder as long as it
 * lives, and the entry has a mark, an extended attribute. If an entry has the mark and no lock, a
 * killed run left it, and a sweep may remove it. If the file system has no attributes, the name and
 * the lock decide. Threads: any. */
#ifndef STP_BASE_TEMPORARY_H
#define STP_BASE_TEMPORARY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* How much longer a temporary name is than the path, at most, in bytes, with its terminating zero.
 */
#define STP_TEMPORARY_BYTES 32

/* Writes a new temporary name for path. out has room for strlen(path) + STP_TEMPORARY_BYTES bytes.
 * Returns false with errno set if there are no random numbers. */
bool stp_temporary_name(char *out, const char *path);
/* Locks and marks an entry that has a temporary name or is about to get one. Returns false if a
 * sweep is looking at the entry right now. A file system without locks or attributes is no failure.
 */
bool stp_temporary_mark(int descriptor);
/* Removes the mark when the entry gets its final name. */
void stp_temporary_unmark(int descriptor);

/* Opens a nameless file in the folder, to read and to write. It ends with the last descriptor of
 * it. Returns -1 with errno set if none can be made. */
int stp_temporary_nameless(const char *folder);

/* Removes an entry of the folder. Returns false if the entry stays. */
typedef bool stp_temporary_remove(int folder, const char *name);
/* Removes what killed runs left for path: folders or files. Returns their number. If bytes is not
 * NULL, *bytes is set to the total size of the files. */
uint64_t stp_temporary_sweep(const char *path, bool folders, stp_temporary_remove *remove,
                             uint64_t *bytes);

#endif
