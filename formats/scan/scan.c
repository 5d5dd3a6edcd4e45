/* Reads scans as one stream of points: of a file, a mesh's vertices or samples of its faces. */
#include "formats/scan/scan.h"

#include "base/memory.h"
#include "formats/scan/colmap/colmap.h"
#include "formats/scan/detect.h"
#include "formats/scan/e57/e57.h"
#include "formats/scan/expe/expe.h"
#include "formats/scan/grid/grid.h"
#include "formats/scan/kitti/kitti.h"
#include "formats/scan/las/las.h"
#include "formats/scan/mesh/coarse_mesh.h"
#include "formats/scan/mesh/hybrid.h"
#include "formats/scan/mesh/line_chain.h"
#include "formats/scan/mesh/mesh_colours.h"
#include "formats/scan/mesh/mesh_read.h"
#include "formats/scan/mesh/mesh_sample.h"
#include "formats/scan/mesh/point_mesh.h"
#include "formats/scan/npy/npy.h"
#include "formats/scan/octree/ept.h"
#include "formats/scan/octree/ept_files.h"
#include "formats/scan/octree/octree.h"
#include "formats/scan/pcd/pcd.h"
#include "formats/scan/ply/ply.h"
#include "formats/scan/remote/mirror.h"
#include "formats/scan/text/pts.h"
#include "formats/scan/text/ptx.h"
#include "formats/scan/text/xyz.h"

#include <stdlib.h>
#include <string.h>

struct stp_scan {
    char *path;       /* that is opened; of a mirror, if the scan is on a web server */
    const char *name; /* for messages */
    stp_scan_params params;
    stp_scan_info info;
    stp_ply *ply;                  /* streamed PLY; NULL if the mesh is held */
    const stp_scan_reader *reader; /* of another streamed format; NULL if there is none */
    void *reader_state;
    stp_point_mesh mesh;        /* empty if the file is streamed */
    size_t next_point;          /* index in the mesh */
    stp_line_set lines;         /* made of the mesh's edges */
    stp_triangle_set triangles; /* the large faces of a hybrid */
    uint8_t *taken; /* per point of the mesh: only lines or large triangles use it; NULL if there
                       are none */
    bool sampling;
    uint64_t point;    /* that is read next, counted for salvage */
    bool singly, lost; /* salvage: records come one by one; there are no more */
    stp_mesh_sampler sampler;
    stp_dvec3 *stations, station_up;
};

const char *stp_reject_name(stp_reject reject)
{
    static const char *const names[STP_REJECT_COUNT] = {
        [STP_REJECT_NONE] = "none",           [STP_REJECT_NOT_FINITE] = "not_finite",
        [STP_REJECT_NO_RETURN] = "no_return", [STP_REJECT_INVALID] = "invalid",
        [STP_REJECT_OUTLIER] = "outlier",     [STP_REJECT_OUTSIDE] = "outside",
        [STP_REJECT_WHERE] = "where",         [STP_REJECT_LOST] = "lost",
        [STP_REJECT_TWICE] = "twice",         [STP_REJECT_ORIGIN] = "origin",
    };
    return names[reject];
}

/* The readers of formats that only have points, by stp_scan_format. */
static const stp_scan_reader *streamed_format(stp_scan_format format)
{
    static const stp_scan_reader *const readers[STP_SCAN_FORMAT_COUNT] = {
        [STP_SCAN_LAS] = &stp_las_reader,       [STP_SCAN_PCD] = &stp_pcd_reader,
        [STP_SCAN_E57] = &stp_e57_reader,       [STP_SCAN_XYZ] = &stp_xyz_reader,
        [STP_SCAN_PTS] = &stp_pts_reader,       [STP_SCAN_PTX] = &stp_ptx_reader,
        [STP_SCAN_GRID] = &stp_grid_reader,     [STP_SCAN_EPT] = &stp_ept_reader,
        [STP_SCAN_EXPE] = &stp_expe_reader,     [STP_SCAN_KITTI] = &stp_kitti_reader,
        [STP_SCAN_COLMAP] = &stp_colmap_reader, [STP_SCAN_NPY] = &stp_npy_reader,
    };
    return readers[format];
}

