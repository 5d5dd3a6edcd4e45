/* What a flight looks at in its own process (memory, descriptors, threads), and figures made of
 * many. Linux only. */
#ifndef STP_TESTS_FLIGHT_WATCH_H
#define STP_TESTS_FLIGHT_WATCH_H

#include "base/sort.h"
#include "tests/support/check.h"

#include <dirent.h>
#include <unistd.h>

/* Figures in the order they came; grows. Zero is empty. */
typedef struct figures {
    double *values;
    size_t count, capacity;
} figures;

static inline void figures_add(figures *f, double value)
{
    if (f->count == f->capacity) {
        f->capacity = f->capacity > 0 ? 2 * f->capacity : 4096;
        f->values = realloc(f->values, f->capacity * sizeof *f->values);
        assert_non_null(f->values);
    }
    f->values[f->count++] = value;
}

/* The value that `share` of values[begin..end) do not exceed; 0 of none. */
static inline double figures_quantile(const figures *f, size_t begin, size_t end, double share)
{
    size_t count = end - begin;
    if (count == 0)
        return 0.0;
    double *sorted = calloc(count, sizeof *sorted);
    assert_non_null(sorted);
    memcpy(sorted, f->values + begin, count * sizeof *sorted);
    stp_sort_doubles(sorted, count);
    double value = sorted[(size_t)fmin(share * (double)count, (double)count - 1.0)];
    free(sorted);
    return value;
}

static inline double figures_of(const figures *f, double share)
{
    return figures_quantile(f, 0, f->count, share);
}

static inline uint64_t watch_rss_bytes(void)
{
    unsigned long long pages = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    assert_non_null(file);
    assert_int_equal(fscanf(file, "%llu %llu", &pages, &resident), 2);
    fclose(file);
    return resident * (uint64_t)sysconf(_SC_PAGESIZE);
}

/* Entries of a folder: of /proc/self/fd the open descriptors and the one it takes to look, of
 * /proc/self/task the threads. */
static inline unsigned watch_count(const char *folder)
{
    unsigned count = 0;
    DIR *open = opendir(folder);
    assert_non_null(open);
    for (const struct dirent *e = readdir(open); e != NULL; e = readdir(open))
        count += e->d_name[0] != '.';
    closedir(open);
    return count;
}

#endif
