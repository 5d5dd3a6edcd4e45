/* Makes many scans the one source of a model: points come as a stream, lines and triangles all at
 * once. */
#ifndef STP_TOOLS_PREP_PREP_INPUTS_H
#define STP_TOOLS_PREP_PREP_INPUTS_H

#include "base/file.h"
#include "formats/scan/remote/mirror.h"
#include "formats/scan/scan.h"
#include "preprocess/plant/plant.h"
#include "preprocess/prep.h"
#include "tools/prep/prep_numbers.h"
#include "tools/prep/prep_system.h"
#include "tools/prep/prep_where.h"

#include <sys/types.h>

/* A file as it was at the first look. */
typedef struct prep_input {
    dev_t device;
    ino_t inode; /* 0: the file is unknown */
    off_t size;
    struct timespec changed;
    uint64_t points;         /* as the survey counted them */
    uint64_t seek_points;    /* stp_scan_info */
    bool plant;              /* its mesh became lines and triangles: it has no points */
    bool mesh;               /* it has faces, and they became points */
    prep_way way;            /* how positions are moved */
    stp_file_mirror *mirror; /* of an address; NULL: none is needed */
    char *name;              /* for the metadata */
    char *why;               /* the reason why the file is left out; NULL: it is read */
} prep_input;

/* Several scans, one after the other. Start with zero, then set paths, count, params and plants.
 * paths are borrowed. */
typedef struct prep_inputs {
    char *const *paths;
    size_t count, current;
    stp_scan_params params;
    stp_scan *scan;
    prep_numbers numbers;              /* attributes; set wanted before */
    prep_where where;                  /* parsed before, if only some points are stored */
    stp_grid_params *grids;            /* per file, of images (prep_series.h); NULL: params.grid */
    prep_input *facts;                 /* per file */
    stp_dvec3 *raster_nodes;           /* of the grid that several inputs make; NULL: none */
    stp_prep_file *files;              /* per file, for the metadata; names are the paths */
    stp_dvec3 *stations, *station_ups; /* of all inputs, one after the other */
    size_t station_count, station_capacity, up_capacity;
    stp_line_set lines; /* of all inputs, one after the other */
    size_t vertex_capacity, strip_capacity;
    stp_edge_counts edges;      /* of all inputs */
    stp_triangle_set triangles; /* of all inputs */
    size_t corner_capacity, triangle_capacity;
    prep_system system;        /* set wanted before */
    const char *temp;          /* folder of copies of addresses; NULL: $TMPDIR */
    bool strict;               /* an input that cannot be read ends the run */
    bool exact;                /* also look for finer steps than those of surveys */
    bool plants;               /* meshes become lines (prep_plants.h) */
    bool vertices;             /* the points of a mesh are its vertices, even if it is coarse */
    char colours_missing[256]; /* why a mesh lacks its colours; "": none does */
    const char *coarse;        /* a mesh that was sampled because it is coarse; NULL: none */
    uint64_t loose_left_out;   /* of such meshes: vertices without a face */
    const char *suspect;      /* a mesh that is read as points and looks like a plant; NULL: none */
    stp_plant_report plant;   /* of all inputs */
    uint32_t stations_before; /* number of stations in the inputs before the current one */
    bool in_part;             /* prep_inputs_read_part */
    uint64_t part_left;       /* records of the part that are still to be read */
    uint64_t part_skip;       /* records of the part's first input that come before the part */
    stp_output *rejects;      /* NULL, or gets a line for each record that is not stored */
    size_t reject_file;       /* file of the last such record */
    uint64_t reject_before;   /* number of records in the files before it */
} prep_inputs;

/* Opens every file once and finds what all inputs together hold, so that a wrong file is reported
 * at once. If one of several files is wrong, or breaks off later, the whole file is left out,
 * unless strict. *source then reads from the inputs. Errors of all files, or of none in particular:
 * those of stp_scan_open, LIMIT (stations), EMPTY (no point and no line in any file),
 * INVALID_ARGUMENT (the same file twice, by whatever names; plants without a mesh; a condition with
 * a name that no input has), UNSUPPORTED (a condition on lines or triangles). */
stp_status prep_inputs_survey(prep_inputs *inputs, stp_prep_source *source, stp_error *err);
/* How an input is opened, after the survey. */
stp_scan_params prep_inputs_params(const prep_inputs *inputs, size_t i);
/* The functions of those names of a stp_prep_source. */
uint64_t prep_inputs_part_begin(void *context, uint64_t place);
stp_status prep_inputs_read_part(void *context, uint64_t begin, uint64_t end, stp_error *err);
/* Lists rejected records in a CSV file: file, index in the file from 0, reason. In a file with
 * lines, the index counts the vertices that no line uses. A file that is left out gets one line
 * without an index. The CSV file appears with prep_inputs_end_rejects; prep_inputs_reject
 * adds a line, as stp_prep_source.rejected. Errors: EXISTS, IO. */
stp_status prep_inputs_begin_rejects(prep_inputs *inputs, const char *path, bool force,
                                     stp_error *err);
stp_status prep_inputs_reject(void *context, uint64_t place, stp_reject reason, stp_error *err);
stp_status prep_inputs_end_rejects(prep_inputs *inputs, stp_error *err);
/* The number of inputs that are left out. */
size_t prep_inputs_unreadable(const prep_inputs *inputs);
void prep_inputs_clear(prep_inputs *inputs);

#endif
