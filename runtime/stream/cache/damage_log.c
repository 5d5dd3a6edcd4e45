/* Keeps the list of damaged blocks and its sentence. */
#include "runtime/stream/cache/damage_log.h"

#include "base/memory.h"

#include <stdio.h>
#include <stdlib.h>

stp_status stp_damage_log_create(stp_damage_log *out, size_t block_count, stp_error *err)
{
    stp_damage_log log = {0};
    stp_status status = stp_alloc(&log.damaged, block_count, sizeof *log.damaged, "slots", err);
    if (status == STP_OK)
        *out = log;
    return status;
}

void stp_damage_log_note(stp_damage_log *log, uint32_t block, const char *message)
{
    if (log->damaged[block])
        return;
    log->damaged[block] = true;
    if (log->count++ == 0)
        log->first_bytes = (size_t)snprintf(log->words, sizeof log->words, "%.500s", message);
    else
        snprintf(log->words + log->first_bytes, sizeof log->words - log->first_bytes,
                 " (and so of %u other block%s)", log->count - 1, log->count == 2 ? "" : "s");
}

void stp_damage_log_destroy(stp_damage_log *log)
{
    free(log->damaged);
    *log = (stp_damage_log){0};
}
