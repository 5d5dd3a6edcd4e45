/* Takes points from all over the scans and prepares them. */
#include "tools/open/open_draft.h"

#include "base/clock.h"
#include "base/memory.h"
#include "formats/scan/value_range.h"
#include "tools/prep/prep_inputs.h"
#include "tools/prep/prep_run.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Points of a draft, if time allows. */
#define DRAFT_POINTS 60000u
/* Points that are read at each place of a file of records. In longer runs the neighbours of a point
 * would be those of its own run, and discs too small to close the gaps between runs. */
#define RUN_POINTS 4u
/* Points that are unpacked of packed chunks. */
#define UNPACKED_POINTS 2000000u
/* With fewer places, a file is read from its beginning to its end. */
#define PLACES_LEAST 64u
/* Seeking ends after this time, on a slow disk. */
#define SEEK_S 0.6
#define BLOCK_POINTS 1024u
/* Of an octree. */
#define DEPTHS_MOST 16

typedef struct draft {
    stp_point *points;
    size_t count, capacity;
    size_t next; /* that prep reads */
    double until_s;
    const prep_where *where;    /* bound to the scan that is read */
    stp_projection *projection; /* of that scan; NULL: its points stay */
} draft;

/* What is taken of a scan: at each of `places`, every step-th of `depth` points. */
typedef struct pattern {
    uint64_t places, apart, depth, step;
    bool seeks;
} pattern;

static pattern pattern_of(const stp_scan_info *info, uint64_t wanted)
{
    /* grids are read with a step; each thread would count lines anew, or read up to its places */
    const bool whole =
        info->raster.columns > 0 || info->grid.columns > 0 || info->counted || info->seek_reads;
    const uint64_t total = info->point_count, apart = whole ? 0 : info->seek_points;
    const pattern all = {1, 0, total, total / wanted + 1, false};
    if (apart == 1 && wanted / RUN_POINTS >= PLACES_LEAST && total > wanted)
        return (pattern){wanted / RUN_POINTS, total / (wanted / RUN_POINTS), RUN_POINTS, 1, true};
    if (apart < 2 || total / apart < PLACES_LEAST)
        return all;
    const uint64_t places = (total + apart - 1) / apart, share = UNPACKED_POINTS / places + 1;
    const uint64_t depth = share < apart ? share : apart;
    return (pattern){places, apart, depth, depth * places / wanted + 1, true};
}

/* Reads the next points of a scan by a pattern, and adds them to d. */
static stp_status read_run(draft *d, stp_scan *scan, const pattern *p, stp_error *err)
{
    stp_status status = STP_OK;
    stp_point block[BLOCK_POINTS];
    size_t count = 1;
    for (uint64_t at = 0; at < p->depth && count > 0; at += count) {
        const uint64_t left = p->depth - at;
        STP_TRY(stp_scan_read(scan, block, left < BLOCK_POINTS ? (size_t)left : BLOCK_POINTS,
                              &count, err));
        if (d->projection)
            prep_system_move(d->projection, block, count);
        prep_where_reject(d->where, stp_scan_get_info(scan), stp_scan_numbers(scan), block, count);
        for (size_t i = (size_t)((p->step - at % p->step) % p->step); i < count; i += p->step) {
            if (block[i].reject == STP_REJECT_WHERE)
                continue;
            STP_TRY(
                stp_grow(&d->points, &d->capacity, d->count + 1, sizeof *d->points, "points", err));
            d->points[d->count++] = block[i];
        }
    }
done:
    return status;
}

/* The bits of `index` in reverse. */
static uint64_t reversed(uint64_t index, unsigned bits)
{
    uint64_t out = 0;
    for (unsigned i = 0; i < bits; i++)
        out |= (index >> i & 1) << (bits - 1 - i);
    return out;
}

/* One scan's places, which the threads of a pool share. Each thread has the scan open for itself.
 */
typedef struct reading {
    const char *path;
    const stp_scan_params *params;
    stp_scan **scans; /* [worker]; those that are NULL are opened when their thread begins */
    const pattern *pattern;
    const uint64_t *places; /* in the order in which they are read */
    draft *runs;            /* of each place */
    double until_s;
} reading;

