/* Keeps one mapped region: all briefs, then all records, then all patches. */
#include "runtime/stream/cache/patch_store.h"

#include <sys/mman.h>

_Static_assert(sizeof(stp_patch_brief) == 64, "a brief is a line of the processor's cache");

#define PATCH_BYTES (sizeof(stp_patch_brief) + sizeof(stp_gpu_patch) + sizeof(stp_mirror_patch))

stp_status stp_patch_store_create(stp_patch_store *out, uint32_t patch_capacity, stp_error *err)
{
    const size_t bytes = patch_capacity * PATCH_BYTES;
    void *region = mmap(NULL, bytes, PROT_READ | PROT_WRITE,
                        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (region == MAP_FAILED)
        return stp_error_set(err, STP_OUT_OF_MEMORY,
                             "no room for %zu bytes of patches: give a smaller --cpu-memory",
                             bytes);
    (void)madvise(region, bytes, MADV_HUGEPAGE);
    *out = (stp_patch_store){region, bytes, patch_capacity};
    return STP_OK;
}

void stp_patch_store_destroy(stp_patch_store *s)
{
    if (s->region)
        munmap(s->region, s->region_bytes);
    *s = (stp_patch_store){0};
}

stp_mirror stp_patch_store_at(const stp_patch_store *s, stp_range patches)
{
    stp_patch_brief *briefs = (stp_patch_brief *)s->region;
    stp_gpu_patch *records = (stp_gpu_patch *)(briefs + s->patch_capacity);
    stp_mirror_patch *all = (stp_mirror_patch *)(records + s->patch_capacity);
    return (stp_mirror){.patches = all + patches.begin,
                        .briefs = briefs + patches.begin,
                        .records = records + patches.begin};
}
