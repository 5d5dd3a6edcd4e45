/* The nearest points found so far, by distance; ties by source. Threads: any, a list each. */
#ifndef STP_PREPROCESS_CLOUD_NEAREST_LIST_H
#define STP_PREPROCESS_CLOUD_NEAREST_LIST_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Most neighbours of a point. */
#define STP_NEIGHBOURS_LIMIT 64
#define STP_NEIGHBOUR_NONE UINT32_MAX
/* The same, where neighbours are places in the cloud. */
#define STP_PLACE_NONE UINT64_MAX

typedef struct stp_nearest_list {
    unsigned capacity, count;
    double squared[STP_NEIGHBOURS_LIMIT];
    uint64_t place[STP_NEIGHBOURS_LIMIT];  /* in the cloud, nearest first */
    uint64_t source[STP_NEIGHBOURS_LIMIT]; /* of each; breaks ties */
} stp_nearest_list;

static inline bool stp_nearest_list_full(const stp_nearest_list *list)
{
    return list->count > 0 && list->count == list->capacity;
}

/* The squared distance beyond which no point can enter the list; infinite while there is room. */
static inline double stp_nearest_list_reach(const stp_nearest_list *list)
{
    return stp_nearest_list_full(list) ? list->squared[list->count - 1] : INFINITY;
}

static inline void stp_nearest_list_insert(stp_nearest_list *list, double squared, uint64_t place,
                                           uint64_t source)
{
    unsigned at = list->count;
    while (at > 0 && (squared < list->squared[at - 1] ||
                      (squared == list->squared[at - 1] && source < list->source[at - 1])))
        at--;
    if (at == list->capacity)
        return;
    if (list->count < list->capacity)
        list->count++;
    for (unsigned i = list->count - 1; i > at; i--) {
        list->squared[i] = list->squared[i - 1];
        list->place[i] = list->place[i - 1];
        list->source[i] = list->source[i - 1];
    }
    list->squared[at] = squared;
    list->place[at] = place;
    list->source[at] = source;
}

#endif
