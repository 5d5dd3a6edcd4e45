/* Rebuilds lost directory entries. */
#include "formats/chunk/repair/lost_entries.h"

#include "base/checked.h"
#include "base/memory.h"
#include "formats/chunk/repair/found_payload.h"
#include "formats/chunk/repair/lost_sections.h"
#include "formats/chunk/verify/verify_join.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* ---- entries that agree with their payloads ---- */

static uint64_t entry_offset(const stp_damaged *d, uint32_t id)
{
    return stp_page_offset(&d->header, id / STP_PAGE_ENTRIES) +
           (uint64_t)(id % STP_PAGE_ENTRIES) * d->header.entry_bytes;
}

/* How many segments of the payload, from the first on, match the entry. */
static stp_status count_sound(const stp_damaged *d, const stp_chunk_entry *e, int *out,
                              stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    uint32_t begin = 0;
    size_t size = e->segment_end[STP_SEGMENT_COUNT - 1];
    *out = 0;
    if (!stp_range_inside(e->offset, size, d->file_bytes))
        return STP_OK;
    STP_TRY(stp_alloc(&bytes, size + 1, 1, "payload", err));
    STP_TRY(stp_damaged_read(d, e->offset, bytes, size, err));
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        bool sound = stp_hash(bytes + begin, e->segment_end[s] - begin) == e->segment_hash[s];
        *out += *out == s && sound;
        begin = e->segment_end[s];
    }
done:
    free(bytes);
    return status;
}

/* Sets the fields of an entry that describe its chunk, from the chunk. */
static stp_status describe(const stp_damaged *d, stp_chunk_entry *e, const stp_chunk *chunk,
                           stp_error *err)
{
    stp_status status = STP_OK;
    void *payload = NULL;
    stp_chunk_entry described = *e;
    STP_TRY(stp_chunk_encode(chunk, (stp_codec)e->codec, &payload, &described, err));
    memcpy(described.segment_end, e->segment_end, sizeof e->segment_end);
    memcpy(described.segment_hash, e->segment_hash, sizeof e->segment_hash);
    STP_TRY(stp_lost_blocks_describe(d, &described, err));
    *e = described;
done:
    free(payload);
    return status;
}

/* How well an entry of a damaged page agrees with its payload. */
typedef enum fit {
    FIT_NOT,
    FIT_PAYLOAD, /* the payload is the entry's */
    FIT_EXACT    /* and every field that follows from the payload is right, to the byte */
} fit;

/* Takes the entry in `bytes` as d->entries[id] if its payload matches it. */
static stp_status try_entry(stp_damaged *d, uint32_t id, const uint8_t *bytes, fit *out,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    uint8_t described[STP_ENTRY_BYTES];
    int sound = 0;
    *out = FIT_NOT;
    if (stp_entry_read(bytes, id, &d->header, &d->entries[id], NULL) != STP_OK)
        return STP_OK;
    STP_TRY(count_sound(d, &d->entries[id], &sound, err));
    if (sound < STP_SEGMENT_COUNT)
        return STP_OK;
    stp_status decoded = stp_damaged_chunk(d, id, 0, &chunk, err);
    if (decoded == STP_CORRUPT) { /* the one flag that decoding needs may be wrong */
        d->entries[id].flags ^= STP_CHUNK_LINKED;
        decoded = stp_damaged_chunk(d, id, 0, &chunk, err);
    }
    if (decoded != STP_OK) {
        status = decoded == STP_CORRUPT || decoded == STP_UNSUPPORTED ? STP_OK : decoded;
        goto done;
    }
    STP_TRY(describe(d, &d->entries[id], chunk, err));
    stp_entry_write(&d->entries[id], described);
    *out = memcmp(described, bytes, sizeof described) == 0 ? FIT_EXACT : FIT_PAYLOAD;
done:
    stp_chunk_destroy(&chunk);
    return status;
}

