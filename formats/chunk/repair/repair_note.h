/* Reads and writes the repairs in a repaired file's metadata (SPEC.md, "Repaired files"). */
#ifndef STP_FORMATS_CHUNK_REPAIR_REPAIR_NOTE_H
#define STP_FORMATS_CHUNK_REPAIR_REPAIR_NOTE_H

#include "formats/chunk/repair/repair_plan.h"

/* Sets marks[id] for each chunk whose level-0 samples stand in for lost points. marks has
 * chunk_count items, all false before. Accepts any text. */
void stp_repair_note_stand_ins(const char *metadata_json, bool *marks, uint32_t chunk_count);

/* Sums over all repairs of a file. */
typedef struct stp_repair_sum {
    uint32_t repairs;
    double points_lost, stand_ins;
} stp_repair_sum;

/* All zero if the metadata records no repair. Accepts any text. */
stp_repair_sum stp_repair_note_sum(const char *metadata_json);

/* The output's metadata (free with free()); NULL if memory is exhausted. Reports each loss. */
char *stp_repair_note_write(const stp_repair_plan *plan, const stp_repair_result *result);

#endif
