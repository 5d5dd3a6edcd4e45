/* Collects frame times and reports them. */
#include "tools/draw/draw_measure.h"

#include "base/memory.h"
#include "base/sort.h"
#include "runtime/cut/model.h"
#include "tools/draw/draw_options.h"
#include "tools/file/source_options.h"

#include <cjson/cJSON.h>
#include <epoxy/gl.h>
#include <stdlib.h>

stp_status draw_measure_add(draw_measure *m, const stp_draw_stats *stats, stp_error *err)
{
    stp_status status = STP_OK;
    const double times[DRAW_TIME_COUNT] = {stats->frame_ms, stats->project_ms, stats->pull_push_ms,
                                           stats->shade_ms};
    for (int i = 0; i < DRAW_TIME_COUNT; i++) {
        STP_TRY(
            stp_grow(&m->times[i], &m->capacity[i], m->count + 1, sizeof(double), "times", err));
        m->times[i][m->count] = times[i];
    }
    m->count++;
    m->last = *stats;
    m->most_missing =
        m->most_missing > stats->chunks_missing ? m->most_missing : stats->chunks_missing;
done:
    return status;
}

void draw_measure_cut(draw_measure *m, const stp_renderer *renderer)
{
    double before = m->cut.max_error_px;
    stp_renderer_measure(renderer, &m->cut);
    if (m->cut.max_error_px < before)
        m->cut.max_error_px = before;
}

/* A quantile of sorted values; 0 if there are none. */
static double quantile(const double *values, size_t count, double q)
{
    return count > 0 ? values[(size_t)(q * (double)(count - 1) + 0.5)] : 0.0;
}

struct cJSON *draw_measure_json(draw_measure *m, const stp_renderer *renderer,
                                const stp_model *model)
{
    static const char *const names[DRAW_TIME_COUNT] = {NULL, "project_ms", "pull_push_ms",
                                                       "shade_ms"};
    char lod[16];
    cJSON *json = cJSON_CreateObject();
    cJSON *frame = cJSON_AddObjectToObject(json, "frame_ms");
    const double *times = m->times[DRAW_FRAME_MS];
    for (int i = 0; i < DRAW_TIME_COUNT && m->count > 0; i++)
        stp_sort_doubles(m->times[i], m->count);
    cJSON_AddNumberToObject(frame, "min", quantile(times, m->count, 0.0));
    cJSON_AddNumberToObject(frame, "median", quantile(times, m->count, 0.5));
    cJSON_AddNumberToObject(frame, "p99", quantile(times, m->count, 0.99));
    cJSON_AddNumberToObject(frame, "max", quantile(times, m->count, 1.0));
    for (int i = DRAW_PROJECT_MS; i < DRAW_TIME_COUNT; i++)
        cJSON_AddNumberToObject(json, names[i], quantile(m->times[i], m->count, 0.5));
    cJSON_AddNumberToObject(json, "points_drawn", (double)m->last.points_drawn);
    cJSON_AddNumberToObject(json, "points_chosen", (double)m->cut.points);
    cJSON_AddNumberToObject(json, "patches_drawn", (double)m->cut.patches);
    cJSON_AddNumberToObject(json, "patches_hidden", (double)m->last.patches_hidden);
    cJSON_AddNumberToObject(json, "blocks_hidden", m->last.blocks_hidden);
    cJSON_AddNumberToObject(json, "chunks_drawn", m->last.chunks_drawn);
    cJSON_AddNumberToObject(json, "chunks_missing", m->most_missing);
    cJSON_AddBoolToObject(json, "cut_complete", m->most_missing == 0);
    cJSON_AddNumberToObject(json, "max_error_px", m->cut.max_error_px);
    draw_options_word(DRAW_LODS, (int)m->last.lod, lod);
    cJSON_AddStringToObject(json, "lod", lod);
    cJSON_AddNumberToObject(json, "passes", m->last.passes);
    cJSON_AddNumberToObject(json, "pyramid_levels", m->last.pyramid_levels);
    cJSON_AddNumberToObject(json, "bytes_read", (double)stp_renderer_bytes_read(renderer));
    stp_memory_use memory = stp_renderer_memory(renderer);
    cJSON_AddNumberToObject(json, "gpu_bytes_used", (double)memory.gpu_used);
    cJSON_AddNumberToObject(json, "gpu_bytes_pinned", (double)stp_renderer_gpu_pinned(renderer));
    cJSON_AddNumberToObject(json, "gpu_bytes_allotted", (double)memory.gpu_allotted);
    source_options_stats(json, model->file);
    cJSON_AddStringToObject(json, "gl_renderer", (const char *)glGetString(GL_RENDERER));
    return json;
}

void draw_measure_clear(draw_measure *m)
{
    for (int i = 0; i < DRAW_TIME_COUNT; i++)
        free(m->times[i]);
    *m = (draw_measure){0};
}
