/* Adds points to a model in place: `stipple prep --append`.
 *
 *     new points ► which leaves they touch ► these leaves' points, and some around them
 *                ► spacings, normals, signs ► new leaves ► the chunks above ► behind the file's end
 *
 * Old points keep position, normal, colour and flags bit for bit. Only the radius of an old point
 * may shrink, if new points lie between it and its neighbours. Chunks that nothing touches keep
 * their payloads. If chunks beside a kept chunk changed so that its errors do not hold any more,
 * they are raised. docs/prep.md ("Adding points") says what a user should know.
 *
 * Memory: as in prep, for the new points and those of the touched leaves. A failure or a kill
 * leaves the model as it was. Threads: those of the pool; the same bytes for any number. */
#ifndef STP_PREPROCESS_APPEND_APPEND_H
#define STP_PREPROCESS_APPEND_APPEND_H

#include "preprocess/prep.h"

/* What became of the model. */
typedef struct stp_append_result {
    uint64_t points_before, points_after;
    uint32_t leaf_count, touched_leaves; /* before */
    uint32_t kept_chunks, new_chunks;    /* of all chunks: payloads that stay, payloads written */
    uint32_t raised_chunks;              /* of the new ones: only errors changed */
    uint64_t unused_bytes;               /* in the file, as `convert` would save */
    bool closed_lost;                    /* it was closed, which is not known any more */
} stp_append_result;

/* Adds the source's points to the model at `path`. params: as for stp_prep_run; lambda, codec,
 * format, force, outliers and layers are the model's or not used. Errors: those of stp_prep_run and
 * of opening a chunk file; UNSUPPORTED (the model is of version 1 or newer than this program,
 * has lines, triangles or attributes, or was repaired or resampled; the source has lines or
 * triangles); IO (the model cannot be
 * written, or another run is changing it); LIMIT (a point is too far away). */
stp_status stp_append_run(const char *path, const stp_prep_source *source,
                          const stp_prep_params *params, stp_pool *pool,
                          const stp_progress *progress, stp_prep_stats *stats,
                          stp_append_result *result, stp_error *err);

#endif
