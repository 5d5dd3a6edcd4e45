/* Reads scans: a stream of points from a file of any supported format.
 *
 * The format is recognised by content first, by name second. Our streaming readers read PLY, LAS,
 * EPT and COPC (octree/), PCD, E57, PTS, PTX, XYZ and other lines of numbers (xyz.h), KITTI, and
 * grids of heights or depths (grid/grid.h: TIFF, PNG, EXR, PFM, PGM, ESRI ASCII, Surfer, HGT,
 * AL3D). OpenMesh reads OBJ, OFF and STL. The points of a mesh are its vertices, or sample_count
 * points spread over its faces (area-uniform, seeded). Normals are the file's, else the faces'
 * (area-weighted), else none. Edges of PLY and OBJ are lines (line_chain.h); a vertex of a line is
 * no point. Points come as the file has them. The caller counts and drops points that are nowhere
 * (stp_scan_is_nowhere), and records that the file itself marks as none (stp_reject). Coordinates
 * are the file's own, in double. If the file says where scanners stood and which one saw a point,
 * the reader passes that on (ply_stations.h, pcd.h, e57.h). Memory: bounded for point files of any
 * size; a mesh with faces or edges is held whole. Threads: one at a time per stp_scan. */
#ifndef STP_FORMATS_SCAN_SCAN_H
#define STP_FORMATS_SCAN_SCAN_H

#include "base/error.h"
#include "base/vec.h"
#include "formats/attribute/attribute.h"
#include "formats/scan/mesh/triangle_set.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Programs write the largest float where there is no sample, with a digit more or less, or half of
 * it. No coordinate is so large. */
#define STP_SCAN_NONE_FROM 1e30

/* Whether programs write a number where a grid has no sample, often without telling so. No branch.
 */
static inline bool stp_is_usual_none(double number)
{
    return (number == -9999.0) | (number == -32767.0) | (number == -32768.0) | (number == -99999.0);
}

/* Whether a coordinate is NaN, infinite or STP_SCAN_NONE_FROM and more. */
static inline bool stp_scan_is_nowhere(stp_dvec3 p)
{
    return !(fabs(p.x) < STP_SCAN_NONE_FROM && fabs(p.y) < STP_SCAN_NONE_FROM &&
             fabs(p.z) < STP_SCAN_NONE_FROM);
}

/* Why a record is not stored. A reader returns every record that the file counts, so that read =
 * stored + rejected. */
typedef enum stp_reject {
    STP_REJECT_NONE,
    STP_REJECT_NOT_FINITE, /* stp_scan_is_nowhere; set by the caller of the reader */
    STP_REJECT_NO_RETURN,  /* the scanner's ray met nothing */
    STP_REJECT_INVALID,    /* the file marks it: withheld, deleted, of unknown position */
    STP_REJECT_OUTLIER,    /* far from everything else; set when all points are read */
    STP_REJECT_OUTSIDE,    /* outside of the region that was asked for */
    STP_REJECT_WHERE,      /* does not fulfil the condition; set by the caller of the reader */
    STP_REJECT_LOST,       /* behind the place where the file is cut or damaged (salvage) */
    STP_REJECT_TWICE,      /* another file has a sample at its place in their grid; likewise */
    STP_REJECT_ORIGIN,     /* a pixel of an image that is exactly at its origin: a hole */
    STP_REJECT_COUNT
} stp_reject;

/* Red, green and blue of a point without a colour: a neutral light grey. */
#define STP_POINT_GREY (200u * 257u)

typedef struct stp_point {
    stp_dvec3 position;
    vec3s normal;    /* unit, or zero if unknown */
    uint16_t rgb[3]; /* full range 0..65535, whatever the file's own depth */
    uint16_t intensity;
    uint8_t class_id;
    uint8_t reject;   /* stp_reject; if it is not NONE, all other members mean nothing */
    uint16_t station; /* index into the scan's stations, counted from 1; 0: unknown */
    uint8_t outlier;  /* 1: marked as an outlier; only written, never read */
    uint32_t pixel;   /* if info.pixels_told: its place in its image (stp_scan_image), row by row;
                         STP_POINT_NO_PIXEL: it has none */
} stp_point;

#define STP_POINT_NO_PIXEL UINT32_MAX

