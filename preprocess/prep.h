/* All of preprocessing: scans, lines and triangles in, one chunk file out.
 *
 * Stages: read, sort, layers (if they are joined), outliers (if they are looked for), surface
 * (neighbours, spacings, normals, pieces), orientation, closed, maps (if they are wanted), patches
 * (with errors, tree and writing). A grid of heights has no sort, orientation and closed
 * (grid/height_grid.h). Memory: as given. If the points and what is known of them, about 90 bytes
 * per point, do not fit, they go to temporary files (base/spill.h). Lines and triangles are held in
 * memory as a whole. A failure or a kill leaves no file. Threads: those of the pool. The output has
 * the same bytes for any number of threads and any memory. */
#ifndef STP_PREPROCESS_PREP_H
#define STP_PREPROCESS_PREP_H

#include "formats/scan/mesh/line_set.h"
#include "formats/scan/mesh/triangle_set.h"
#include "formats/scan/scan.h"
#include "preprocess/cloud/outliers.h"
#include "preprocess/maps/maps.h"
#include "preprocess/orient/orientation.h"
#include "preprocess/surface/join_layers.h"
#include "preprocess/surface/surface.h"
#include "preprocess/tree/tree.h"
#include "preprocess/viewpoint/first_camera.h"

/* The default number of neighbours of a point. */
#define STP_PREP_NEIGHBOURS 16u

/* A file that points come from, for the metadata. */
typedef struct stp_prep_file {
    const char *name;     /* without its folder */
    uint64_t point_count; /* points read from it, final after reading */
    stp_scan_note *notes;
    uint32_t note_count;
    bool unreadable; /* nothing from it is stored */
    stp_scan_grid grid;
    stp_scan_image *images; /* as stp_scan_info has them */
    uint32_t image_count;
    bool pixels_told;
    stp_scan_raster raster;
    stp_dvec3 *raster_nodes; /* of a raster that was moved (scan.h), z is 0; NULL: it was not */
    stp_station_word station_word;
    uint32_t station_begin, station_count; /* of the source's stations */
} stp_prep_file;

/* Where the points come from. */
typedef struct stp_prep_source {
    void *context;
    /* Reads up to capacity points. *count is 0 at the end. */
    stp_status (*read)(void *context, stp_point *points, size_t capacity, size_t *count,
                       stp_error *err);
    /* Called when read fails. True: the whole file being read, *file, is left out, even points that
     * were read already, and the next read goes on after it. NULL: an error of read ends the run.
     */
    bool (*leaves_out)(void *context, const stp_error *why, size_t *file);
    const size_t *file; /* file of the points read last; NULL if leaves_out is NULL */
    /* The last place, not behind `place`, at which a part may begin: every record of some files,
     * every so manieth of others, else only the first. NULL: there are no parts. */
    uint64_t (*part_begin)(void *context, uint64_t place);
    /* From here on read gives the records from `begin`, a place of part_begin, to `end`, and the
     * files have the point counts of their headers. 0 to UINT64_MAX: all of them, counted anew.
     * Errors: those of read. */
    stp_status (*read_part)(void *context, uint64_t begin, uint64_t end, stp_error *err);
    /* Called for each record that is not stored, with its number among all records: during reading,
     * and for dropped outliers after reading, again in ascending order. May be NULL. */
    stp_status (*rejected)(void *context, uint64_t place, stp_reject reason, stp_error *err);
    const stp_attribute_list *kept; /* attributes that the model keeps; NULL: none */
    /* The packed numbers of the points read last, point by point; asked for if `kept` has any. */
    const uint8_t *(*numbers)(void *context);
    uint64_t point_count;   /* records; there will not be more */
    uint32_t attributes;    /* STP_POINT_HAS_*: normals, which orient the model, only if every
                               input has them */
    bool some_normals;      /* some inputs have normals */
    double coordinate_step; /* scale of integer coordinates, 0 for floats */
    double intensity_full;  /* all files' number for intensity 65535; 0: not known */
    bool floats;            /* some points have no such scale */
    /* What formats say is up (stp_prep_told_up): z, else y, else -y; nothing: not told. */
    bool heights, y_up, y_down;
    bool y_likely_down;           /* -y is up unless the points say that z is */
    const stp_dvec3 *stations;    /* stations of the points, borrowed */
    const stp_dvec3 *station_ups; /* up axes of the stations; zero: not told; NULL: none told */
    uint32_t station_count;
    const stp_line_set *lines;         /* beside the points, borrowed; NULL for none */
    const stp_triangle_set *triangles; /* likewise */
    const stp_mesh *mesh;          /* the faces under the points, for maps, borrowed; NULL: none */
    stp_scan_raster raster;        /* if the records are one grid of heights */
    const stp_dvec3 *raster_nodes; /* of it, if it was moved; borrowed */
    const stp_prep_file *files;    /* borrowed, valid to the end */
    size_t file_count;             /* at least 1 */
} stp_prep_source;

