/* Allocation that reports. */
#include "base/memory.h"

#include "base/checked.h"

#include <stdlib.h>
#include <string.h>

static stp_status out_of_memory(size_t count, size_t size, const char *what, stp_error *err)
{
    return stp_error_set(err, STP_OUT_OF_MEMORY,
                         "no memory for %zu %s of %zu bytes: close other programs or use a smaller "
                         "input",
                         count, what, size);
}

stp_status stp_alloc(void *out, size_t count, size_t size, const char *what, stp_error *err)
{
    void *memory = NULL;
    if (count > 0) {
        memory = calloc(count, size);
        if (!memory)
            return out_of_memory(count, size, what, err);
    }
    memcpy(out, &memory, sizeof memory);
    return STP_OK;
}

stp_status stp_alloc_unset(void *out, size_t count, size_t size, const char *what, stp_error *err)
{
    void *memory = NULL;
    size_t bytes = 0;
    if (count > 0) {
        memory = stp_mul_size(count, size, &bytes) ? malloc(bytes) : NULL;
        if (!memory)
            return out_of_memory(count, size, what, err);
    }
    memcpy(out, &memory, sizeof memory);
    return STP_OK;
}

stp_status stp_text_copy(char **out, const char *text, const char *what, stp_error *err)
{
    size_t bytes = strlen(text) + 1;
    stp_status status = stp_alloc(out, bytes, 1, what, err);
    if (status == STP_OK)
        memcpy(*out, text, bytes);
    return status;
}

stp_status stp_grow(void *array, size_t *capacity, size_t needed, size_t size, const char *what,
                    stp_error *err)
{
    if (needed <= *capacity)
        return STP_OK;
    size_t wanted = *capacity < 16 ? 16 : *capacity;
    while (wanted < needed) {
        if (wanted > SIZE_MAX / 2)
            return out_of_memory(needed, size, what, err);
        wanted *= 2;
    }
    size_t bytes = 0;
    void *old = NULL;
    memcpy(&old, array, sizeof old);
    void *memory = stp_mul_size(wanted, size, &bytes) ? realloc(old, bytes) : NULL;
    if (!memory)
        return out_of_memory(wanted, size, what, err);
    memcpy(array, &memory, sizeof memory);
    *capacity = wanted;
    return STP_OK;
}
