/* How a chunk file becomes LAS or LAZ: its lattice and coordinate system. Threads: any. */
#ifndef STP_TOOLS_FILE_EXPORT_LAS_H
#define STP_TOOLS_FILE_EXPORT_LAS_H

#include "formats/chunk/chunk_file.h"
#include "formats/scan/las/las_write.h"

/* Whether the name ends as LAS files do, packed (LAZ) or not; whether as those of LAZ do. */
bool export_las_is_named(const char *path);
bool export_las_is_packed(const char *path);
/* Fills in steps, offset and wkt: those of the first source that says them, else the finest steps
 * for the model's box. *wkt: owned by the caller, free with free(); NULL: none. Errors: UNSUPPORTED
 * (lines or triangles), OUT_OF_MEMORY. */
stp_status export_las_params(stp_las_writer_params *out, char **wkt, const stp_chunk_file *file,
                             stp_error *err);

#endif