/* Tries the entries of damaged pages. fits: by id. */
static stp_status try_entries(stp_damaged *d, fit *fits, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t bytes[STP_ENTRY_BYTES];
    for (uint32_t id = 0; id < d->header.chunk_count; id++) {
        uint64_t at = entry_offset(d, id);
        if (d->known[id] || !stp_range_inside(at, sizeof bytes, d->file_bytes))
            continue;
        STP_TRY(stp_damaged_read(d, at, bytes, sizeof bytes, err));
        STP_TRY(try_entry(d, id, bytes, &fits[id], err));
    }
done:
    return status;
}

/* ---- places that the tree proves ---- */

static bool lists(const stp_chunk_entry *parent, uint32_t child)
{
    return child >= parent->first_child && child - parent->first_child < parent->child_count;
}

static stp_status joins(const stp_damaged *d, uint32_t parent_id, const stp_chunk *parent,
                        uint32_t id, const stp_chunk *chunk, bool *out, stp_error *err)
{
    const char *fault = NULL;
    uint32_t patch = 0;
    const stp_chunk_entry *above = &d->entries[parent_id];
    stp_status status = stp_verify_join(parent, above, id - above->first_child, chunk,
                                        &d->entries[id], &fault, &patch, err);
    *out = status == STP_OK && !fault;
    return status;
}

static bool is_whole(const stp_damaged *d, const fit *fits, uint32_t id)
{
    return fits[id] != FIT_NOT || (d->known[id] && d->finest[id] == 0);
}

/* What joints with other chunks prove of an entry's origin. Only the entry itself stores the
 * origin. */
typedef struct place {
    bool proven, refuted;
    uint32_t strange; /* the parent that has the chunk elsewhere, or STP_CHUNK_NONE */
} place;

/* If a chunk's samples are where its parent or its children have them, both places are proved. */
static stp_status prove_children(stp_damaged *d, const fit *fits, place *places, uint32_t parent,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *e = &d->entries[parent];
    stp_chunk *above = NULL, *chunk = NULL;
    for (uint32_t id = e->first_child; id < e->first_child + e->child_count; id++) {
        bool joined = false;
        if ((fits[id] == FIT_NOT && fits[parent] == FIT_NOT) || !is_whole(d, fits, id))
            continue;
        if (!above)
            STP_TRY(stp_damaged_chunk(d, parent, 0, &above, err));
        STP_TRY(stp_damaged_chunk(d, id, 2, &chunk, err));
        STP_TRY(joins(d, parent, above, id, chunk, &joined, err));
        stp_chunk_destroy(&chunk);
        places[id].strange = joined ? STP_CHUNK_NONE : parent;
        if (!joined)
            continue;
        places[id].proven = places[parent].proven = true;
        if (fits[id] != FIT_NOT) {
            d->entries[id].parent = parent;
            d->entries[id].depth = (uint8_t)(e->depth + 1u);
        }
    }
done:
    stp_chunk_destroy(&above);
    stp_chunk_destroy(&chunk);
    return status;
}

/* If the file is one chunk, the header's box must be the box of its points. */
static stp_status prove_single(const stp_damaged *d, place *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    stp_dbox box = stp_dbox_empty();
    STP_TRY(stp_damaged_chunk(d, 0, 0, &chunk, err));
    stp_chunk_box(chunk, d->entries[0].origin, &box);
    const stp_dbox *should = &d->header.box;
    out->proven = box.min.x == should->min.x && box.min.y == should->min.y &&
                  box.min.z == should->min.z && box.max.x == should->max.x &&
                  box.max.y == should->max.y && box.max.z == should->max.z;
    out->refuted = !out->proven;
done:
    stp_chunk_destroy(&chunk);
    return status;
}

/* If a parent and a child do not join, one of them is wrong: the one that nothing else proves. If
 * nothing proves either, blames the parent, because it can be rebuilt. */
static void blame(place *places, uint32_t count)
{
    for (uint32_t id = 1; id < count; id++) {
        uint32_t parent = places[id].strange;
        if (parent == STP_CHUNK_NONE)
            continue;
        if (places[parent].proven)
            places[id].refuted = !places[id].proven;
        else
            places[parent].refuted = true;
    }
}

