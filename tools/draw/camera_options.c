/* Options of the camera. */
#include "tools/draw/camera_options.h"

#include <string.h>

camera_options camera_options_default(void)
{
    return (camera_options){.fovy_deg = STP_CAMERA_FOVY_DEG, .size = {1024, 1024}};
}

void camera_options_fill(camera_options *o, cli_option out[CAMERA_OPTION_COUNT])
{
    const cli_option options[CAMERA_OPTION_COUNT] = {
        {"--size", 0, CLI_EXTENT, o->size, "WxH",
         "size of the picture in pixels (1024x1024; view: by the screen)", &o->has_size},
        {"--camera", 0, CLI_STRING, &o->path, "C.json",
         "JSON file with eye, look, up, fovy_deg (or height) and size", NULL},
        {"--eye", 0, CLI_VEC3, o->eye, "x,y,z", "position of the eye", &o->has_eye},
        {"--look", 0, CLI_VEC3, o->look, "x,y,z", "point that the eye looks at", &o->has_look},
        {"--up", 0, CLI_VEC3, o->up, "x,y,z", "direction that is up in the picture", &o->has_up},
        {"--fovy", 0, CLI_NUMBER, &o->fovy_deg, "DEG", "vertical angle of view (45)", &o->has_fovy},
    };
    memcpy(out, options, sizeof options);
}

stp_status camera_options_size(const camera_options *o, int size[2], stp_error *err)
{
    stp_status status = STP_OK;
    stp_camera file = {0};
    if (o->path != NULL)
        STP_TRY(stp_camera_load(&file, o->path, err));
    bool from_file = !o->has_size && file.size[0] > 0 && file.size[1] > 0;
    memcpy(size, from_file ? file.size : o->size, sizeof file.size);
done:
    return status;
}

static void take(stp_dvec3 *out, const double v[3], bool given)
{
    if (given)
        *out = (stp_dvec3){v[0], v[1], v[2]};
}

stp_status camera_options_apply(const camera_options *o, stp_camera *camera, stp_error *err)
{
    stp_status status = STP_OK;
    if (o->path != NULL)
        STP_TRY(stp_camera_load(camera, o->path, err));
    take(&camera->eye, o->eye, o->has_eye);
    take(&camera->look, o->look, o->has_look);
    take(&camera->up, o->up, o->has_up);
    if (o->has_fovy) {
        camera->fovy_deg = o->fovy_deg;
        camera->height = 0.0;
    }
done:
    return status;
}
