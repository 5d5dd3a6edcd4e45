/* Strips that continue each other, over a whole file: where one ends, the next begins. */
#ifndef STP_FORMATS_CHUNK_VERIFY_VERIFY_JOINTS_H
#define STP_FORMATS_CHUNK_VERIFY_VERIFY_JOINTS_H

#include "formats/chunk/chunk_file.h"

/* Of a vertex of a strip: equal where a strip continues another one. Threads: any. */
uint64_t stp_joint_number(const stp_sample *sample, const stp_patch *patch, stp_dvec3 origin);

/* A number for each vertex at which a strip is continued, less one for each at which one continues,
 * summed: over all leaves 0 where all of them meet, hardly ever otherwise. Equal numbers: the same
 * place, and all else but the radius. Adds up modulo 2^64. Threads: any. */
uint64_t stp_verify_joints(const stp_chunk *chunk, stp_dvec3 origin);

#endif
