/* Writes points as a stream of LAS 1.4, or of LAZ.
 *
 * Point format 7 with colour (16 bits), else 6. With attributes (params.numbers): the least of
 * formats 0 to 3 if one of them is scan_angle_rank, else of 6 to 8; an attribute that the format
 * has no field for becomes extra bytes. A coordinate is written as the integer nearest to
 * (coordinate - offset) / step. Also written: intensity and class if given; the station's number,
 * counted from 1, as point source ID (0: unknown; LAS has no field for positions of stations);
 * return 1 of 1. Everything else is zero, and so is the date, so that the same points make the same
 * bytes. LAS has no normals. finish fills in the header's counts and box, so the number of points
 * need not be known before. The file appears whole or not at all (base/file.h). Memory: bounded.
 * Threads: one at a time per writer. */
#ifndef STP_FORMATS_SCAN_LAS_LAS_WRITE_H
#define STP_FORMATS_SCAN_LAS_LAS_WRITE_H

#include "base/error.h"
#include "formats/scan/scan.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_las_writer_params {
    bool force;          /* replace an existing file */
    bool packed;         /* LAZ: the points are packed, in chunks of STP_LAZ_CHUNK_POINTS */
    uint32_t attributes; /* STP_POINT_HAS_*: COLOUR chooses the format; NORMAL is refused */
    double step;         /* of coordinates on all axes, the file's scale */
    double steps[3];     /* by axis; zero: step */
    const stp_attribute_list *numbers; /* attributes by LAS's names, borrowed; NULL: none */
    const char *wkt;                   /* coordinate system, copied; NULL: none */
    stp_dvec3 offset;                  /* coordinates lie within 2^31 steps of this point */
} stp_las_writer_params;

typedef struct stp_las_writer stp_las_writer;

/* The finest power of ten as step such that 32-bit integers cover `reach` from the offset. reach is
 * finite and positive. */
double stp_las_finest_step(double reach);

/* Writes a header. path is copied. Errors: EXISTS, IO, OUT_OF_MEMORY; INVALID_ARGUMENT (normals, a
 * step that is not finite and positive); UNSUPPORTED (more extra bytes than LAZ can have). */
stp_status stp_las_writer_create(stp_las_writer **out, const char *path,
                                 const stp_las_writer_params *params, stp_error *err);
/* Appends count points. Errors: IO; INVALID_ARGUMENT (a coordinate is not finite or too far from
 * the offset). */
stp_status stp_las_writer_points(stp_las_writer *writer, const stp_point *points, size_t count,
                                 stp_error *err);
/* The same with the points' attributes, packed. They replace what the point says of intensity and
 * colour. */
stp_status stp_las_writer_numbered_points(stp_las_writer *writer, const stp_point *points,
                                          const uint8_t *packed, size_t count, stp_error *err);
/* Makes the file appear and destroys the writer (*writer NULL, also on failure, then without a
 * file). Errors: IO, EXISTS. */
stp_status stp_las_writer_finish(stp_las_writer **writer, stp_error *err);
/* Abandons the file if not finished. Sets *writer to NULL; NULL inside is fine. */
void stp_las_writer_destroy(stp_las_writer **writer);

#endif
