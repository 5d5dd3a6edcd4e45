/* Copies what is kept of a block, patch by patch. The packed samples of a patch begin with its
 * coarse levels, so what is kept of them is a prefix; only what precedes them is shorter for coarse
 * levels (runtime/stream/texels.h). */
#include "runtime/stream/cache/shrink.h"

#include <string.h>

/* How many packed samples a patch has at levels >= finest. */
static uint32_t packed_of(const stp_mirror_patch *patch, int finest)
{
    uint32_t count = 0;
    for (int l = finest; l < STP_LEVEL_COUNT - 1; l++)
        count += patch->count[l];
    return count;
}

/* Texels of a patch: those before its packed samples, and all, as it is and as it will be. */
typedef struct extent {
    uint32_t had_head, had, head, kept;
} extent;

static extent extent_of(const stp_resident *r, uint32_t p, int finest)
{
    const stp_mirror_patch *patch = &r->mirror.patches[p];
    const stp_gpu_patch *record = &r->mirror.records[p];
    const bool apart = (record->flags & STP_GPU_PATCH_APART) != 0;
    const uint32_t end = p + 1 < r->placement.patches.count
                             ? record[1].first
                             : r->placement.texels.begin + r->placement.texels.count;
    extent e = {.had_head = stp_texels_head(apart, patch->finest), .had = end - record->first};
    e.head = e.had_head;
    e.kept = e.had;
    const uint32_t packed = packed_of(patch, patch->finest);
    if (finest <= patch->finest || packed == 0)
        return e;
    /* a sample has so many bits at most, which the packed samples' length tells */
    const uint32_t bits = 64 * (e.had - e.had_head) / packed;
    e.head = stp_texels_head(apart, finest);
    e.kept = e.head + (packed_of(patch, finest) * bits + 63) / 64;
    return e;
}

uint32_t stp_shrink_texels(const stp_resident *r, const uint8_t *finest)
{
    uint32_t texels = 0;
    for (uint32_t p = 0; p < r->placement.patches.count; p++)
        texels += extent_of(r, p, finest[p]).kept;
    return texels;
}

/* Texels that are copied at once. */
typedef struct run {
    uint32_t from, to, count;
} run;

static void copy_run(const stp_object_texture *texture, const stp_upload_ring *ring,
                     uint64_t offset, const run *r)
{
    if (r->count > 0)
        glCopyNamedBufferSubData(texture->samples.name, ring->buffer.name,
                                 (GLintptr)(r->from * (uint64_t)STP_TEXEL_BYTES),
                                 (GLintptr)(offset + r->to * (uint64_t)STP_TEXEL_BYTES),
                                 (GLsizeiptr)(r->count * (uint64_t)STP_TEXEL_BYTES));
}

/* Adds texels to a run, or copies it and begins another one. */
static void add_run(const stp_object_texture *texture, const stp_upload_ring *ring, uint64_t offset,
                    run *r, run more)
{
    if (r->from + r->count == more.from && r->to + r->count == more.to) {
        r->count += more.count;
        return;
    }
    copy_run(texture, ring, offset, r);
    *r = more;
}

/* Copies what is kept to the ring, and tells the patches where it is from the block's first texel
 * on. */
static void collect(const stp_object_texture *texture, const stp_upload_ring *ring, uint64_t offset,
                    stp_resident *r, const uint8_t *finest)
{
    run copied = {0};
    uint32_t at = 0;
    for (uint32_t p = 0; p < r->placement.patches.count; p++) {
        stp_gpu_patch *record = &r->mirror.records[p];
        const extent e = extent_of(r, p, finest[p]);
        add_run(texture, ring, offset, &copied, (run){record->first, at, e.head});
        add_run(texture, ring, offset, &copied,
                (run){record->first + e.had_head, at + e.head, e.kept - e.head});
        record->first = at;
        at += e.kept;
        if (finest[p] <= r->mirror.patches[p].finest)
            continue;
        r->mirror.patches[p].finest = finest[p];
        r->mirror.briefs[p].finest = finest[p] & 3u;
        record->count = (uint8_t)((stp_gpu_patch_count(record) - 1) |
                                  (unsigned)finest[p] << STP_GPU_PATCH_FINEST_SHIFT);
    }
    copy_run(texture, ring, offset, &copied);
}

bool stp_shrink(stp_object_texture *texture, stp_upload_ring *ring, stp_resident *r,
                const uint8_t *finest, stp_status *status, stp_error *err)
{
    stp_range piece;
    stp_placement *at = &r->placement;
    const uint32_t texels = stp_shrink_texels(r, finest);
    const uint64_t bytes = texels * (uint64_t)STP_TEXEL_BYTES;
    const uint64_t patches = at->patches.count * (uint64_t)sizeof(stp_gpu_patch);
    if (!stp_upload_ring_take(ring, bytes + patches, &piece, status, err))
        return false;
    const uint64_t offset = stp_upload_ring_offset(piece);
    collect(texture, ring, offset, r, finest);
    stp_range_pool_give(&texture->sample_ranges, at->texels);
    /* the place that was just left is large enough, and there is memory to note it */
    (void)stp_range_pool_take(&texture->sample_ranges, texels, &at->texels, status, err);
    for (uint32_t p = 0; p < at->patches.count; p++)
        r->mirror.records[p].first += at->texels.begin;
    memcpy(stp_upload_ring_memory(ring, piece) + bytes, r->mirror.records, patches);
    stp_upload_ring_copy(ring, &texture->samples, offset,
                         at->texels.begin * (uint64_t)STP_TEXEL_BYTES, bytes);
    stp_upload_ring_copy(ring, &texture->patches, offset + bytes,
                         at->patches.begin * (uint64_t)sizeof(stp_gpu_patch), patches);
    stp_upload_ring_copied(ring, piece);
    r->partial = true;
    return true;
}
