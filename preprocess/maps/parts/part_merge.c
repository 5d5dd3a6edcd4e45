/* Merges parts. */
#include "preprocess/maps/parts/part_merge.h"

#include "base/memory.h"
#include "base/sort.h"
#include "preprocess/orient/forest.h"

#include <stdlib.h>
#include <string.h>

/* Candidates that ranks look at, to answer several questions at once. */
#define LOOK 2048u

typedef enum answer { ANSWER_NONE = 0, ANSWER_NO, ANSWER_YES } answer;

/* A pair that may be merged. It is out of date if a part has changed since. */
typedef struct candidate {
    double increase; /* of the sum of errors */
    uint32_t a, b;   /* a < b */
    uint32_t version_a, version_b;
    answer fits;
} candidate;

/* The parts that touch a part, any of them maybe merged since. */
typedef struct touching {
    uint32_t *list;
    size_t count, capacity;
} touching;

typedef struct merging {
    stp_part *parts;
    stp_forest merged;  /* of parts */
    uint32_t *versions; /* by part */
    touching *around;   /* by part */
    double cosine;
    candidate *heap;
    size_t heap_count, heap_capacity;
    vec3s *corners; /* of two parts */
    size_t corner_capacity;
    uint32_t *looks; /* by part: the last time that it was looked at */
    uint32_t look;
} merging;

static uint32_t root_of(merging *m, uint32_t part)
{
    uint8_t parity = 0;
    return stp_forest_find(&m->merged, part, &parity);
}

static bool comes_before(const candidate *p, const candidate *q)
{
    if (p->increase != q->increase)
        return p->increase < q->increase;
    return p->a != q->a ? p->a < q->a : p->b < q->b;
}

static bool is_old(const merging *m, const candidate *c)
{
    return m->versions[c->a] != c->version_a || m->versions[c->b] != c->version_b;
}

/* Puts a candidate at a place of the heap, or below. */
static void sink(merging *m, size_t at, candidate c)
{
    for (;;) {
        size_t child = 2 * at + 1;
        if (child >= m->heap_count)
            break;
        if (child + 1 < m->heap_count && comes_before(&m->heap[child + 1], &m->heap[child]))
            child++;
        if (!comes_before(&m->heap[child], &c))
            break;
        m->heap[at] = m->heap[child];
        at = child;
    }
    m->heap[at] = c;
}

/* Drops candidates that are out of date. */
static void drop_old(merging *m)
{
    size_t kept = 0;
    for (size_t i = 0; i < m->heap_count; i++)
        if (!is_old(m, &m->heap[i]))
            m->heap[kept++] = m->heap[i];
    m->heap_count = kept;
    for (size_t i = kept / 2; i-- > 0;)
        sink(m, i, m->heap[i]);
}

static stp_status push(merging *m, candidate c, stp_error *err)
{
    size_t wanted = m->heap_count + 1;
    if (wanted > m->heap_capacity) {
        drop_old(m);
        wanted = m->heap_count + m->heap_count / 4 + 1; /* else it would soon be full again */
    }
    stp_status status = stp_grow(&m->heap, &m->heap_capacity, wanted, sizeof *m->heap, "maps", err);
    if (status != STP_OK)
        return status;
    size_t at = m->heap_count++;
    for (; at > 0 && comes_before(&c, &m->heap[(at - 1) / 2]); at = (at - 1) / 2)
        m->heap[at] = m->heap[(at - 1) / 2];
    m->heap[at] = c;
    return STP_OK;
}

static candidate pop(merging *m)
{
    const candidate first = m->heap[0], last = m->heap[--m->heap_count];
    if (m->heap_count > 0)
        sink(m, 0, last);
    return first;
}

/* Whether the union has few enough points and one spacing. */
static bool may_merge(const stp_part *p, const stp_part *q)
{
    const double by_area = p->area * q->points / (q->area * p->points);
    const double most = STP_PART_SPACINGS * STP_PART_SPACINGS;
    return (uint64_t)p->points + q->points <= STP_PART_POINTS_MOST && by_area <= most &&
           by_area * most >= 1.0;
}

