/* Parts of work, and packets from rank to rank. */
#include "preprocess/ranks/ranks.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

stp_rank_part stp_ranks_part(const stp_ranks *ranks, unsigned rank, uint64_t count)
{
    const unsigned parts = stp_ranks_count(ranks);
    return (stp_rank_part){count * rank / parts, count * (rank + 1) / parts};
}

stp_rank_part stp_ranks_own(const stp_ranks *ranks, uint64_t count)
{
    return stp_ranks_part(ranks, ranks ? ranks->self : 0, count);
}

unsigned stp_ranks_find(const stp_ranks *ranks, const uint64_t *begins, uint64_t item)
{
    unsigned low = 0, high = ranks->count - 1;
    while (low < high) {
        const unsigned middle = low + (high - low + 1) / 2;
        if (begins[middle] <= item)
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

stp_status stp_ranks_broadcast(stp_ranks *ranks, unsigned from, void *data, size_t bytes,
                               stp_error *err)
{
    if (stp_ranks_count(ranks) == 1 || bytes == 0)
        return STP_OK;
    ranks->sent_bytes += bytes * (ranks->count - 1);
    return ranks->broadcast(ranks, from, data, bytes, err);
}

/* Makes room for the bytes that come. */
static stp_status receive(stp_bytes *bytes, uint64_t size, stp_error *err)
{
    bytes->size = 0;
    return stp_bytes_append(bytes, NULL, size, err);
}

stp_status stp_ranks_broadcast_bytes(stp_ranks *ranks, unsigned from, stp_bytes *bytes,
                                     stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t size = bytes->size;
    if (stp_ranks_count(ranks) == 1)
        return STP_OK;
    STP_TRY(stp_ranks_broadcast(ranks, from, &size, sizeof size, err));
    if (from != ranks->self)
        STP_TRY(receive(bytes, size, err));
    STP_TRY(stp_ranks_broadcast(ranks, from, bytes->data, bytes->size, err));
done:
    return status;
}

stp_status stp_ranks_share(stp_ranks *ranks, void *array, uint64_t count, size_t size,
                           stp_error *err)
{
    stp_status status = STP_OK;
    for (unsigned rank = 0; rank < stp_ranks_count(ranks) && status == STP_OK; rank++) {
        const stp_rank_part part = stp_ranks_part(ranks, rank, count);
        status = stp_ranks_broadcast(ranks, rank, (char *)array + part.begin * size,
                                     (part.end - part.begin) * size, err);
    }
    return status;
}

stp_status stp_ranks_send_bytes(stp_ranks *ranks, unsigned from, stp_bytes *bytes, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t size = bytes->size;
    if (ranks->self != from && ranks->self != 0)
        return STP_OK;
    STP_TRY(ranks->send(ranks, from, 0, &size, sizeof size, err));
    if (ranks->self == 0)
        STP_TRY(receive(bytes, size, err));
    STP_TRY(ranks->send(ranks, from, 0, bytes->data, bytes->size, err));
    ranks->sent_bytes += sizeof size + size;
done:
    return status;
}

/* Tells each rank how many bytes come. */
static stp_status tell_sizes(stp_ranks *ranks, const size_t *sent, size_t *received, stp_error *err)
{
    size_t *size = NULL;
    stp_status status = stp_alloc(&size, ranks->count, sizeof *size, "ranks", err);
    if (status != STP_OK)
        return status;
    for (unsigned rank = 0; rank < ranks->count; rank++)
        size[rank] = sizeof *size;
    status = ranks->exchange(ranks, sent, size, received, size, err);
    free(size);
    return status;
}

stp_status stp_ranks_exchange(stp_ranks *ranks, const void *data, const size_t *sent, void *out,
                              size_t *received, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(tell_sizes(ranks, sent, received, err));
    STP_TRY(ranks->exchange(ranks, data, sent, out, received, err));
done:
    return status;
}

stp_status stp_ranks_exchange_bytes(stp_ranks *ranks, const void *data, const size_t *sent,
                                    stp_bytes *out, size_t *received, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t size = 0;
    STP_TRY(tell_sizes(ranks, sent, received, err));
    for (unsigned rank = 0; rank < ranks->count; rank++)
        size += received[rank];
    STP_TRY(receive(out, size, err));
    STP_TRY(ranks->exchange(ranks, data, sent, out->data, received, err));
    STP_TRY(stp_ranks_sum(ranks, &size, 1, err));
    ranks->sent_bytes += size;
done:
    return status;
}

stp_status stp_ranks_gather(stp_ranks *ranks, const void *own, size_t bytes, void *out,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned count = stp_ranks_count(ranks);
    size_t *sizes = NULL;
    char *copies = NULL;
    if (count == 1) {
        memcpy(out, own, bytes);
        return STP_OK;
    }
    STP_TRY(stp_alloc(&sizes, count, sizeof *sizes, "ranks", err));
    STP_TRY(stp_alloc(&copies, count, bytes, "ranks", err));
    for (unsigned rank = 0; rank < count; rank++) {
        sizes[rank] = bytes;
        memcpy(copies + rank * bytes, own, bytes);
    }
    STP_TRY(ranks->exchange(ranks, copies, sizes, out, sizes, err));
    ranks->sent_bytes += bytes * count * (count - 1);
done:
    free(copies);
    free(sizes);
    return status;
}

stp_status stp_ranks_join(stp_ranks *ranks, stp_bytes *bytes, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes packet = {0}, all = {0};
    for (unsigned rank = 0; rank < stp_ranks_count(ranks); rank++) {
        packet.size = 0;
        if (rank == ranks->self)
            STP_TRY(stp_bytes_append(&packet, bytes->data, bytes->size, err));
        STP_TRY(stp_ranks_broadcast_bytes(ranks, rank, &packet, err));
        STP_TRY(stp_bytes_append(&all, packet.data, packet.size, err));
    }
    free(bytes->data);
    *bytes = all;
    all = (stp_bytes){0};
done:
    free(packet.data);
    free(all.data);
    return status;
}

stp_status stp_ranks_sum(stp_ranks *ranks, uint64_t *numbers, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *all = NULL;
    if (stp_ranks_count(ranks) == 1)
        return STP_OK;
    STP_TRY(stp_alloc(&all, ranks->count, count * sizeof *all, "ranks", err));
    STP_TRY(stp_ranks_gather(ranks, numbers, count * sizeof *all, all, err));
    memset(numbers, 0, count * sizeof *numbers);
    for (size_t i = 0; i < ranks->count * count; i++)
        numbers[i % count] += all[i];
done:
    free(all);
    return status;
}

stp_status stp_ranks_deal(stp_ranks *ranks, stp_bytes *items, size_t size,
                          stp_rank_of_item *rank_of, const void *context, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned count = stp_ranks_count(ranks);
    stp_bytes sorted = {0}, in = {0};
    size_t *sent = NULL, *at = NULL;
    if (count == 1)
        return STP_OK;
    STP_TRY(stp_alloc(&sent, 2 * (size_t)count, sizeof *sent, "ranks", err));
    STP_TRY(stp_alloc(&at, count, sizeof *at, "ranks", err));
    STP_TRY(stp_bytes_append(&sorted, NULL, items->size, err));
    for (size_t i = 0; i < items->size; i += size)
        sent[rank_of(context, items->data + i)] += size;
    for (unsigned rank = 1; rank < count; rank++)
        at[rank] = at[rank - 1] + sent[rank - 1];
    for (size_t i = 0; i < items->size; i += size) {
        size_t *to = &at[rank_of(context, items->data + i)];
        memcpy(sorted.data + *to, items->data + i, size);
        *to += size;
    }
    STP_TRY(stp_ranks_exchange_bytes(ranks, sorted.data, sent, &in, sent + count, err));
    free(items->data);
    *items = in;
    in = (stp_bytes){0};
done:
    free(sorted.data);
    free(in.data);
    free(sent);
    free(at);
    return status;
}

stp_status stp_ranks_ask(stp_ranks *ranks, const uint64_t *numbers, const size_t *counts,
                         stp_rank_answer *answer, const void *context, stp_bytes *in,
                         stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned count = ranks->count;
    stp_bytes told = {0}, out = {0};
    size_t *sizes = NULL;
    STP_TRY(stp_alloc(&sizes, 4 * (size_t)count, sizeof *sizes, "ranks", err));
    size_t *asked = sizes, *heard = asked + count, *sent = heard + count, *received = sent + count;
    for (unsigned rank = 0; rank < count; rank++)
        asked[rank] = counts[rank] * sizeof *numbers;
    STP_TRY(stp_ranks_exchange_bytes(ranks, numbers, asked, &told, heard, err));
    stp_cursor from = {told.data, told.size};
    for (unsigned rank = 0; rank < count; rank++) {
        const size_t before = out.size;
        for (size_t i = 0; i < heard[rank] / sizeof *numbers; i++) {
            uint64_t number = 0;
            STP_TRY(stp_packet_take(&from, &number, sizeof number, err));
            STP_TRY(answer(context, number, &out, err));
        }
        sent[rank] = out.size - before;
    }
    STP_TRY(stp_ranks_exchange_bytes(ranks, out.data, sent, in, received, err));
done:
    free(told.data);
    free(out.data);
    free(sizes);
    return status;
}

stp_status stp_ranks_agree(stp_ranks *ranks, uint64_t number, const char *what, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t first = number;
    unsigned odd = 0;
    for (unsigned r = 0; r < stp_ranks_count(ranks); r++) {
        uint64_t other = number;
        STP_TRY(stp_ranks_broadcast(ranks, r, &other, sizeof other, err));
        first = r == 0 ? other : first;
        odd = odd == 0 && other != first ? r : odd;
    }
    if (odd > 0)
        status = stp_error_set(err, STP_INVALID_ARGUMENT,
                               "%s has %s %s: all ranks must have the same options, see the same "
                               "files under the same names, and be of one kind",
                               ranks->names[odd], what, ranks->names[0]);
done:
    return status;
}

stp_status stp_packet_take(stp_cursor *from, void *out, size_t size, stp_error *err)
{
    if (size > from->left)
        return stp_error_set(err, STP_INTERNAL,
                             "a packet ends %zu bytes early: the ranks run "
                             "different programs",
                             size - from->left);
    if (size > 0)
        memcpy(out, from->bytes, size);
    stp_cursor_skip(from, size);
    return STP_OK;
}

stp_status stp_packet_take_array(stp_cursor *from, void *out, size_t count, size_t size,
                                 stp_error *err)
{
    void *array = NULL;
    stp_status status = stp_alloc(&array, count, size, "a packet", err);
    if (status == STP_OK)
        status = stp_packet_take(from, array, count * size, err);
    if (status != STP_OK) {
        free(array);
        return status;
    }
    memcpy(out, &array, sizeof array);
    return STP_OK;
}