enum {
    STP_POINT_HAS_NORMAL = 1u << 0,
    STP_POINT_HAS_COLOUR = 1u << 1,
    STP_POINT_HAS_INTENSITY = 1u << 2,
    STP_POINT_HAS_CLASS = 1u << 3,
    STP_POINT_HAS_STATION = 1u << 4, /* points name stations; positions of some may be missing. Not
                                        set for default stations */
    STP_POINT_HAS_OUTLIER = 1u << 5  /* only for writers */
};

/* Most stations of a scan. */
#define STP_STATION_LIMIT 65535u

/* What images of one size and type that are given together are (grid/depth_guess.h). */
typedef enum stp_depth_series {
    STP_SERIES_NONE, /* each image decides */
    STP_SERIES_HEIGHTS,
    STP_SERIES_DEPTHS
} stp_depth_series;

/* How to read a grid of heights or depths (grid/grid.h). All zero: heights, as the file has them.
 */
typedef struct stp_grid_params {
    const char *colour; /* an image of the same size; NULL: none */
    const char *mask;   /* likewise; black, or alpha 0, means that there is no sample */
    bool has_invalid;
    double invalid;        /* the number that stands for no sample, beside the file's own */
    double dx, dy;         /* between columns and rows; 0: the file's, else 1 */
    double scale;          /* of the numbers; 0: 1 */
    double fx, fy, cx, cy; /* pixels: a pinhole camera; fx 0: heights */
    bool along_ray;        /* depths are measured along the ray, not along the axis */
    double disparity_focal, disparity_base; /* pixels, length: depth = focal base / number; 0: no
                                               disparities */
    stp_depth_series series; /* known: of what kind the image is; depths have a scale */
} stp_grid_params;

/* The part of a scan that is read. All zero: all of it. */
typedef struct stp_scan_region {
    bool bounded;
    double min[3], max[3]; /* a box with its faces, in the file's own coordinates */
    double resolution; /* octrees are read down to the first depth whose spacing is not above it;
                          0: down to the last */
} stp_scan_region;

typedef struct stp_scan_params {
    uint64_t
        sample_count; /* 0: the vertices; else the number of points spread over a mesh's faces */
    uint64_t seed;
    bool recompute_normals; /* give no normals at all */
    bool hybrid;            /* large triangles of a mesh become no points (hybrid.h) */
    bool sample_coarse;  /* sample_count and hybrid are chosen for a mesh whose vertices do not tell
                            its faces (mesh/coarse_mesh.h), if neither is given, nor a bounded
                            region */
    double line_radius;  /* half the width of lines without a width; 0: from their box */
    const char *columns; /* for XYZ, TXT, CSV and PTS, "x,y,z,_,r,g,b" (columns.h); NULL: guessed.
                            Used until the scan is open */
    const stp_grid_params *grid; /* for grids alone; NULL: as the file has it */
    uint32_t grid_step; /* of grids that are images (grid/grid.h) every so manieth column and row
                           alone, if at least two of each are left; 0: each */
    bool numbers;       /* reading also keeps the numbers of all attributes (stp_scan_numbers) */
    bool keep_withheld; /* points that LAS, LAZ or EPT mark as withheld are no rejects; an attribute
                           `withheld` says which */
    bool keep_grid;     /* of PTX and E57, the points of a scan are the pixels of an image */
    bool salvage;       /* of a file that is cut or damaged, the records up to there are points and
                           all others that it declares are lost (STP_REJECT_LOST) */
    const stp_scan_region
        *region; /* NULL: all of it. Must outlive the scan, as the next two must */
    struct stp_file_mirror *mirror; /* of the address (remote/mirror.h); NULL: the path is no
                                  address, or it is an EPT's */
    const struct stp_byte_source_params *web; /* for addresses; NULL: the defaults */
    struct stp_pool *pool; /* helps reading, and is idle then; NULL: none. Must outlive the scan */
} stp_scan_params;

/* A text of the file about itself, beside its points. A model keeps it in its metadata. */
typedef struct stp_scan_note {
    const char *name; /* "wkt", "geokeys", "left_out" (fields of points that are not read),
                         "columns" (the meaning of the numbers of a line), ... */
    const char *text;
} stp_scan_note;

/* Counts of a file's edges, and of the edges that become no lines: they name a vertex that does not
 * exist, join a vertex with itself, repeat an edge, end at a coordinate that is not finite, or are
 * sides of faces. */
typedef struct stp_edge_counts {
    uint64_t read, no_vertex, no_length, repeated, not_finite, of_faces;
} stp_edge_counts;

