/* Crumbs between the sheets. */
#include "preprocess/orient/crumbs.h"

#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/orient/kept_walk.h"

#include <string.h>

/* Crumbs lie beside crumbs: turning one may make another wrong. */
#define SWEEPS 3

typedef struct crumb_vote {
    const stp_sheets *sheets;
    float *odds; /* by kept point: log odds; above 0 if its neighbours agree */
    float *sums; /* by piece: sum over a crumb */
} crumb_vote;

static float odds_of(const stp_sheets *s, uint64_t self, const uint64_t *list)
{
    float sum = 0.0f;
    for (unsigned i = 0; i < s->k && list[i] != STP_PLACE_NONE; i++) {
        bool own = stp_sheets_root(s, self) == stp_sheets_root(s, list[i]);
        if (own || !(s->cloud->marks[list[i]] & STP_MARK_ORIENTED))
            continue;
        stp_relation r = stp_relate_marked(s->cloud, self, list[i]);
        if (r.rank < STP_RANK_NONE)
            sum += stp_relation_odds(r);
    }
    return sum;
}

/* Whether a kept point may be turned. */
static bool is_asked(const stp_sheets *s, uint64_t point)
{
    return stp_sheets_on_crumb(s, point) && s->cloud->marks[point] & STP_MARK_ORIENTED;
}

static stp_status weigh_cell(void *context, size_t index, unsigned worker, stp_error *err)
{
    const crumb_vote *vote = context;
    const stp_sheets *s = vote->sheets;
    (void)worker;
    (void)err;
    for (stp_kept_walk kept = stp_kept_begin(s, index); stp_kept_next(&kept);)
        vote->odds[kept.number] =
            is_asked(s, kept.self) ? odds_of(s, kept.self, kept.neighbours) : 0.0f;
    return STP_OK;
}

static void sum_crumbs(void *context)
{
    const crumb_vote *vote = context;
    const stp_sheets *s = vote->sheets;
    for (uint32_t c = 0; c < s->cloud->cell_count; c++) {
        stp_spill_relieve(s->cloud->spill);
        for (uint32_t i = 0; i < s->graphs[c].kept_count; i++) {
            const uint64_t point = s->cloud->cells[c].begin + s->graphs[c].kept[i];
            if (is_asked(s, point))
                vote->sums[stp_sheets_root(s, point)] += vote->odds[s->kept_begin[c] + i];
        }
    }
}

static void turn_crumbs(const crumb_vote *vote)
{
    const stp_sheets *s = vote->sheets;
    for (uint32_t c = 0; c < s->cloud->cell_count; c++) {
        stp_spill_relieve(s->cloud->spill);
        for (uint32_t i = 0; i < s->graphs[c].kept_count; i++) {
            const uint64_t point = s->cloud->cells[c].begin + s->graphs[c].kept[i];
            if (is_asked(s, point) && vote->sums[stp_sheets_root(s, point)] < 0.0f)
                s->cloud->marks[point] ^= STP_MARK_TURNED;
        }
    }
}

stp_status stp_crumbs_turn(const stp_sheets *s, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_spill *spill = s->cloud->spill;
    const uint64_t kept = s->kept_begin[s->cloud->cell_count];
    const size_t bytes = s->piece_count * sizeof(float);
    crumb_vote vote = {.sheets = s};
    STP_TRY(stp_spill_alloc(spill, &vote.odds, kept, sizeof *vote.odds, "pieces", err));
    STP_TRY(stp_spill_alloc(spill, &vote.sums, s->piece_count, sizeof *vote.sums, "pieces", err));
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        STP_TRY(stp_cloud_run_own(s->cloud, pool, weigh_cell, &vote, err));
        memset(vote.sums, 0, bytes);
        STP_TRY(stp_cloud_in_turn(s->cloud, sum_crumbs, &vote, vote.sums, bytes, err));
        turn_crumbs(&vote);
        STP_TRY(stp_cloud_refresh(s->cloud, STP_ARRAY_MARKS, err));
    }
done:
    stp_spill_free(spill, vote.sums);
    stp_spill_free(spill, vote.odds);
    return status;
}