/* Whether a chunk's patch vertices lie in the file's box: the only test of a place that nothing
 * proves. */
static stp_status lies_inside(const stp_damaged *d, uint32_t id, bool *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    const stp_dbox *box = &d->header.box;
    STP_TRY(stp_damaged_chunk(d, id, 2, &chunk, err));
    *out = true;
    for (uint32_t p = 0; p < chunk->patch_count && !d->header_rebuilt; p++) {
        const stp_sample *sample = &chunk->samples[STP_LEVEL_COUNT - 1][p];
        double room = stp_sample_radius(sample, &chunk->patches[p]);
        stp_dvec3 at =
            stp_dvec3_add(d->entries[id].origin, stp_sample_position(sample, &chunk->patches[p]));
        *out &= at.x >= box->min.x - room && at.x <= box->max.x + room;
        *out &= at.y >= box->min.y - room && at.y <= box->max.y + room;
        *out &= at.z >= box->min.z - room && at.z <= box->max.z + room;
    }
done:
    stp_chunk_destroy(&chunk);
    return status;
}

/* told: by id, set if an entry is taken although nothing proves its place. */
static stp_status prove(stp_damaged *d, const fit *fits, bool *told, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = d->header.chunk_count;
    place *places = NULL;
    STP_TRY(stp_alloc(&places, count, sizeof *places, "directory", err));
    for (uint32_t id = 0; id < count; id++)
        places[id].strange = STP_CHUNK_NONE;
    for (uint32_t id = 0; id < count; id++)
        if (is_whole(d, fits, id) && d->entries[id].child_count > 0)
            STP_TRY(prove_children(d, fits, places, id, err));
    if (count == 1 && fits[0] != FIT_NOT)
        STP_TRY(prove_single(d, &places[0], err));
    blame(places, count);
    for (uint32_t id = 0; id < count; id++) {
        bool exact = fits[id] == FIT_EXACT && !places[id].refuted;
        if (exact && !places[id].proven)
            STP_TRY(lies_inside(d, id, &exact, err));
        if (fits[id] != FIT_NOT && (places[id].proven || exact)) {
            d->known[id] = true;
            d->finest[id] = 0;
            told[id] = !places[id].proven;
        }
    }
done:
    free(places);
    return status;
}

/* ---- payloads without an entry ---- */

typedef struct gap {
    uint64_t begin, end;
} gap;

static int compare_gaps(const void *a, const void *b)
{
    const gap *x = a, *y = b;
    return x->begin < y->begin ? -1 : x->begin > y->begin;
}

/* Finds the bytes between the payloads of known chunks. *gaps must have room for one more than
 * there are chunks. */
static size_t find_gaps(const stp_damaged *d, gap *gaps)
{
    const uint64_t end = stp_payloads_end(&d->header);
    const uint64_t limit = end < d->file_bytes ? end : d->file_bytes;
    size_t taken = 0, count = 0;
    for (uint32_t id = 0; id < d->header.chunk_count; id++)
        if (d->known[id])
            gaps[taken++] =
                (gap){d->entries[id].offset,
                      d->entries[id].offset + d->entries[id].segment_end[STP_SEGMENT_COUNT - 1]};
    qsort(gaps, taken, sizeof *gaps, compare_gaps);
    uint64_t at = stp_header_span(&d->header);
    for (size_t i = 0; i <= taken; i++) {
        gap next = i < taken ? gaps[i] : (gap){limit, limit};
        if (next.begin > at && next.begin <= limit)
            gaps[count++] = (gap){at, next.begin}; /* at most as many as were read */
        at = next.end > at ? next.end : at;
    }
    return count;
}

/* The parent that lists an unknown chunk and has its patch vertices; STP_CHUNK_NONE if there is
 * none. */
static uint32_t listing_parent(const stp_damaged *d, uint32_t id)
{
    for (uint32_t p = 0; p < id; p++)
        if (d->known[p] && d->finest[p] == 0 && lists(&d->entries[p], id))
            return p;
    return STP_CHUNK_NONE;
}

