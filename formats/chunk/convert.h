/* Copies a chunk file with payloads of another codec or version, or with another default threshold.
 *
 * Samples, patches, entries and the order of payloads stay as they are. Only the payloads' codec,
 * their blocks and their offsets change. Threads: one call at a time per file. */
#ifndef STP_FORMATS_CHUNK_CONVERT_H
#define STP_FORMATS_CHUNK_CONVERT_H

#include "base/pool.h"
#include "base/progress.h"
#include "formats/chunk/chunk_file.h"

typedef struct stp_convert_params {
    bool keep_codec; /* copies payloads; codec is then not used */
    stp_codec codec; /* codec of all payloads, without blocks */
    int format;      /* major version of the output: 1, 2 (in blocks), or 0: the file's own */
    uint32_t block_samples; /* least level-0 samples of a block; 0: what pays for the codec */
    double threshold_px;    /* > 0: the model's new default threshold */
    bool drop_attributes;   /* version 1 has none */
    bool force;             /* replace an existing file */
    stp_pool *pool;         /* NULL: one thread */
    const stp_progress *progress;
} stp_convert_params;

/* Writes a model to another file. The file appears whole or not at all. Memory: a few chunks a
 * thread. Errors: those of reading and of writing a chunk file; UNSUPPORTED (the version is newer
 * than this program's: the program would lose what it does not know); INVALID_ARGUMENT (attributes
 * in version 1); CANCELLED. */
stp_status stp_chunk_file_convert(stp_chunk_file *file, const char *output,
                                  const stp_convert_params *params, stp_error *err);

/* The default threshold in pixels from the file's metadata; 0 if there is none. */
double stp_chunk_file_threshold(const stp_chunk_file_info *info);
/* The intensity in the sources' own numbers that a sample's 255 stands for; 0: not known. */
double stp_chunk_file_intensity_top(const stp_chunk_file_info *info);

/* Whether the file's metadata asks to be shown unlit. */
bool stp_chunk_file_unlit(const stp_chunk_file_info *info);

/* Makes threshold_px the default of the file at `path`. Writes the file anew beside itself; when
 * the new file is whole and on the disk, it takes the old one's place. So a crash or a full disk
 * leaves the old file. Changing the file in place would not be safe: metadata and directory lie
 * behind the payloads without a gap, up to the file's end, and the header holds their checksums and
 * offsets. Metadata of another length would overwrite what the old header still needs. So this
 * takes the time and room of a copy; payloads are copied. (In version 2 the records of blocks are
 * made from them anew.) Errors: INVALID_ARGUMENT (not a finite number above 0), those of
 * stp_chunk_file_convert. */
stp_status stp_chunk_file_set_threshold(const char *path, double threshold_px, stp_error *err);

#endif