/* What formats say is up; zero: they do not. */
static inline stp_dvec3 stp_prep_told_up(const stp_prep_source *source)
{
    if (source->heights)
        return (stp_dvec3){0.0, 0.0, 1.0};
    return (stp_dvec3){0.0, source->y_up ? 1.0 : source->y_down ? -1.0 : 0.0, 0.0};
}

/* How much is to be prepared. */
typedef struct stp_prep_size {
    uint64_t points;
    uint64_t number_bytes; /* of a point's attributes and its pixel */
    bool grid;             /* stp_prep_stats.keeps_grid */
    bool bent;             /* and its raster was moved */
    bool maps;             /* stp_prep_params.maps */
    bool fills;            /* stp_maps_params.fill */
    bool shared;           /* by stp_prep_params.ranks: each has a share of the points */
    uint64_t read;         /* then: those that this rank reads */
} stp_prep_size;

/* What a run will need, known before it begins. */
typedef struct stp_prep_plan {
    uint64_t memory_bytes; /* the limit */
    uint64_t own_bytes; /* with temporary files: what arrays may take in memory alone (spill.h) */
    uint64_t temporary_bytes;      /* temporary files for a surface; 0: everything fits in memory */
    uint64_t most_temporary_bytes; /* the same if every piece is a crumb, as in foliage */
    uint64_t free_bytes;           /* free in the folder, if temporary_bytes is not 0 */
    char *folder;                  /* of temporary files, owned */
} stp_prep_plan;

typedef struct stp_prep_params {
    unsigned neighbour_count;    /* 0: STP_PREP_NEIGHBOURS, or more if points lie in scan lines */
    double lambda;               /* 0: 1.7 */
    double precision;            /* 0: half the source's scale, if it has one */
    bool exact;                  /* stored positions round to the numbers that were read */
    bool join_layers;            /* see join_layers.h; not together with exact */
    const stp_maps_params *maps; /* points become elevation maps (maps.h); not together with exact,
                                    attributes, nor mode NONE of orientation; NULL: they do not */
    unsigned normal_bits; /* of the grid that normals are rounded to, 6 to 12; 0: those that the
                             input gave are not rounded, the others as their noise allows */
    stp_orient_mode orient;
    stp_dvec3 orient_position;
    bool holes_grow; /* of grids and images: nothing is drawn where samples are missing (holes.h) */
    stp_codec codec; /* without blocks */
    int format;      /* major version of the file: 2 (or 0) is in blocks, 1 is not */
    stp_outlier_mode outliers;
    double outlier_distance; /* spacings; 0: STP_OUTLIER_DISTANCE */
    bool unlit;              /* the default shading of the file is unlit */
    bool force;
    uint64_t memory_bytes;   /* the process's limit; 0: half the machine's */
    const char *temp_folder; /* NULL: the output's folder */
    stp_ranks *ranks;        /* that prepare the model together, borrowed; NULL: none */
    /* Points and records are numbered from here on: 0, but in tests of numbers beyond 2^32. */
    uint64_t first_place;
    /* Called with the run's needs before a point is read. May be NULL. */
    void (*planned)(const stp_prep_plan *plan);
} stp_prep_params;

#define STP_PREP_STAGE_COUNT 9