/* The origin that puts the chunk's first patch vertex, in world order, where the parent's first
 * sample is. */
static stp_dvec3 tell_origin(const stp_chunk *parent, stp_dvec3 parent_origin, uint32_t child,
                             const stp_chunk *chunk)
{
    stp_dvec3 above = {INFINITY, INFINITY, INFINITY}, below = above;
    for (uint32_t p = 0; p < parent->patch_count; p++)
        for (uint32_t i = parent->level_begin[0][p];
             parent->patches[p].child == child && i < parent->level_begin[0][p + 1]; i++) {
            stp_dvec3 at = stp_dvec3_add(
                parent_origin, stp_sample_position(&parent->samples[0][i], &parent->patches[p]));
            above = stp_found_before(at, above) ? at : above;
        }
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        stp_dvec3 at =
            stp_sample_position(&chunk->samples[STP_LEVEL_COUNT - 1][p], &chunk->patches[p]);
        below = stp_found_before(at, below) ? at : below;
    }
    return stp_dvec3_sub(above, below);
}

/* An origin is the rounded middle of a box. Gives its zeros the sign of that middle. */
static stp_dvec3 sign_zeros(const stp_chunk_entry *e)
{
    stp_dvec3 o = e->origin;
    o.x = o.x == 0.0 ? copysign(0.0, (double)e->box_min.x + (double)e->box_max.x) : o.x;
    o.y = o.y == 0.0 ? copysign(0.0, (double)e->box_min.y + (double)e->box_max.y) : o.y;
    o.z = o.z == 0.0 ? copysign(0.0, (double)e->box_min.z + (double)e->box_max.z) : o.z;
    return o;
}

/* Judges a found payload, which may itself be damaged, by the checksums left in the entry. If some
 * match, the entry was not wiped, and a segment that does not match is lost. If none matches,
 * nothing proves the payload. */
static stp_status judge_payload(stp_damaged *d, uint32_t id, bool *told, stp_error *err)
{
    stp_chunk_entry *e = &d->entries[id];
    uint8_t bytes[STP_ENTRY_BYTES];
    stp_status status = stp_damaged_read(d, entry_offset(d, id), bytes, sizeof bytes, err);
    int sound = 0, matching = 0;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        uint64_t hash = stp_get_u64(bytes + 24 + 8 * s);
        bool matches = hash == e->segment_hash[s];
        sound += sound == s && (matches || hash == 0); /* a zero hash: a wiped place */
        matching += matches;
    }
    told[id] = matching < STP_SEGMENT_COUNT;
    d->known[id] = true;
    d->finest[id] = (uint8_t)(matching == 0 ? 0 : STP_SEGMENT_COUNT - sound);
    if (d->finest[id] != 0)
        stp_damaged_say(d, "chunk %" PRIu32 ": its segment %d is lost", id, sound);
    return status;
}

/* Takes the payload at the gap's begin as chunk id's, if it decodes and lies where its parent has
 * it. */
static stp_status try_payload(stp_damaged *d, uint32_t id, uint32_t parent, gap *g, bool *found,
                              bool *told, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *above = NULL, *chunk = NULL;
    const stp_chunk_entry *p = &d->entries[parent];
    stp_chunk_entry e = {.offset = g->begin,
                         .parent = parent,
                         .first_child = STP_CHUNK_NONE,
                         .codec = p->codec, /* a writer uses one codec for a file */
                         .depth = (uint8_t)(p->depth + 1u)};
    uint32_t vertices = 0, child = id - p->first_child;
    *found = false;
    STP_TRY(stp_damaged_chunk(d, parent, 0, &above, err));
    for (uint32_t i = 0; i < above->patch_count; i++)
        vertices += above->patches[i].child == child ? above->patches[i].counts[0] : 0u;
    STP_TRY(stp_found_payload(d, g->end, vertices, &e, &chunk, err));
    if (!chunk)
        goto done;
    e.points_under = chunk->level_begin[0][chunk->patch_count];
    e.origin = tell_origin(above, p->origin, child, chunk);
    STP_TRY(describe(d, &e, chunk, err));
    e.origin = sign_zeros(&e);
    d->entries[id] = e;
    STP_TRY(joins(d, parent, above, id, chunk, found, err));
    if (!*found)
        goto done;
    g->begin += e.segment_end[STP_SEGMENT_COUNT - 1];
    STP_TRY(judge_payload(d, id, told, err));
done:
    stp_chunk_destroy(&above);
    stp_chunk_destroy(&chunk);
    return status;
}

