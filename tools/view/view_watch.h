/* Notices that files of a folder were saved. Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_VIEW_WATCH_H
#define STP_TOOLS_VIEW_VIEW_WATCH_H

#include <stdint.h>

/* A number made of the names, sizes and times of change of the files in the folder and in its
 * sub-folders: another one after a save. Zero for a folder that cannot be read or is NULL. */
uint64_t view_watch_state(const char *folder);

#endif