typedef struct stp_prep_stats {
    uint64_t points_in, points_out;
    uint64_t rejected[STP_REJECT_COUNT]; /* by reason; NONE: 0 */
    stp_dbox box;                        /* of the points that were read and not rejected */
    stp_line_counts lines;
    stp_triangle_counts triangles;
    stp_tree_stats tree;
    stp_resolution resolution; /* what tree.displacement is compared with */
    stp_orientation orientation;
    uint64_t closed_count;       /* points whose backs are proven hidden (enclosure.h) */
    stp_outlier_mode outliers;   /* what was done with outliers */
    double outlier_distance;     /* and from how many spacings on */
    uint64_t outlier_count;      /* marked, or dropped and among the rejected */
    uint16_t intensity_greatest; /* of all that is stored */
    uint16_t intensity_max;      /* 255 in the file stands for it, and for what is more */
    uint32_t station_count;      /* scanner positions that normals were turned to */
    uint32_t stations_off;       /* stations that cannot have seen their points: removed */
    uint32_t stations_refused;   /* those of them that a file claims */
    unsigned line_neighbours;    /* chosen for points in scan lines (scan_lines.h); else 0 */
    stp_first_camera first;      /* the camera that first shows the model */
    uint64_t points_unstationed; /* stored points of unknown stations, if normals need stations */
    uint64_t points_black;       /* that are exactly black, and nearly: of clouds with colours */
    uint64_t points_dark;
    uint64_t points_uncoloured; /* the black ones, if that means that they have no colour */
    uint64_t temporary_bytes;   /* greatest size of temporary files at a time */
    stp_surface_counts normals_wide;
    unsigned normal_bits;   /* of the grid of normals that the input did not give; 0: no points */
    unsigned normal_step;   /* of that grid, in codes of 12 bits (normal_grid.h) */
    uint32_t images;        /* of depth cameras that stay grids of pixels (depth_image.h) */
    uint32_t images_turned; /* those of them whose squares' columns are the image's rows */
    uint64_t pixels_loose;  /* points of no image, or off its rays, beside them */
    bool keeps_grid;        /* the scan is a grid of heights and stays one (height_grid.h) */
    bool holes_grow;        /* was requested */
    double odd_heights[2], odd_shares[2]; /* of a grid: grid_range.h */
    bool join_layers;                     /* was requested */
    bool makes_maps;                      /* was requested */
    bool fills_gaps;                      /* between maps: likewise */
    stp_joined_layers joined;
    stp_maps_counts maps;  /* points_out counts the points that they represent, too */
    uint64_t normals_seen; /* normals from windows of images, because of noise along the rays */
    double seconds;
    double stage_seconds[STP_PREP_STAGE_COUNT];
    unsigned rank_count; /* processes that prepared the model; 0: one, without MPI */
    bool each_has_all;   /* these are several, and could not share the points: each held all */
    uint64_t stage_sent_bytes[STP_PREP_STAGE_COUNT]; /* from rank to rank (ranks.h) */
    uint64_t stage_peak_bytes[STP_PREP_STAGE_COUNT]; /* peak memory up to the stage's end; 0: stage
                                                        left out */
} stp_prep_stats;

/* How far points that maps stand for are from the stored surface: from the maps' surface, and what
 * storing moves that by. */
static inline double stp_prep_maps_greatest(const stp_maps_counts *maps, const stp_tree_stats *tree)
{
    return maps->greatest + tree->displacement.greatest;
}

static inline double stp_prep_maps_mean(const stp_maps_counts *maps, const stp_tree_stats *tree)
{
    return stp_maps_mean(maps) + stp_displacement_mean(&tree->displacement);
}

/* Names of the stages, in order. */
extern const char *const stp_prep_stage_names[STP_PREP_STAGE_COUNT];

/* Errors: LIMIT (more points than a run can take: 2^STP_PLACE_BITS - 1, or 2^32 - 3 if they become
 * maps). */
stp_status stp_prep_check_count(const stp_prep_source *source, const stp_prep_params *params,
                                stp_error *err);
/* How much a run over this source with these parameters has to prepare. */
stp_prep_size stp_prep_size_of(const stp_prep_source *source, const stp_prep_params *params);
/* Plans a run. Errors: IO (no such folder), LIMIT (too little memory for any model), OUT_OF_MEMORY.
 */
stp_status stp_prep_plan_make(stp_prep_plan *out, const char *path, const stp_prep_size *size,
                              const stp_prep_params *params, unsigned thread_count, stp_error *err);
/* Errors: IO (fewer bytes are free than the run needs). */
stp_status stp_prep_plan_check(const stp_prep_plan *plan, stp_error *err);
void stp_prep_plan_clear(stp_prep_plan *plan);

/* Runs preprocessing. Errors: EMPTY (no valid point, line or triangle), LIMIT (more
 * points than stp_prep_check_count allows, or lines and triangles that take more than half of the
 * memory), and those of the plan, the source and the stages. */
stp_status stp_prep_run(const char *path, const stp_prep_source *source,
                        const stp_prep_params *params, stp_pool *pool, const stp_progress *progress,
                        stp_prep_stats *stats, stp_error *err);

#endif
