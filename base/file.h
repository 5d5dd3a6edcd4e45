/* Output files that appear whole or not at all, reading input files, and making folders.
 *
 * An stp_output is a file without a name until commit flushes, syncs and names it: a killed run
 * leaves nothing. Where the file system has no such files it has a temporary name (temporary.h),
 * and what a killed run left, the next one removes. Threads: one at a time. */
#ifndef STP_BASE_FILE_H
#define STP_BASE_FILE_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_output stp_output;

/* Removes what killed runs left for the same output: temporary files of ours that no process holds.
 * Returns how many; *bytes, where it is not NULL: how much. */
uint64_t stp_output_sweep(const char *path, uint64_t *bytes);

/* Sweeps first. Errors: EXISTS (path exists, force is false), IO (folder missing or read-only),
 * OUT_OF_MEMORY. */
stp_status stp_output_create(stp_output **out, const char *path, bool force, stp_error *err);
/* Refuses an output that is an input, by whatever name. Errors: INVALID_ARGUMENT. */
stp_status stp_output_check_input(const char *path, const char *input, stp_error *err);
/* Refuses a path that is this output's own, by whatever name. Errors: INVALID_ARGUMENT. */
stp_status stp_output_check_other(const stp_output *output, const char *path, stp_error *err);
/* Appends size bytes. Errors: IO (a full disk is said so). */
stp_status stp_output_write(stp_output *output, const void *data, size_t size, stp_error *err);
/* Writes at an offset that was written before; the append position stays. Errors: IO. */
stp_status stp_output_write_at(stp_output *output, uint64_t offset, const void *data, size_t size,
                               stp_error *err);
/* Bytes appended so far. */
uint64_t stp_output_size(const stp_output *output);
/* What another process may write to in this one's stead; of the output. */
int stp_output_descriptor(const stp_output *output);
/* A name by which this process can read what was written; valid until commit. */
const char *stp_output_temporary_path(const stp_output *output);
/* Makes the file appear under its final name and destroys the output. Errors: IO, EXISTS. */
stp_status stp_output_commit(stp_output **output, stp_error *err);
/* Removes the temporary file if not committed. Sets *output to NULL. */
void stp_output_destroy(stp_output **output);

/* Reads exactly size bytes at offset. Errors: IO; CORRUPT when the file ends early. */
stp_status stp_file_read_at(int descriptor, const char *path, uint64_t offset, void *data,
                            size_t size, stp_error *err);
/* Opens for reading and gives the size. Errors: NOT_FOUND, IO (a folder, no permission). */
stp_status stp_file_open(const char *path, int *descriptor, uint64_t *size, stp_error *err);

/* Makes a folder and those above it, as far as they are missing, with such permissions (less the
 * umask). Errors: IO (the one that cannot be made is named; errno says why, too), OUT_OF_MEMORY.
 */
stp_status stp_folder_make(const char *path, unsigned mode, stp_error *err);

#endif