static const char *ply_name(stp_ply_encoding encoding)
{
    static const char *const names[] = {
        [STP_PLY_ASCII] = "PLY ascii",
        [STP_PLY_BINARY_LITTLE_ENDIAN] = "PLY binary_little_endian",
        [STP_PLY_BINARY_BIG_ENDIAN] = "PLY binary_big_endian",
    };
    return names[encoding];
}

static const char *mesh_name(stp_scan_format format)
{
    if (format == STP_SCAN_STL_ASCII)
        return "STL ascii";
    return format == STP_SCAN_STL_BINARY ? "STL binary" : stp_scan_format_name(format);
}

static stp_status copy_stations(stp_scan *scan, const stp_ply *ply, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_ply_stations *stations = &ply->header.stations;
    const size_t count = ply->has_camera ? 1 : stations->count;
    STP_TRY(stp_alloc(&scan->stations, count, sizeof *scan->stations, "stations", err));
    for (size_t i = 0; i < count; i++)
        scan->stations[i] = ply->has_camera ? ply->camera : stations->list[i].position;
    scan->info.stations = scan->stations;
    scan->info.station_count = (uint32_t)count;
    if (ply->has_camera) {
        scan->station_up = ply->camera_up;
        scan->info.station_ups = &scan->station_up;
        scan->info.station_word = STP_STATION_CLAIMED;
    }
done:
    return status;
}

static void note_mesh(stp_scan *scan)
{
    scan->info.attributes = scan->mesh.attributes;
    if (scan->mesh.materials.missing[0] != '\0')
        scan->info.colours_missing = scan->mesh.materials.missing;
}

/* Whether a coarse mesh would be sampled. */
static bool samples_coarse(const stp_scan_params *params)
{
    const bool cut = params->region && params->region->bounded;
    return params->sample_coarse && params->sample_count == 0 && !params->hybrid && !cut;
}

/* Goes back to the first vertex, without the mesh. */
static stp_status stream_vertices(stp_scan *scan, stp_error *err)
{
    stp_point_mesh_free(&scan->mesh);
    stp_ply_close(&scan->ply);
    const stp_status status = stp_ply_open(&scan->ply, scan->path, scan->params.salvage, err);
    if (status == STP_OK)
        scan->info.grid = scan->ply->grid; /* whose cells are the file's */
    return status;
}

/* Reads the whole file as a mesh and closes it, if it has edges, faces are needed, or it may be
 * coarse: larger files are scans. If it is not, or faces or edges are cut off, it stays open. */
static stp_status hold_mesh(stp_scan *scan, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_ply *ply = scan->ply;
    const stp_scan_params *params = &scan->params;
    const bool normals = !(ply->attributes & STP_POINT_HAS_NORMAL) && !params->recompute_normals;
    const bool coloured = !params->numbers && stp_ply_faces_have_colours(ply);
    const bool wants_faces = normals || coloured || params->sample_count > 0 || params->hybrid;
    const bool needed = ply->edges || (ply->faces && wants_faces);
    const bool may_be_coarse = samples_coarse(params) && !params->salvage && ply->faces &&
                               ply->grid.columns == 0 &&
                               ply->vertex->count <= STP_COARSE_VERTEX_LIMIT;
    uint64_t samples = 0;
    if (!needed && !may_be_coarse)
        return STP_OK;
    const stp_status read = stp_ply_read_mesh(scan->ply, &scan->mesh, err);
    if (read == STP_CORRUPT && params->salvage) { /* the points without faces and edges */
        scan->info.face_count = 0;
        return stream_vertices(scan, err);
    }
    STP_TRY(read);
    STP_TRY(stp_mesh_take_colours(&scan->mesh, scan->path, err));
    if (!needed) {
        STP_TRY(stp_mesh_measure_coarse(&scan->mesh, &samples, err));
        if (samples == 0)
            return stream_vertices(scan, err);
    }
    note_mesh(scan);
    scan->info.face_count = scan->mesh.face_count;
    scan->info.grid = (stp_scan_grid){0};
    stp_ply_close(&scan->ply);
done:
    return status;
}