/* How far to trust what a file says about where its points were seen from. */
typedef enum stp_station_word {
    STP_STATION_TOLD,    /* the format has a field for it, which scanners' programs fill */
    STP_STATION_CLAIMED, /* the field may mean something else; believed if the points allow it */
    STP_STATION_DEFAULT, /* nobody wrote it; believed if the points speak for it */
    STP_STATION_GUESSED  /* the format has no such field: the origin, if coordinates are the
                            sensor's own (preprocess/viewpoint/own_frame.h). No point names it */
} stp_station_word;

/* The pixel of a point in the image that the scanner took. */
typedef struct stp_grid_cell {
    uint64_t place; /* index of the point in the file */
    uint32_t column, row;
} stp_grid_cell;

/* The image whose pixels are the points. columns 0: there is no image. Without cells, a point's
 * index in the file is its pixel, row by row. With cells, only some of the points have a pixel. */
typedef struct stp_scan_grid {
    uint32_t columns, rows;
    const stp_grid_cell *cells; /* owned by the scan, like stations */
    uint32_t cell_count;
} stp_scan_grid;

/* One of several images in a file. A record's place among its records is its pixel, row by row,
 * unless the points tell their pixels. */
typedef struct stp_scan_image {
    uint64_t first, count;  /* its records of the file */
    uint32_t columns, rows; /* fewer pixels than 2^32 - 1 */
    uint16_t station;       /* which saw it, from 1 */
} stp_scan_image;

/* A grid of heights in the plane. A sample lies at x + column dx, y - row dy; the first row is the
 * top one. columns 0: there is no such grid. */
typedef struct stp_scan_raster {
    uint32_t columns, rows;
    double x, y, dx, dy; /* dx and dy are positive */
    double skew[2]; /* of a turned grid: what a column adds to y, and a row to x. Then nodes (see
                       below) tell where it lies */
    unsigned order; /* of the file's points: STP_RASTER_*; 0: row by row */
    double scale, offset; /* a height is scale * number + offset; 0: the file has the heights */
} stp_scan_raster;

/* The file's points stand column by column; from the last column on; from the last row on. */
enum { STP_RASTER_BY_COLUMN = 1u, STP_RASTER_FROM_RIGHT = 2u, STP_RASTER_FROM_BELOW = 4u };

/* The column (out[0]) and row of the file's point i. */
static inline void stp_scan_raster_find(const stp_scan_raster *raster, uint64_t i, uint32_t out[2])
{
    const bool by_column = raster->order & STP_RASTER_BY_COLUMN;
    const uint32_t run = by_column ? raster->rows : raster->columns;
    const uint32_t within = (uint32_t)(i % run), runs = (uint32_t)(i / run);
    out[0] = by_column ? runs : within;
    out[1] = by_column ? within : runs;
    if (raster->order & STP_RASTER_FROM_RIGHT)
        out[0] = raster->columns - 1 - out[0];
    if (raster->order & STP_RASTER_FROM_BELOW)
        out[1] = raster->rows - 1 - out[1];
}

/* The place of the file's point i, row by row. */
static inline uint64_t stp_scan_raster_place(const stp_scan_raster *raster, uint64_t i)
{
    uint32_t at[2];
    if (raster->order == 0)
        return i;
    stp_scan_raster_find(raster, i, at);
    return (uint64_t)at[1] * raster->columns + at[0];
}

/* Another coordinate system bends a raster, or it is turned. Then nodes tell where it lies: the
 * places of some of its samples, row by row. They are STP_RASTER_NODE columns and rows apart, the
 * last ones less. */
#define STP_RASTER_NODE 64u

/* The number of nodes along so many columns or rows. */
static inline uint32_t stp_raster_node_count(uint32_t columns)
{
    return (columns - 1) / STP_RASTER_NODE + 2;
}

/* The column of a node: the last one's is that of the last sample; or the next one, if the last
 * sample has a node already. */
static inline uint32_t stp_raster_node_column(uint32_t node, uint32_t columns)
{
    const uint32_t place = node * STP_RASTER_NODE;
    if (place < columns || node == 0)
        return place;
    return columns - 1 > place - STP_RASTER_NODE ? columns - 1 : columns;
}

