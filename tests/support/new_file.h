/* Writes a file for a test. */
#ifndef STP_TESTS_SUPPORT_NEW_FILE_H
#define STP_TESTS_SUPPORT_NEW_FILE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <unistd.h>

/* An old file of this name is removed first: to empty one that was just written waits for the disk.
 */
static inline bool write_new_file(const char *path, const void *bytes, size_t size)
{
    unlink(path);
    FILE *file = fopen(path, "wb");
    const bool written = file && fwrite(bytes, 1, size, file) == size;
    return (!file || fclose(file) == 0) && written;
}

#endif
