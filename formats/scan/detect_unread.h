/* Names known formats that are not read here, so that a message can say what to do. Threads: any.
 */
#ifndef STP_FORMATS_SCAN_DETECT_UNREAD_H
#define STP_FORMATS_SCAN_DETECT_UNREAD_H

#include <stddef.h>

/* What a file is that begins with these bytes, as in "FILE is %s", and what to do with it. The name
 * tells more about archives. NULL: nothing that is known here. */
const char *stp_unread_content(const char *bytes, size_t length, const char *name,
                               const char **advice);
/* The same by the name alone, for files whose content nobody knows. */
const char *stp_unread_name(const char *name, const char **advice);

#endif
