/* Plans the memory and disk space of a run of preprocessing, and makes room. */
#include "base/memory.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/scan_lines.h"
#include "preprocess/prep_job.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

/* Memory besides the arrays by point: of the program, and of each thread. */
#define FIXED_BYTES (48u << 20)
#define THREAD_BYTES (40u << 20)
/* Per point: the point, its sheet and mark, and its share of the boxes. */
#define POINT_BYTES (sizeof(stp_cloud_point) + 6u)
/* Per point, while the pieces of a surface are joined: edges at cells' borders, and the neighbours
 * of points on crumbs. The statue takes 3 bytes, an airborne survey with trees 17. */
#define SURFACE_BYTES 20u
/* Per point on every rank: boxes, pieces of surface, patch vertices (docs/mpi.md). */
#define RANK_BYTES 7u
/* Per point if each point is a crumb, without its neighbours: 8 edges (64), its place (4), the
 * pieces' trees, sizes, numbers and sums (30). */
#define CRUMBS_BYTES 98u
/* Per point of which maps are made: its part, its place in the order of the maps, and a sample of a
 * map, or two. */
#define MAPS_BYTES 40u
/* Per such point also, if the gaps between maps are filled: borders, triangles, their vertices;
 * never in temporary files. Dragon takes 90 bytes, a statue of 300 K 136. */
#define FILL_BYTES 140u
/* Per sample of a grid of heights: the height and its colour, and until a leaf is written its
 * samples of all levels and its share of patches. */
#define GRID_BYTES 44u
/* Of a grid that was moved also: where the sample is. */
#define BENT_BYTES 16u
/* Per sample that a rank read, until ranks have given them to each other: height and colour. */
#define GRID_READ_BYTES 14u
/* For a million points that are drawn from outside; and in the worst case for each thread's depth
 * buffer (visibility.c). */
#define VIEW_BYTES (32u << 20)
#define THREAD_VIEW_BYTES (64u << 20)

/* At least so much is planned for files if there are any. */
#define FILES_BYTES (32u << 20)

/* Maps number their points with 32 bits. */
#define MAPPED_POINTS (UINT32_MAX - 2)

/* Greatest size of a neighbour in a list (graph.c), in bytes. */
static uint64_t step_bytes(uint64_t point_count)
{
    uint64_t bytes = 1;
    while (2 * point_count >> (7 * bytes))
        bytes++;
    return bytes;
}

/* What a rank needs of the points, as long as their surface is unknown. While it sorts, it also has
 * the part that it read; later, blocks along its borders, which may be as many as its own. */
static uint64_t point_bytes(const stp_prep_size *size, unsigned ranks)
{
    const uint64_t own = size->points / ranks * POINT_BYTES;
    const uint64_t read = size->read * sizeof(stp_cloud_point);
    return ranks > 1 ? own + (read > own ? read : own) + size->points * RANK_BYTES
                     : size->points * POINT_BYTES;
}

/* What a rank needs of a grid. */
static uint64_t grid_bytes(const stp_prep_size *size, unsigned ranks)
{
    const uint64_t bent = size->bent ? BENT_BYTES : 0;
    const uint64_t own = size->points / ranks * (GRID_BYTES + bent);
    return ranks > 1 ? own + size->read * (GRID_READ_BYTES + bent) + size->points * RANK_BYTES
                     : size->points * (GRID_BYTES + bent);
}

/* Attributes, and once more: no worse than that encoded, by the rank that has the chunk and by rank
 * 0, which writes them. */
static uint64_t number_bytes(const stp_prep_size *size, const stp_ranks *ranks, unsigned count)
{
    if (count == 1)
        return size->points * 2 * size->number_bytes;
    const uint64_t encoded = stp_ranks_is_first(ranks) ? size->points : size->points / count;
    return (size->read + encoded) * size->number_bytes;
}