static stp_status read_place(void *context, size_t index, unsigned worker, stp_error *err)
{
    reading *r = context;
    stp_status status = STP_OK;
    if (index >= PLACES_LEAST && stp_clock_seconds() > r->until_s)
        return STP_OK;
    if (r->scans[worker] == NULL)
        STP_TRY(stp_scan_open(&r->scans[worker], r->path, r->params, err));
    STP_TRY(stp_scan_seek(r->scans[worker], r->places[index] * r->pattern->apart, err));
    STP_TRY(read_run(&r->runs[index], r->scans[worker], r->pattern, err));
done:
    return status;
}

/* Adds the runs to d, in their order. */
static stp_status join_runs(draft *d, const draft *runs, size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t i = 0; i < count; i++) {
        if (runs[i].count == 0)
            continue;
        STP_TRY(stp_grow(&d->points, &d->capacity, d->count + runs[i].count, sizeof *d->points,
                         "points", err));
        memcpy(d->points + d->count, runs[i].points, runs[i].count * sizeof *d->points);
        d->count += runs[i].count;
    }
done:
    return status;
}

/* The places of a pattern in an order in which the first ones are spread as evenly as all. */
static void order_places(uint64_t *places, uint64_t count)
{
    unsigned bits = 0;
    while (UINT64_C(1) << bits < count)
        bits++;
    for (uint64_t i = 0, n = 0; n < count; i++) {
        places[n] = reversed(i, bits);
        n += places[n] < count;
    }
}

/* Seeks to the places of a scan. first: the scan, open; it is closed. */
static stp_status read_places(draft *d, reading *r, stp_scan **first, stp_pool *pool,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const size_t count = (size_t)r->pattern->places;
    const unsigned threads = stp_pool_thread_count(pool);
    uint64_t *places = NULL;
    STP_TRY(stp_alloc(&places, count, sizeof *places, "places", err));
    STP_TRY(stp_alloc(&r->runs, count, sizeof *r->runs, "places", err));
    STP_TRY(stp_alloc(&r->scans, threads, sizeof *r->scans, "scans", err));
    order_places(places, count);
    r->places = places;
    r->scans[0] = *first;
    *first = NULL;
    for (size_t i = 0; i < count; i++) {
        r->runs[i].where = d->where;
        r->runs[i].projection = d->projection;
    }
    /* one thread at a time uses a mirror or a projection */
    const bool alone = r->params->mirror != NULL || d->projection != NULL;
    if (!alone)
        STP_TRY(stp_pool_run(pool, count, read_place, r, err));
    for (size_t i = 0; alone && i < count; i++)
        STP_TRY(read_place(r, i, 0, err));
    STP_TRY(join_runs(d, r->runs, count, err));
done:
    for (unsigned i = 0; r->scans != NULL && i < threads; i++)
        stp_scan_close(&r->scans[i]);
    for (size_t i = 0; r->runs != NULL && i < count; i++)
        free(r->runs[i].points);
    free(r->scans);
    free(r->runs);
    free(places);
    return status;
}

/* Opens a scan; of an octree, the depths from the root on that have points enough. *count: points
 * of the whole scan. */
static stp_status open_part(stp_scan **scan, const char *path, stp_scan_params *params,
                            stp_scan_region *region, uint64_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_scan_open(scan, path, params, err));
    const double spacing = stp_scan_get_info(*scan)->octree_spacing;
    *count = stp_scan_get_info(*scan)->point_count;
    for (int depth = 0; spacing > 0.0 && depth < DEPTHS_MOST; depth++) {
        stp_scan_close(scan);
        *region = (stp_scan_region){.resolution = ldexp(spacing, -depth)};
        params->region = region;
        STP_TRY(stp_scan_open(scan, path, params, err));
        const uint64_t part = stp_scan_get_info(*scan)->point_count;
        if (part >= DRAFT_POINTS || part == *count)
            break;
    }
done:
    return status;
}

/* Reads a part of a scan. total: points of all scans. */
static stp_status read_scan(draft *d, prep_inputs *in, size_t f, uint64_t total, stp_pool *pool,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_scan *scan = NULL;
    stp_scan_region region;
    stp_scan_params params = prep_inputs_params(in, f);
    const size_t before = d->count;
    uint64_t points = 0;
    STP_TRY(open_part(&scan, in->paths[f], &params, &region, &points, err));
    prep_where_open(&in->where, stp_scan_get_info(scan));
    d->where = &in->where;
    d->projection = in->facts[f].way.projection;
    const double share = (double)points / (double)total * DRAFT_POINTS;
    const pattern p = pattern_of(stp_scan_get_info(scan), (uint64_t)share + 1);
    reading r = {.path = in->paths[f], .params = &params, .pattern = &p, .until_s = d->until_s};
    STP_TRY(p.seeks ? read_places(d, &r, &scan, pool, err) : read_run(d, scan, &p, err));
    for (size_t i = before; i < d->count; i++)
        if (d->points[i].station > 0)
            d->points[i].station = (uint16_t)(d->points[i].station + in->files[f].station_begin);
done:
    stp_scan_close(&scan);
    return status;
}

