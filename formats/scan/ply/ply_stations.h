/* Where scanners stood, as a PLY file says it.
 *
 * PLY has no place for it, so this is a convention: header lines
 *
 *     comment station NUMBER X Y Z
 *
 * in the points' own coordinates, one for each station, and a vertex property `station` (any type;
 * also scalar_station, as CloudCompare would rename it) with the number of the station that saw the
 * point. A file with one position and without the property was seen from there as a whole.
 *
 * Comments are free text and files pass through programs that drop or join them, so nothing here is
 * a fault: a comment that is not exactly so is a comment; a number with two different positions has
 * none; a point whose number has no position, is negative, fractional or not finite has an unknown
 * station; positions of several stations without the property say nothing of the points. Threads:
 * any once settled. */
#ifndef STP_FORMATS_SCAN_PLY_PLY_STATIONS_H
#define STP_FORMATS_SCAN_PLY_PLY_STATIONS_H

#include "base/error.h"
#include "base/vec.h"

#include <stddef.h>
#include <stdint.h>

typedef struct stp_ply_station {
    stp_dvec3 position;
    uint32_t number;
} stp_ply_station;

typedef struct stp_ply_stations {
    stp_ply_station *list; /* settled: by number, each once */
    size_t count, capacity;
} stp_ply_stations;

/* Takes the rest of a comment's line, [begin, end), if it gives a station's position. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_ply_stations_add(stp_ply_stations *stations, const char *begin, const char *end,
                                stp_error *err);
/* Sorts the list and drops what is repeated or contradicts itself. At most STP_STATION_LIMIT stay,
 * those of the lowest numbers. */
void stp_ply_stations_settle(stp_ply_stations *stations);
/* Place of the station with this number in the settled list, counted from 1; 0 if there is none. */
uint16_t stp_ply_stations_find(const stp_ply_stations *stations, double number);
void stp_ply_stations_free(stp_ply_stations *stations);

#endif
