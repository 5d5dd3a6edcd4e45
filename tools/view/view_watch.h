/* Notices when files in a folder are saved. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_WATCH_H
#define STP_TOOLS_VIEW_VIEW_WATCH_H

#include <stdint.h>

/* A number made of the names, sizes and times of change of the files in the folder and its
 * sub-folders. The number changes after a save. 0 if the folder is NULL or cannot be read. */
uint64_t view_watch_state(const char *folder);

#endif
