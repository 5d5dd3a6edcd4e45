/* A damaged chunk file as far as it can be read: bits put back, structures rebuilt, and what is
 * still unreadable marked.
 *
 * The file is never written to: what is mended lies over it in memory. Threads: one. */
#ifndef STP_FORMATS_CHUNK_REPAIR_DAMAGED_H
#define STP_FORMATS_CHUNK_REPAIR_DAMAGED_H

#include "formats/chunk/layout.h"
#include "formats/chunk/repair/repair.h"

/* Bytes that stand in place of the file's. */
typedef struct stp_mend {
    uint64_t offset;
    size_t size;
    uint8_t *bytes;
} stp_mend;

#define STP_NOTHING_READABLE 3

typedef struct stp_damaged {
    const char *path;
    const stp_repair_params *params;
    int descriptor;
    uint64_t file_bytes; /* as found */
    stp_mend *mends;     /* what is later lies over what is earlier */
    size_t mend_count, mend_capacity;
    stp_header header;
    bool header_rebuilt;      /* from the directory */
    bool header_told;         /* and without a proof */
    uint32_t entries_told;    /* directory entries taken or rebuilt without a proof */
    char *metadata;           /* ends in a zero byte */
    bool metadata_lost;       /* metadata is what was found */
    stp_chunk_entry *entries; /* by id */
    bool *known;              /* by id: the entry */
    uint8_t *finest;          /* by id: level that can be read, STP_NOTHING_READABLE */
} stp_damaged;

/* Opens and mends what can be without loss. Errors: those of stp_chunk_file_repair. */
stp_status stp_damaged_open(stp_damaged *out, const char *path, const stp_repair_params *params,
                            stp_error *err);
void stp_damaged_close(stp_damaged *d);

/* Says a line of the report. */
void stp_damaged_say(const stp_damaged *d, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Reads with what is mended; zeros where a cut file has nothing. Errors: IO. */
stp_status stp_damaged_read(const stp_damaged *d, uint64_t offset, void *bytes, size_t size,
                            stp_error *err);
/* Lays a copy of the bytes over the file's. Errors: OUT_OF_MEMORY. */
stp_status stp_damaged_mend(stp_damaged *d, uint64_t offset, const void *bytes, size_t size,
                            stp_error *err);
/* The checksum of some bytes, and whether it stands behind them in the file and so may itself be
 * what was damaged. */
typedef struct stp_hash_place {
    uint64_t value;
    bool follows;
} stp_hash_place;

/* Puts the flipped bit of size checked bytes (and the hash where it follows them) back, in the file
 * and in `bytes`, and says so. *mended: there was one. Errors: OUT_OF_MEMORY, CANCELLED. */
stp_status stp_damaged_mend_bit(stp_damaged *d, uint64_t offset, uint8_t *bytes, size_t size,
                                stp_hash_place hash, const char *what, bool *mended,
                                stp_error *err);

/* Decodes a chunk whose entry is known. Checksums are not looked at. Errors: IO, CORRUPT,
 * UNSUPPORTED, OUT_OF_MEMORY. */
stp_status stp_damaged_chunk(const stp_damaged *d, uint32_t id, int finest_level, stp_chunk **out,
                             stp_error *err);

#endif
