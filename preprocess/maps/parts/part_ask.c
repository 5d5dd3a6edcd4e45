/* Ranks answer questions about parts together. */
#include "base/memory.h"
#include "base/sort.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/maps/parts/part_field.h"

#include <stdlib.h>

/* Copies of parts of other ranks. */
typedef struct asking {
    stp_part_field *field;
    stp_ranks *ranks;
    uint64_t *wanted; /* parts, rank after rank */
    size_t wanted_count, capacity;
    size_t *counts; /* by rank: of these */
    stp_bytes in;   /* what comes */
} asking;

static unsigned owner_of(const stp_part_field *field, uint32_t part)
{
    return stp_ranks_find(field->cloud->blocks->ranks, field->firsts, part);
}

/* Wants the parts of other ranks that a part was joined with. */
static stp_status want(asking *a, uint32_t part, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_part_field *f = a->field;
    for (; part != STP_PART_NONE; part = f->next[part]) {
        stp_part_copy *copy = &f->copies[part];
        if (owner_of(f, part) == a->ranks->self || copy->points || copy->count > 0)
            continue;
        copy->count = 1; /* it is wanted */
        STP_TRY(stp_grow(&a->wanted, &a->capacity, a->wanted_count + 1, sizeof *a->wanted, "maps",
                         err));
        a->wanted[a->wanted_count++] = part;
    }
done:
    return status;
}

/* Packs a part that another rank asks for. */
static stp_status answer(const void *context, uint64_t part, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_part_field *f = context;
    const uint32_t begin = f->begins[part], end = f->begins[part + 1];
    const uint32_t count = end - begin;
    STP_TRY(stp_bytes_append(out, &count, sizeof count, err));
    for (uint32_t i = begin; i < end; i++) {
        const stp_part_point p = stp_part_field_point(f, f->places[i]);
        STP_TRY(stp_bytes_append(out, &p, sizeof p, err));
    }
done:
    return status;
}

static stp_status take(asking *a, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cursor from = {a->in.data, a->in.size};
    for (size_t i = 0; i < a->wanted_count; i++) {
        stp_part_copy *copy = &a->field->copies[a->wanted[i]];
        STP_TRY(stp_packet_take(&from, &copy->count, sizeof copy->count, err));
        STP_TRY(
            stp_packet_take_array(&from, &copy->points, copy->count, sizeof *copy->points, err));
    }
done:
    return status;
}

/* Gets the parts of other ranks that this rank needs for its answers. */
static stp_status fetch(asking *a, const stp_part_question *questions, uint32_t count,
                        stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t i = 0; i < count; i++)
        if (owner_of(a->field, questions[i].a) == a->ranks->self) {
            STP_TRY(want(a, questions[i].a, err));
            STP_TRY(want(a, questions[i].b, err));
        }
    uint64_t all = a->wanted_count;
    STP_TRY(stp_ranks_sum(a->ranks, &all, 1, err));
    if (all == 0)
        return STP_OK;
    STP_TRY(stp_alloc(&a->counts, a->ranks->count, sizeof *a->counts, "ranks", err));
    stp_sort_u64(a->wanted, a->wanted_count);
    for (size_t i = 0; i < a->wanted_count; i++)
        a->counts[owner_of(a->field, (uint32_t)a->wanted[i])]++;
    STP_TRY(stp_ranks_ask(a->ranks, a->wanted, a->counts, answer, a->field, &a->in, err));
    STP_TRY(take(a, err));
done:
    return status;
}

stp_status stp_part_field_ask(stp_part_field *field, stp_part_question *questions, uint32_t count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    asking a = {.field = field, .ranks = field->firsts ? field->cloud->blocks->ranks : NULL};
    uint64_t *bits = NULL; /* a question each */
    if (a.ranks)
        STP_TRY(fetch(&a, questions, count, err));
    STP_TRY(stp_alloc(&bits, count / 64 + 1, sizeof *bits, "maps", err));
    for (uint32_t i = 0; i < count; i++) {
        stp_part_question *q = &questions[i];
        bool fits = false;
        if (!a.ranks || owner_of(field, q->a) == a.ranks->self)
            STP_TRY(stp_part_field_fits(field, q->a, q->b, &q->cone, &fits, err));
        bits[i / 64] |= (uint64_t)fits << i % 64;
    }
    STP_TRY(stp_ranks_sum(a.ranks, bits, count / 64 + 1, err));
    for (uint32_t i = 0; i < count; i++)
        questions[i].fits = bits[i / 64] >> i % 64 & 1u;
done:
    free(bits);
    free(a.wanted);
    free(a.counts);
    free(a.in.data);
    return status;
}
