/* What a repaired file's metadata says of its repairs (SPEC.md, "Repaired files"). */
#ifndef STP_FORMATS_CHUNK_REPAIR_REPAIR_NOTE_H
#define STP_FORMATS_CHUNK_REPAIR_REPAIR_NOTE_H

#include "formats/chunk/repair/repair_plan.h"

/* Sets marks[id] (chunk_count, false before) of the chunks whose level-0 samples stand in for lost
 * points. Any text is taken. */
void stp_repair_note_stand_ins(const char *metadata_json, bool *marks, uint32_t chunk_count);

/* Over all repairs of a file. */
typedef struct stp_repair_sum {
    uint32_t repairs;
    double points_lost, stand_ins;
} stp_repair_sum;

/* All zero where the metadata tells of no repair. Any text is taken. */
stp_repair_sum stp_repair_note_sum(const char *metadata_json);

/* The output's metadata, which free() frees; NULL: memory is exhausted. Says each loss. */
char *stp_repair_note_write(const stp_repair_plan *plan, const stp_repair_result *result);

#endif
