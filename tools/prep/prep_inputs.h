/* Many scans as the one source of a model: their points as they come, their lines and
 * triangles all at once. */
#ifndef STP_TOOLS_PREP_PREP_INPUTS_H
#define STP_TOOLS_PREP_PREP_INPUTS_H

#include "base/file.h"
#include "formats/scan/scan.h"
#include "preprocess/plant/plant.h"
#include "preprocess/prep.h"

#include <sys/types.h>

/* A file as it was when it was first looked at. */
typedef struct prep_input {
    dev_t device;
    ino_t inode; /* 0: nothing is known */
    off_t size;
    struct timespec changed;
    bool plant; /* its mesh has become lines and triangles: it has no points */
    char *why;  /* it cannot be read and is left out, as this says; NULL: it is read */
} prep_input;

/* Several scans, one after the other. Zero, then paths, count, params and plants; paths are
 * borrowed. */
typedef struct prep_inputs {
    char *const *paths;
    size_t count, current;
    stp_scan_params params;
    stp_scan *scan;
    prep_input *facts;                 /* by file */
    stp_prep_file *files;              /* by file: for the metadata; names are the paths' */
    stp_dvec3 *stations, *station_ups; /* of all inputs, one after the other */
    size_t station_count, station_capacity, up_capacity;
    stp_line_set lines; /* of all inputs, one after the other */
    size_t vertex_capacity, strip_capacity;
    stp_edge_counts edges;      /* of all inputs */
    stp_triangle_set triangles; /* likewise */
    size_t corner_capacity, triangle_capacity;
    bool strict;              /* an input that cannot be read ends all */
    bool exact;               /* finer steps than a survey's are looked for */
    bool plants;              /* meshes become lines (prep_plants.h) */
    stp_plant_report plant;   /* of all of them */
    uint32_t stations_before; /* of the inputs before the current one */
    stp_output *rejects;      /* NULL, or gets a line for each record that is not stored */
    size_t reject_file;       /* of the last such record, */
    uint64_t reject_before;   /* and how many records the files before it have */
} prep_inputs;

/* What all inputs together are; every file is opened once, so that a wrong one is told at once: of
 * several it is left out as a whole, also where it breaks off later, unless they are strict.
 * *source then reads from the inputs. Errors, of all or of what is no fault of one file: those of
 * stp_scan_open, LIMIT (stations), EMPTY (no point and no line in any), INVALID_ARGUMENT (a file
 * twice, by whatever names; plants, and no mesh). */
stp_status prep_inputs_survey(prep_inputs *inputs, stp_prep_source *source, stp_error *err);
/* Names rejected records in a CSV file: file, index in it from 0 (of a file with lines: among the
 * vertices that no line goes through), reason; of a file that is left out one line without an
 * index. It appears with prep_inputs_end_rejects. Errors: EXISTS, IO. */
stp_status prep_inputs_begin_rejects(prep_inputs *inputs, const char *path, bool force,
                                     stp_error *err);
stp_status prep_inputs_end_rejects(prep_inputs *inputs, stp_error *err);
/* How many inputs are left out. */
size_t prep_inputs_unreadable(const prep_inputs *inputs);
void prep_inputs_clear(prep_inputs *inputs);

#endif
