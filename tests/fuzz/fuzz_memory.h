/* Turns bytes into a file in memory, for readers that take a path. */
#ifndef STP_TESTS_FUZZ_FUZZ_MEMORY_H
#define STP_TESTS_FUZZ_FUZZ_MEMORY_H

#include <fcntl.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

/* The first file's descriptor, so that a file can name itself as one beside it: `100`. */
#define FUZZ_DESCRIPTOR 100

/* Returns the file's descriptor, which the caller closes; *path names the file until then. Aborts
 * if there is no memory. */
static inline int fuzz_memory_file(const uint8_t *data, size_t size, char path[64])
{
    const int made = memfd_create("fuzz", MFD_CLOEXEC);
    const int descriptor = fcntl(made, F_DUPFD_CLOEXEC, FUZZ_DESCRIPTOR);
    close(made);
    if (descriptor < 0 || (size > 0 && write(descriptor, data, size) != (ssize_t)size))
        abort();
    snprintf(path, 64, "/proc/self/fd/%d", descriptor);
    return descriptor;
}

#endif