/* Streams the vertices. Holds the whole file only if it has edges, or if faces are needed. */
static stp_status open_ply(stp_scan *scan, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_ply_open(&scan->ply, scan->path, scan->params.salvage, err));
    const stp_ply *ply = scan->ply;
    scan->info.format = ply_name(ply->header.encoding);
    scan->info.attributes = ply->attributes;
    if (ply->intensity_scale > 0.0 && ply->intensity_low == 0.0)
        scan->info.intensity_full = 65535.0 / ply->intensity_scale;
    scan->info.point_count = ply->vertex->count;
    scan->info.lost_count = ply->lost_count;
    const bool strips = ply->faces && strcmp(ply->faces->name, "tristrips") == 0;
    scan->info.face_count = ply->faces && !strips ? ply->faces->count : 0;
    STP_TRY(copy_stations(scan, ply, err));
    scan->info.y_likely_down = stp_ply_has_splats(ply);
    scan->info.grid = ply->grid;
    STP_TRY(hold_mesh(scan, err));
    if (scan->ply == NULL) /* it is held */
        return STP_OK;
    ply = scan->ply;
    if (stp_ply_has_fixed_records(ply))
        scan->info.seek_points = 1;
    scan->info.extra = ply->numbers.list.count > 0 ? &ply->numbers.list : NULL;
    if (scan->params.numbers)
        STP_TRY(stp_ply_numbers_keep(scan->ply, err));
done:
    return status;
}

static stp_status open_mesh(stp_scan *scan, stp_scan_format format, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_mesh_read(&scan->mesh, scan->path, format, err));
    scan->info.format = mesh_name(format);
    scan->info.point_count = scan->mesh.point_count;
    scan->info.face_count = scan->mesh.face_count;
    scan->info.y_up = format == STP_SCAN_GLTF;
    note_mesh(scan);
done:
    return status;
}

/* Turns edges into lines. Vertices that no line uses stay points. */
static stp_status take_edges(stp_scan *scan, stp_error *err)
{
    stp_status status = STP_OK;
    stp_point_mesh *mesh = &scan->mesh;
    if (mesh->edge_count == 0)
        return STP_OK;
    if (scan->params.recompute_normals)
        mesh->attributes &= ~(uint32_t)STP_POINT_HAS_NORMAL;
    STP_TRY(stp_line_chain(&scan->lines, &scan->taken, mesh, scan->params.line_radius,
                           &scan->info.edges, err));
    scan->info.attributes |= mesh->attributes & STP_POINT_HAS_COLOUR;
    for (size_t i = 0; i < mesh->point_count; i++)
        scan->info.point_count -= scan->taken[i];
done:
    return status;
}

/* From here on the reader is closed together with the scan. */
static stp_status open_streamed(stp_scan *scan, const stp_scan_reader *reader, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&scan->reader_state, 1, reader->state_bytes, "a reader", err));
    scan->reader = reader;
    STP_TRY(reader->open(scan->reader_state, &scan->info, scan->path, &scan->params, err));
done:
    return status;
}

/* Takes normals from the faces if the file has none; removes normals if none are wanted. */
static void decide_normals(stp_scan *scan)
{
    if (scan->params.recompute_normals) {
        scan->info.attributes &= ~(uint32_t)STP_POINT_HAS_NORMAL;
    } else if (!(scan->info.attributes & STP_POINT_HAS_NORMAL) && scan->mesh.triangle_count > 0) {
        stp_point_mesh_set_normals(&scan->mesh);
        scan->info.attributes |= STP_POINT_HAS_NORMAL;
        scan->info.normals_from_faces = true;
    }
}

/* Lets a coarse mesh be sampled, and its large triangles be kept. */
static stp_status choose_sampling(stp_scan *scan, stp_error *err)
{
    stp_status status = STP_OK;
    stp_scan_params *params = &scan->params;
    if (!samples_coarse(params))
        return STP_OK;
    STP_TRY(stp_mesh_measure_coarse(&scan->mesh, &params->sample_count, err));
    scan->info.coarse_samples = params->sample_count;
    params->hybrid = params->sample_count > 0;
    if (params->hybrid)
        STP_TRY(stp_mesh_begin_samples(&scan->mesh, &scan->taken, scan->path, err));
    scan->info.loose_left_out = scan->mesh.loose_left_out;
done:
    return status;
}

