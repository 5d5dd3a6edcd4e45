/* Writes a repaired file that differs from its input: payloads, the tree without chunks that are
 * gone, and metadata that names what is lost. */
#ifndef STP_FORMATS_CHUNK_REPAIR_REPAIR_WRITE_H
#define STP_FORMATS_CHUNK_REPAIR_REPAIR_WRITE_H

#include "formats/chunk/repair/repair_plan.h"

/* Writes a plan whose chunks are built. check is called before the output appears
 * (stp_chunk_writer_params). Reports what is lost. Errors: those of the writer, of check, and IO.
 */
stp_status stp_repair_write(stp_repair_plan *plan,
                            stp_status (*check)(void *context, const char *path, stp_error *err),
                            void *context, stp_repair_result *out, stp_error *err);

#endif
