/* One run of preprocessing: what is given, what is decided from it, and what the stages make. The
 * run itself is in prep.c; each prep_*.c has stages. Threads: the one that called stp_prep. */
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
 * the spill. Errors: those of stp_prep_plan_make, stp_prep_plan_check and stp_spill_create. */
stp_status stp_prep_plan_room(stp_prep_job *job, const stp_prep_size *size, stp_error *err);
/* Notes the stage's time and memory and reports that the next stage begins. Errors: CANCELLED. */
stp_status stp_prep_end_stage(stp_prep_job *job, int stage, stp_error *err);
/* Fails unless the points, and what is known of them, are the same on all ranks: else their parts
 * would not fit together. Files may differ, or processors whose mathematics round otherwise. If
 * ranks share the points, the cells tell. what: what a rank did that differs, for the message. */
stp_status stp_prep_agree(const stp_prep_job *job, const char *what, stp_error *err);
/* The scanner positions to be noted in the metadata: the one given, or the source's. */
const stp_dvec3 *stp_prep_stations(const stp_prep_job *job);
/* What the source gives of points, as STP_HAS_* of a file: colour, intensity, class. */
uint32_t stp_prep_given(const stp_prep_source *source);
/* Makes room for records [begin, end) and their attributes. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_prep_make_room(stp_prep_job *job, uint64_t begin, uint64_t end, stp_error *err);

#endif
