/* Arrays that may be larger than the memory a program is given.
 *
 * Without a limit, arrays are plain memory. With a limit, they lie in mapped nameless files in the
 * caller's folder; small arrays share a file. The system loads a page when it is touched. A
 * watching thread drops pages whenever the process holds more than its limit. Dropped pages stay in
 * the file, so only time changes, never data; the system may also keep them in memory that nobody
 * else needs. Arrays that fit into a given part of the limit lie in no file: nothing is written to
 * a disk. A killed run leaves nothing. Walking an array from end to end is as fast as with plain
 * memory; random access is slower.
 *
 * The limit is for the whole process, so its other allocations should stay far below it. Threads:
 * any. */
#ifndef STP_BASE_SPILL_H
#define STP_BASE_SPILL_H

#include "base/error.h"

#include <stddef.h>
#include <stdint.h>

typedef struct stp_spill stp_spill;

typedef struct stp_spill_params {
    uint64_t memory_bytes; /* the process's limit; 0: no limit, folder is not used */
    uint64_t own_bytes;    /* with a limit: what arrays may take that lie in no file */
    const char *folder;
} stp_spill_params;

/* Creates a spill. Errors: OUT_OF_MEMORY, IO (no file can be made in the folder). */
stp_status stp_spill_create(stp_spill **out, const stp_spill_params *params, stp_error *err);
/* Destroys the spill and the arrays in files that are left. */
void stp_spill_destroy(stp_spill **spill);

/* Sets *out to count zeroed elements of size bytes, aligned for any type; NULL if count is 0.
 * `what` names the elements in the message. Space in the folder is taken at once, so a full disk
 * shows up here. spill NULL: plain memory. Errors: OUT_OF_MEMORY, IO (the folder is full; the
 * message says how much was asked for). */
stp_status stp_spill_alloc(stp_spill *spill, void *out, size_t count, size_t size, const char *what,
                           stp_error *err);
/* Like stp_spill_alloc, for an array that is used in parts: a part takes no memory, and no space in
 * the folder, before stp_spill_claim. Errors: those of stp_spill_alloc. */
stp_status stp_spill_alloc_sparse(stp_spill *spill, void *out, size_t count, size_t size,
                                  const char *what, stp_error *err);
/* Takes space for a part of a sparse array: whole pages that hold nothing yet. They are zero, and
 * may be used until they are forgotten. Errors: IO. */
stp_status stp_spill_claim(stp_spill *spill, void *part, size_t bytes, const char *what,
                           stp_error *err);
/* Moves *array, which is plain memory, into the spill. If the spill uses files, *array becomes a
 * copy in a file and the old memory is freed; else nothing happens. Errors: those of
 * stp_spill_alloc; *array then stays as it was. */
stp_status stp_spill_move(stp_spill *spill, void *array, size_t count, size_t size,
                          const char *what, stp_error *err);
/* Frees an array of this spill, or plain memory. NULL is allowed. */
void stp_spill_free(stp_spill *spill, void *array);

/* Gives back the disk space of a part of an array, before the whole array is freed. The part's
 * content is lost; do not touch it again. Plain memory that is not sparse keeps its space, and so
 * do file systems that cannot give it back. */
void stp_spill_forget(stp_spill *spill, void *part, size_t bytes);

/* Drops pages now if the process holds too much. Call it before work that touches some megabytes:
 * on a crowded machine the watching thread may come late. NULL is allowed. */
void stp_spill_relieve(stp_spill *spill);
/* The most bytes that the folder has held at a time so far, without forgotten parts. 0 for plain
 * memory. */
uint64_t stp_spill_most_file_bytes(stp_spill *spill);

#endif
