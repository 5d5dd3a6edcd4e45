/* A damaged chunk file as far as it can be read: flipped bits are put back, structures rebuilt, and
 * what is still unreadable is marked.
 *
 * The file is never written to: mended bytes lie over it in memory. Threads: one. */
#ifndef STP_FORMATS_CHUNK_REPAIR_DAMAGED_H
#define STP_FORMATS_CHUNK_REPAIR_DAMAGED_H

#include "formats/chunk/layout.h"
#include "formats/chunk/repair/repair.h"

/* Bytes that replace the file's. */
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
    stp_mend *mends;     /* later mends lie over earlier ones */
    size_t mend_count, mend_capacity;
    stp_header header;
    bool header_rebuilt;      /* from the directory */
    bool header_told;         /* rebuilt without a proof */
    uint32_t entries_told;    /* directory entries taken or rebuilt without a proof */
    char *metadata;           /* ends in a zero byte */
    bool metadata_lost;       /* metadata holds the damaged bytes as found */
    bool sections_lost;       /* a section, or records of blocks, cannot be mended */
    uint8_t *table;           /* the records of a packed table of blocks; NULL: not read, or lost */
    stp_chunk_entry *entries; /* by id */
    bool *known;              /* by id: whether the entry is known */
    uint8_t *finest;          /* by id: finest level that can be read, or STP_NOTHING_READABLE */
} stp_damaged;

/* Opens the file and mends what can be mended without loss. Errors: those of stp_chunk_file_repair.
 */
stp_status stp_damaged_open(stp_damaged *out, const char *path, const stp_repair_params *params,
                            stp_error *err);
void stp_damaged_close(stp_damaged *d);

/* Adds a line to the report. */
void stp_damaged_say(const stp_damaged *d, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Reads the file with its mends; zeros beyond the end of a cut file. Errors: IO. */
stp_status stp_damaged_read(const stp_damaged *d, uint64_t offset, void *bytes, size_t size,
                            stp_error *err);
/* Lays a copy of the bytes over the file's. Errors: OUT_OF_MEMORY. */
stp_status stp_damaged_mend(stp_damaged *d, uint64_t offset, const void *bytes, size_t size,
                            stp_error *err);
/* The checksum of some bytes. follows: the checksum stands behind the bytes in the file, so it may
 * itself be damaged. */
typedef struct stp_hash_place {
    uint64_t value, mask; /* mask: bits of the value that are known */
    bool follows;
} stp_hash_place;

/* Finds the flipped bit of `size` checked bytes (and of the hash, if it follows them), puts it back
 * in the file's mends and in `bytes`, and reports it. *mended: a bit was found. Errors:
 * OUT_OF_MEMORY, CANCELLED. */
stp_status stp_damaged_mend_bit(stp_damaged *d, uint64_t offset, uint8_t *bytes, size_t size,
                                stp_hash_place hash, const char *what, bool *mended,
                                stp_error *err);

/* Reads bytes under a checksum into *bytes (free with free(); a zero byte follows them), and mends
 * a flipped bit. mask: bits of the hash that are known. *sound: they are as the checksum says.
 * *bytes is empty if they lie beyond the file's end. Errors: IO, OUT_OF_MEMORY, CANCELLED. */
stp_status stp_damaged_read_checked(stp_damaged *d, uint64_t offset, size_t size, uint64_t hash,
                                    uint64_t mask, const char *what, uint8_t **bytes, bool *sound,
                                    stp_error *err);

/* Decodes a chunk whose entry is known. Does not compare checksums. Errors: IO, CORRUPT,
 * UNSUPPORTED, OUT_OF_MEMORY. */
stp_status stp_damaged_chunk(const stp_damaged *d, uint32_t id, int finest_level, stp_chunk **out,
                             stp_error *err);

#endif
