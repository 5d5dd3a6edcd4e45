/* Reads PGM (P2, P5; up to 16 bits) and PFM of one channel, whose rows go from bottom to top. */
#include "base/file.h"
#include "base/memory.h"
#include "formats/scan/grid/raster.h"
#include "formats/scan/grid/raster_numbers.h"
#include "formats/scan/number.h"

#include <stdlib.h>
#include <string.h>

typedef struct pnm_raster {
    stp_raster_text text; /* the file; its text if the numbers are digits */
    uint64_t begin;       /* of the pixels */
    uint32_t width, height;
    size_t bytes; /* of a pixel; 0: digits */
    bool floats, little;
    unsigned char *row;
} pnm_raster;

static bool is_space(unsigned char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

/* Reads a word of the header. Comments go from # to the end of the line. */
static stp_status read_word(pnm_raster *p, char word[32], stp_error *err)
{
    stp_status status = STP_OK;
    size_t length = 0, available;
    bool comment = false;
    for (;;) {
        const unsigned char *byte;
        STP_TRY(stp_source_peek(&p->text.source, 1, &byte, &available, err));
        if (available == 0 || length == 31)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: its header is damaged: copy or export it again",
                                 p->text.source.path);
        const unsigned char c = *byte;
        if (!comment && length > 0 && is_space(c))
            break;
        stp_source_consume(&p->text.source, 1);
        comment = c == '#' ? length == 0 : comment && c != '\n';
        if (!comment && !is_space(c))
            word[length++] = (char)c;
    }
    word[length] = '\0';
done:
    return status;
}

static stp_status read_number(pnm_raster *p, double least, double most, double *out, stp_error *err)
{
    char word[32];
    stp_status status = read_word(p, word, err);
    if (status != STP_OK)
        return status;
    if (!stp_number_parse(word, word + strlen(word), out) || !(*out >= least) || !(*out <= most))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: its header says %s, which cannot be: export it again",
                             p->text.source.path, word);
    return STP_OK;
}

static stp_status open_pnm(void *state, stp_raster_info *info, const char *path, stp_raster_use use,
                           uint32_t step, stp_error *err)
{
    pnm_raster *p = state;
    stp_status status = STP_OK;
    char magic[32];
    double width, height, last;
    (void)use;
    (void)step;
    p->text.source.descriptor = -1;
    STP_TRY(stp_source_open(&p->text.source, path, err));
    STP_TRY(read_word(p, magic, err));
    p->floats = strcmp(magic, "Pf") == 0;
    STP_TRY(read_number(p, 1.0, STP_RASTER_SIDE_LIMIT, &width, err));
    STP_TRY(read_number(p, 1.0, STP_RASTER_SIDE_LIMIT, &height, err));
    STP_TRY(p->floats ? read_number(p, -1e30, 1e30, &last, err)
                      : read_number(p, 1.0, 65535.0, &last, err));
    stp_source_consume(&p->text.source, 1); /* one space ends the header */
    p->begin = p->text.source.offset;
    p->width = (uint32_t)width;
    p->height = (uint32_t)height;
    p->little = p->floats && last < 0.0;
    p->bytes = p->floats ? 4 : strcmp(magic, "P2") == 0 ? 0 : last > 255.0 ? 2 : 1;
    *info = (stp_raster_info){.format = p->floats ? "PFM" : "PGM",
                              .width = p->width,
                              .height = p->height,
                              .channels = 1,
                              .floats = p->floats,
                              .full = p->floats ? 1.0 : last};
    const uint64_t wanted = (uint64_t)p->width * p->height * p->bytes;
    if (p->text.source.size - p->begin < wanted)
        status = stp_error_set(
            err, STP_CORRUPT, "%s ends early: it has %llu bytes of %llu: copy or export it again",
            path, (unsigned long long)p->text.source.size, (unsigned long long)(p->begin + wanted));
    else
        status = stp_alloc(&p->row, p->width, p->bytes + 1, "a row of an image", err);
done:
    return status;
}

static double value_of(const pnm_raster *p, const unsigned char *b)
{
    return p->floats ? stp_raster_float(b, p->little) : p->bytes == 2 ? b[0] << 8 | b[1] : b[0];
}

static stp_status read_pnm(void *state, uint32_t row, double *values, stp_error *err)
{
    pnm_raster *p = state;
    stp_status status = STP_OK;
    const size_t stride = p->width * p->bytes;
    if (p->bytes == 0)
        return stp_raster_text_read(&p->text, row, values, p->width, err);
    const uint64_t place = p->floats ? p->height - 1 - row : row;
    STP_TRY(stp_file_read_at(p->text.source.descriptor, p->text.source.path,
                             p->begin + place * stride, p->row, stride, err));
    for (uint32_t i = 0; i < p->width; i++)
        values[i] = value_of(p, p->row + i * p->bytes);
done:
    return status;
}

static void close_pnm(void *state)
{
    pnm_raster *p = state;
    stp_source_close(&p->text.source);
    free(p->row);
}

const stp_raster_reader stp_raster_pnm = {.state_bytes = sizeof(pnm_raster),
                                          .each = true,
                                          .open = open_pnm,
                                          .read = read_pnm,
                                          .close = close_pnm};
