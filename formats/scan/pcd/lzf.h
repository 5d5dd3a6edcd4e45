/* Data compressed with LZF, decoded as a stream out of a file.
 *
 * LZF: a byte below 32 is followed by so many literal bytes and one more; another one holds in its
 * upper three bits the length of a match less two (7: a byte with more to add follows) and in its
 * lower five the upper bits of the distance less one, whose lower eight follow. So a match reaches
 * back 8,192 bytes at most and is at most 264 long, and a decoder needs no more memory than that
 * and its blocks: a plain struct of about 40 KiB, which may be copied to mark a place. Every length
 * and distance is checked. Threads: one at a time per decoder. */
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
    uint64_t next_load, end; /* compressed bytes in the file that are not yet in `in` */
    uint64_t size, decoded;  /* bytes of the whole when decoded, and so far */
    size_t in_begin, in_end;
    size_t out_begin, out_end; /* decoded, not yet given */
    unsigned char in[STP_LZF_BLOCK];
    unsigned char out[STP_LZF_WINDOW + STP_LZF_BLOCK + STP_LZF_MATCH_MAX];
} stp_lzf;

/* The compressed bytes are [begin, end) of the file and become size bytes. */
void stp_lzf_init(stp_lzf *lzf, int descriptor, const char *path, uint64_t begin, uint64_t end,
                  uint64_t size);
/* The next size bytes, into memory of that size, or nowhere (NULL). Errors: IO, CORRUPT. */
stp_status stp_lzf_read(stp_lzf *lzf, void *out, uint64_t size, stp_error *err);
/* After the last byte: that nothing compressed is left over. Errors: CORRUPT. */
stp_status stp_lzf_finish(const stp_lzf *lzf, stp_error *err);

#endif
