/* Arrays that may be larger than the memory a program is given.
 *
 * With no limit they are plain memory. With one, they lie in nameless files in a folder of the
 * caller's, mapped, small ones together: its pages come when they are touched, and a watching
 * thread lets go of all of them whenever the process holds more than its limit. They stay in the
 * file, so nothing changes but time, and the system may keep them in memory nobody else needs. A
 * killed run leaves nothing. Who walks an array from end to end is as fast as with plain memory;
 * who jumps about is not.
 *
 * The limit is the whole process's: what else it allocates should be far below it. Threads: any. */
#ifndef STP_BASE_SPILL_H
#define STP_BASE_SPILL_H

#include "base/error.h"

#include <stddef.h>
#include <stdint.h>

typedef struct stp_spill stp_spill;

typedef struct stp_spill_params {
    uint64_t memory_bytes; /* the process's limit; 0: none, and folder is not used */
    const char *folder;
} stp_spill_params;

/* Errors: OUT_OF_MEMORY, IO (no file can be made in the folder). */
stp_status stp_spill_create(stp_spill **out, const stp_spill_params *params, stp_error *err);
/* Arrays that are still there go, too. */
void stp_spill_destroy(stp_spill **spill);

/* Sets *out to count zeroed elements of size bytes, aligned for any type; NULL for none. `what`
 * names them. Room in the folder is taken at once, so that a full disk is found here. spill NULL:
 * plain memory. Errors: OUT_OF_MEMORY, IO (the folder is full: says how much was asked). */
stp_status stp_spill_alloc(stp_spill *spill, void *out, size_t count, size_t size, const char *what,
                           stp_error *err);
/* Moves *array, plain memory, here: where this is files, *array is replaced by a copy in one and
 * what it was is freed. Errors: as stp_spill_alloc; then *array is as before. */
stp_status stp_spill_move(stp_spill *spill, void *array, size_t count, size_t size,
                          const char *what, stp_error *err);
/* Frees an array of this spill's, or plain memory; NULL is none. */
void stp_spill_free(stp_spill *spill, void *array);

/* Gives the room of a part of an array back before all of it is freed: what it held is lost, and it
 * must not be touched again. Plain memory keeps it, and so do file systems that cannot. */
void stp_spill_forget(stp_spill *spill, void *part, size_t bytes);

/* Lets go of pages now if the process holds too much: for who begins a piece of work that touches
 * some megabytes, since on a crowded machine the watching thread may come late. NULL is fine. */
void stp_spill_relieve(stp_spill *spill);
/* Greatest number of bytes in the folder so far, but for what was forgotten; of plain memory 0. */
uint64_t stp_spill_most_file_bytes(stp_spill *spill);

#endif
