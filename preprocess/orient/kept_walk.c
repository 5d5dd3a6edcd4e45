/* Unpacks the lists of kept neighbours, point by point. */
#include "preprocess/orient/kept_walk.h"

#include "preprocess/cloud/place_list.h"

stp_kept_walk stp_kept_begin(const stp_sheets *s, size_t cell)
{
    const stp_graph *graph = &s->graphs[cell];
    return (stp_kept_walk){.graph = graph,
                           .next_list = graph->lists,
                           .k = s->k,
                           .number_begin = s->kept_begin[cell],
                           .place_begin = s->cloud->cells[cell].begin};
}

bool stp_kept_next(stp_kept_walk *walk)
{
    if (walk->done == walk->graph->kept_count)
        return false;
    walk->number = walk->number_begin + walk->done;
    walk->self = walk->place_begin + walk->graph->kept[walk->done++];
    walk->next_list = stp_place_list_next(walk->next_list, walk->self, walk->k, walk->neighbours);
    return true;
}
