/* The whole of preprocessing: scans, lines and triangles in, one chunk file out.
 *
 * Stages: read, sort, layers (where they are joined), outliers (where they are looked for), surface
 * (neighbours, spacings, normals, pieces), orientation, patches (with errors, tree and writing).
 * Memory: what is given; where the points and what is known of them, about 90 bytes each, do not
 * fit there, they lie in temporary files (base/spill.h); lines and triangles are held in memory
 * whole. A failure or a kill leaves no file. Threads: those of the pool; the same bytes for any
 * number, and for any memory. */
#ifndef STP_PREPROCESS_PREP_H
#define STP_PREPROCESS_PREP_H

#include "formats/scan/mesh/line_set.h"
#include "formats/scan/mesh/triangle_set.h"
#include "formats/scan/scan.h"
#include "preprocess/cloud/outliers.h"
#include "preprocess/orient/orientation.h"
#include "preprocess/surface/join_layers.h"
#include "preprocess/surface/surface.h"
#include "preprocess/tree/tree.h"
#include "preprocess/viewpoint/first_camera.h"

/* Neighbours asked for of each point, where the caller does not say. */
#define STP_PREP_NEIGHBOURS 16u

/* A file that points come from, for the metadata. */
typedef struct stp_prep_file {
    const char *name;     /* without its folder */
    uint64_t point_count; /* that were read of it, in the end */
    stp_scan_note *notes;
    uint32_t note_count;
    bool unreadable; /* nothing of it is stored */
    stp_scan_grid grid;
    stp_station_word station_word;
    uint32_t station_begin, station_count; /* of the source's */
} stp_prep_file;

/* Where the points come from. */
typedef struct stp_prep_source {
    void *context;
    /* Fills up to capacity points, *count 0 at the end. */
    stp_status (*read)(void *context, stp_point *points, size_t capacity, size_t *count,
                       stp_error *err);
    /* Asked when read fails: true if the file that is being read, *file, is left out as a whole,
     * what came of it already included, and the next read goes on behind it. NULL: read's error
     * ends all.
     */
    bool (*leaves_out)(void *context, const stp_error *why, size_t *file);
    const size_t *file; /* of the points that came last; NULL where leaves_out is */
    /* Hears of each record that is not stored, by its number in all that is read, while it is read
     * and, of outliers, once more from the first on when all are; may be NULL. */
    stp_status (*rejected)(void *context, uint64_t place, stp_reject reason, stp_error *err);
    uint64_t point_count;         /* records, no more will come */
    uint32_t attributes;          /* STP_POINT_HAS_* */
    double coordinate_step;       /* scale of integer coordinates, 0 for floats */
    bool floats;                  /* some of the points have no such scale */
    bool heights;                 /* z is the height */
    const stp_dvec3 *stations;    /* that the points are from, borrowed */
    const stp_dvec3 *station_ups; /* their up axes, likewise; zero where not told, NULL: nowhere */
    uint32_t station_count;
    const stp_line_set *lines;         /* beside the points, borrowed; NULL for none */
    const stp_triangle_set *triangles; /* likewise */
    const stp_prep_file *files;        /* borrowed, valid to the end */
    size_t file_count;                 /* at least 1 */
} stp_prep_source;

/* What a run will take, before it begins. */
typedef struct stp_prep_plan {
    uint64_t memory_bytes;         /* the limit */
    uint64_t temporary_bytes;      /* of files, for a surface; 0: everything fits in memory */
    uint64_t most_temporary_bytes; /* where nothing but crumbs is found, such as of leaves */
    uint64_t free_bytes;           /* in the folder, where temporary_bytes is not 0 */
    char *folder;                  /* of temporary files, owned */
} stp_prep_plan;

typedef struct stp_prep_params {
    unsigned neighbour_count; /* 0: STP_PREP_NEIGHBOURS */
    double lambda;            /* 0: 1.7 */
    double precision;         /* 0: half the source's scale, if it has one */
    bool exact;               /* positions round to the numbers that were read */
    bool join_layers;         /* join_layers.h; not with exact */
    stp_orient_mode orient;
    stp_dvec3 orient_position;
    stp_codec codec;
    stp_outlier_mode outliers;
    double outlier_distance; /* spacings; 0: STP_OUTLIER_DISTANCE */
    bool unlit;              /* drawn so unless told otherwise */
    bool force;
    uint64_t memory_bytes;   /* the process's limit; 0: half the machine's */
    const char *temp_folder; /* NULL: where the output goes */
    /* Hears what the run will take before a point is read; may be NULL. */
    void (*planned)(const stp_prep_plan *plan);
} stp_prep_params;

#define STP_PREP_STAGE_COUNT 8

typedef struct stp_prep_stats {
    uint64_t points_in, points_out;
    uint64_t rejected[STP_REJECT_COUNT]; /* by reason; NONE: 0 */
    stp_dbox box;                        /* of the points that were read and not rejected */
    stp_line_counts lines;
    stp_triangle_counts triangles;
    stp_tree_stats tree;
    stp_resolution resolution; /* what tree.displacement is held against */
    stp_orientation orientation;
    uint64_t closed_count;       /* points whose backs are proven hidden (enclosure.h) */
    stp_outlier_mode outliers;   /* what was done with them, */
    double outlier_distance;     /* and at how many spacings */
    uint64_t outlier_count;      /* marked, or dropped and among the rejected */
    uint16_t intensity_max;      /* of what is stored; 255 in the file stands for it */
    uint32_t station_count;      /* scanner positions that normals were turned to */
    uint32_t stations_off;       /* that points cannot be seen from: taken off, */
    uint32_t stations_refused;   /* and those of them that a file claims */
    stp_first_camera first;      /* what the model is first seen by */
    uint64_t points_unstationed; /* stored, of unknown stations, where normals ask for them */
    uint64_t temporary_bytes;    /* of files, at most at a time */
    stp_surface_counts normals_wide;
    bool join_layers; /* was asked for */
    stp_joined_layers joined;
    uint64_t normals_seen; /* from windows of images, because of noise along the rays */
    double seconds;
    double stage_seconds[STP_PREP_STAGE_COUNT];
    uint64_t stage_peak_bytes[STP_PREP_STAGE_COUNT]; /* held at most up to the stage's end; 0: it
                                                        was left out */
} stp_prep_stats;

/* Names of the stages, in order. */
extern const char *const stp_prep_stage_names[STP_PREP_STAGE_COUNT];

/* Errors: IO (no such folder, not enough room in it), LIMIT (too little memory for any model),
 * OUT_OF_MEMORY. */
stp_status stp_prep_plan_make(stp_prep_plan *out, const char *path, uint64_t point_count,
                              const stp_prep_params *params, unsigned thread_count, stp_error *err);
void stp_prep_plan_clear(stp_prep_plan *plan);

/* Errors: EMPTY (no valid point, line or triangle), LIMIT (more than 2^32 - 2 points, or lines and
 * triangles that take more than half of the memory), those of the plan, the source
 * and the stages. */
stp_status stp_prep_run(const char *path, const stp_prep_source *source,
                        const stp_prep_params *params, stp_pool *pool, const stp_progress *progress,
                        stp_prep_stats *stats, stp_error *err);

#endif
