/* Chunks on their way from the file to the GPU: threads that read payloads and threads that decode
 * them, so that the render thread does neither.
 *
 * A load goes through these states: QUEUED (wanted, nothing done) - FETCHING (a reader reads it) -
 * FETCHED (its payload is in memory) - PLACED (the render thread said where it goes) - DECODING -
 * DONE (it stands where it goes) or FAILED. The render thread takes FETCHED and DONE loads when it
 * has time; it never waits but in stp_stream_wait.
 * Bounds: STP_STREAM_LOADS_LIMIT loads beyond QUEUED, STP_STREAM_WANTS_LIMIT queued, payloads in a
 * store of fixed size. What is no longer wanted is not begun; what was read stays in the store.
 * Threads: the render thread calls; readers and decoders are the stream's own. */
#ifndef STP_RUNTIME_STREAM_STREAM_H
#define STP_RUNTIME_STREAM_STREAM_H

#include "runtime/cut/level_choice.h"
#include "runtime/cut/scene.h"
#include "runtime/stream/object_texture.h"
#include "runtime/stream/payload_store.h"

#define STP_STREAM_LOADS_LIMIT 32
#define STP_STREAM_WANTS_LIMIT 1024
/* Reads in flight at most, whatever the sources are. */
#define STP_STREAM_READERS_LIMIT 8

/* One chunk, wanted down to a level. */
typedef struct stp_want {
    uint32_t chunk;
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

/* Where a chunk is decoded to. */
typedef struct stp_load_place {
    stp_placement placement; /* in the Object Texture */
    uint32_t slot;
    stp_range piece; /* of the upload ring */
    uint8_t *memory; /* the piece's: samples, then the numbers of their patches, then patches */
} stp_load_place;

/* Offsets in a piece, bytes. */
uint64_t stp_load_numbers_offset(const stp_placement *placement);
uint64_t stp_load_patches_offset(const stp_placement *placement);
uint64_t stp_load_bytes(const stp_placement *placement);

typedef struct stp_load {
    stp_load_state state;
    stp_want want;
    unsigned rank;     /* the less the earlier it is taken; STP_STREAM_WANTS_LIMIT: not asked for */
    bool dropped;      /* it was not asked for for a while: if reading fails, that is old news */
    stp_range payload; /* in the store, pinned while not FREE; empty: it found no memory */
    stp_load_place place;
    /* When DONE; who takes the load owns these. */
    stp_gpu_patch *patches;
    stp_patch_brief *briefs;
    stp_error error; /* when FAILED */
} stp_load;

typedef struct stp_stream stp_stream;

typedef struct stp_stream_params {
    const stp_scene *scene; /* borrowed; outlives the stream */
    uint64_t payload_bytes; /* for payloads */
    unsigned decoder_count; /* at least 1 */
    /* Called from a thread when a load is FETCHED, DONE or FAILED; must not call back; may be NULL.
     */
    void (*wake)(void *);
    void *wake_context;
} stp_stream_params;

/* Errors: OUT_OF_MEMORY, LIMIT (no threads). */
stp_status stp_stream_create(stp_stream **out, const stp_stream_params *params, stp_error *err);
/* Waits for what is being decoded; reads under way are interrupted, also those of others that share
 * a model. */
void stp_stream_destroy(stp_stream **stream);

/* What is wanted now, most wanted first: replaces the queue, of which no more than
 * STP_STREAM_WANTS_LIMIT are kept. Loads that are FETCHED and no longer wanted are dropped. */
void stp_stream_want(stp_stream *stream, const stp_want *wants, size_t count);

/* The most wanted FETCHED load, or NULL. */
stp_load *stp_stream_next_fetched(stp_stream *stream);
/* The load of a chunk that is FETCHED, DONE or FAILED, or NULL. */
stp_load *stp_stream_find(stp_stream *stream, uint32_t chunk);
/* Decodes a FETCHED load. */
void stp_stream_decode(stp_stream *stream, stp_load *load, const stp_load_place *place);
/* A load that is DONE or FAILED, or NULL. */
stp_load *stp_stream_next_done(stp_stream *stream);
/* Ends a load that is FETCHED, DONE or FAILED. */
void stp_stream_release(stp_stream *stream, stp_load *load);

/* How often a load became FETCHED, DONE or FAILED so far. */
uint64_t stp_stream_news_count(stp_stream *stream);
/* Waits until that is no longer `seen`; returns at once where nothing is under way. */
void stp_stream_wait(stp_stream *stream, uint64_t seen);
/* Loads and wants under way. */
size_t stp_stream_pending(stp_stream *stream);
/* Whether a load waits for the render thread. */
bool stp_stream_has_news(stp_stream *stream);
uint64_t stp_stream_bytes_read(stp_stream *stream);

#endif
