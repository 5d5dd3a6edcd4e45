/* Takes points from all over the scans and prepares them. */
#include "tools/open/open_draft.h"

#include "base/clock.h"
#include "base/memory.h"
#include "formats/scan/value_range.h"
#include "tools/prep/prep_inputs.h"
#include "tools/prep/prep_run.h"

#include <math.h>
#include <stdlib.h>

/* Points of a draft, if time allows. */
#define DRAFT_POINTS 60000u
/* Points that are read at each place of a file of records. In longer runs the neighbours of a point
 * would be those of its own run, and discs too small to close the gaps between runs. */
#define RUN_POINTS 4u
/* Points that are unpacked of packed chunks. */
#define UNPACKED_POINTS 2000000u
/* With fewer places, a file is read from its beginning to its end. */
#define PLACES_LEAST 64u
/* Seeking ends after this time, on a slow disk. Places come in an order in which the first ones are
 * spread as evenly as all of them. */
#define SEEK_S 0.6
#define BLOCK_POINTS 1024u
/* Of an octree. */
#define DEPTHS_MOST 16

typedef struct draft {
    stp_point *points;
    size_t count, capacity;
    size_t next; /* that prep reads */
    double until_s;
} draft;

/* What is taken of a scan: at each of `places`, every step-th of `depth` points. */
typedef struct pattern {
    uint64_t places, apart, depth, step;
    bool seeks;
} pattern;

static pattern pattern_of(const stp_scan_info *info, uint64_t wanted)
{
    const uint64_t total = info->point_count, apart = info->seek_points;
    const pattern all = {1, 0, total, total / wanted + 1, false};
    if (apart == 1 && wanted / RUN_POINTS >= PLACES_LEAST && total > wanted)
        return (pattern){wanted / RUN_POINTS, total / (wanted / RUN_POINTS), RUN_POINTS, 1, true};
    if (apart < 2 || total / apart < PLACES_LEAST)
        return all;
    const uint64_t places = (total + apart - 1) / apart, share = UNPACKED_POINTS / places + 1;
    const uint64_t depth = share < apart ? share : apart;
    return (pattern){places, apart, depth, depth * places / wanted + 1, true};
}

static stp_status read_run(draft *d, stp_scan *scan, const pattern *p, uint32_t stations_before,
                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_point block[BLOCK_POINTS];
    size_t count = 1;
    for (uint64_t at = 0; at < p->depth && count > 0; at += count) {
        const uint64_t left = p->depth - at;
        STP_TRY(stp_scan_read(scan, block, left < BLOCK_POINTS ? (size_t)left : BLOCK_POINTS,
                              &count, err));
        for (size_t i = (size_t)((p->step - at % p->step) % p->step); i < count; i += p->step) {
            STP_TRY(
                stp_grow(&d->points, &d->capacity, d->count + 1, sizeof *d->points, "points", err));
            if (block[i].station > 0)
                block[i].station = (uint16_t)(block[i].station + stations_before);
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

static stp_status read_scan(draft *d, stp_scan *scan, uint64_t wanted, uint32_t stations_before,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const pattern p = pattern_of(stp_scan_get_info(scan), wanted);
    unsigned bits = 0;
    while (UINT64_C(1) << bits < p.places)
        bits++;
    for (uint64_t i = 0, done = 0; i < UINT64_C(1) << bits; i++) {
        const uint64_t place = reversed(i, bits);
        if (place >= p.places)
            continue;
        if (p.seeks && done++ >= PLACES_LEAST && stp_clock_seconds() > d->until_s)
            break;
        if (p.seeks)
            STP_TRY(stp_scan_seek(scan, place * p.apart, err));
        STP_TRY(read_run(d, scan, &p, stations_before, err));
    }
done:
    return status;
}

/* Opens a scan; of an octree, the depths from the root on that have points enough. *count: points
 * of the whole scan. */
static stp_status open_part(stp_scan **scan, const prep_inputs *in, size_t f,
                            stp_scan_region *region, uint64_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_scan_params params = prep_inputs_params(in, f);
    STP_TRY(stp_scan_open(scan, in->paths[f], &params, err));
    const double spacing = stp_scan_get_info(*scan)->octree_spacing;
    *count = stp_scan_get_info(*scan)->point_count;
    params.region = region;
    for (int depth = 0; spacing > 0.0 && depth < DEPTHS_MOST; depth++) {
        stp_scan_close(scan);
        *region = (stp_scan_region){.resolution = ldexp(spacing, -depth)};
        STP_TRY(stp_scan_open(scan, in->paths[f], &params, err));
        const uint64_t part = stp_scan_get_info(*scan)->point_count;
        if (part >= DRAFT_POINTS || part == *count)
            break;
    }
done:
    return status;
}

static stp_status read_all(draft *d, prep_inputs *in, uint64_t total, stp_error *err)
{
    stp_status status = STP_OK;
    stp_scan *scan = NULL;
    d->until_s = stp_clock_seconds() + SEEK_S;
    for (size_t f = 0; f < in->count; f++) {
        const size_t before = d->count;
        if (in->facts[f].why)
            continue;
        stp_scan_region region;
        uint64_t points = 0;
        STP_TRY(open_part(&scan, in, f, &region, &points, err));
        const double share = (double)points / (double)total * DRAFT_POINTS;
        STP_TRY(read_scan(d, scan, (uint64_t)share + 1, in->files[f].station_begin, err));
        if (in->facts[f].way.projection)
            prep_system_move(in->facts[f].way.projection, d->points + before, d->count - before);
        in->files[f].point_count = d->count - before;
        in->files[f].raster.columns = 0; /* what is taken is no grid any more */
        in->files[f].grid.columns = in->files[f].grid.rows = in->files[f].grid.cell_count = 0;
        stp_scan_close(&scan);
    }
done:
    stp_scan_close(&scan);
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

stp_status open_draft_make(bool *made, const prep_paths *scans, const char *path,
                           const cli_common *common, stp_error *err)
{
    stp_status status = STP_OK;
    draft d = {0};
    stp_pool *pool = NULL;
    stp_prep_source source = {0};
    stp_prep_stats stats = {0};
    prep_inputs in = {.paths = scans->list, .count = scans->count};
    stp_prep_params params = prep_run_defaults(true);
    params.codec = STP_CODEC_RAW; /* the fastest */
    *made = false;
    STP_TRY(prep_inputs_survey(&in, &source, err));
    if (source.point_count <= OPEN_DRAFT_WORTH || in.lines.strip_count > 0 ||
        in.triangles.triangle_count > 0)
        goto done;
    STP_TRY(read_all(&d, &in, source.point_count, err));
    source.context = &d;
    source.read = read_draft;
    source.point_count = d.count;
    source.leaves_out = NULL;
    source.rejected = NULL;
    STP_TRY(stp_pool_create(&pool, (unsigned)common->threads, err));
    const stp_progress silent = *cli_progress(&(cli_common){.quiet = true});
    STP_TRY(stp_prep_run(path, &source, &params, pool, &silent, &stats, err));
    *made = true;
done:
    stp_pool_destroy(&pool);
    prep_inputs_clear(&in);
    free(d.points);
    return status;
}
