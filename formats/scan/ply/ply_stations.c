/* Reads stations from the comments of a PLY header. */
#include "formats/scan/ply/ply_stations.h"

#include "base/memory.h"
#include "formats/scan/number.h"
#include "formats/scan/scan.h"
#include "formats/scan/source.h"

#include <stdlib.h>
#include <string.h>

stp_status stp_ply_stations_add(stp_ply_stations *stations, const char *begin, const char *end,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const char *at = begin;
    const char *word = stp_token(&at, end);
    uint64_t number;
    double xyz[3];
    if (!word || at - word != 7 || memcmp(word, "station", 7) != 0)
        return STP_OK;
    word = stp_token(&at, end);
    if (!word || !stp_number_parse_u64(word, at, &number) || number > UINT32_MAX)
        return STP_OK;
    for (int i = 0; i < 3; i++) {
        word = stp_token(&at, end);
        if (!word || !stp_number_parse(word, at, &xyz[i]))
            return STP_OK;
    }
    const stp_ply_station station = {{xyz[0], xyz[1], xyz[2]}, (uint32_t)number};
    if (stp_token(&at, end) || !stp_dvec3_finite(station.position))
        return STP_OK;
    STP_TRY(stp_grow(&stations->list, &stations->capacity, stations->count + 1,
                     sizeof *stations->list, "stations", err));
    stations->list[stations->count++] = station;
done:
    return status;
}

static int compare_numbers(const void *a, const void *b)
{
    const stp_ply_station *p = a, *q = b;
    return p->number < q->number ? -1 : p->number > q->number;
}

static bool same_position(const stp_ply_station *a, const stp_ply_station *b)
{
    return a->position.x == b->position.x && a->position.y == b->position.y &&
           a->position.z == b->position.z;
}

void stp_ply_stations_sort(stp_ply_stations *stations)
{
    stp_ply_station *list = stations->list;
    size_t kept = 0, next;
    if (stations->count > 0)
        qsort(list, stations->count, sizeof *list, compare_numbers);
    for (size_t i = 0; i < stations->count && kept < STP_STATION_LIMIT; i = next) {
        bool agreed = true;
        for (next = i + 1; next < stations->count && list[next].number == list[i].number; next++)
            agreed &= same_position(&list[next], &list[i]);
        if (agreed)
            list[kept++] = list[i];
    }
    stations->count = kept;
}

uint16_t stp_ply_stations_find(const stp_ply_stations *stations, double number)
{
    const stp_ply_station *list = stations->list;
    size_t begin = 0, end = stations->count;
    if (!(number >= 0.0 && number <= (double)UINT32_MAX && number == (double)(uint32_t)number))
        return 0;
    const uint32_t wanted = (uint32_t)number;
    if (wanted < end && list[wanted].number == wanted)
        return (uint16_t)(wanted + 1); /* fast path: most files number stations from 0 on */
    while (begin < end) {
        const size_t middle = begin + (end - begin) / 2;
        if (list[middle].number < wanted)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin < stations->count && list[begin].number == wanted ? (uint16_t)(begin + 1) : 0;
}

void stp_ply_stations_free(stp_ply_stations *stations)
{
    free(stations->list);
    *stations = (stp_ply_stations){0};
}
