/* A damaged chunk file made whole again: the library part of `stipple verify --repair`.
 *
 * What is sound is kept byte by byte. A flipped bit is found by the checksum over it and put back.
 * A header is rebuilt from directory, metadata and points; lost directory entries from payloads and
 * the chunks around them. Where payloads are lost:
 *   - an inner chunk is rebuilt from the patch vertices of its children, and so are those above it;
 *   - a leaf keeps the finest level there is; if there is none, what its parent shows in its place.
 * Their samples *stand in* for the points that are lost: the file draws without a hole, and its
 * metadata names them (SPEC.md, "Repaired files"), as do the lines of the report.
 * Memory: the directory, what is rebuilt (1 GiB at most), and a few megabytes a thread. */
#ifndef STP_FORMATS_CHUNK_REPAIR_REPAIR_H
#define STP_FORMATS_CHUNK_REPAIR_REPAIR_H

#include "base/pool.h"
#include "base/progress.h"
#include "formats/chunk/measure/surroundings.h"

/* An inner chunk out of its children (with level 3 at least, in order), without tangential errors:
 * patches of child c name it. *carry: by level-0 sample, free with free(). Errors: OUT_OF_MEMORY,
 * LIMIT. */
typedef stp_status stp_parent_build(const stp_placed_chunk *children, uint32_t count,
                                    stp_chunk **out, stp_dvec3 *origin, stp_carry **carry,
                                    stp_error *err);

typedef struct stp_repair_params {
    const char *output; /* may be the input's own name: then it is replaced, if nothing is lost */
    bool force;
    stp_parent_build *build_parent;
    stp_pool *pool;
    const stp_progress *progress; /* may be NULL */
    /* One line each for what was damaged: where, and what became of it. */
    void (*say)(void *context, const char *line);
    void *context;
} stp_repair_params;

typedef struct stp_repair_result {
    bool sound;           /* nothing to do, nothing written */
    bool whole;           /* the output's points are all of the input's, and so is its metadata */
    uint64_t points_lost; /* of the points that were stored */
    uint64_t stand_ins;   /* samples in their place */
} stp_repair_result;

/* The output appears whole, and checked by stp_chunk_file_verify, or not at all. Errors: NOT_FOUND,
 * FORMAT, VERSION, IO, EXISTS, OUT_OF_MEMORY, CANCELLED; CORRUPT: it cannot be repaired, or (where
 * all checksums are right) it was not damaged but written wrong; LIMIT: too much is damaged;
 * INVALID_ARGUMENT: something is lost and the output is the input. */
stp_status stp_chunk_file_repair(const char *path, const stp_repair_params *params,
                                 stp_repair_result *out, stp_error *err);

#endif
