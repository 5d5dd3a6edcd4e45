/* Describes model, cameras and options as short strings. */
#include "tools/draw/fly_job.h"

#include "tools/cli/cli_value.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

#define TEXT_BYTES 512

/* True for options that are not part of the job: budgets change no pixel, and the resulting cameras
 * are recorded instead of camera options. */
static bool is_passed_over(const cli_option *option)
{
    static const char *const names[] = {
        "--gpu-memory", "--cpu-memory", "--cache",        "--cache-size", "--no-cache",
        "--size",       "--camera",     "--eye",          "--look",       "--up",
        "--fovy",       "--view",       "--allow-damage", "--occlusion"};
    bool found = option->help == NULL; /* another spelling */
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        found |= strcmp(option->name, names[i]) == 0;
    return found;
}

static void value_text(const cli_option *option, char out[TEXT_BYTES])
{
    const double *v = option->target;
    const int *n = option->target;
    const char *text = "";
    size_t length = 0;
    switch (option->kind) {
    case CLI_FLAG:
        snprintf(out, TEXT_BYTES, "%s", *(const bool *)option->target ? "yes" : "no");
        break;
    case CLI_STRING:
    case CLI_OPTIONS:
        text = *(const char *const *)option->target;
        snprintf(out, TEXT_BYTES, "%s", text != NULL ? text : "");
        break;
    case CLI_CHOICE:
        (void)cli_choice_at(option->argument, *n, &text, &length);
        snprintf(out, TEXT_BYTES, "%.*s", (int)length, text);
        break;
    case CLI_UINT:
    case CLI_BYTES:
        snprintf(out, TEXT_BYTES, "%" PRIu64, *(const uint64_t *)option->target);
        break;
    case CLI_NUMBER:
    case CLI_AMOUNT:
    case CLI_SECONDS:
        snprintf(out, TEXT_BYTES, "%.17g", v[0]);
        break;
    case CLI_VEC3:
        snprintf(out, TEXT_BYTES, "%.17g,%.17g,%.17g", v[0], v[1], v[2]);
        break;
    case CLI_EXTENT:
        snprintf(out, TEXT_BYTES, "%dx%d", n[0], n[1]);
        break;
    }
}

/* A hash of the model's directory, which has the hash of every byte that is drawn. */
static uint64_t model_hash(const stp_model *model)
{
    uint64_t hash = model->info->file_bytes;
    for (uint32_t id = 0; id < model->info->chunk_count; id++) {
        const stp_chunk_entry *e = &model->entries[id];
        hash = XXH3_64bits_withSeed(e->segment_hash, sizeof e->segment_hash, hash);
    }
    return hash;
}

static uint64_t cameras_hash(const fly_job_params *params)
{
    uint64_t hash = 0;
    for (uint64_t i = 0; i < params->frame_count; i++) {
        stp_camera c = stp_path_frame(params->path, params->rate, params->frame_count, i);
        const double values[] = {c.eye.x, c.eye.y, c.eye.z, c.look.x,   c.look.y, c.look.z,
                                 c.up.x,  c.up.y,  c.up.z,  c.fovy_deg, c.height};
        hash = XXH3_64bits_withSeed(values, sizeof values, hash);
    }
    return hash;
}

struct cJSON *fly_job_create(const fly_job_params *params)
{
    char text[TEXT_BYTES];
    cJSON *job = cJSON_CreateObject();
    cJSON_AddStringToObject(job, "program", "stipple " STIPPLE_VERSION);
    cJSON_AddStringToObject(job, "gl_renderer", params->gl_renderer);
    snprintf(text, sizeof text, "%016" PRIx64, model_hash(params->model));
    cJSON_AddStringToObject(job, "model", text);
    snprintf(text, sizeof text, "%" PRIu64, params->frame_count);
    cJSON_AddStringToObject(job, "frames", text);
    snprintf(text, sizeof text, "%016" PRIx64, cameras_hash(params));
    cJSON_AddStringToObject(job, "cameras", text);
    snprintf(text, sizeof text, "%dx%d", params->size[0], params->size[1]);
    cJSON_AddStringToObject(job, "--size", text);
    for (size_t i = 0; i < params->option_count; i++) {
        if (is_passed_over(&params->options[i]))
            continue;
        value_text(&params->options[i], text);
        cJSON_AddStringToObject(job, params->options[i].name, text);
    }
    return job;
}
