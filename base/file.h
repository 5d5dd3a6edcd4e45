/* Output files that appear whole or not at all; reading input files; making folders.
 *
 * stp_output is a file without a name. Commit flushes it, syncs it and gives it its name, so a
 * killed run leaves nothing. If the file system has no nameless files, the output has a temporary
 * name (temporary.h), and the next run removes what a killed run left. Threads: one at a time. */
#ifndef STP_BASE_FILE_H
#define STP_BASE_FILE_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_output stp_output;

/* Removes what killed runs left for the same output: our temporary files that no process holds.
 * Returns their number. If bytes is not NULL, *bytes is set to their total size. */
uint64_t stp_output_sweep(const char *path, uint64_t *bytes);

/* Creates an output, after a sweep. Errors: EXISTS (path exists and force is false), IO (the folder
 * is missing or read-only), OUT_OF_MEMORY. */
stp_status stp_output_create(stp_output **out, const char *path, bool force, stp_error *err);
/* The same with a temporary name: other processes may open the file by it and write to it. */
stp_status stp_output_create_shared(stp_output **out, const char *path, bool force, stp_error *err);
/* Opens a file to change it in place, and locks it: no other run can reopen it until the output is
 * destroyed. Programs may read it meanwhile. What is written is appended; stp_output_sync makes it
 * stay. Not for commit. Errors: NOT_FOUND, IO (no permission, write-protected, locked, no regular
 * file), OUT_OF_MEMORY. */
stp_status stp_output_reopen(stp_output **out, const char *path, stp_error *err);
/* Drops all bytes of a reopened file from `size` on: appending goes on there. Errors: IO. */
stp_status stp_output_keep(stp_output *output, uint64_t size, stp_error *err);
/* Writes all to the disk. What was appended to a reopened file stays from now on, also if the
 * output is destroyed. Errors: IO. */
stp_status stp_output_sync(stp_output *output, stp_error *err);
/* Fails if the output and the input are the same file, whatever their names. Errors:
 * INVALID_ARGUMENT. */
stp_status stp_output_check_input(const char *path, const char *input, stp_error *err);
/* Fails if path names this output's own file, however it is spelled. Errors: INVALID_ARGUMENT. */
stp_status stp_output_check_other(const stp_output *output, const char *path, stp_error *err);
/* Appends size bytes. Errors: IO (the message says if the disk is full). */
stp_status stp_output_write(stp_output *output, const void *data, size_t size, stp_error *err);
/* Leaves size bytes to other processes: appending goes on behind them. Errors: likewise. */
stp_status stp_output_skip(stp_output *output, uint64_t size, stp_error *err);
/* Overwrites bytes that were written before. The append position does not move. Errors: IO. */
stp_status stp_output_write_at(stp_output *output, uint64_t offset, const void *data, size_t size,
                               stp_error *err);
/* Bytes appended so far. */
uint64_t stp_output_size(const stp_output *output);
/* The output's descriptor, which another process may write to instead of this one. The output keeps
 * ownership. */
int stp_output_descriptor(const stp_output *output);
/* A path by which this process can read what was written. Valid until commit. */
const char *stp_output_temporary_path(const stp_output *output);
/* Gives the file its final name and destroys the output, also on failure. Errors: IO, EXISTS. */
stp_status stp_output_commit(stp_output **output, stp_error *err);
/* Removes the temporary file if not committed. Sets *output to NULL. */
void stp_output_destroy(stp_output **output);

/* Opens a file that another process created, to write to it. Errors: IO. */
stp_status stp_file_join(const char *path, int *descriptor, stp_error *err);
/* Writes size bytes at offset. Errors: IO (the message says if the disk is full). */
stp_status stp_file_write_at(int descriptor, const char *path, uint64_t offset, const void *data,
                             size_t size, stp_error *err);
/* Syncs and closes the file. Errors: likewise. */
stp_status stp_file_close(int descriptor, const char *path, stp_error *err);
/* Reads exactly size bytes at offset. Errors: IO; CORRUPT when the file ends early. */
stp_status stp_file_read_at(int descriptor, const char *path, uint64_t offset, void *data,
                            size_t size, stp_error *err);
/* Opens for reading and gives the size. Errors: NOT_FOUND, IO (a folder, no permission). */
stp_status stp_file_open(const char *path, int *descriptor, uint64_t *size, stp_error *err);
/* Reads a whole file; a zero byte follows it. Free *out with free(). Errors: as of these two,
 * OUT_OF_MEMORY. */
stp_status stp_file_load(const char *path, uint8_t **out, size_t *size, stp_error *err);

/* Makes a folder and its missing parents with these permissions (less the umask). Errors: IO (names
 * the folder that cannot be made; errno holds the reason too), OUT_OF_MEMORY. */
stp_status stp_folder_make(const char *path, unsigned mode, stp_error *err);

/* Whether a name ends in, say, ".laz", in capitals or not. */
bool stp_path_ends_in(const char *path, const char *ending);

#endif
