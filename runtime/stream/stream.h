/* Brings blocks from the file to the GPU: some threads read payloads, others decode them, so the
 * render thread does neither.
 *
 * A load passes through these states:
 *   QUEUED    wanted, nothing done yet
 *   FETCHING  a reader reads the payload
 *   FETCHED   the payload is in memory
 *   PLACED    the render thread has said where the block goes
 *   DECODING  a decoder works on it
 *   DONE      the decoded block is in its place; or FAILED
 * The render thread takes FETCHED and DONE loads when it has time. It waits only in
 * stp_stream_wait. Limits: STP_STREAM_LOADS_LIMIT loads beyond QUEUED, STP_STREAM_WANTS_LIMIT
 * queued, and a payload store of fixed size. A load that is no longer wanted is not begun; if a
 * server takes long to send it, the read is given up. Payloads that were read stay in the store.
 * Threads: the render thread calls; readers and decoders belong to the stream. */
#ifndef STP_RUNTIME_STREAM_STREAM_H
#define STP_RUNTIME_STREAM_STREAM_H

#include "runtime/cut/level_choice.h"
#include "runtime/cut/scene.h"
#include "runtime/stream/cache/object_texture.h"
#include "runtime/stream/payload_store.h"
#include "runtime/stream/spots.h"

/* Reads join neighbours, which may be far less wanted and then wait for their turn. So there are
 * many more loads than reads in flight. */
#define STP_STREAM_LOADS_LIMIT 4096
#define STP_STREAM_WANTS_LIMIT 8192
/* At most so many reads are in flight, whatever the sources are: with STP_SOURCE_REQUEST_BYTES,
 * 2 MiB. */
#define STP_STREAM_READERS_LIMIT 16

/* One block, wanted down to a level. */
typedef struct stp_want {
    uint32_t block;
    int finest;
} stp_want;

typedef enum stp_load_state {
    STP_LOAD_FREE,
    STP_LOAD_FETCHING,
    STP_LOAD_FETCHED,
    STP_LOAD_PLACED,
    STP_LOAD_DECODING,
    STP_LOAD_DONE,
    STP_LOAD_FAILED
} stp_load_state;

/* How a block is seen, for the choice of its patches' levels (runtime/stream/cache/patch_levels.h).
 */
typedef struct stp_patch_view {
    stp_gpu_frame frame;
    stp_gpu_chunk record;
    bool ahead; /* the next view is somewhere near */
} stp_patch_view;

/* What the CPU keeps of a block on the GPU: arrays by patch. The cache lends the memory of patches,
 * briefs and records (runtime/stream/cache/patch_store.h). */
typedef struct stp_mirror {
    stp_mirror_patch *patches;
    stp_patch_brief *briefs;
    stp_square *squares; /* if level 0 is of squares of a grid; else NULL */
    stp_raster *rasters; /* of the squares */
    stp_spot *spots;     /* of wide patches; may be NULL */
    stp_gpu_patch *records;
} stp_mirror;

void stp_mirror_clear(stp_mirror *mirror);

/* Where the decoded block goes. */
typedef struct stp_load_place {
    stp_placement placement; /* in the Object Texture */
    stp_mirror mirror;       /* the memory lent */
    uint32_t slot;
    stp_range piece; /* of the upload ring */
    uint8_t *memory; /* of the piece: samples, then patches */
    uint32_t texels; /* of the place that the samples need, if DONE */
    /* By patch: only levels from this one on are kept; NULL: all that are wanted. If the patches
     * are not known yet, the stream lists them for view, if that is there. It frees both. */
    uint8_t *finest;
    stp_patch_view *view;
    uint32_t look; /* the view that the list is made for */
} stp_load_place;

typedef struct stp_load {
    stp_load_state state;
    stp_want want;
    unsigned rank;     /* lower ranks are taken first; STP_STREAM_WANTS_LIMIT: not asked for */
    bool dropped;      /* was not asked for at some time: a failed read is then old news */
    stp_range payload; /* in the store, pinned unless FREE; empty: there was no memory */
    stp_load_place place;
    stp_mirror mirror; /* if DONE; whoever takes the load owns it */
    stp_error error;   /* when FAILED */
} stp_load;

typedef struct stp_stream stp_stream;

typedef struct stp_stream_params {
    const stp_scene *scene; /* borrowed; outlives the stream */
    uint64_t payload_bytes; /* for payloads */
    unsigned decoder_count; /* at least 1 */
    /* Called from a stream thread when a load is FETCHED, DONE or FAILED. Must not call the stream.
     * May be NULL. */
    void (*wake)(void *);
    void *wake_context;
} stp_stream_params;

/* Errors: OUT_OF_MEMORY, LIMIT (no threads). */
stp_status stp_stream_create(stp_stream **out, const stp_stream_params *params, stp_error *err);
/* Waits for decoding to end. Interrupts reads, including those of other streams on the same
 * model. */
void stp_stream_destroy(stp_stream **stream);

/* Replaces the queue, most wanted first; keeps at most STP_STREAM_WANTS_LIMIT. Drops loads that are
 * FETCHED and no longer wanted. */
void stp_stream_want(stp_stream *stream, const stp_want *wants, size_t count);

/* The most wanted FETCHED load, or NULL. */
stp_load *stp_stream_next_fetched(stp_stream *stream);
/* The load of a block that is FETCHED, DONE or FAILED, or NULL. */
stp_load *stp_stream_find(stp_stream *stream, uint32_t block);
/* Decodes a FETCHED load. */
void stp_stream_decode(stp_stream *stream, stp_load *load, const stp_load_place *place);
/* A load that is DONE or FAILED, or NULL. */
stp_load *stp_stream_next_done(stp_stream *stream);
/* Ends a load that is FETCHED, DONE or FAILED. */
void stp_stream_release(stp_stream *stream, stp_load *load);

/* How often a load became FETCHED, DONE or FAILED so far. */
uint64_t stp_stream_news_count(stp_stream *stream);
/* Waits until stp_stream_news_count is not `seen`. Returns at once if nothing is under way. */
void stp_stream_wait(stp_stream *stream, uint64_t seen);
/* The number of loads and wants under way. */
size_t stp_stream_pending(stp_stream *stream);
/* Whether a load waits for the render thread. */
bool stp_stream_has_news(stp_stream *stream);
uint64_t stp_stream_bytes_read(stp_stream *stream);

#endif
