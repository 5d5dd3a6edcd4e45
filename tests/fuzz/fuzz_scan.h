/* Helpers for the fuzz targets of scan readers: turn bytes into a file and read it in every way. */
#ifndef STP_TESTS_FUZZ_FUZZ_SCAN_H
#define STP_TESTS_FUZZ_FUZZ_SCAN_H

#include "formats/scan/coordinate_step.h"
#include "formats/scan/mesh/mesh.h"
#include "formats/scan/scan.h"
#include "tests/fuzz/fuzz_memory.h"
#include "tests/fuzz/fuzz_target.h"

#include <math.h>

/* Checks that strips share no vertex, follow one another, and have finite lengths. */
static inline void fuzz_take_lines(stp_scan *scan)
{
    stp_line_set lines = {0};
    uint64_t next = 0;
    stp_scan_take_lines(scan, &lines);
    for (uint64_t i = 0; i < lines.strip_count; i++) {
        fuzz_require(lines.strips[i].begin == next && lines.strips[i].count >= 2,
                     "strips follow each other");
        next += lines.strips[i].count;
    }
    fuzz_require(next == lines.vertex_count, "strips have all vertices");
    for (uint64_t i = 0; i < lines.vertex_count; i++)
        fuzz_require(stp_dvec3_finite(lines.vertices[i].position) &&
                         isfinite(lines.vertices[i].radius) && lines.vertices[i].radius >= 0.0f,
                     "a vertex of a line is made of numbers");
    stp_line_set_clear(&lines);
}

static inline void fuzz_take_triangles(stp_scan *scan)
{
    stp_triangle_set set = {0};
    stp_scan_take_triangles(scan, &set);
    for (uint64_t i = 0; i < set.triangle_count; i++)
        for (int k = 0; k < 3; k++)
            fuzz_require(set.triangles[i][k] < set.vertex_count, "a kept triangle's corners exist");
    for (uint64_t i = 0; i < set.vertex_count; i++)
        fuzz_require(isfinite(set.vertices[i].radius), "a triangle's radius is a number");
    stp_triangle_set_clear(&set);
}

/* Checks the attributes of points: their names are unique, and every byte of theirs is there. */
static inline void fuzz_check_numbers(const stp_scan *scan, size_t count)
{
    const stp_attribute_list *list = stp_scan_get_info(scan)->extra;
    const uint8_t *packed = stp_scan_numbers(scan);
    unsigned sum = 0;
    for (size_t i = 0; packed && i < count * stp_attribute_list_bytes(list); i++)
        sum += packed[i];
    fuzz_require(sum <= count * 255u * 8u * STP_ATTRIBUTES_LIMIT, "a sum of bytes");
    for (uint32_t i = 0; list && i < list->count; i++)
        fuzz_require(stp_attribute_find(list, list->items[i].name) == i, "names are unique");
}

/* Of a packed file that declares 2^60 points, all but a few are lost. They come one by one, and
 * prep would refuse so many before it reads them. */
#define FUZZ_LOST_MOST 1000000u

/* Reads a scan to its end. A failure must have a message. A success must give as many points as it
 * promised, all in range. */
static inline void fuzz_read_scan(const char *path, const stp_scan_params *params)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    stp_point points[100];
    uint64_t total = 0;
    size_t count = 1;
    stp_status status = stp_scan_open(&scan, path, params, &err);
    fuzz_require((status == STP_OK) == (scan != NULL), "a scan exactly where opening succeeds");
    for (uint32_t i = 0; scan && i < stp_scan_get_info(scan)->station_count; i++)
        fuzz_require(stp_dvec3_finite(stp_scan_get_info(scan)->stations[i]),
                     "a station's position is finite");
    if (scan) {
        fuzz_take_lines(scan);
        fuzz_take_triangles(scan);
    }
    while (status == STP_OK && count > 0) {
        if (params && params->salvage && total > FUZZ_LOST_MOST)
            goto done;
        status = stp_scan_read(scan, points, 100, &count, &err);
        for (size_t i = 0; i < count && status == STP_OK; i++) {
            const vec3s n = points[i].normal;
            const float length = sqrtf(n.x * n.x + n.y * n.y + n.z * n.z);
            fuzz_require(length == 0.0f || fabsf(length - 1.0f) < 1e-5f,
                         "a normal is unit or zero");
            fuzz_require(points[i].station <= stp_scan_get_info(scan)->station_count,
                         "a point's station has a position");
        }
        if (status == STP_OK)
            fuzz_check_numbers(scan, count);
        total += status == STP_OK ? count : 0;
    }
    if (status == STP_OK)
        fuzz_require(total == stp_scan_get_info(scan)->point_count, "all points are read");
    else
        fuzz_require(status == err.status && err.message[0], "a failure says why");
