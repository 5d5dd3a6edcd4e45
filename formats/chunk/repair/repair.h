/* Repairs a damaged chunk file: the library part of `stipple verify --repair`.
 *
 * Sound parts are kept byte by byte. A flipped bit is found by the checksum over it and put back. A
 * header is rebuilt from directory, metadata and points; lost directory entries from payloads and
 * the chunks around them. If a payload is lost:
 *   - an inner chunk is rebuilt from the patch vertices of its children, and so are the chunks
 *     above it;
 *   - a leaf keeps the finest level that is left; if none is left, it gets what its parent shows
 *     in its place.
 *
 * The samples of these leaves *stand in* for the lost points: the file draws without a hole. Its
 * metadata (SPEC.md, "Repaired files") and the lines of the report name them. Memory: the
 * directory, the rebuilt chunks (1 GiB at most), and a few megabytes a thread. */
#ifndef STP_FORMATS_CHUNK_REPAIR_REPAIR_H
#define STP_FORMATS_CHUNK_REPAIR_REPAIR_H

#include "base/pool.h"
#include "base/progress.h"
#include "formats/chunk/measure/surroundings.h"

/* Builds an inner chunk, without tangential errors, from its children (in order, with level 3 at
 * least). The patches of child c name it. *carry: by level-0 sample, free with free(). Errors:
 * OUT_OF_MEMORY, LIMIT. */
typedef stp_status stp_parent_build(const stp_placed_chunk *children, uint32_t count,
                                    stp_chunk **out, stp_dvec3 *origin, stp_carry **carry,
                                    stp_error *err);

typedef struct stp_repair_params {
    const char *output; /* if it is the input: replaces it, unless something is lost */
    bool force;
    stp_parent_build *build_parent;
    stp_pool *pool;
    const stp_progress *progress; /* may be NULL */
    /* Receives one line for each damage: where it is, and what became of it. */
    void (*say)(void *context, const char *line);
    void *context;
} stp_repair_params;

typedef struct stp_repair_result {
    bool sound;           /* nothing was damaged, nothing was written */
    bool whole;           /* no point, no metadata and no attribute is lost */
    bool attributes_lost; /* all of them */
    uint64_t points_lost; /* of the points that were stored */
    uint64_t stand_ins;   /* samples that stand in for them */
} stp_repair_result;

/* The output appears whole, and checked by stp_chunk_file_verify, or not at all. Errors: NOT_FOUND,
 * FORMAT, VERSION, IO, EXISTS, OUT_OF_MEMORY, CANCELLED; CORRUPT: it cannot be repaired, or, if all
 * checksums match, it was not damaged but written wrong; LIMIT: too much is damaged;
 * INVALID_ARGUMENT: something is lost and the output is the input. */
stp_status stp_chunk_file_repair(const char *path, const stp_repair_params *params,
                                 stp_repair_result *out, stp_error *err);

#endif
