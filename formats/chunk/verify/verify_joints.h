/* Checks, over a whole file, that strips which continue each other meet: where one ends, the next
 * begins. */
#ifndef STP_FORMATS_CHUNK_VERIFY_VERIFY_JOINTS_H
#define STP_FORMATS_CHUNK_VERIFY_VERIFY_JOINTS_H

#include "formats/chunk/chunk_file.h"

/* A number for a strip's end vertex: equal for both vertices at which a strip continues another.
 * Threads: any. */
uint64_t stp_joint_number(const stp_sample *sample, const stp_patch *patch, stp_dvec3 origin);

/* Sum over a chunk's strips, modulo 2^64: plus the number of each vertex flagged continued, minus
 * the number of each vertex flagged continues. Over all leaves the sum is 0 if all strips meet, and
 * hardly ever otherwise. Equal numbers mean the same place and equal bytes except for the radius.
 * Threads: any. */
uint64_t stp_verify_joints(const stp_chunk *chunk, stp_dvec3 origin);

#endif