/* The cone of two parts together. Their corners are then in m->corners. */
static stp_status cone_of_both(merging *m, const stp_part *p, const stp_part *q,
                               stp_normal_cone *out, stp_error *err)
{
    const size_t count = (size_t)p->corner_count + q->corner_count;
    stp_status status =
        stp_grow(&m->corners, &m->corner_capacity, count, sizeof *m->corners, "normals", err);
    if (status != STP_OK)
        return status;
    memcpy(m->corners, p->corners, p->corner_count * sizeof *m->corners);
    memcpy(m->corners + p->corner_count, q->corners, q->corner_count * sizeof *m->corners);
    *out = stp_normal_cone_of(m->corners, count);
    return STP_OK;
}

/* Makes a pair a candidate if it may be merged. */
static stp_status consider(merging *m, stp_part_pair pair, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t a = pair.a, b = pair.b;
    const stp_part *p = &m->parts[a], *q = &m->parts[b];
    stp_normal_cone cone;
    if (!may_merge(p, q))
        return STP_OK;
    STP_TRY(cone_of_both(m, p, q, &cone, err));
    if (cone.cosine < m->cosine)
        return STP_OK;
    const double both =
        stp_part_error(&cone, p->area + q->area, stp_dvec3_add(p->facing, q->facing));
    const double apart =
        stp_part_error(&p->cone, p->area, p->facing) + stp_part_error(&q->cone, q->area, q->facing);
    STP_TRY(
        push(m, (candidate){both - apart, a, b, m->versions[a], m->versions[b], ANSWER_NONE}, err));
done:
    return status;
}

/* Part a takes part b > a in. */
static stp_status merge(merging *m, uint32_t a, uint32_t b, stp_error *err)
{
    stp_status status = STP_OK;
    stp_part *p = &m->parts[a], *q = &m->parts[b];
    vec3s *corners = NULL;
    uint32_t count = 0;
    STP_TRY(cone_of_both(m, p, q, &p->cone, err));
    STP_TRY(stp_normal_cone_corners(m->corners, p->corner_count + q->corner_count, &p->cone,
                                    &corners, &count, err));
    free(p->corners);
    free(q->corners);
    q->corners = NULL;
    p->corners = corners;
    p->corner_count = count;
    p->points += q->points;
    p->area += q->area;
    p->facing = stp_dvec3_add(p->facing, q->facing);
    stp_forest_join(&m->merged, a, b, false);
    m->versions[a]++;
    m->versions[b]++;
done:
    return status;
}

static stp_status add_touching(touching *t, uint32_t part, stp_error *err)
{
    stp_status status =
        stp_grow(&t->list, &t->capacity, t->count + 1, sizeof *t->list, "maps", err);
    if (status == STP_OK)
        t->list[t->count++] = part;
    return status;
}

/* Part a, which has taken b in, touches what b touched. Considers all pairs with it anew. */
static stp_status meet_again(merging *m, uint32_t a, uint32_t b, stp_error *err)
{
    stp_status status = STP_OK;
    touching *t = &m->around[a];
    size_t kept = 0;
    for (size_t i = 0; i < m->around[b].count; i++)
        STP_TRY(add_touching(t, m->around[b].list[i], err));
    free(m->around[b].list);
    m->around[b] = (touching){0};
    for (size_t i = 0; i < t->count; i++)
        t->list[i] = root_of(m, t->list[i]);
    stp_sort_u32(t->list, t->count);
    for (size_t i = 0; i < t->count; i++)
        if (t->list[i] != a && (kept == 0 || t->list[kept - 1] != t->list[i]))
            t->list[kept++] = t->list[i];
    t->count = kept;
    for (size_t i = 0; i < kept; i++)
        STP_TRY(consider(m, stp_part_pair_of(a, t->list[i]), err));
done:
    return status;
}

static stp_status begin(merging *m, uint32_t part_count, const stp_part_pair *pairs,
                        size_t pair_count, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_forest_create(&m->merged, part_count, NULL, err));
    STP_TRY(stp_alloc(&m->versions, part_count, sizeof *m->versions, "maps", err));
    STP_TRY(stp_alloc(&m->around, part_count, sizeof *m->around, "maps", err));
    for (size_t i = 0; i < pair_count; i++) {
        STP_TRY(add_touching(&m->around[pairs[i].a], pairs[i].b, err));
        STP_TRY(add_touching(&m->around[pairs[i].b], pairs[i].a, err));
        STP_TRY(consider(m, pairs[i], err));
    }
done:
    return status;
}

static int compare_candidates(const void *a, const void *b)
{
    const candidate *p = *(candidate *const *)a, *q = *(candidate *const *)b;
    return comes_before(q, p) - comes_before(p, q);
}

