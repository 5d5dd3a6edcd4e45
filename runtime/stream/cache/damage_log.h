/* Records which blocks of a scene are damaged, and one sentence about them: the error of the first,
 * and how many more there are. Threads: the render thread. */
#ifndef STP_RUNTIME_STREAM_CACHE_DAMAGE_LOG_H
#define STP_RUNTIME_STREAM_CACHE_DAMAGE_LOG_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Zero is empty and may be destroyed. */
typedef struct stp_damage_log {
    bool *damaged; /* by block */
    uint32_t count;
    char words[560];
    size_t first_bytes; /* length of the first error in `words` */
} stp_damage_log;

/* A log for block_count blocks, none damaged. Errors: OUT_OF_MEMORY. */
stp_status stp_damage_log_create(stp_damage_log *out, size_t block_count, stp_error *err);
/* Records a damaged block with its error message. A block recorded before counts once. */
void stp_damage_log_note(stp_damage_log *log, uint32_t block, const char *message);
void stp_damage_log_destroy(stp_damage_log *log);

#endif
