/* Scans in: a stream of points out of any supported file.
 *
 * Recognised by content first, name second: PLY, LAS, PCD, E57, PTS, PTX, XYZ and other lines of
 * numbers (xyz.h; our streaming readers); OBJ, OFF, STL (OpenMesh). A mesh's vertices are the
 * points, or sample_count points spread over its faces (area-uniform, seeded). Normals: the file's,
 * else the faces' (area-weighted), else none. Edges of PLY and OBJ are lines (line_chain.h):
 * vertices that these go through are no points. Points are given as they are: NaN and infinite ones
 * are the caller's to count and drop, and so are records that the file itself says are none
 * (stp_reject). Coordinates are the file's own, in double. Where scanners stood and which one saw a
 * point is told where the file says so (ply_stations.h, pcd.h, e57.h). Memory: bounded for point
 * files whatever their size; a mesh with faces or edges is held whole. Threads: one at a time per
 * stp_scan.
 */
#ifndef STP_FORMATS_SCAN_SCAN_H
#define STP_FORMATS_SCAN_SCAN_H

#include "base/error.h"
#include "base/vec.h"
#include "formats/scan/mesh/triangle_set.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Why a record is not stored. A reader gives every record that the file counts, so that read =
 * stored + rejected. */
typedef enum stp_reject {
    STP_REJECT_NONE,
    STP_REJECT_NOT_FINITE, /* a coordinate is NaN or infinite: told by who reads the points */
    STP_REJECT_NO_RETURN,  /* the scanner's ray met nothing */
    STP_REJECT_INVALID,    /* the file marks it: withheld, deleted, of unknown position */
    STP_REJECT_OUTLIER,    /* far from everything else: told when all points are read */
    STP_REJECT_COUNT
} stp_reject;

/* Red, green and blue of what has no colour: a neutral light grey. */
#define STP_POINT_GREY (200u * 257u)

typedef struct stp_point {
    stp_dvec3 position;
    vec3s normal;    /* unit, or zero where unknown */
    uint16_t rgb[3]; /* full range 0..65535, whatever the file's own depth */
    uint16_t intensity;
    uint8_t class_id;
    uint8_t reject;   /* stp_reject; position and all else mean nothing where it is not NONE */
    uint16_t station; /* place among the scan's stations, counted from 1; 0: unknown */
    uint8_t outlier;  /* 1: marked as one; written alone */
} stp_point;

enum {
    STP_POINT_HAS_NORMAL = 1u << 0,
    STP_POINT_HAS_COLOUR = 1u << 1,
    STP_POINT_HAS_INTENSITY = 1u << 2,
    STP_POINT_HAS_CLASS = 1u << 3,
    STP_POINT_HAS_STATION = 1u << 4, /* points name stations, of which positions may be missing;
                                        not where these are a default */
    STP_POINT_HAS_OUTLIER = 1u << 5  /* of a writer alone */
};

/* Most stations of a scan. */
#define STP_STATION_LIMIT 65535u

typedef struct stp_scan_params {
    uint64_t sample_count; /* 0: the vertices; else so many points over the faces of a mesh */
    uint64_t seed;
    bool recompute_normals; /* give no normals at all */
    bool hybrid;            /* of a mesh, large triangles are no points (hybrid.h) */
    double line_radius;     /* half the width of lines that have none; 0: by their box */
    const char *columns;    /* of XYZ, TXT, CSV and PTS, "x,y,z,_,r,g,b" (columns.h); NULL: found.
                               Used until the scan is open */
} stp_scan_params;

/* What a file says of itself beside its points and a model keeps in its metadata. */
typedef struct stp_scan_note {
    const char *name; /* "wkt", "geokeys", "left_out" (fields of points that are not read),
                         "columns" (what the numbers of a line were taken for), ... */
    const char *text;
} stp_scan_note;

/* Edges of a file, and those of them that are no lines: they name a vertex that does not exist,
 * join one with itself, are there already, end where a coordinate is not finite, or are sides of
 * faces. */
typedef struct stp_edge_counts {
    uint64_t read, no_vertex, no_length, repeated, not_finite, of_faces;
} stp_edge_counts;

/* How far a file's word of where its points were seen from may be trusted. */
typedef enum stp_station_word {
    STP_STATION_TOLD,    /* the format has a place for it that scanners' programs fill */
    STP_STATION_CLAIMED, /* it may mean something else: believed where the points allow it */
    STP_STATION_DEFAULT  /* nobody wrote it: believed where the points speak for it */
} stp_station_word;

/* Where a point of a scan lies in the image that the scanner took. */
typedef struct stp_grid_cell {
    uint64_t place; /* of the point in the file */
    uint32_t column, row;
} stp_grid_cell;

/* The image whose pixels are the points; columns 0: there is none. Without cells the place of a
 * point is its pixel, row by row; else some of the points are named. */
typedef struct stp_scan_grid {
    uint32_t columns, rows;
    const stp_grid_cell *cells; /* the scan's own, like stations */
    uint32_t cell_count;
} stp_scan_grid;

typedef struct stp_scan_info {
    const char *format;   /* "PLY ascii", "OBJ", ... */
    uint64_t point_count; /* what will be read */
    uint64_t face_count;
    stp_edge_counts edges;
    uint32_t attributes;    /* STP_POINT_HAS_* */
    double coordinate_step; /* scale of integer or short decimal coordinates, 0: floats */
    bool heights;           /* z is the height, as surveyors have it: the format says so */
    bool normals_from_faces;
    const stp_dvec3 *stations; /* where scanners stood; the scan's own, valid until it is closed */
    uint32_t station_count;
    const stp_dvec3 *station_ups; /* the scanners' up axes, of any length; NULL: not told */
    stp_station_word station_word;
    stp_scan_grid grid;
    const stp_scan_note *notes; /* the scan's own, like stations */
    uint32_t note_count;
} stp_scan_info;

typedef struct stp_scan stp_scan;

/* "not_finite", ...: as in files of figures. */
const char *stp_reject_name(stp_reject reject);

/* Reads the header (a mesh: everything; lines of numbers: all once, to count them). Errors:
 * NOT_FOUND, IO, FORMAT, CORRUPT (with line or byte), UNSUPPORTED, INVALID_ARGUMENT (sampling a
 * file without faces, or a hybrid of one), OUT_OF_MEMORY. */
stp_status stp_scan_open(stp_scan **out, const char *path, const stp_scan_params *params,
                         stp_error *err);
const stp_scan_info *stp_scan_get_info(const stp_scan *scan);
/* Its large triangles likewise, where params say hybrid. */
void stp_scan_take_triangles(stp_scan *scan, stp_triangle_set *out);
/* Its lines, once: *out, which must be empty, owns them from here on; none are left. */
void stp_scan_take_lines(stp_scan *scan, stp_line_set *out);
/* Reads up to capacity points; *count 0 only at the end. Errors: IO, CORRUPT. */
stp_status stp_scan_read(stp_scan *scan, stp_point *points, size_t capacity, size_t *count,
                         stp_error *err);
void stp_scan_close(stp_scan **scan);

#endif
