/* The camera that first shows a model: prep decides it, and the file's metadata keeps it. */
#ifndef STP_PREPROCESS_VIEWPOINT_FIRST_CAMERA_H
#define STP_PREPROCESS_VIEWPOINT_FIRST_CAMERA_H

#include "base/vec_types.h"

typedef enum stp_first_why {
    STP_FIRST_WHOLE = 0, /* no camera: the whole model is shown */
    STP_FIRST_SCANNER,
    STP_FIRST_INTERIOR,
    STP_FIRST_MAIN, /* all but a few points that lie far away */
    STP_FIRST_PART, /* the part that has the most points: others lie far away */
    STP_FIRST_SIDE  /* the broad side of something flat */
} stp_first_why;

typedef struct stp_first_camera {
    stp_first_why why;
    stp_dvec3 eye, look, up;
    double fovy_deg, aspect; /* width / height of what should be visible */
    stp_dvec3 model_up;      /* what is up, by the points; zero: they do not say */
} stp_first_camera;

#endif
