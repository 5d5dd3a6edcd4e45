/* Decodes LZF data as a stream from a file. */
#include "formats/scan/pcd/lzf.h"

#include "base/file.h"

#include <stdbool.h>
#include <string.h>

#define LITERALS_MAX 32u
#define TOKEN_MAX (1u + LITERALS_MAX) /* most bytes of input for one step */

void stp_lzf_init(stp_lzf *lzf, int descriptor, const char *path, uint64_t begin, uint64_t end,
                  uint64_t size)
{
    lzf->descriptor = descriptor;
    lzf->path = path;
    lzf->next_load = begin;
    lzf->end = end;
    lzf->size = size;
    lzf->decoded = 0;
    lzf->in_begin = lzf->in_end = lzf->out_begin = lzf->out_end = 0;
}

static uint64_t input_offset(const stp_lzf *lzf)
{
    return lzf->next_load - (lzf->in_end - lzf->in_begin);
}

static stp_status fault(const stp_lzf *lzf, const char *what, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: byte %llu: compressed data %s, after %llu of %llu bytes decoded: the "
                         "file is damaged or cut; copy or export it again",
                         lzf->path, (unsigned long long)input_offset(lzf), what,
                         (unsigned long long)lzf->decoded, (unsigned long long)lzf->size);
}

/* Loads more input if a step might need it. */
static stp_status load(stp_lzf *lzf, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t held = lzf->in_end - lzf->in_begin;
    const uint64_t left = lzf->end - lzf->next_load;
    size_t part = sizeof lzf->in - held;
    part = part < left ? part : (size_t)left;
    memmove(lzf->in, lzf->in + lzf->in_begin, held);
    lzf->in_begin = 0;
    lzf->in_end = held;
    STP_TRY(
        stp_file_read_at(lzf->descriptor, lzf->path, lzf->next_load, lzf->in + held, part, err));
    lzf->in_end += part;
    lzf->next_load += part;
done:
    return status;
}

/* Adds the `length` decoded bytes at out_end to the output. */
static void advance(stp_lzf *lzf, size_t consumed, size_t length)
{
    lzf->in_begin += consumed;
    lzf->out_end += length;
    lzf->decoded += length;
}

static void copy_match(unsigned char *to, size_t distance, size_t length)
{
    const unsigned char *from = to - distance;
    if (distance >= length)
        memcpy(to, from, length);
    else if (distance == 1)
        memset(to, *from, length);
    else
        for (size_t i = 0; i < length; i++)
            to[i] = from[i];
}

/* Decodes one run of literals or one match. */
static stp_status step(stp_lzf *lzf, stp_error *err)
{
    const unsigned char *in = lzf->in + lzf->in_begin;
    const size_t held = lzf->in_end - lzf->in_begin;
    const uint64_t room = lzf->size - lzf->decoded;
    unsigned char *to = lzf->out + lzf->out_end;
    size_t length, used;
    if (held == 0)
        return fault(lzf, "ends early", err);
    if (in[0] < LITERALS_MAX) {
        length = in[0] + 1u;
        used = 1 + length;
        if (held < used)
            return fault(lzf, "ends early", err);
        if (length > room)
            return fault(lzf, "holds more than is declared", err);
        memcpy(to, in + 1, length);
    } else {
        const bool is_long = in[0] >> 5 == 7;
        used = is_long ? 3 : 2;
        if (held < used)
            return fault(lzf, "ends early", err);
        length = (in[0] >> 5) + 2u + (is_long ? in[1] : 0u);
        const size_t distance = ((in[0] & 31u) << 8 | in[used - 1]) + 1u;
        if (length > room)
            return fault(lzf, "holds more than is declared", err);
        if (distance > lzf->decoded)
            return fault(lzf, "refers to what is before its begin", err);
        copy_match(to, distance, length);
    }
    advance(lzf, used, length);
    return STP_OK;
}

/* Decodes a block and keeps the window before it. */
static stp_status decode(stp_lzf *lzf, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t keep = lzf->out_end < STP_LZF_WINDOW ? lzf->out_end : STP_LZF_WINDOW;
    memmove(lzf->out, lzf->out + lzf->out_end - keep, keep);
    lzf->out_begin = lzf->out_end = keep;
    while (lzf->out_end < STP_LZF_WINDOW + STP_LZF_BLOCK && lzf->decoded < lzf->size) {
        if (lzf->in_end - lzf->in_begin < TOKEN_MAX && lzf->next_load < lzf->end)
            STP_TRY(load(lzf, err));
        STP_TRY(step(lzf, err));
    }
done:
    return status;
}

stp_status stp_lzf_read(stp_lzf *lzf, void *out, uint64_t size, stp_error *err)
{
    stp_status status = STP_OK;
    unsigned char *to = out;
    while (size > 0) {
        if (lzf->out_begin == lzf->out_end) {
            if (lzf->decoded == lzf->size)
                return fault(lzf, "ends early", err);
            STP_TRY(decode(lzf, err));
        }
        size_t part = lzf->out_end - lzf->out_begin;
        part = part < size ? part : (size_t)size;
        if (to) {
            memcpy(to, lzf->out + lzf->out_begin, part);
            to += part;
        }
        lzf->out_begin += part;
        size -= part;
    }
done:
    return status;
}

stp_status stp_lzf_finish(const stp_lzf *lzf, stp_error *err)
{
    const bool over = lzf->in_begin < lzf->in_end || lzf->next_load < lzf->end;
    return over ? fault(lzf, "goes on behind its last value", err) : STP_OK;
}
