/* Compares what the file system says of the inputs. */
#include "tools/prep/prep_twice.h"

#include "base/memory.h"

#include <stdlib.h>

/* An input and its index. */
typedef struct placed {
    const prep_input *facts;
    size_t place;
} placed;

static int compare_placed(const void *a, const void *b)
{
    const placed *x = a, *y = b;
    if (x->facts->device != y->facts->device)
        return x->facts->device < y->facts->device ? -1 : 1;
    if (x->facts->inode != y->facts->inode)
        return x->facts->inode < y->facts->inode ? -1 : 1;
    return (x->place > y->place) - (x->place < y->place);
}

stp_status prep_inputs_check_twice(const prep_inputs *in, stp_error *err)
{
    stp_status status = STP_OK;
    placed *order = NULL;
    STP_TRY(stp_alloc(&order, in->count, sizeof *order, "inputs", err));
    for (size_t i = 0; i < in->count; i++)
        order[i] = (placed){&in->facts[i], i};
    qsort(order, in->count, sizeof *order, compare_placed);
    for (size_t i = 1; i < in->count && status == STP_OK; i++) {
        const prep_input *a = order[i - 1].facts, *b = order[i].facts;
        if (a->inode != 0 && a->inode == b->inode && a->device == b->device)
            status = stp_error_set(err, STP_INVALID_ARGUMENT,
                                   "%s is the same file as %s: give it once, or each of its "
                                   "points would be stored twice",
                                   in->paths[order[i].place], in->paths[order[i - 1].place]);
    }
done:
    free(order);
    return status;
}