static uint64_t machine_bytes(void)
{
    long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0 ? (uint64_t)pages * (uint64_t)size : (uint64_t)4 << 30;
}

/* The folder of a file. */
static stp_status folder_of(const char *path, char **out, stp_error *err)
{
    const char *slash = strrchr(path, '/');
    size_t length = !slash ? 1 : slash == path ? 1 : (size_t)(slash - path);
    stp_status status = stp_alloc(out, length + 1, 1, "a path", err);
    if (status == STP_OK)
        memcpy(*out, slash ? path : ".", length);
    return status;
}

static stp_status look_at_folder(stp_prep_plan *plan, stp_error *err)
{
    struct statvfs room;
    if (statvfs(plan->folder, &room) != 0)
        return stp_error_set(err, STP_IO,
                             "%s: no folder for temporary files: %s: give another (--temp)",
                             plan->folder, strerror(errno));
    plan->free_bytes = (uint64_t)room.f_bavail * room.f_frsize;
    return STP_OK;
}

stp_status stp_prep_plan_check(const stp_prep_plan *plan, stp_error *err)
{
    if (plan->free_bytes < plan->temporary_bytes)
        return stp_error_set(
            err, STP_IO,
            "%s has %.1f GB free, but about %.1f GB of temporary files are needed: "
            "free some, give another folder (--temp) or more memory (--memory)",
            plan->folder, 1e-9 * (double)plan->free_bytes, 1e-9 * (double)plan->temporary_bytes);
    return STP_OK;
}

stp_status stp_prep_check_count(const stp_prep_source *source, const stp_prep_params *params,
                                stp_error *err)
{
    const uint64_t most = params->maps ? MAPPED_POINTS : STP_PLACE_MASK;
    if (source->point_count <= most)
        return STP_OK;
    return stp_error_set(err, STP_LIMIT,
                         "%s: there may be at most %llu points %s: split the input into several "
                         "models",
                         source->files[0].name, (unsigned long long)most,
                         params->maps ? "that become maps" : "in a model");
}

stp_status stp_prep_plan_make(stp_prep_plan *out, const char *path, const stp_prep_size *size,
                              const stp_prep_params *params, unsigned thread_count, stp_error *err)
{
    stp_status status = STP_OK;
    /* as many as for points in scan lines, which only the points tell */
    const unsigned k = params->neighbour_count ? params->neighbour_count : STP_SCAN_LINE_NEIGHBOURS;
    uint64_t fixed = FIXED_BYTES + (uint64_t)thread_count * THREAD_BYTES;
    const uint64_t points = size->points;
    const unsigned ranks = size->shared ? stp_ranks_count(params->ranks) : 1;
    const uint64_t numbers = number_bytes(size, params->ranks, ranks);
    const uint64_t maps = points / ranks * (size->maps ? MAPS_BYTES : 0);
    const uint64_t fill = points * (size->fills ? FILL_BYTES : 0);
    const uint64_t here = point_bytes(size, ranks), share = points / ranks;
    uint64_t surface =
        (size->grid ? grid_bytes(size, ranks) : here + share * SURFACE_BYTES) + numbers + maps;
    uint64_t most = size->grid
                        ? surface
                        : here + points * CRUMBS_BYTES + share * k * step_bytes(points) + numbers +
                              maps + VIEW_BYTES + (uint64_t)thread_count * THREAD_VIEW_BYTES;
    stp_prep_plan plan = {.memory_bytes =
                              params->memory_bytes ? params->memory_bytes : machine_bytes() / 2};
    if (params->temp_folder)
        STP_TRY(stp_text_copy(&plan.folder, params->temp_folder, "a path", err));
    else
        STP_TRY(folder_of(path, &plan.folder, err));
    if (plan.memory_bytes < fixed) {
        status =
            stp_error_set(err, STP_LIMIT,
                          "%.0f MB of memory are too few for %u threads: give %.0f MB or more "
                          "(--memory) or fewer --threads",
                          1e-6 * (double)plan.memory_bytes, thread_count, 1e-6 * (double)fixed);
        goto done;
    }
    if (fixed + most + fill > plan.memory_bytes) {
        const uint64_t needed = surface + (size->grid ? 0 : VIEW_BYTES); /* nothing is drawn */
        const uint64_t half = (plan.memory_bytes - fixed) / 2;
        plan.own_bytes = needed + fill <= half ? half : 0;
        plan.temporary_bytes = plan.own_bytes > 0 ? FILES_BYTES : needed;
        plan.most_temporary_bytes =
            most > plan.own_bytes + FILES_BYTES ? most - plan.own_bytes : FILES_BYTES;
        STP_TRY(look_at_folder(&plan, err));
    }
    *out = plan;
    plan.folder = NULL;
done:
    free(plan.folder);
    return status;
}

