/* The processes that prepare one model together, called ranks as MPI calls them.
 *
 * Each rank reads a part of the points, sorts a run of them (cloud_parts.h), and owns it from there
 * on (cloud_blocks.h). All ranks run the same stages and decide alike: each finds what concerns its
 * own points, and gives to all what concerns all. Rank 0 alone writes the model.
 * The functions here do nothing if ranks is NULL: a process is alone unless mpirun started several
 * (meeting.h). All ranks call the
 * same functions in the same order. Threads: the main thread only. */
#ifndef STP_PREPROCESS_RANKS_RANKS_H
#define STP_PREPROCESS_RANKS_RANKS_H

#include "base/progress.h"
#include "formats/chunk/codec/table/column.h"

/* The longest name of a machine, with its terminating zero. */
#define STP_HOST_BYTES 64

typedef struct stp_ranks stp_ranks;
struct stp_ranks {
    unsigned self, count;         /* self in [0, count) */
    const char *const *names;     /* by rank, for messages: "rank 1 on node07" */
    const stp_progress *progress; /* whoever waits gives up when it says so; NULL: never */
    uint64_t sent_bytes; /* by all ranks so far, as rank 0 knows; a copy to each rank counts */

    /* Gives rank `from`'s bytes to every rank. Errors: IO, CANCELLED. */
    stp_status (*broadcast)(stp_ranks *ranks, unsigned from, void *data, size_t bytes,
                            stp_error *err);
    /* Gives rank `from`'s bytes to rank `to`, another one; only these two call it. */
    stp_status (*send)(stp_ranks *ranks, unsigned from, unsigned to, void *data, size_t bytes,
                       stp_error *err);
    /* stp_ranks_exchange, when it is known what comes. */
    stp_status (*exchange)(stp_ranks *ranks, const void *data, const size_t *sent, void *out,
                           const size_t *received, stp_error *err);
    /* Waits for all ranks and ends what connects them. Errors: likewise. */
    stp_status (*finish)(stp_ranks *ranks, stp_error *err);
    /* Ends all processes. */
    void (*abort_all)(int code);
};

/* What one rank does of things in a row. */
typedef struct stp_rank_part {
    uint64_t begin, end;
} stp_rank_part;

static inline bool stp_ranks_is_first(const stp_ranks *ranks)
{
    return !ranks || ranks->self == 0;
}

static inline unsigned stp_ranks_count(const stp_ranks *ranks)
{
    return ranks ? ranks->count : 1;
}

/* The part of `count` things that a rank does; this rank's own. */
stp_rank_part stp_ranks_part(const stp_ranks *ranks, unsigned rank, uint64_t count);
stp_rank_part stp_ranks_own(const stp_ranks *ranks, uint64_t count);
/* The rank that has an item, if rank r has those from begins[r] on, and one of them has it. */
unsigned stp_ranks_find(const stp_ranks *ranks, const uint64_t *begins, uint64_t item);

/* Gives bytes of rank `from` to every rank. The others' data, as long, are replaced. */
stp_status stp_ranks_broadcast(stp_ranks *ranks, unsigned from, void *data, size_t bytes,
                               stp_error *err);
/* The same for bytes whose number only rank `from` knows. */
stp_status stp_ranks_broadcast_bytes(stp_ranks *ranks, unsigned from, stp_bytes *bytes,
                                     stp_error *err);
/* Gives each rank's part (stp_ranks_part) of an array of `count` items to every rank. */
stp_status stp_ranks_share(stp_ranks *ranks, void *array, uint64_t count, size_t size,
                           stp_error *err);
/* Gives bytes of rank `from`, which is not 0, to rank 0. The other ranks do nothing. */
stp_status stp_ranks_send_bytes(stp_ranks *ranks, unsigned from, stp_bytes *bytes, stp_error *err);

/* Gives each rank a part of `data`, which has the parts rank after rank: sent[r] bytes for rank r.
 * Puts what comes into out, rank after rank, and its bytes into received[]. At most 2^31 - 1 bytes
 * each way. The caller counts them in sent_bytes. */
stp_status stp_ranks_exchange(stp_ranks *ranks, const void *data, const size_t *sent, void *out,
                              size_t *received, stp_error *err);

/* stp_ranks_exchange into bytes that grow as needed. Errors: likewise, and OUT_OF_MEMORY. */
stp_status stp_ranks_exchange_bytes(stp_ranks *ranks, const void *data, const size_t *sent,
                                    stp_bytes *out, size_t *received, stp_error *err);

/* Puts `bytes` of each rank into out, rank after rank, on every rank. */
stp_status stp_ranks_gather(stp_ranks *ranks, const void *own, size_t bytes, void *out,
                            stp_error *err);
/* Replaces bytes by those of all ranks, rank after rank. Errors: likewise, and OUT_OF_MEMORY. */
stp_status stp_ranks_join(stp_ranks *ranks, stp_bytes *bytes, stp_error *err);
/* Adds up numbers of all ranks, each number by itself. */
stp_status stp_ranks_sum(stp_ranks *ranks, uint64_t *numbers, size_t count, stp_error *err);

/* Gives each item, of `size` bytes, to the rank that rank_of names; what comes replaces the items:
 * rank after rank, those of a rank in its order. Errors: likewise, and OUT_OF_MEMORY. */
typedef unsigned stp_rank_of_item(const void *context, const void *item);
stp_status stp_ranks_deal(stp_ranks *ranks, stp_bytes *items, size_t size,
                          stp_rank_of_item *rank_of, const void *context, stp_error *err);
/* Asks other ranks for things by number, rank after rank: counts[r] of rank r. `answer` packs one
 * that this rank has. Replaces *in by the answers, in order. Errors: likewise. */
typedef stp_status stp_rank_answer(const void *context, uint64_t number, stp_bytes *out,
                                   stp_error *err);
stp_status stp_ranks_ask(stp_ranks *ranks, const uint64_t *numbers, const size_t *counts,
                         stp_rank_answer *answer, const void *context, stp_bytes *in,
                         stp_error *err);

/* Fails on every rank if they have other numbers than rank 0. what: is said of the first
 * that has: "other points than". Errors: INVALID_ARGUMENT, CANCELLED. */
stp_status stp_ranks_agree(stp_ranks *ranks, uint64_t number, const char *what, stp_error *err);

/* Reads `size` bytes of a packet into out, which may be NULL if size is 0. Errors: INTERNAL. */
stp_status stp_packet_take(stp_cursor *from, void *out, size_t size, stp_error *err);
/* The same into new memory. Errors: OUT_OF_MEMORY, INTERNAL. */
stp_status stp_packet_take_array(stp_cursor *from, void *out, size_t count, size_t size,
                                 stp_error *err);

#endif