static stp_status read_all(draft *d, prep_inputs *in, uint64_t total, stp_pool *pool,
                           stp_error *err)
{
    stp_status status = STP_OK;
    d->until_s = stp_clock_seconds() + SEEK_S;
    for (size_t f = 0; f < in->count; f++) {
        const size_t before = d->count;
        if (in->facts[f].why)
            continue;
        STP_TRY(read_scan(d, in, f, total, pool, err));
        in->files[f].point_count = d->count - before;
        in->files[f].raster.columns = 0;
        in->files[f].grid.columns = in->files[f].grid.rows = in->files[f].grid.cell_count = 0;
    }
done:
    return status;
}

static stp_status read_draft(void *context, stp_point *points, size_t capacity, size_t *count,
                             stp_error *err)
{
    draft *d = context;
    (void)err;
    for (*count = 0; *count < capacity && d->next < d->count; (*count)++)
        points[*count] = d->points[d->next++];
    return STP_OK;
}

static stp_status survey(prep_inputs *in, const prep_paths *scans, uint32_t grid_step,
                         const char *where, stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    prep_inputs_clear(in);
    *in = (prep_inputs){.paths = scans->list, .count = scans->count};
    *source = (stp_prep_source){0};
    in->params.grid_step = grid_step;
    STP_TRY(prep_where_parse(&in->where, where, err));
    in->params.numbers = where != NULL;
    STP_TRY(prep_inputs_survey(in, source, err));
done:
    return status;
}

/* Whether all scans are grids of heights or images of a camera. */
static bool are_grids(const prep_inputs *in)
{
    bool grids = true;
    for (size_t f = 0; f < in->count; f++)
        grids &= in->files[f].raster.columns > 0 || in->files[f].grid.columns > 0;
    return grids;
}

/* Takes points of the scans for the source. */
static stp_status take_points(draft *d, prep_inputs *in, stp_prep_source *source, stp_pool *pool,
                              stp_error *err)
{
    const stp_status status = read_all(d, in, source->point_count, pool, err);
    source->context = d;
    source->read = read_draft;
    source->point_count = d->count;
    source->raster = (stp_scan_raster){0}; /* what is taken is no grid any more */
    source->leaves_out = NULL;
    source->rejected = NULL;
    return status;
}

stp_status open_draft_make(bool *made, const prep_paths *scans, const char *path, const char *where,
                           const cli_common *common, stp_error *err)
{
    stp_status status = STP_OK;
    draft d = {0};
    stp_pool *pool = NULL;
    stp_prep_source source = {0};
    stp_prep_stats stats = {0};
    prep_inputs in = {0};
    stp_prep_params params = prep_run_defaults(true);
    params.codec = STP_CODEC_RAW; /* the fastest */
    *made = false;
    STP_TRY(survey(&in, scans, 0, where, &source, err));
    if (source.point_count <= OPEN_DRAFT_WORTH || in.lines.strip_count > 0 ||
        in.triangles.triangle_count > 0)
        goto done;
    if (are_grids(&in) && !where) { /* such a draft may not be empty */
        const double step = sqrt((double)source.point_count / DRAFT_POINTS);
        STP_TRY(survey(&in, scans, (uint32_t)ceil(step), where, &source, err));
    }
    STP_TRY(stp_pool_create(&pool, (unsigned)common->threads, err));
    if (source.point_count > OPEN_DRAFT_WORTH) {
        STP_TRY(take_points(&d, &in, &source, pool, err));
        if (where && d.count == 0)
            goto done;
    }
    const stp_progress silent = *cli_progress(&(cli_common){.quiet = true});
    STP_TRY(stp_prep_run(path, &source, &params, pool, &silent, &stats, err));
    *made = true;
done:
    stp_pool_destroy(&pool);
    prep_inputs_clear(&in);
    free(d.points);
    return status;
}
