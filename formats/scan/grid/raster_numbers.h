/* Numbers as several formats of grids have them. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_GRID_RASTER_NUMBERS_H
#define STP_FORMATS_SCAN_GRID_RASTER_NUMBERS_H

#include "formats/scan/source.h"

#include <stdint.h>

/* Numbers with blanks or line ends between. */
typedef struct stp_raster_text {
    stp_source source;
    const char *at, *end; /* the rest of a line; NULL: none is begun */
} stp_raster_text;

/* Reads a number, perhaps with a comma before decimals. False if it is none. */
bool stp_raster_text_number(const char *begin, const char *end, double *number);
/* Reads the next count numbers. row: for messages, from 0. Errors: IO, CORRUPT. */
stp_status stp_raster_text_read(stp_raster_text *text, uint32_t row, double *numbers,
                                uint32_t count, stp_error *err);
/* Whether a number may be that of columns or rows. */
bool stp_raster_is_side(double number);
/* A float of 32 bits, the least byte first or last. */
double stp_raster_float(const unsigned char bytes[4], bool little);

#endif
