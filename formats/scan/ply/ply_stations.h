/* Reads where scanners stood from a PLY file.
 *
 * PLY has no field for stations, so this is a convention. For each station the header has a line
 *
 *     comment station NUMBER X Y Z
 *
 * in the points' own coordinates. The vertex property `station` (any type; also scalar_station, as
 * CloudCompare renames it) is the number of the station that saw the point. If a file has one
 * position and no such property, that station saw all points.
 *
 * Comments are free text, and programs drop or join them when they rewrite files. So nothing here
 * is a fault. A comment of another form is an ordinary comment. A number with two different
 * positions has none. The station of a point is unknown if its number has no position, is negative,
 * fractional or not finite. Without the property, positions of several stations say nothing about
 * the points. Threads: any once sorted. */
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
    stp_ply_station *list; /* if sorted: sorted by number, each once */
    size_t count, capacity;
} stp_ply_stations;

/* Adds a station if the rest of a comment line, [begin, end), gives its position. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_ply_stations_add(stp_ply_stations *stations, const char *begin, const char *end,
                                stp_error *err);
/* Sorts the list and drops repeated and contradictory stations. Keeps at most STP_STATION_LIMIT,
 * those with the lowest numbers. */
void stp_ply_stations_sort(stp_ply_stations *stations);
/* The index of the station with this number in the sorted list, counted from 1; 0 if there is
 * none. */
uint16_t stp_ply_stations_find(const stp_ply_stations *stations, double number);
void stp_ply_stations_free(stp_ply_stations *stations);

#endif
