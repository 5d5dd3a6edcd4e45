/* One run of preprocessing, as its parts share it. */
#ifndef STP_PREPROCESS_PREP_JOB_H
#define STP_PREPROCESS_PREP_JOB_H

#include "formats/chunk/outside.h"
#include "preprocess/grid/grid_records.h"
#include "preprocess/prep.h"

/* The leaves of lines, of triangles, of maps and of depth images; they are never in temporary
 * files. */
typedef struct stp_prep_shapes {
    stp_triangle_set fill; /* between maps, and the source's triangles */
    stp_line_leaves lines;
    stp_triangle_leaves triangles;
    stp_map_leaves map_leaves;
    stp_depth_images depths;
} stp_prep_shapes;

/* One run of all stages: what is given, what is decided from it, and what the stages make. */
typedef struct stp_prep_job {
    const char *path;
    const stp_prep_source *source;
    const stp_prep_params *params;
    stp_pool *pool;
    const stp_progress *progress;
    stp_prep_stats *stats;

    unsigned k;
    stp_prep_plan plan;
    stp_tree_params tree;
    stp_orient_params orient;

    stp_spill *spill;
    stp_cloud cloud;               /* empty if the scan is a grid of heights */
    bool in_parts;                 /* until they are sorted, each rank has a part of the points */
    stp_height_grid grid;          /* else without columns */
    stp_grid_part part;            /* the file at hand, if several files make the grid */
    stp_grid_records grid_records; /* that this rank read, until ranks have shared the grid */
    stp_maps maps;                 /* none unless they are wanted */
    uint8_t *numbers; /* attributes of `records`, packed, in the spill; NULL: none are kept */
    uint64_t *begins; /* by rank: its first record, from first_place on, then where the last one's
                         end; NULL: none reads a part */
    stp_rank_part records;   /* that this process reads */
    bool lists_rejects;      /* rank 0 lists rejected records */
    stp_bytes rejects;       /* those of this rank's part, until rank 0 has them */
    stp_attribute_list kept; /* the source's, with what is known when all points are read */
    uint64_t unlike;         /* bit a: attribute a is not what the points' fields say */
    stp_prep_shapes shapes;
    stp_outside outside;
    double since; /* when the stage began, as stp_clock_seconds */
} stp_prep_job;

/* Stages, by their places in stp_prep_stage_names. */
enum {
    STP_STAGE_READ,
    STP_STAGE_SORT,
    STP_STAGE_LAYERS,
    STP_STAGE_OUTLIERS,
    STP_STAGE_SURFACE,
    STP_STAGE_ORIENTATION,
    STP_STAGE_CLOSED,
    STP_STAGE_MAPS,
    STP_STAGE_PATCHES
};

/* Decides what the parameters and the source leave open, and empties the statistics. */
void stp_prep_job_begin(stp_prep_job *job);
/* Plans memory and temporary files for a run of that size, in place of any plan before, and creates
 * the spill. Errors: those of stp_prep_plan_make and stp_spill_create. */
stp_status stp_prep_plan_room(stp_prep_job *job, const stp_prep_size *size, stp_error *err);
/* Notes the stage's time and memory and reports that the next stage begins. Errors: CANCELLED. */
stp_status stp_prep_end_stage(stp_prep_job *job, int stage, stp_error *err);
/* Fails unless the points, and what is known of them, are the same on all ranks: else their parts
 * would not fit together. Files may differ, or processors whose mathematics round otherwise. If
 * ranks share the points, the cells tell. what: what a rank did that differs, for the message. */
stp_status stp_prep_agree(const stp_prep_job *job, const char *what, stp_error *err);
/* Runs all stages of points from the stations that files claim to maps and images. Errors: those
 * of the stages. */
stp_status stp_prep_treat_points(stp_prep_job *job, stp_error *err);
/* Sets what 255 stands for in a sample's intensity. Errors: those of stp_cloud_every. */
stp_status stp_prep_decide_intensity(stp_prep_job *job, stp_error *err);
/* Marks outliers, or drops them and tells the source. Errors: those of stp_outliers_find and
 * stp_outliers_drop, and of the source. */
stp_status stp_prep_treat_outliers(stp_prep_job *job, stp_error *err);
/* Chooses the stations that normals will be turned to, if any. */
void stp_prep_choose_stations(stp_prep_job *job);
/* The scanner positions to be noted in the metadata: the one given, or the source's. */
const stp_dvec3 *stp_prep_stations(const stp_prep_job *job);
/* What the source gives of points, as STP_HAS_* of a file: colour, intensity, class. */
uint32_t stp_prep_given(const stp_prep_source *source);
/* How the cloud's surface is to be found, once the cloud and the plan are there. */
stp_surface_params stp_prep_surface_params(const stp_prep_job *job);
/* The longest side of the box of points, lines and triangles. Errors: LIMIT (coordinates too large,
 * or the box too small, for a picture). */
