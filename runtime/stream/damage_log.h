/* Which chunks of a scene are damaged, and one sentence about them: the first one's error, and how
 * many more there are. Threads: the render thread. */
#ifndef STP_RUNTIME_STREAM_DAMAGE_LOG_H
#define STP_RUNTIME_STREAM_DAMAGE_LOG_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Zero is empty and may be destroyed. */
typedef struct stp_damage_log {
    bool *damaged; /* by chunk */
    uint32_t count;
    char words[560];
    size_t first_bytes; /* of the first error in words */
} stp_damage_log;

/* Of so many chunks, none damaged. Errors: OUT_OF_MEMORY. */
stp_status stp_damage_log_create(stp_damage_log *out, size_t chunk_count, stp_error *err);
/* message: the error's; a chunk that is known to be damaged already counts once. */
void stp_damage_log_note(stp_damage_log *log, uint32_t chunk, const char *message);
void stp_damage_log_destroy(stp_damage_log *log);

#endif
