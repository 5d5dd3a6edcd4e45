/* Inputs that lie on web servers: an EPT is read file by file, a COPC by ranges, everything else is
 * copied to a nameless file while the run lasts. */
#ifndef STP_TOOLS_PREP_PREP_WEB_H
#define STP_TOOLS_PREP_PREP_WEB_H

#include "formats/scan/remote/mirror.h"

/* How servers are asked: Ctrl-C ends a read. Valid as long as the program. */
const stp_byte_source_params *prep_web_params(void);
/* Opens the mirror of an input; *mirror stays NULL if the input needs none. folder: --temp, or
 * NULL. Errors: those of stp_mirror_open. */
stp_status prep_web_open(stp_file_mirror **mirror, const char *path, const char *folder,
                         stp_error *err);
/* The name of an input for metadata: without folders (of an EPT, with the last one) and without an
 * address's query. Free with free(). Errors: OUT_OF_MEMORY. */
stp_status prep_web_name(char **out, const char *path, stp_error *err);

#endif