stp_status stp_prep_side(double *out, const stp_prep_source *source, const stp_prep_stats *stats,
                         stp_error *err);
/* Cuts the source's lines and triangles into leaves. Errors: LIMIT (they are too large for the
 * memory), EMPTY (there are no points either), OUT_OF_MEMORY. */
stp_status stp_prep_cut_shapes(stp_prep_job *job, stp_error *err);
/* Adds the triangles between maps to those of the source, and cuts all into leaves, if there are
 * any between maps. Errors: those of stp_triangle_leaves_create. */
stp_status stp_prep_fill_maps(stp_prep_job *job, stp_error *err);
void stp_prep_clear_shapes(stp_prep_shapes *shapes);
/* Counts a stored point in the statistics. */
void stp_prep_count(stp_prep_stats *stats, const stp_cloud_point *point);
/* Reads all points into the cloud, or into the grid if the job keeps it. If the scanner's position
 * is given, they all belong to station 1. A cloud without colours gets a light grey. Errors: those
 * of the source, EMPTY, CORRUPT (more points than the source counts), CANCELLED, OUT_OF_MEMORY, IO.
 */
stp_status stp_prep_read(stp_prep_job *job, stp_error *err);
/* Says that holes cannot grow: INVALID_ARGUMENT. */
stp_status stp_prep_no_grid(stp_error *err);
/* Whether holes may be able to grow, if they are to: images may still become points. Errors:
 * INVALID_ARGUMENT. */
stp_status stp_prep_grid_check(const stp_prep_job *job, stp_error *err);
/* Makes the grid empty, and room for the records of it that this rank reads. Errors: OUT_OF_MEMORY,
 * IO. */
stp_status stp_prep_grid_begin(stp_prep_job *job, stp_error *err);
void stp_prep_grid_clear(stp_prep_job *job);
/* Notes odd heights and where to look first. Errors: OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_prep_grid_look(stp_prep_job *job, stp_error *err);
/* Whether several files make one grid, and this process reads them all. */
bool stp_prep_grid_has_parts(const stp_prep_job *job);
/* Puts a record into the grid, or where this rank's records are. *reject becomes TWICE if the grid
 * has a sample there. */
void stp_prep_grid_add(stp_prep_job *job, const stp_point *point, uint64_t record,
                       stp_reject *reject);
/* Rejects samples at places that files before give, once ranks have read their parts. Errors: those
 * of stp_grid_records_sift and stp_prep_reject. */
stp_status stp_prep_grid_sift(stp_prep_job *job, stp_error *err);
/* Gives each rank the samples of the tiles that it will make leaves of. Errors: those of
 * stp_grid_records_give and stp_leaf_order. */
stp_status stp_prep_grid_share(stp_prep_job *job, stp_error *err);
/* A grid's neighbours are known, so all stages up to the first view have nothing to find. Errors:
 * those of the grid's functions. */
stp_status stp_prep_treat_grid(stp_prep_job *job, stp_error *err);
/* Heights that are floats have no step, and how far apart they are says little about how fine they
 * are: they keep a quarter of their noise and a 16th bit of their range, but no more than a part of
 * a cell: `finest`. */
void stp_prep_height_precision(stp_prep_job *job, double noise, double finest);
/* Bits of the normals of leaves that are grids: so many, but no more than these need. */
unsigned stp_prep_grid_bits(unsigned bits);
/* Decides whether each rank reads a part of the inputs alone. All ranks decide alike. Errors:
 * CANCELLED, IO. */
stp_status stp_prep_choose_parts(stp_prep_job *job, stp_error *err);
/* Whether points of some file tell their pixels. */
bool stp_prep_tells_pixels(const stp_prep_source *source);
/* How much a run has to prepare, once parts are chosen. */
stp_prep_size stp_prep_job_size(const stp_prep_job *job);
/* Tells the source of a rejected record, at once or when all parts are read. Errors: those of the
 * source, OUT_OF_MEMORY. */
stp_status stp_prep_reject(stp_prep_job *job, uint64_t place, stp_reject reason, stp_error *err);
/* Tells the source, on rank 0, of the rejected records that ranks have kept, in ascending order.
 * Errors: likewise, IO, CANCELLED. */
stp_status stp_prep_give_rejects(stp_prep_job *job, stp_error *err);
/* Makes room for records [begin, end) and their attributes. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_prep_make_room(stp_prep_job *job, uint64_t begin, uint64_t end, stp_error *err);
/* Sorts the parts that ranks read, once the claims of their files are checked; ranks then share
 * the points. Errors: those of stp_claims_check and stp_cloud_sort_parts. */
stp_status stp_prep_sort_parts(stp_prep_job *job, stp_error *err);
/* Lets `read` read this rank's part, and adds up what all ranks read. If any rank fails, each reads
 * everything, which says why or leaves a file out. Errors: those of read. */
stp_status stp_prep_read_part(stp_prep_job *job, stp_status (*read)(stp_prep_job *, stp_error *),
                              stp_error *err);

#endif