/* Separates large triangles from those that become points. Nothing may be left to sample. */
static stp_status split_hybrid(stp_scan *scan, stp_error *err)
{
    stp_status status = STP_OK;
    stp_point_mesh *mesh = &scan->mesh;
    const bool sampled = scan->params.sample_count > 0;
    if (mesh->triangle_count == 0)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s has no faces to make a hybrid surface of: read its points as they "
                             "are (no --hybrid)",
                             scan->path);
    if (!scan->taken)
        STP_TRY(stp_alloc(&scan->taken, mesh->point_count, 1, "points", err));
    for (size_t i = 0; scan->params.recompute_normals && i < mesh->point_count; i++)
        mesh->points[i].normal = (vec3s){{0.0f, 0.0f, 0.0f}};
    STP_TRY(stp_hybrid_split(mesh, &scan->params.sample_count, scan->taken, &scan->triangles, err));
    scan->info.point_count = 0;
    for (size_t i = 0; !sampled && i < mesh->point_count; i++)
        scan->info.point_count += !scan->taken[i];
    if (sampled && scan->params.sample_count == 0) { /* the vertices are no points either */
        scan->sampler.mesh = mesh;
        scan->sampling = true;
        scan->info.point_count = mesh->loose_count;
    }
done:
    return status;
}

static stp_status start_sampling(stp_scan *scan, stp_error *err)
{
    stp_status status = STP_OK;
    if (scan->mesh.triangle_count == 0)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s has no faces to put %llu samples on: read its points as they are "
                             "(no --sample)",
                             scan->path, (unsigned long long)scan->params.sample_count);
    STP_TRY(stp_mesh_sampler_init(&scan->sampler, &scan->mesh, scan->params.sample_count,
                                  scan->params.seed, scan->path, err));
    scan->sampling = true;
    scan->info.point_count = scan->params.sample_count + scan->mesh.loose_count;
    scan->info.attributes &= ~(uint32_t)STP_POINT_HAS_STATION; /* no scanner saw the samples */
    scan->info.station_count = 0;
done:
    return status;
}

/* Fails if columns are named for a format that names its own, or what is no grid is called one. */
static stp_status check_params(const stp_scan *scan, stp_scan_format format, stp_error *err)
{
    const stp_scan_region *region = scan->params.region;
    if (scan->params.grid != NULL && format != STP_SCAN_GRID)
        return stp_error_set(
            err, STP_INVALID_ARGUMENT,
            "%s is no grid of heights or depths: --colour, --mask, --invalid, "
            "--spacing, --height-scale, --pinhole, --depth and --disparity are for grids",
            scan->name);
    if (region && region->resolution > 0.0 && format != STP_SCAN_LAS && format != STP_SCAN_EPT)
        return stp_octree_missing(scan->name, err);
    if (!scan->params.columns || format == STP_SCAN_XYZ || format == STP_SCAN_PTS ||
        format == STP_SCAN_NPY)
        return STP_OK;
    return stp_error_set(
        err, STP_INVALID_ARGUMENT,
        "%s: this format names its own columns: --columns is for XYZ, TXT, CSV, PTS and NPY",
        scan->name);
}

/* Fails if a part was asked for of what has no parts: lines, and the faces that a hybrid keeps. */
static stp_status check_region(const stp_scan *scan, stp_error *err)
{
    const stp_scan_region *region = scan->params.region;
    if (!region || !region->bounded || (scan->info.edges.read == 0 && !scan->params.hybrid))
        return STP_OK;
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "%s has lines or faces that are kept, and --bounds cuts only points: cut "
                         "it first, or read its points alone",
                         scan->name);
}

