/* Which bytes of a payload hold what: positions, normals, and so on.
 *
 * Decoders count while they decode, if the scratch memory has an stp_shares. What they count adds
 * up to the payload. Draco: a stream of columns holds one kind of thing. Raw: by layout. zstd:
 * several planes share a frame, and each gets a part of the frame in proportion to the entropy of
 * its bytes (order 0). Threads: any; each thread needs shares of its own. */
#ifndef STP_FORMATS_CHUNK_CODEC_SHARES_H
#define STP_FORMATS_CHUNK_CODEC_SHARES_H

#include <stddef.h>
#include <stdint.h>

typedef enum stp_share {
    STP_SHARE_POSITIONS,
    STP_SHARE_NORMALS,
    STP_SHARE_RADII,
    STP_SHARE_COLOURS,
    STP_SHARE_INTENSITIES,
    STP_SHARE_CLASSES, /* and flags */
    STP_SHARE_PATCHES, /* patch headers: origins, counts, bounds, errors, links */
    STP_SHARE_FRAME,   /* all else: indices of blocks, heads of tables */
    STP_SHARE_COUNT
} stp_share;

typedef struct stp_shares {
    uint64_t bytes[STP_SHARE_COUNT];
} stp_shares;

/* Adds a table of samples of `bytes` in all, by the bytes of its columns (predict.h). */
void stp_shares_add_samples(stp_shares *shares, const uint64_t *column_bytes, uint64_t bytes);
/* Adds samples of codec 0, of `bytes` in all. */
void stp_shares_add_raw(stp_shares *shares, uint64_t bytes);

/* Costs of bytes that are packed together: each share gets a part of the bytes in proportion to its
 * cost. */
typedef struct stp_share_costs {
    double cost[STP_SHARE_COUNT];
} stp_share_costs;

/* Adds the entropy of a plane of bytes. */
void stp_share_costs_add(stp_share_costs *costs, stp_share share, const uint8_t *plane,
                         size_t count);
/* Divides `bytes` by the costs. */
void stp_shares_add_packed(stp_shares *shares, const stp_share_costs *costs, uint64_t bytes);

/* The share of a column of samples (predict.h), of a plane of samples (families.h). */
stp_share stp_share_of_column(unsigned column);
stp_share stp_share_of_plane(unsigned plane);

#endif
