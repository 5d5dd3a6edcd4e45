/* Records the camera's path as keyframes for `stipple fly --path`. Threads: the main thread only.
 */
#ifndef STP_TOOLS_VIEW_KEPT_VIEW_RECORD_H
#define STP_TOOLS_VIEW_KEPT_VIEW_RECORD_H

#include "runtime/camera/path.h"

/* Zero records nothing. */
typedef struct view_record {
    bool on;
    double begun_s;
    double still_s; /* last time at which the camera was still that of the last keyframe, from
                       begun_s */
    stp_keyframe *frames;
    size_t count, capacity;
} view_record;

void view_record_begin(view_record *record, double now_s);
/* Adds the camera if it moved. A rest gets a keyframe at its begin and its end. Errors:
 * OUT_OF_MEMORY, LIMIT (keyframes), UNSUPPORTED (the projection changed). After an error the caller
 * must end the recording. */
stp_status view_record_note(view_record *record, const stp_camera *camera, double now_s,
                            stp_error *err);
/* Ends where the camera is now, makes the path even (view_smooth.h) and writes it to a new file.
 * Errors: those of stp_path_save. */
stp_status view_record_end(view_record *record, const stp_camera *camera, const char *path,
                           double now_s, stp_error *err);
void view_record_destroy(view_record *record);

#endif
