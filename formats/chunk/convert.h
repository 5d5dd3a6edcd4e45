/* A chunk file as another one: with payloads of another codec, or another default threshold.
 *
 * Every sample, patch and entry stays as it is, and the payloads' order; only where payloads lie
 * and what they are coded by changes. Threads: one call at a time per file. */
#ifndef STP_FORMATS_CHUNK_CONVERT_H
#define STP_FORMATS_CHUNK_CONVERT_H

#include "base/pool.h"
#include "base/progress.h"
#include "formats/chunk/chunk_file.h"

typedef struct stp_convert_params {
    bool keep_codec;     /* payloads are copied */
    stp_codec codec;     /* else what all of them become */
    double threshold_px; /* > 0: becomes the model's default threshold */
    bool force;          /* replace an existing file */
    stp_pool *pool;      /* NULL: one thread */
    const stp_progress *progress;
} stp_convert_params;

/* Writes a model to another file, which appears whole or not at all. A few chunks a thread are in
 * memory. Errors: those of reading and of writing a chunk file; UNSUPPORTED (a version newer than
 * this program's, of which it would lose what it does not know); CANCELLED. */
stp_status stp_chunk_file_convert(stp_chunk_file *file, const char *output,
                                  const stp_convert_params *params, stp_error *err);

/* The threshold in pixels that the file's metadata names as its default; 0 if it names none. */
double stp_chunk_file_threshold(const stp_chunk_file_info *info);

/* Whether the file's metadata asks to be shown unlit. */
bool stp_chunk_file_unlit(const stp_chunk_file_info *info);

/* Makes threshold_px the default of the file at `path`. The file is written anew beside itself and
 * takes its own place when it is whole and on the disk: a crash or a full disk leaves the old one.
 * It is not changed where it is, for that would not be safe: metadata and directory end where the
 * file does and lie behind the payloads without a gap, and their checksums and offsets stand in the
 * header, so that new metadata of another length would overwrite what the old header still needs.
 * So it takes the time and the room of a copy; payloads are copied, not decoded. Errors:
 * INVALID_ARGUMENT (not a finite number above 0), those of stp_chunk_file_convert. */
stp_status stp_chunk_file_set_threshold(const char *path, double threshold_px, stp_error *err);

#endif
