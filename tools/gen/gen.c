/* stipple gen: makes a scan of a known surface, its true mesh and, for one shape, its true picture.
 */
#include "base/clock.h"
#include "base/memory.h"
#include "base/pool.h"
#include "tools/draw/camera_options.h"
#include "tools/gen/gen_scan.h"
#include "tools/gen/truth.h"
#include "tools/gen/visibility.h"

#include <stdlib.h>
#include <string.h>

extern const cli_command cli_gen;

/* Points per task. A batch is this many tasks, written in order. */
enum { TASK_POINTS = 1 << 15, BATCH_TASKS = 8 };

typedef struct options {
    const char *output, *mesh, *truth;
    uint64_t point_count, seed, station_count, mesh_triangles;
    double noise;
    int order;
    bool normals, no_colour, force;
    camera_options camera;
} options;

typedef struct batch {
    const gen_sampler *sampler;
    uint64_t first, end;
    stp_point *points;
} batch;

static stp_status fill_task(void *context, size_t index, unsigned worker, stp_error *err)
{
    (void)worker;
    (void)err;
    const batch *b = context;
    uint64_t offset = (uint64_t)index * TASK_POINTS;
    uint64_t left = b->end - b->first - offset;
    size_t count = left < TASK_POINTS ? (size_t)left : TASK_POINTS;
    gen_sampler_fill(b->sampler, b->first + offset, count, b->points + offset, NULL);
    return STP_OK;
}

static stp_status write_points(const options *o, const gen_surface *surface, stp_pool *pool,
                               const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    gen_sampler *sampler = NULL;
    gen_scan scan = {0};
    batch work = {0};
    gen_sampler_params params = {.surface = surface,
                                 .point_count = o->point_count,
                                 .seed = o->seed,
                                 .station_count = o->station_count,
                                 .noise_spacings = o->noise,
                                 .random_order = o->order == 1};
    STP_TRY(gen_sampler_create(&sampler, &params, pool, err));
    const uint32_t attributes = (o->normals ? STP_POINT_HAS_NORMAL : 0u) |
                                (o->no_colour ? 0u : STP_POINT_HAS_COLOUR) |
                                (surface->has_class ? STP_POINT_HAS_CLASS : 0u) |
                                (o->station_count > 1 ? STP_POINT_HAS_STATION : 0u);
    STP_TRY(gen_scan_create(&scan, o->output, o->force, attributes, sampler, &params, err));
    size_t batch_points = (size_t)TASK_POINTS * BATCH_TASKS;
    STP_TRY(stp_alloc(&work.points, batch_points, sizeof *work.points, "points", err));
    work.sampler = sampler;
    while (work.first < o->point_count) {
        uint64_t left = o->point_count - work.first;
        work.end = work.first + (left < batch_points ? left : batch_points);
        size_t count = (size_t)(work.end - work.first);
        size_t tasks = (count + TASK_POINTS - 1) / TASK_POINTS;
        STP_TRY(stp_pool_run(pool, tasks, fill_task, &work, err));
        STP_TRY(gen_scan_points(&scan, work.points, count, err));
        work.first = work.end;
        STP_TRY(stp_progress_update(progress, "points", work.first, o->point_count, err));
    }
    STP_TRY(gen_scan_finish(&scan, err));
done:
    free(work.points);
    gen_scan_destroy(&scan);
    gen_sampler_destroy(&sampler);
    return status;
}

typedef struct vertex_batch {
    const gen_surface *surface;
    const gen_mesh *mesh;
    size_t first, count;
    stp_point *points;
} vertex_batch;

static stp_status vertex_task(void *context, size_t index, unsigned worker, stp_error *err)
{
    (void)worker;
    (void)err;
    const vertex_batch *b = context;
    size_t end = (index + 1) * TASK_POINTS < b->count ? (index + 1) * TASK_POINTS : b->count;
    for (size_t i = index * TASK_POINTS; i < end; i++) {
        gen_hit hit;
        gen_surface_vertex(b->surface, b->mesh, b->first + i, &hit);
        b->points[i] = gen_hit_point(&hit);
    }
    return STP_OK;
}

