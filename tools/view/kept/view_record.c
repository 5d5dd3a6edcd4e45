/* Makes a path from cameras that were seen one after the other. */
#include "tools/view/kept/view_record.h"

#include "base/memory.h"
#include "tools/view/kept/view_smooth.h"

#include <stdlib.h>
#include <string.h>

/* Seconds between two keyframes. */
#define STEP_S 0.1

void view_record_begin(view_record *r, double now_s)
{
    r->on = true;
    r->begun_s = now_s;
    r->still_s = 0.0;
    r->count = 0;
}

static stp_status add(view_record *r, const stp_camera *camera, double time_s, stp_error *err)
{
    if (r->count == STP_PATH_KEYFRAMES_LIMIT)
        return stp_error_set(err, STP_LIMIT, "the recording ends: it has %u keyframes",
                             STP_PATH_KEYFRAMES_LIMIT);
    stp_status status =
        stp_grow(&r->frames, &r->capacity, r->count + 1, sizeof *r->frames, "keyframes", err);
    if (status == STP_OK)
        r->frames[r->count++] = (stp_keyframe){time_s, *camera};
    return status;
}

stp_status view_record_note(view_record *r, const stp_camera *camera, double now_s, stp_error *err)
{
    double time_s = now_s - r->begun_s;
    if (!r->on)
        return STP_OK;
    if (r->count == 0)
        return add(r, camera, 0.0, err);
    const stp_keyframe last = r->frames[r->count - 1];
    if (stp_camera_equal(&last.camera, camera)) {
        r->still_s = time_s;
        return STP_OK;
    }
    if ((last.camera.height > 0.0) != (camera->height > 0.0))
        return stp_error_set(
            err, STP_UNSUPPORTED,
            "the recording ends: a path is perspective or orthographic throughout");
    if (time_s - last.time_s < STEP_S)
        return STP_OK;
    if (r->still_s - last.time_s >= STEP_S && time_s - r->still_s > 0.0) {
        stp_status status = add(r, &last.camera, r->still_s, err);
        if (status != STP_OK)
            return status;
    }
    r->still_s = time_s;
    return add(r, camera, time_s, err);
}

/* Whether the camera at the end can be the last keyframe. A recording that ended because of its
 * length or of the projection keeps what it has. */
static bool may_add_last(const view_record *r, const stp_camera *camera, double time_s)
{
    if (r->count == 0)
        return true;
    const stp_keyframe *last = &r->frames[r->count - 1];
    return r->count < STP_PATH_KEYFRAMES_LIMIT && time_s > last->time_s &&
           (last->camera.height > 0.0) == (camera->height > 0.0);
}

stp_status view_record_end(view_record *r, const stp_camera *camera, const char *path, double now_s,
                           stp_error *err)
{
    double time_s = now_s - r->begun_s;
    stp_status status = STP_OK;
    stp_path_params params = {0};
    stp_keyframe *frames = NULL;
    r->on = false;
    if (may_add_last(r, camera, time_s))
        STP_TRY(add(r, camera, time_s, err));
    STP_TRY(view_smooth(&frames, &params.count, r->frames, r->count, err));
    params.keyframes = frames;
    STP_TRY(stp_path_save(&params, path, false, err));
done:
    free(frames);
    return status;
}

void view_record_destroy(view_record *r)
{
    free(r->frames);
    *r = (view_record){0};
}