/* Marks the chunks that some chunk names as its parent: they are no leaves. */
static void mark_parents(const stp_damaged *d, bool *inner)
{
    for (uint32_t id = 1; id < d->header.chunk_count; id++)
        if (d->known[id] && d->entries[id].parent < d->header.chunk_count)
            inner[d->entries[id].parent] = true;
}

/* Fills the gaps with leaves, one after the other in the order of ids. */
static stp_status fill_gaps(stp_damaged *d, gap *gaps, size_t gap_count, const bool *inner,
                            bool *told, stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t i = 0; i < gap_count; i++) {
        bool found = true;
        while (found && gaps[i].begin < gaps[i].end) {
            found = false;
            for (uint32_t id = 1; id < d->header.chunk_count && !found; id++) {
                uint32_t parent =
                    d->known[id] || inner[id] ? STP_CHUNK_NONE : listing_parent(d, id);
                if (parent != STP_CHUNK_NONE)
                    STP_TRY(try_payload(d, id, parent, &gaps[i], &found, told, err));
                if (found)
                    stp_damaged_say(d,
                                    "chunk %" PRIu32 ": its directory entry is rebuilt from its "
                                    "payload",
                                    id);
            }
        }
    }
done:
    return status;
}

/* Whether a partly sound chunk lies where its parent has it or, if no parent can tell, where it may
 * lie. False if the payload does not decode. */
static stp_status has_place(const stp_damaged *d, uint32_t id, bool *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *above = NULL, *chunk = NULL;
    uint32_t parent = listing_parent(d, id);
    *out = false;
    stp_status decoded = stp_damaged_chunk(d, id, 2, &chunk, err);
    if (decoded != STP_OK)
        return decoded == STP_CORRUPT || decoded == STP_UNSUPPORTED ? STP_OK : decoded;
    if (parent == STP_CHUNK_NONE) {
        STP_TRY(lies_inside(d, id, out, err));
    } else {
        STP_TRY(stp_damaged_chunk(d, parent, 0, &above, err));
        STP_TRY(joins(d, parent, above, id, chunk, out, err));
    }
done:
    stp_chunk_destroy(&above);
    stp_chunk_destroy(&chunk);
    return status;
}

/* Takes entries with partly sound payloads, if nothing better was found. */
static stp_status take_partial(stp_damaged *d, bool *told, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t bytes[STP_ENTRY_BYTES];
    for (uint32_t id = 0; id < d->header.chunk_count; id++) {
        stp_chunk_entry *e = &d->entries[id];
        int sound = 0;
        bool placed = false;
        if (d->known[id])
            continue;
        STP_TRY(stp_damaged_read(d, entry_offset(d, id), bytes, sizeof bytes, err));
        if (stp_entry_read(bytes, id, &d->header, e, NULL) != STP_OK)
            continue;
        STP_TRY(count_sound(d, e, &sound, err));
        if (sound > 0 && sound < STP_SEGMENT_COUNT) /* a wholly sound one was refuted */
            STP_TRY(has_place(d, id, &placed, err));
        if (!placed)
            continue;
        d->known[id] = told[id] = true;
        d->finest[id] = (uint8_t)(STP_SEGMENT_COUNT - sound);
        stp_damaged_say(d, "chunk %" PRIu32 ": its segment %d is lost", id, sound);
    }
done:
    return status;
}

/* ---- pages ---- */