done:
    stp_scan_close(&scan);
}

/* Looks for a step: a step must be returned exactly if the status is OK. */
static inline void fuzz_find_step(const char *path)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    double step = -1.0;
    if (stp_scan_open(&scan, path, NULL, &err) != STP_OK)
        return;
    const stp_status status = stp_scan_find_step(scan, false, &step, &err);
    fuzz_require((status == STP_OK) == (step >= 0.0), "a step exactly where finding it succeeds");
    stp_scan_close(&scan);
}

static inline void fuzz_read_mesh(const char *path)
{
    stp_error err = {0};
    stp_mesh *mesh = NULL;
    if (stp_mesh_load(&mesh, path, &err) != STP_OK)
        return;
    for (uint64_t i = 0; i < mesh->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            fuzz_require(mesh->triangles[i][k] < mesh->vertex_count, "a triangle's corners exist");
    stp_mesh_destroy(&mesh);
}

/* Makes an image of 3 x 2 texels, once, that meshes can name: `99`. */
static inline void fuzz_make_image(void)
{
    static const uint8_t png[] = {137, 80,  78,  71,  13,  10, 26, 10, 0,   0,  0,   13, 73,  72,
                                  68,  82,  0,   0,   0,   3,  0,  0,  0,   2,  8,   2,  0,   0,
                                  0,   18,  22,  241, 77,  0,  0,  0,  25,  73, 68,  65, 84,  120,
                                  218, 5,   193, 1,   1,   0,  0,  0,  130, 32, 199, 54, 150, 89,
                                  65,  101, 145, 154, 141, 57, 69, 56, 8,   53, 202, 80, 82,  138,
                                  0,   0,   0,   0,   73,  69, 78, 68, 174, 66, 96,  130};
    static int made = -1;
    if (made >= 0)
        return;
    made = memfd_create("image", MFD_CLOEXEC);
    if (write(made, png, sizeof png) != (ssize_t)sizeof png || dup2(made, FUZZ_DESCRIPTOR - 1) < 0)
        abort();
}

/* Reads the begin of a mesh that is sampled if it is coarse: with many points, always. */
static inline void fuzz_read_coarse(const char *path)
{
    const stp_scan_params params = {.sample_coarse = true};
    stp_error err = {0};
    stp_scan *scan = NULL;
    stp_point points[100];
    size_t count;
    if (stp_scan_open(&scan, path, &params, &err) != STP_OK)
        return;
    fuzz_take_triangles(scan);
    (void)stp_scan_read(scan, points, 100, &count, &err);
    stp_scan_close(&scan);
}

static inline int fuzz_scan_bytes(const uint8_t *data, size_t size)
{
    char path[64];
    fuzz_make_image();
    const int descriptor = fuzz_memory_file(data, size, path);
    const stp_scan_params sampled = {.sample_count = 150, .seed = size};
    const stp_scan_params plain = {.recompute_normals = true};
    const stp_scan_params hybrid = {.hybrid = true, .sample_count = 90, .line_radius = 0.5};
    const stp_scan_region box = {.bounded = true, .min = {-10, -10, -10}, .max = {1e5, 1e5, 1e5}};
    const stp_scan_params part = {.region = &box};
    const stp_scan_params numbers = {.numbers = true};
    const stp_scan_params grid = {.keep_grid = true};
    const stp_scan_params salvage = {.salvage = true, .numbers = true};
    fuzz_read_scan(path, NULL);
    fuzz_read_scan(path, &part);
    fuzz_read_scan(path, &numbers);
    fuzz_read_scan(path, &grid);
    fuzz_read_scan(path, &salvage);
    fuzz_read_scan(path, &sampled);
    fuzz_read_scan(path, &plain);
    fuzz_read_scan(path, &hybrid);
    fuzz_read_coarse(path);
    fuzz_find_step(path);
    fuzz_read_mesh(path);
    close(descriptor);
    return 0;
}

#endif