void stp_prep_plan_clear(stp_prep_plan *plan)
{
    free(plan->folder);
    *plan = (stp_prep_plan){0};
}

/* Whether the scan stays a grid. Other inputs, and what changes or turns points, need them one by
 * one. */
static bool keeps_grid(const stp_prep_source *source, const stp_prep_params *params)
{
    return source->raster.columns > 0 &&
           (source->attributes & STP_POINT_HAS_NORMAL || source->raster_nodes) &&
           !params->join_layers && !params->maps && params->outliers == STP_OUTLIERS_KEEP &&
           params->orient == STP_ORIENT_AUTO;
}

/* Whether points of some file tell their pixels. */
static bool tells_pixels(const stp_prep_source *source)
{
    for (size_t f = 0; f < source->file_count; f++)
        if (source->files[f].pixels_told)
            return true;
    return false;
}

stp_prep_size stp_prep_size_of(const stp_prep_source *source, const stp_prep_params *params)
{
    const bool grid = keeps_grid(source, params);
    const uint64_t places = (uint64_t)source->raster.columns * source->raster.rows;
    return (stp_prep_size){.points = grid ? places : source->point_count,
                           .number_bytes =
                               (source->kept ? stp_attribute_list_bytes(source->kept) : 0) +
                               (tells_pixels(source) ? sizeof(uint32_t) : 0),
                           .grid = grid,
                           .bent = grid && source->raster_nodes,
                           .maps = params->maps != NULL,
                           .fills = params->maps && params->maps->fill};
}

stp_status stp_prep_plan_room(stp_prep_job *job, const stp_prep_size *size, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_plan_clear(&job->plan);
    STP_TRY(stp_prep_plan_make(&job->plan, job->path, size, job->params,
                               stp_pool_thread_count(job->pool), err));
    STP_TRY(stp_prep_plan_check(&job->plan, err));
    const stp_spill_params room = {.memory_bytes =
                                       job->plan.temporary_bytes ? job->plan.memory_bytes : 0,
                                   .own_bytes = job->plan.own_bytes,
                                   .folder = job->plan.folder};
    STP_TRY(stp_spill_create(&job->spill, &room, err));
done:
    return status;
}

stp_status stp_prep_make_room(stp_prep_job *job, uint64_t begin, uint64_t end, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_attribute_list *kept = job->source->kept;
    const bool grid = job->stats->keeps_grid;
    job->records = (stp_rank_part){begin, end};
    STP_TRY(stp_cloud_create(&job->cloud, job->params->first_place, grid ? 0 : end - begin,
                             job->spill, err));
    if (tells_pixels(job->source) && !grid)
        STP_TRY(stp_spill_alloc(job->spill, &job->cloud.pixels, job->source->point_count,
                                sizeof *job->cloud.pixels, "pixels", err));
    if (kept && kept->count > 0)
        STP_TRY(stp_spill_alloc(job->spill, &job->numbers, end - begin,
                                stp_attribute_list_bytes(kept), "attributes", err));
done:
    return status;
}
