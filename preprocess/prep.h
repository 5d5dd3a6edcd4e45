/* The whole of preprocessing: scans in, one chunk file out.
 *
 * Stages: read, sort, neighbours, spacing, normals, orientation, patches (with errors, tree and
 * writing). Memory: the points are held in memory (about 150 bytes each with k = 16); a failure
 * leaves no file. Threads: those of the pool; the same bytes for any number. */
#ifndef STP_PREPROCESS_PREP_H
#define STP_PREPROCESS_PREP_H

#include "formats/scan/scan.h"
#include "preprocess/orientation.h"
#include "preprocess/tree.h"

/* Where the points come from: fills up to capacity points, *count 0 at the end. */
typedef struct stp_prep_source {
    void *context;
    stp_status (*read)(void *context, stp_point *points, size_t capacity, size_t *count,
                       stp_error *err);
    uint64_t point_count;      /* expected, for progress */
    uint32_t attributes;       /* STP_POINT_HAS_* */
    double coordinate_step;    /* scale of integer coordinates, 0 for floats */
    const stp_dvec3 *stations; /* that the points are from, borrowed */
    uint32_t station_count;
    const char *name; /* for the metadata: without its folder */
} stp_prep_source;

typedef struct stp_prep_params {
    unsigned neighbour_count; /* 0: 16 */
    double lambda;            /* 0: 1.7 */
    double precision;         /* 0: half the source's scale, if it has one */
    stp_orient_mode orient;
    stp_dvec3 orient_position;
    stp_codec codec;
    bool force;
} stp_prep_params;

#define STP_PREP_STAGE_COUNT 7

typedef struct stp_prep_stats {
    uint64_t points_in, points_out;
    uint64_t rejected[STP_REJECT_COUNT]; /* by reason; NONE: 0 */
    stp_tree_stats tree;
    stp_orientation orientation;
    uint32_t station_count;      /* scanner positions that normals were turned to */
    uint64_t points_unstationed; /* stored, of unknown stations, where normals ask for them */
    double seconds;
    double stage_seconds[STP_PREP_STAGE_COUNT];
} stp_prep_stats;

/* Names of the stages, in order. */
extern const char *const stp_prep_stage_names[STP_PREP_STAGE_COUNT];

/* Errors: EMPTY (no valid point), LIMIT (more than 2^32 - 2 points), those of the source and the
 * stages. */
stp_status stp_prep_run(const char *path, const stp_prep_source *source,
                        const stp_prep_params *params, stp_pool *pool, const stp_progress *progress,
                        stp_prep_stats *stats, stp_error *err);

#endif
