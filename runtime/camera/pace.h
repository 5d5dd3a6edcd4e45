/* Holds a frame rate: finds the threshold and the resolution at which frames take the wanted time.
 *
 * Model of a frame's time: a fixed part + sample_ms * samples drawn. Both are learned from the last
 * few frames. A higher threshold saves samples alone, so the threshold rises only while samples are
 * a fair share of the time. If that is not enough, the picture gets fewer pixels. A single frame
 * far off the ones before has another cause and does not count; a second one does. Threads: any (no
 * shared state). */
#ifndef STP_RUNTIME_CAMERA_PACE_H
#define STP_RUNTIME_CAMERA_PACE_H

#include <stdbool.h>
#include <stdint.h>

/* The share of a frame's time that drawing may take; the rest is for showing the frame. */
#define STP_PACE_SHARE 0.9
/* Fewer pixels look better than a coarser threshold. */
#define STP_PACE_THRESHOLD_MOST_PX 4.0
/* Each step divides the width and the height by the square root of 2: a quarter at least. */
#define STP_PACE_STEPS_MOST 4

/* Zero is the start; stp_pace_ask comes before the first frame. */
typedef struct stp_pace {
    double fps;          /* wanted */
    double asked_px;     /* the finest threshold while frames follow each other */
    double threshold_px; /* of the next frame, in pixels of its own picture */
    double scale;        /* of the next frame: its width over the full width, 2^(-step / 2) */
    int step;
    /* The last frames, later ones weighing more: weight, mean samples and milliseconds, sums of
     * products of deviations. */
    double weight, samples, ms, samples_samples, samples_ms;
    double sample_ms; /* time of a sample */
    double drawn;     /* samples of the last frame; after a step, as many as the next may have */
    bool skips;       /* the next frame does not count: its textures are new */
    bool strayed;     /* the last frame did not count: far off the ones before */
    int slow, quick;  /* frames that call for fewer, for more pixels */
    /* The last step to fewer pixels: where from, and the time of a frame there. 0: it has helped */
    int before_step;
    double before_ms;
    int most_step; /* further steps do not help, or did not when last tried */
} stp_pace;

/* Sets what is wanted: fps > 0, asked_px > 0. What was learned stays. */
void stp_pace_ask(stp_pace *pace, double fps, double asked_px);

/* Takes the time of the last frame, drawn at threshold_px and scale, and the number of samples that
 * it drew. Sets threshold_px and scale of the next. */
void stp_pace_follow(stp_pace *pace, double frame_ms, uint64_t samples);

/* False if neither a coarser threshold nor fewer pixels hold the rate. */
bool stp_pace_holds(const stp_pace *pace);

#endif
