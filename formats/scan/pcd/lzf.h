/* Decodes LZF data as a stream from a file.
 *
 * LZF: a byte b < 32 is followed by b + 1 literal bytes. Any other byte begins a match. Its upper
 * three bits are the length less two (7: the next byte is added to the length). Its lower five bits
 * are the upper bits of the distance less one; the next byte is the lower eight bits. So a match
 * reaches back at most 8,192 bytes and is at most 264 long. A decoder needs only that window and
 * its blocks: it is a plain struct of about 40 KiB, which may be copied to mark a place. Every
 * length and distance is checked. Threads: one at a time per decoder. */
#ifndef STP_FORMATS_SCAN_PCD_LZF_H
#define STP_FORMATS_SCAN_PCD_LZF_H

#include "base/error.h"

#include <stddef.h>
#include <stdint.h>

#define STP_LZF_WINDOW 8192u
#define STP_LZF_BLOCK 16384u
#define STP_LZF_MATCH_MAX 264u

typedef struct stp_lzf {
    int descriptor;          /* borrowed */
    const char *path;        /* borrowed; for messages */
    uint64_t next_load, end; /* compressed bytes of the file that are not yet in `in` */
    uint64_t size, decoded;  /* decoded bytes: in all, and so far */
    size_t in_begin, in_end;
    size_t out_begin, out_end; /* decoded, not yet given to the caller */
    unsigned char in[STP_LZF_BLOCK];
    unsigned char out[STP_LZF_WINDOW + STP_LZF_BLOCK + STP_LZF_MATCH_MAX];
} stp_lzf;

/* The compressed bytes are [begin, end) of the file. They decode to size bytes. */
void stp_lzf_init(stp_lzf *lzf, int descriptor, const char *path, uint64_t begin, uint64_t end,
                  uint64_t size);
/* Decodes the next size bytes into out, or drops them if out is NULL. Errors: IO, CORRUPT. */
stp_status stp_lzf_read(stp_lzf *lzf, void *out, uint64_t size, stp_error *err);
/* After the last byte: checks that no compressed bytes are left over. Errors: CORRUPT. */
stp_status stp_lzf_finish(const stp_lzf *lzf, stp_error *err);

#endif