/* The place of a column and row, at a height. */
static inline stp_dvec3 stp_scan_raster_at(const stp_scan_raster *raster, double column, double row,
                                           double z)
{
    return (stp_dvec3){raster->x + column * raster->dx + row * raster->skew[1],
                       raster->y - row * raster->dy + column * raster->skew[0], z};
}

typedef struct stp_scan_info {
    const char *format;   /* "PLY ascii", "OBJ", ... */
    uint64_t point_count; /* the number of points that will be read, those lost among them */
    uint64_t lost_count;  /* that the file declares, and has no room for (salvage) */
    uint64_t face_count;
    stp_edge_counts edges;
    uint32_t attributes;    /* STP_POINT_HAS_* */
    double coordinate_step; /* scale of integer or short decimal coordinates; 0: floats */
    double intensity_full;  /* the file's number for intensity 65535, if 0 is 0; 0: not known */
    uint64_t seek_points;   /* reading may go on at multiples of it (stp_scan_seek); 0: nowhere */
    bool seek_reads;        /* such a seek reads the file up to there */
    bool counted;           /* opening read the file from end to end, to count its points */
    double octree_spacing;  /* of the root's points, of an octree whose depths a region's resolution
                               chooses; 0: it is none */
    bool heights;           /* the format says that z is the height, as surveyors use it */
    bool y_up;              /* the format says that y points up, as glTF does */
    bool y_down;            /* it says that y points down, as COLMAP's lists of points do */
    bool y_likely_down;     /* y points down unless the points say that z is up: Gaussian splats */
    bool normals_from_faces;
    const char *colours_missing; /* why faces lack their colours: a file that could not be read;
                                    NULL: they do not. Owned by the scan */
    uint64_t coarse_samples;     /* sample_count as params.sample_coarse chose it; 0: it did not */
    uint64_t loose_left_out; /* then, vertices that no face uses and that are no points either */
    const stp_dvec3
        *stations; /* where scanners stood; owned by the scan, valid until it is closed */
    uint32_t station_count;
    const stp_dvec3 *station_ups; /* the scanners' up axes, of any length; NULL: not given */
    stp_station_word station_word;
    stp_scan_grid grid;
    const stp_scan_image *images; /* of several scans, or if points tell their pixels; owned by the
                                     scan, like stations */
    uint32_t image_count;
    bool pixels_told; /* by stp_point.pixel */
    stp_scan_raster raster;
    const stp_attribute_list *extra; /* attributes beside those of stp_point; NULL: none. Owned by
                                        the scan, like stations */
    const stp_scan_note *notes;
    uint32_t note_count;
} stp_scan_info;

typedef struct stp_scan stp_scan;

/* "not_finite", ...: the name in statistics and in the file of rejects. */
const char *stp_reject_name(stp_reject reject);

/* path: of a file, or with params.mirror its address, or the address of an EPT's ept.json. Reads
 * the header. Reads a mesh completely, and lines of numbers once, to count them. Errors: NOT_FOUND,
 * IO, FORMAT, CORRUPT (with line or byte), UNSUPPORTED, INVALID_ARGUMENT (sampling or hybrid of a
 * file without faces), OUT_OF_MEMORY. */
stp_status stp_scan_open(stp_scan **out, const char *path, const stp_scan_params *params,
                         stp_error *err);
const stp_scan_info *stp_scan_get_info(const stp_scan *scan);
/* Moves the scan's large triangles to *out in the same way, if params.hybrid was set. */
void stp_scan_take_triangles(stp_scan *scan, stp_triangle_set *out);
/* Moves the scan's lines to *out, which must be empty and owns them from here on. The scan has no
 * lines left. */
void stp_scan_take_lines(stp_scan *scan, stp_line_set *out);
/* Reads up to capacity points; *count 0 only at the end. Errors: IO, CORRUPT. */
stp_status stp_scan_read(stp_scan *scan, stp_point *points, size_t capacity, size_t *count,
                         stp_error *err);
/* The packed numbers of the points read last, point by point: all attributes of info.extra. Valid
 * until the next call. NULL if there are none or params.numbers is false. */
const uint8_t *stp_scan_numbers(const stp_scan *scan);
/* Reads on at this point, a multiple of info.seek_points and below info.point_count. Readers then
 * read little ahead. Errors: INVALID_ARGUMENT (seek_points is 0), IO, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_scan_seek(stp_scan *scan, uint64_t point, stp_error *err);
void stp_scan_close(stp_scan **scan);

#endif