/* Finds out whether the first candidate fits, here and now. */
static stp_status find_answer(merging *m, stp_part_field *field, stp_error *err)
{
    stp_status status = STP_OK;
    candidate *c = &m->heap[0];
    stp_normal_cone cone;
    bool fits = false;
    STP_TRY(cone_of_both(m, &m->parts[c->a], &m->parts[c->b], &cone, err));
    STP_TRY(stp_part_field_fits(field, c->a, c->b, &cone, &fits, err));
    c->fits = fits ? ANSWER_YES : ANSWER_NO;
done:
    return status;
}

/* Of the first candidates of the heap, finds out which fit: of each part the one that comes first,
 * since it will hardly change before its turn. An answer never decides the order. */
static stp_status find_answers(merging *m, stp_part_field *field, stp_error *err)
{
    stp_status status = STP_OK;
    candidate **seen = NULL, **asked = NULL;
    stp_part_question *questions = NULL;
    size_t count = 0;
    uint32_t n = 0;
    STP_TRY(stp_alloc((void *)&seen, 2 * (size_t)LOOK, sizeof *seen, "maps", err));
    STP_TRY(stp_alloc(&questions, LOOK, sizeof *questions, "maps", err));
    asked = seen + LOOK;
    for (size_t i = 0; i < m->heap_count && i < LOOK; i++)
        if (!is_old(m, &m->heap[i]))
            seen[count++] = &m->heap[i];
    qsort((void *)seen, count, sizeof *seen, compare_candidates);
    m->look++;
    for (size_t i = 0; i < count; i++) {
        candidate *c = seen[i];
        const bool first = m->looks[c->a] != m->look && m->looks[c->b] != m->look;
        m->looks[c->a] = m->looks[c->b] = m->look;
        if (!first || c->fits != ANSWER_NONE)
            continue;
        questions[n] = (stp_part_question){.a = c->a, .b = c->b};
        STP_TRY(cone_of_both(m, &m->parts[c->a], &m->parts[c->b], &questions[n].cone, err));
        asked[n++] = c;
    }
    STP_TRY(stp_part_field_ask(field, questions, n, err));
    for (uint32_t i = 0; i < n; i++)
        asked[i]->fits = questions[i].fits ? ANSWER_YES : ANSWER_NO;
done:
    free((void *)seen);
    free(questions);
    return status;
}

/* Merges until no candidate is left. */
static stp_status run(merging *m, stp_part_field *field, stp_error *err)
{
    stp_status status = STP_OK;
    while (m->heap_count > 0) {
        candidate *top = &m->heap[0];
        const bool old = is_old(m, top);
        if (!old && top->fits == ANSWER_NONE)
            STP_TRY(field->firsts ? find_answers(m, field, err) : find_answer(m, field, err));
        const candidate c = pop(m);
        if (old || c.fits == ANSWER_NO)
            continue;
        stp_part_field_join(field, c.a, c.b);
        STP_TRY(merge(m, c.a, c.b, err));
        STP_TRY(meet_again(m, c.a, c.b, err));
    }
done:
    return status;
}

static void clear(merging *m, uint32_t part_count)
{
    for (uint32_t i = 0; m->around && i < part_count; i++)
        free(m->around[i].list);
    free(m->around);
    stp_forest_clear(&m->merged);
    free(m->versions);
    free(m->looks);
    free(m->heap);
    free(m->corners);
}

stp_status stp_parts_merge(stp_part *parts, uint32_t part_count, const stp_part_pair *pairs,
                           size_t pair_count, double cosine, stp_part_field *field, uint32_t **out,
                           stp_error *err)
{
    stp_status status = STP_OK;
    merging m = {.parts = parts, .cosine = cosine};
    uint32_t *roots = NULL;
    STP_TRY(stp_alloc(&roots, part_count, sizeof *roots, "maps", err));
    STP_TRY(begin(&m, part_count, pairs, pair_count, err));
    if (field->firsts)
        STP_TRY(stp_alloc(&m.looks, part_count, sizeof *m.looks, "maps", err));
    STP_TRY(run(&m, field, err));
    for (uint32_t i = 0; i < part_count; i++)
        roots[i] = root_of(&m, i);
    *out = roots;
    roots = NULL;
done:
    clear(&m, part_count);
    free(roots);
    return status;
}
