/* Finds and saves a profile on a thread of its own. */
#include "tools/view/view_profile.h"

#include "base/memory.h"
#include "formats/chunk/byte_source.h"
#include "runtime/window/window.h"
#include "tools/profile/profile_write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool is_cancelled(void *context)
{
    view_profile *p = context;
    pthread_mutex_lock(&p->lock);
    const bool cancelled = p->cancelled;
    pthread_mutex_unlock(&p->lock);
    return cancelled;
}

static int compare(const void *a, const void *b)
{
    const profile_point *p = a, *q = b;
    return (p->distance > q->distance) - (p->distance < q->distance);
}

/* Appends the points of another file. */
static stp_status join(profile *all, const profile *more, stp_error *err)
{
    stp_status status = stp_grow(&all->points, &all->capacity, all->count + more->count + 1,
                                 sizeof *all->points, "points of the profile", err);
    if (status != STP_OK)
        return status;
    if (more->count > 0)
        memcpy(all->points + all->count, more->points, more->count * sizeof *more->points);
    all->count += more->count;
    all->width = fmax(all->width, more->width);
    all->length = more->length;
    all->coloured |= more->coloured;
    return STP_OK;
}

static stp_status find_all(view_profile *p, profile *out, stp_error *err)
{
    const stp_progress progress = {.context = p, .cancelled = is_cancelled};
    stp_status status = STP_OK;
    profile all = {0}, one = {0};
    for (size_t i = 0; i < p->file_count; i++) {
        status = profile_find(&one, p->files[i], &p->line, &progress, err);
        if (status == STP_EMPTY && (i + 1 < p->file_count || all.count > 0))
            continue; /* another model may have points there */
        if (status != STP_OK)
            goto done;
        STP_TRY(join(&all, &one, err));
        profile_clear(&one);
    }
    status = STP_OK;
    if (p->file_count > 1 && all.count > 0)
        qsort(all.points, all.count, sizeof *all.points, compare);
    *out = all;
    all = (profile){0};
done:
    profile_clear(&one);
    profile_clear(&all);
    return status;
}

/* Puts the points into the cells of the chart; the first one of a cell gives it its colour. */
static stp_status fill_cells(view_profile *p, stp_error *err)
{
    static const uint8_t ink[3] = {110, 180, 240}; /* of points without colours */
    bool *taken = NULL;
    stp_status status = STP_OK;
    STP_TRY(
        stp_alloc(&taken, VIEW_PROFILE_COLUMNS * VIEW_PROFILE_ROWS, sizeof *taken, "a chart", err));
    p->low = INFINITY;
    p->high = -INFINITY;
    for (size_t i = 0; i < p->found.count; i++) {
        p->low = fmin(p->low, p->found.points[i].position.z);
        p->high = fmax(p->high, p->found.points[i].position.z);
    }
    const double rise = fmax(p->high - p->low, 1e-300);
    p->cell_count = 0;
    for (size_t i = 0; i < p->found.count && p->cell_count < VIEW_PROFILE_CELLS; i++) {
        const profile_point *q = &p->found.points[i];
        const int column = (int)((VIEW_PROFILE_COLUMNS - 1) * q->distance / p->found.length);
        const int row = (int)((VIEW_PROFILE_ROWS - 1) * (q->position.z - p->low) / rise);
        if (taken[row * VIEW_PROFILE_COLUMNS + column])
            continue;
        taken[row * VIEW_PROFILE_COLUMNS + column] = true;
        view_profile_cell *cell = &p->cells[p->cell_count++];
        *cell = (view_profile_cell){(uint16_t)column, (uint16_t)row, {0}};
        memcpy(cell->rgb, p->found.coloured ? q->rgb : ink, sizeof ink);
    }
done:
    free(taken);
    return status;
}

