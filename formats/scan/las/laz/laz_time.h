/* Codes GPS times as multiples of the last difference, in up to four interleaved sequences
 * (LASzip's items GPSTIME11 version 2 and POINT14). */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_TIME_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_TIME_H

#include "formats/scan/las/laz/laz_stream.h"

#define STP_LAZ_TIME_SEQUENCES 4u

typedef struct stp_laz_time {
    uint64_t last[STP_LAZ_TIME_SEQUENCES]; /* the bits of a double */
    int32_t difference[STP_LAZ_TIME_SEQUENCES];
    int32_t extremes[STP_LAZ_TIME_SEQUENCES]; /* differences in a row that did not fit */
    unsigned current, newest;                 /* sequences */
    stp_laz_symbols multiple, first;
    stp_laz_integer change;
} stp_laz_time;

/* may_stay: the codes have one for "unchanged", as in GPSTIME11. */
void stp_laz_time_place(stp_laz_time *t, bool may_stay, stp_laz_arena *arena);
void stp_laz_time_begin(stp_laz_time *t, uint64_t first);
/* The next time. It differs from the one before unless it may stay. */
uint64_t stp_laz_time_next(stp_laz_time *t, bool may_stay, stp_laz_stream *d, uint64_t time);

#endif