/* A matching checksum proves everything that the entries say, payloads included. */
static stp_status mend_page(stp_damaged *d, uint32_t page, uint8_t *bytes, size_t hashed,
                            bool *told, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t at = stp_page_offset(&d->header, page);
    uint8_t stored[STP_HASH_BYTES] = {0};
    if (stp_range_inside(at + hashed, sizeof stored, d->file_bytes))
        STP_TRY(stp_damaged_read(d, at + hashed, stored, sizeof stored, err));
    stp_put_u64(bytes + hashed, stp_hash(bytes, hashed));
    bool proven = memcmp(stored, bytes + hashed, sizeof stored) == 0;
    for (uint32_t i = 0; proven && i < stp_page_entry_count(&d->header, page); i++)
        told[page * STP_PAGE_ENTRIES + i] = false;
    STP_TRY(stp_damaged_mend(d, at, bytes, hashed + STP_HASH_BYTES, err));
    stp_damaged_say(d, "directory page %" PRIu32 " is rebuilt%s", page,
                    proven ? "; its checksum proves it" : "");
done:
    return status;
}

/* Records of blocks follow the chunks' ids: tells entries of damaged pages which are theirs. */
static void number_blocks(stp_damaged *d, const bool *was_known)
{
    uint32_t next = 0;
    for (uint32_t id = 0; id < d->header.chunk_count && d->known[id]; id++) {
        if (!was_known[id])
            d->entries[id].first_block = next;
        next = d->entries[id].first_block + d->entries[id].block_count;
    }
}

/* Writes the damaged pages whose entries are all known. */
static stp_status mend_pages(stp_damaged *d, const bool *was_known, bool *told, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t bytes[STP_PAGE_ENTRIES * STP_ENTRY_BYTES + STP_HASH_BYTES];
    for (uint32_t page = 0; page < stp_page_count(&d->header); page++) {
        uint32_t first = page * STP_PAGE_ENTRIES, count = stp_page_entry_count(&d->header, page);
        size_t hashed = (size_t)count * STP_ENTRY_BYTES;
        bool complete = !was_known[first] && d->header.entry_bytes == STP_ENTRY_BYTES;
        for (uint32_t i = 0; i < count; i++) {
            complete &= d->known[first + i] && d->finest[first + i] == 0;
            stp_entry_write(&d->entries[first + i], bytes + (size_t)i * STP_ENTRY_BYTES);
        }
        if (!complete)
            continue;
        STP_TRY(mend_page(d, page, bytes, hashed, told, err));
    }
done:
    return status;
}

stp_status stp_lost_entries_find(stp_damaged *d, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = d->header.chunk_count;
    fit *fits = NULL;
    bool *was_known = NULL, *inner = NULL, *told = NULL;
    gap *gaps = NULL;
    STP_TRY(stp_alloc(&fits, count, sizeof *fits, "directory", err));
    STP_TRY(stp_alloc(&was_known, count, sizeof *was_known, "directory", err));
    STP_TRY(stp_alloc(&told, count, sizeof *told, "directory", err));
    STP_TRY(stp_alloc(&inner, count, sizeof *inner, "directory", err));
    STP_TRY(stp_alloc(&gaps, (size_t)count + 1, sizeof *gaps, "directory", err));
    memcpy(was_known, d->known, count * sizeof *was_known);
    STP_TRY(try_entries(d, fits, err));
    STP_TRY(prove(d, fits, told, err));
    mark_parents(d, inner);
    STP_TRY(fill_gaps(d, gaps, find_gaps(d, gaps), inner, told, err));
    STP_TRY(take_partial(d, told, err));
    number_blocks(d, was_known);
    STP_TRY(mend_pages(d, was_known, told, err));
    for (uint32_t id = 0; id < count; id++)
        d->entries_told += told[id];
    if (d->entries_told > 0)
        stp_damaged_say(d,
                        "%" PRIu32 " directory entries are taken though no checksum proves them: "
                        "they agree with their payloads",
                        d->entries_told);
done:
    free(fits);
    free(was_known);
    free(inner);
    free(told);
    free(gaps);
    return status;
}
