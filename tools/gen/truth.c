/* Ray casting of the bumpy sphere. */
#include "tools/gen/truth.h"

#include "base/file.h"
#include "base/memory.h"

#include <cjson/cJSON.h>
#include <stdlib.h>
#include <unistd.h>

typedef struct view {
    const gen_surface *surface;
    stp_image *image;
    stp_dvec3 eye, back, right, up;
    double half_height; /* of the image plane at distance 1 */
} view;

void gen_camera_default(gen_camera *camera, const gen_surface *surface)
{
    double distance = surface->radius / sin(22.5 * (3.14159265358979323846 / 180.0));
    *camera =
        (gen_camera){.eye = {surface->centre.x, surface->centre.y, surface->centre.z + distance},
                     .look = {surface->centre.x, surface->centre.y, surface->centre.z},
                     .up = {0.0, 1.0, 0.0},
                     .fovy_deg = 45.0,
                     .size = {1024, 1024}};
}

static bool take_numbers(const cJSON *json, const char *key, double *numbers, int count)
{
    const cJSON *array = cJSON_GetObjectItemCaseSensitive(json, key);
    if (array == NULL)
        return true;
    if (!cJSON_IsArray(array) || cJSON_GetArraySize(array) != count)
        return false;
    for (int i = 0; i < count; i++) {
        const cJSON *item = cJSON_GetArrayItem(array, i);
        if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble))
            return false;
        numbers[i] = item->valuedouble;
    }
    return true;
}

static const char *parse_camera(const cJSON *json, gen_camera *camera)
{
    double size[2] = {camera->size[0], camera->size[1]};
    const cJSON *angle = cJSON_GetObjectItemCaseSensitive(json, "fovy_deg");
    if (!cJSON_IsObject(json))
        return "it is not a JSON object";
    if (!take_numbers(json, "eye", camera->eye, 3))
        return "eye is not three numbers";
    if (!take_numbers(json, "look", camera->look, 3))
        return "look is not three numbers";
    if (!take_numbers(json, "up", camera->up, 3))
        return "up is not three numbers";
    if (angle != NULL && !cJSON_IsNumber(angle))
        return "fovy_deg is not a number";
    if (angle != NULL)
        camera->fovy_deg = angle->valuedouble;
    if (!take_numbers(json, "size", size, 2) || !(size[0] >= 1.0 && size[0] <= 16384.0) ||
        !(size[1] >= 1.0 && size[1] <= 16384.0))
        return "size is not two numbers from 1 to 16384";
    camera->size[0] = (int)size[0];
    camera->size[1] = (int)size[1];
    return NULL;
}

stp_status gen_camera_load(gen_camera *camera, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    int descriptor = -1;
    uint64_t size = 0;
    char *text = NULL;
    cJSON *json = NULL;
    gen_camera result = *camera;
    STP_TRY(stp_file_open(path, &descriptor, &size, err));
    if (size > 1u << 20) {
        status =
            stp_error_set(err, STP_LIMIT, "%s: a camera file of more than 1 MiB is not one", path);
        goto done;
    }
    STP_TRY(stp_alloc(&text, (size_t)size + 1, 1, "bytes of camera file", err));
    STP_TRY(stp_file_read_at(descriptor, path, 0, text, (size_t)size, err));
    json = cJSON_ParseWithLength(text, (size_t)size);
    const char *fault = parse_camera(json, &result);
    if (fault != NULL) {
        status = stp_error_set(err, STP_CORRUPT, "%s is no camera: %s", path, fault);
        goto done;
    }
    *camera = result;
done:
    cJSON_Delete(json);
    free(text);
    if (descriptor >= 0)
        close(descriptor);
    return status;
}

/* |p| minus the radius in p's direction: positive outside. */
static double outside(const gen_surface *surface, stp_dvec3 p, gen_hit *hit)
{
    surface->project(surface, p, hit);
    return stp_dvec3_length(p) - stp_dvec3_length(hit->position);
}

/* The first root along the ray inside the surface's ball. `outside` changes by no more than twice
 * the distance (its slopes are below sqrt(3)), so half its value is a safe step; a safe step never
 * passes a root, and one that has become tiny is at it. */
static bool cast(const gen_surface *surface, stp_dvec3 eye, stp_dvec3 direction, gen_hit *hit)
{
    double along = -stp_dvec3_dot(eye, direction);
    double gap = stp_dvec3_dot(eye, eye) - along * along;
    double reach = surface->radius * surface->radius - gap;
    if (reach <= 0.0)
        return false;
    double t = fmax(along - sqrt(reach), 0.0), end = along + sqrt(reach);
    while (t < end) {
        double value = outside(surface, stp_dvec3_add(eye, stp_dvec3_scale(direction, t)), hit);
        if (value < 1e-9)
            return true;
        t += fmax(0.5 * value, 1e-9);
    }
    return false;
}

static stp_status render_row(void *context, size_t row, unsigned worker, stp_error *err)
{
    (void)worker;
    (void)err;
    const view *v = context;
    int width = v->image->width, height = v->image->height;
    for (int column = 0; column < width; column++) {
        double x = (2.0 * ((double)column + 0.5) - (double)width) / (double)height;
        double y = 1.0 - 2.0 * ((double)row + 0.5) / (double)height;
        stp_dvec3 direction = stp_dvec3_scale(v->back, -1.0);
        direction = stp_dvec3_add(direction, stp_dvec3_scale(v->right, x * v->half_height));
        direction = stp_dvec3_add(direction, stp_dvec3_scale(v->up, y * v->half_height));
        gen_hit hit;
        uint8_t *pixel = v->image->rgba + 4 * (row * (size_t)width + (size_t)column);
        if (!cast(v->surface, v->eye, stp_dvec3_normalize(direction), &hit))
            continue;
        double facing = stp_dvec3_dot(stp_dvec3_from_float(hit.normal), v->back);
        double light = 0.05 + 0.85 * fmax(0.0, facing);
        for (int i = 0; i < 3; i++)
            pixel[i] = (uint8_t)((double)hit.colour.raw[i] * light * 255.0 + 0.5);
        pixel[3] = 255;
    }
    return STP_OK;
}

static stp_dvec3 vector(const double numbers[3])
{
    return (stp_dvec3){numbers[0], numbers[1], numbers[2]};
}

stp_status gen_truth_render(stp_image *image, const gen_surface *surface, const gen_camera *camera,
                            stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_image result = {.width = camera->size[0], .height = camera->size[1]};
    view v = {.surface = surface, .image = &result, .eye = vector(camera->eye)};
    v.back = stp_dvec3_normalize(stp_dvec3_sub(v.eye, vector(camera->look)));
    v.right = stp_dvec3_normalize(stp_dvec3_cross(vector(camera->up), v.back));
    v.up = stp_dvec3_cross(v.back, v.right);
    v.half_height = tan(camera->fovy_deg * (0.5 * 3.14159265358979323846 / 180.0));
    if (!(stp_dvec3_length(v.right) > 0.5))
        return stp_error_set(
            err, STP_INVALID_ARGUMENT,
            "the camera has no direction: eye is at look, or up is along the view");
    if (!(camera->fovy_deg > 0.0 && camera->fovy_deg < 180.0))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "a vertical field of view of %g degrees is not between 0 and 180",
                             camera->fovy_deg);
    STP_TRY(
        stp_alloc(&result.rgba, (size_t)result.width * (size_t)result.height, 4, "pixels", err));
    STP_TRY(stp_pool_run(pool, (size_t)result.height, render_row, &v, err));
    *image = result;
    result.rgba = NULL;
done:
    free(result.rgba);
    return status;
}