/* Opens the file at scan->path. */
static stp_status open_by_format(stp_scan *scan, stp_error *err)
{
    stp_status status = STP_OK;
    stp_scan_format format = STP_SCAN_EPT;
    if (!stp_is_address(scan->path))
        STP_TRY(stp_scan_detect_named(&format, scan->path, scan->name, err));
    STP_TRY(check_params(scan, format, err));
    if (scan->params.mirror && format != STP_SCAN_LAS)
        STP_TRY(stp_mirror_need(scan->params.mirror, 0, UINT64_MAX, err));
    const stp_scan_reader *reader = streamed_format(format);
    if (reader)
        STP_TRY(open_streamed(scan, reader, err));
    else
        STP_TRY(format == STP_SCAN_PLY ? open_ply(scan, err) : open_mesh(scan, format, err));
    STP_TRY(take_edges(scan, err));
    STP_TRY(check_region(scan, err));
    decide_normals(scan);
    STP_TRY(choose_sampling(scan, err));
    if (scan->params.hybrid)
        STP_TRY(split_hybrid(scan, err));
    if (scan->params.sample_count > 0)
        STP_TRY(start_sampling(scan, err));
    scan->info.point_count += scan->info.lost_count;
done:
    return status;
}

/* Readers know a mirror's path. Messages have the address instead. */
static stp_status say(const stp_scan *scan, stp_status status, const stp_error *why, stp_error *err)
{
    const char *at = strstr(why->message, scan->path);
    if (status == STP_OK)
        return STP_OK;
    if (!at || !scan->params.mirror)
        return stp_error_set(err, status, "%s", why->message);
    return stp_error_set(err, status, "%.*s%s%s", (int)(at - why->message), why->message,
                         scan->name, at + strlen(scan->path));
}

/* Chooses what is opened: a file, a mirror, or the address of an EPT. */
static stp_status choose_path(stp_scan *scan, const char *path, stp_error *err)
{
    stp_file_mirror *mirror = scan->params.mirror;
    if (stp_is_address(path) && !mirror && !stp_ept_is_named(path))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s is an address: copy the file here and give its path", path);
    if (mirror && stp_mirror_size(mirror) > 0) {
        const uint64_t head = STP_MIRROR_BLOCK_BYTES;
        const stp_status status = stp_mirror_need(mirror, 0, head, err);
        if (status != STP_OK)
            return status;
    }
    const stp_status status =
        stp_text_copy(&scan->path, mirror ? stp_mirror_path(mirror) : path, "path", err);
    scan->name = mirror ? stp_mirror_name(mirror) : scan->path;
    return status;
}

stp_status stp_scan_open(stp_scan **out, const char *path, const stp_scan_params *params,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    stp_scan *scan = NULL;
    STP_TRY(stp_alloc(&scan, 1, sizeof *scan, "scan", err));
    if (params)
        scan->params = *params;
    STP_TRY(choose_path(scan, path, err));
    STP_TRY(say(scan, open_by_format(scan, &why), &why, err));
    *out = scan;
    scan = NULL;
done:
    stp_scan_close(&scan);
    return status;
}

const stp_scan_info *stp_scan_get_info(const stp_scan *scan)
{
    return &scan->info;
}

void stp_scan_take_lines(stp_scan *scan, stp_line_set *out)
{
    *out = scan->lines;
    scan->lines = (stp_line_set){0};
}

void stp_scan_take_triangles(stp_scan *scan, stp_triangle_set *out)
{
    *out = scan->triangles;
    scan->triangles = (stp_triangle_set){0};
}

/* Reads the points of the mesh that are not taken. */
static size_t read_untaken(stp_scan *scan, stp_point *points, size_t capacity)
{
    size_t count = 0;
    for (; scan->next_point < scan->mesh.point_count && count < capacity; scan->next_point++)
        if (!scan->taken[scan->next_point])
            points[count++] = scan->mesh.points[scan->next_point];
    return count;
}

static size_t read_vertices(stp_scan *scan, stp_point *points, size_t capacity)
{
    const size_t left = scan->mesh.point_count - scan->next_point;
    const size_t part = capacity < left ? capacity : left;
    if (part > 0)
        memcpy(points, scan->mesh.points + scan->next_point, part * sizeof *points);
    scan->next_point += part;
    return part;
}

/* Points outside of the region are rejected, so that every record is accounted for. */
static void reject_outside(const stp_scan_region *region, stp_point *points, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (points[i].reject == STP_REJECT_NONE && !stp_scan_region_has(region, points[i].position))
            points[i].reject = STP_REJECT_OUTSIDE;
}