static stp_status write_file(const view_profile *p, stp_error *err)
{
    stp_status status = STP_OK;
    stp_output *output = NULL;
    STP_TRY(stp_output_create(&output, p->path, false, err));
    STP_TRY(p->chart ? profile_write_svg(&p->found, output, err)
                     : profile_write_csv(&p->found, output, err));
    STP_TRY(stp_output_commit(&output, err));
done:
    stp_output_destroy(&output);
    return status;
}

static void *work(void *context)
{
    view_profile *p = context;
    if (p->state == VIEW_PROFILE_SAVING) {
        p->status = write_file(p, &p->error);
    } else {
        p->status = find_all(p, &p->found, &p->error);
        if (p->status == STP_OK)
            p->status = fill_cells(p, &p->error);
    }
    pthread_mutex_lock(&p->lock);
    p->done = true;
    pthread_mutex_unlock(&p->lock);
    stp_window_wake();
    return NULL;
}

static bool is_running(const view_profile *p)
{
    return p->state == VIEW_PROFILE_FINDING || p->state == VIEW_PROFILE_SAVING;
}

static stp_status start(view_profile *p, view_profile_state state, stp_error *err)
{
    const view_profile_state before = p->state;
    p->state = state;
    p->done = p->cancelled = false;
    p->error = (stp_error){0};
    pthread_mutex_init(&p->lock, NULL);
    if (pthread_create(&p->thread, NULL, work, p) == 0)
        return STP_OK;
    pthread_mutex_destroy(&p->lock);
    p->state = before;
    return stp_error_set(err, STP_LIMIT, "no thread for the profile");
}

static stp_status refuse(stp_error *err)
{
    return stp_error_set(err, STP_LIMIT, "a profile is being made: wait until it is there");
}

stp_status view_profile_begin(view_profile *p, stp_chunk_file *const *files, size_t count,
                              const profile_line *line, stp_error *err)
{
    if (is_running(p) || count > VIEW_PROFILE_FILES)
        return refuse(err);
    view_profile_forget(p, NULL);
    p->line = *line;
    p->file_count = count;
    memcpy(p->files, files, count * sizeof *files);
    return start(p, VIEW_PROFILE_FINDING, err);
}

stp_status view_profile_save(view_profile *p, const char *path, bool chart, stp_error *err)
{
    if (p->state != VIEW_PROFILE_READY)
        return refuse(err);
    strncpy(p->path, path, sizeof p->path - 1);
    p->chart = chart;
    return start(p, VIEW_PROFILE_SAVING, err);
}

/* Joins the thread of a job. */
static void end(view_profile *p)
{
    pthread_join(p->thread, NULL);
    pthread_mutex_destroy(&p->lock);
    const bool failed = p->state == VIEW_PROFILE_FINDING && p->status != STP_OK;
    p->state = failed ? VIEW_PROFILE_NONE : VIEW_PROFILE_READY;
}

bool view_profile_poll(view_profile *p, stp_status *status, stp_error *err)
{
    if (!is_running(p))
        return false;
    pthread_mutex_lock(&p->lock);
    const bool done = p->done;
    pthread_mutex_unlock(&p->lock);
    if (!done)
        return false;
    end(p);
    *status = p->status;
    *err = p->error;
    return true;
}

void view_profile_forget(view_profile *p, const stp_chunk_file *file)
{
    bool reads = file == NULL;
    for (size_t i = 0; i < p->file_count; i++)
        reads |= p->files[i] == file;
    if (!reads)
        return;
    if (is_running(p)) {
        pthread_mutex_lock(&p->lock);
        p->cancelled = true;
        pthread_mutex_unlock(&p->lock);
        for (size_t i = 0; i < p->file_count; i++) /* a server may keep a read waiting */
            if (file == NULL || p->files[i] == file)
                stp_byte_source_cancel(stp_chunk_file_source(p->files[i]));
        end(p);
    }
    profile_clear(&p->found);
    p->state = VIEW_PROFILE_NONE;
    p->cell_count = p->file_count = 0;
}