static stp_status write_mesh(const options *o, const gen_surface *surface, stp_pool *pool,
                             const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ply_writer *writer = NULL;
    gen_mesh mesh = {0};
    vertex_batch work = {.surface = surface, .mesh = &mesh};
    uint64_t triangles = o->mesh_triangles ? o->mesh_triangles : surface->mesh_triangles;
    STP_TRY(stp_progress_update(progress, "mesh", 0, 0, err));
    STP_TRY(surface->mesh(surface, triangles, pool, &mesh, err));
    stp_ply_writer_params params = {.force = o->force,
                                    .vertex_count = mesh.vertex_count,
                                    .triangle_count = mesh.triangle_count,
                                    .attributes = STP_POINT_HAS_NORMAL | STP_POINT_HAS_COLOUR};
    STP_TRY(stp_ply_writer_create(&writer, o->mesh, &params, err));
    size_t capacity = (size_t)TASK_POINTS * BATCH_TASKS;
    STP_TRY(stp_alloc(&work.points, capacity, sizeof *work.points, "points", err));
    while (work.first < mesh.vertex_count) {
        size_t left = mesh.vertex_count - work.first;
        work.count = left < capacity ? left : capacity;
        STP_TRY(stp_pool_run(pool, (work.count + TASK_POINTS - 1) / TASK_POINTS, vertex_task, &work,
                             err));
        STP_TRY(stp_ply_writer_points(writer, work.points, work.count, err));
        work.first += work.count;
        STP_TRY(stp_progress_update(progress, "mesh", work.first, mesh.vertex_count, err));
    }
    STP_TRY(stp_ply_writer_triangles(writer, (const uint32_t(*)[3])mesh.triangles,
                                     mesh.triangle_count, err));
    STP_TRY(stp_ply_writer_finish(&writer, err));
done:
    free(work.points);
    gen_mesh_clear(&mesh);
    stp_ply_writer_destroy(&writer);
    return status;
}

static stp_status write_truth(const options *o, const gen_surface *surface, stp_pool *pool,
                              stp_error *err)
{
    stp_status status = STP_OK;
    stp_image image = {0};
    stp_ball ball = {surface->centre, surface->radius};
    stp_view view;
    int size[2];
    STP_TRY(camera_options_size(&o->camera, size, err));
    stp_camera camera = gen_truth_camera(surface, size);
    STP_TRY(camera_options_apply(&o->camera, &camera, err));
    STP_TRY(stp_view_create(&view, &camera, &ball, size[0], size[1], err));
    STP_TRY(gen_truth_render(&image, surface, &view, pool, err));
    STP_TRY(stp_image_save(&image, o->truth, o->force, err));
done:
    stp_image_destroy(&image);
    return status;
}

static stp_status generate(const options *o, gen_shape shape, const cli_common *common,
                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_pool *pool = NULL;
    gen_surface surface;
    const stp_progress *progress = cli_progress(common);
    const char *const outputs[CLI_OUTPUT_LIMIT] = {o->output, o->mesh, o->truth};
    STP_TRY(cli_check_outputs(outputs, &o->camera.path, 1, o->force, err));
    gen_surface_init(&surface, shape, o->point_count, o->seed);
    STP_TRY(stp_pool_create(&pool, (unsigned)common->threads, err));
    if (o->output != NULL)
        STP_TRY(write_points(o, &surface, pool, progress, err));
    if (o->mesh != NULL)
        STP_TRY(write_mesh(o, &surface, pool, progress, err));
    if (o->truth != NULL)
        STP_TRY(write_truth(o, &surface, pool, err));
done:
    cli_progress_end();
    stp_pool_destroy(&pool);
    return status;
}