/* Reads the next points as they are. */
static stp_status read_points(stp_scan *scan, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    size_t got = 0;
    if (scan->reader)
        STP_TRY(say(scan, scan->reader->read(scan->reader_state, points, capacity, &got, &why),
                    &why, err));
    else if (scan->ply)
        STP_TRY(say(scan, stp_ply_read(scan->ply, points, capacity, &got, &why), &why, err));
    else if (scan->sampling)
        got = stp_mesh_sampler_next(&scan->sampler, points, capacity);
    else
        got = scan->taken ? read_untaken(scan, points, capacity)
                          : read_vertices(scan, points, capacity);
    *count = got;
done:
    return status;
}

/* Goes back to the point after the last one that was read, where records then come one by one.
 * False if that leads nowhere. */
static bool begin_singly(stp_scan *scan)
{
    const uint64_t apart = scan->info.seek_points;
    stp_point point;
    size_t got = 1;
    if (scan->singly || apart == 0)
        return false;
    scan->singly = true;
    uint64_t at = scan->point / apart * apart;
    if (stp_scan_seek(scan, at, NULL) != STP_OK)
        return false;
    for (; at < scan->point && got == 1; at++)
        if (read_points(scan, &point, 1, &got, NULL) != STP_OK)
            return false;
    return true;
}

/* The records up to the place where the file is cut or damaged, then as many lost ones as it
 * declares more. Readers that cannot seek read one by one: a block would be lost as a whole. */
static stp_status read_salvaged(stp_scan *scan, stp_point *points, size_t capacity, size_t *count,
                                stp_error *err)
{
    const uint64_t left = scan->info.point_count - scan->point;
    stp_status status = STP_CORRUPT;
    size_t got = 0;
    while (!scan->lost && capacity > 0) {
        const bool singly = scan->singly || scan->info.seek_points == 0;
        status = read_points(scan, points, singly ? 1 : capacity, &got, err);
        if (status != STP_OK && status != STP_CORRUPT)
            return status;
        if (status == STP_OK && got > 0)
            break;
        scan->lost = status == STP_OK || !begin_singly(scan);
    }
    if (scan->lost) {
        got = left < capacity ? (size_t)left : capacity;
        for (size_t i = 0; i < got; i++)
            points[i] = (stp_point){.reject = STP_REJECT_LOST};
    }
    scan->point += got;
    *count = got;
    return STP_OK;
}

stp_status stp_scan_read(stp_scan *scan, stp_point *points, size_t capacity, size_t *count,
                         stp_error *err)
{
    stp_status status = STP_OK;
    size_t got = 0;
    STP_TRY(scan->params.salvage ? read_salvaged(scan, points, capacity, &got, err)
                                 : read_points(scan, points, capacity, &got, err));
    if (scan->params.recompute_normals)
        for (size_t i = 0; i < got; i++)
            points[i].normal = (vec3s){{0.0f, 0.0f, 0.0f}};
    reject_outside(scan->params.region, points, got);
    *count = got;
done:
    return status;
}

const uint8_t *stp_scan_numbers(const stp_scan *scan)
{
    if (!scan->params.numbers || !scan->info.extra || scan->lost)
        return NULL;
    return scan->ply ? scan->ply->numbers.packed : scan->reader->numbers(scan->reader_state);
}

stp_status stp_scan_seek(stp_scan *scan, uint64_t point, stp_error *err)
{
    if (scan->info.seek_points == 0)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%s can only be read from its beginning",
                             scan->path);
    if (scan->reader)
        return scan->reader->seek(scan->reader_state, point, err);
    stp_ply_seek(scan->ply, point);
    return STP_OK;
}

void stp_scan_close(stp_scan **scan)
{
    stp_scan *s = *scan;
    if (!s)
        return;
    if (s->reader)
        s->reader->close(s->reader_state);
    free(s->reader_state);
    stp_ply_close(&s->ply);
    stp_point_mesh_free(&s->mesh);
    stp_line_set_clear(&s->lines);
    stp_triangle_set_clear(&s->triangles);
    free(s->taken);
    free(s->stations);
    free(s->path);
    free(s);
    *scan = NULL;
}