/* Returns a usage message if something is missing or does not fit together, else NULL. */
static const char *check(const options *o, gen_shape shape)
{
    if (o->output == NULL && o->mesh == NULL && o->truth == NULL)
        return "no output: give -o F.ply, --mesh F.ply or --truth I.png";
    if (o->output != NULL && o->point_count == 0)
        return "no number of points: give -n N, 1 or more";
    if (o->output != NULL && o->normals && gen_scan_is_las(o->output))
        return "--normals: LAS has no normals; give -o F.ply";
    if (o->truth != NULL && shape != GEN_BUMPY)
        return "--truth needs the shape bumpy";
    if (o->mesh_triangles > 0 && shape == GEN_BUILDING)
        return "--mesh-triangles: the building's mesh is the building";
    if (o->mesh_triangles > 0 && shape == GEN_TREE)
        return "--mesh-triangles: the tree's mesh is the tree; give -n N for about N vertices";
    if (o->station_count > GEN_STATION_LIMIT)
        return "--stations: at most 64 are possible";
    if (!(o->noise >= 0.0))
        return "--noise: must not be negative";
    return NULL;
}

static int run(int argc, char **argv)
{
    options o = {.camera = camera_options_default()};
    cli_common common = {0};
    stp_error error = {0};
    const cli_option own[] = {
        {"--points", 'n', CLI_UINT, &o.point_count, "N", "number of points", NULL},
        {"--output", 'o', CLI_STRING, &o.output, "F.ply|F.las|F.laz", "the scan to write", NULL},
        {"--order", 0, CLI_CHOICE, &o.order, "scan|random",
         "scan: neighbours in space are neighbours in the file; random: not (scan)", NULL},
        {"--noise", 0, CLI_NUMBER, &o.noise, "SPACINGS",
         "standard deviation of noise along the normal, in sample spacings (0)", NULL},
        {"--seed", 0, CLI_UINT, &o.seed, "K",
         "seed of the random numbers: another seed gives another scan (0)", NULL},
        {"--normals", 0, CLI_FLAG, &o.normals, NULL, "write the true normals", NULL},
        {"--no-colour", 0, CLI_FLAG, &o.no_colour, NULL, "write no colours", NULL},
        {"--stations", 0, CLI_UINT, &o.station_count, "N",
         "sample only what one of N scanner stations around sees (at most 64)", NULL},
        {"--mesh", 0, CLI_STRING, &o.mesh, "F.ply", "write the true surface as triangles", NULL},
        {"--mesh-triangles", 0, CLI_UINT, &o.mesh_triangles, "N",
         "approximate number of triangles of --mesh (as the shape needs)", NULL},
        {"--truth", 0, CLI_STRING, &o.truth, "I.png", "write the exact picture (bumpy only)", NULL},
        {"--force", 'f', CLI_FLAG, &o.force, NULL, "replace existing files", NULL},
    };
    cli_option list[sizeof own / sizeof *own + CAMERA_OPTION_COUNT];
    memcpy(list, own, sizeof own);
    camera_options_fill(&o.camera, list + sizeof own / sizeof *own);
    const char *name = NULL;
    size_t name_count = 0;
    int result = cli_parse(&cli_gen, list, sizeof list / sizeof *list, argc, argv, &name, 1, 1,
                           &name_count, &common);
    if (result != CLI_CONTINUE)
        return result;
    gen_shape shape = gen_shape_find(name);
    if (shape == GEN_SHAPE_COUNT)
        return cli_usage(&cli_gen, "no shape is called %s", name);
    const char *fault = check(&o, shape);
    if (fault != NULL)
        return cli_usage(&cli_gen, "%s", fault);
    if (generate(&o, shape, &common, &error) != STP_OK)
        return cli_fail(&cli_gen, &error);
    return CLI_DONE;
}

const cli_command cli_gen = {
    .name = "gen",
    .summary = "make a scan of a known surface",
    .usage = "stipple gen SHAPE -n N -o F.ply [options]",
    .details =
        "Shapes: statue, bumpy, terrain, sphere, plane, torus, sheet (two sides one spacing "
        "apart),\n"
        "tree (leaves and branches; its mesh has about N vertices, 16 million at most),\n"
        "building (twenty rooms with doors, windows and furniture).\n"
        "The scan is LAS 1.4 if its name ends in .las, packed (LAZ) if in .laz, else PLY.\n"
        "Points are spread evenly over the true surface. Memory grows with the tree, but not with\n"
        "the number of points of other shapes.\n"
        "With --stations, a PLY file says where the stations are and which one saw a point. A LAS\n"
        "file says only which station saw a point, as point source ID.\n"
        "The camera options are for the picture of --truth.",
    .run = run,
};
