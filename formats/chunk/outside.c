/* Reads and writes the grid of outside cubes as JSON runs, and looks up balls in it. */
#include "formats/chunk/outside.h"

#include "base/memory.h"

#include <cjson/cJSON.h>
#include <stdlib.h>

/* A ball with more cubes than this is not looked up: the answer is no. */
#define CUBES_LIMIT 32768.0

static size_t cube_count(const stp_outside *o)
{
    return (size_t)o->cells[0] * (size_t)o->cells[1] * (size_t)o->cells[2];
}

cJSON *stp_outside_to_json(const stp_outside *outside)
{
    cJSON *json = cJSON_CreateObject();
    const double origin[3] = {outside->origin.x, outside->origin.y, outside->origin.z};
    cJSON_AddNumberToObject(json, "points", (double)outside->point_count);
    cJSON_AddItemToObject(json, "origin", cJSON_CreateDoubleArray(origin, 3));
    cJSON_AddNumberToObject(json, "cell", outside->cell);
    cJSON_AddItemToObject(json, "cells", cJSON_CreateIntArray(outside->cells, 3));
    cJSON *runs = cJSON_AddArrayToObject(json, "outside");
    cJSON *openings = outside->opening_count ? cJSON_AddArrayToObject(json, "openings") : NULL;
    for (uint32_t i = 0; i < outside->opening_count; i++) {
        const stp_opening *o = &outside->openings[i];
        const double ball[4] = {o->centre.x, o->centre.y, o->centre.z, o->radius};
        cJSON_AddItemToArray(openings, cJSON_CreateDoubleArray(ball, 4));
    }
    uint8_t value = 1;
    for (size_t i = 0, begin = 0, count = cube_count(outside); i <= count; i++)
        if (i == count || outside->outside[i] != value) {
            cJSON_AddItemToArray(runs, cJSON_CreateNumber((double)(i - begin)));
            begin = i;
            value ^= 1;
        }
    return json;
}

/* Reads exactly `count` numbers; false if the array is anything else. */
static bool read_numbers(const cJSON *array, int count, double *out)
{
    if (!cJSON_IsArray(array) || cJSON_GetArraySize(array) != count)
        return false;
    const cJSON *item = array->child;
    for (int i = 0; i < count; i++, item = item->next) {
        if (!cJSON_IsNumber(item) || !isfinite(item->valuedouble))
            return false;
        out[i] = item->valuedouble;
    }
    return true;
}

static bool read_frame(stp_outside *o, const cJSON *closed)
{
    double origin[3], cells[3];
    const cJSON *points = cJSON_GetObjectItemCaseSensitive(closed, "points");
    const cJSON *cell = cJSON_GetObjectItemCaseSensitive(closed, "cell");
    if (!read_numbers(cJSON_GetObjectItemCaseSensitive(closed, "origin"), 3, origin) ||
        !read_numbers(cJSON_GetObjectItemCaseSensitive(closed, "cells"), 3, cells) ||
        !cJSON_IsNumber(points) || !(points->valuedouble >= 1.0) ||
        !(points->valuedouble <= 0x1p53) || !cJSON_IsNumber(cell) || !isfinite(cell->valuedouble) ||
        !(cell->valuedouble > 0.0))
        return false;
    for (int i = 0; i < 3; i++) {
        if (!(cells[i] >= 1.0 && cells[i] <= STP_OUTSIDE_CELLS_LIMIT &&
              cells[i] == floor(cells[i])))
            return false;
        o->cells[i] = (int)cells[i];
    }
    o->point_count = (uint64_t)points->valuedouble;
    o->origin = (stp_dvec3){origin[0], origin[1], origin[2]};
    o->cell = cell->valuedouble;
    return true;
}

/* Fills the cubes; false if the runs do not end with the grid. */
static bool read_runs(const stp_outside *o, const cJSON *runs)
{
    size_t at = 0, count = cube_count(o);
    uint8_t value = 1;
    if (!cJSON_IsArray(runs))
        return false;
    for (const cJSON *run = runs->child; run; run = run->next, value ^= 1) {
        if (!cJSON_IsNumber(run) || !(run->valuedouble >= 0.0) ||
            !(run->valuedouble <= (double)(count - at)))
            return false;
        for (size_t end = at + (size_t)run->valuedouble; at < end; at++)
            o->outside[at] = value;
    }
    return at == count;
}

/* False if an item is no ball, or there are too many. */
static bool read_openings(stp_outside *o, const cJSON *openings)
{
    if (!openings)
        return true;
    if (!cJSON_IsArray(openings) || (uint32_t)cJSON_GetArraySize(openings) != o->opening_count)
        return false;
    stp_opening *out = o->openings;
    for (const cJSON *item = openings->child; item; item = item->next, out++) {
        double ball[4];
        if (!read_numbers(item, 4, ball) || !(ball[3] > 0.0))
            return false;
        *out = (stp_opening){{ball[0], ball[1], ball[2]}, ball[3]};
    }
    return true;
}

static stp_status read_closed(stp_outside *o, const cJSON *closed, stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *openings = cJSON_GetObjectItemCaseSensitive(closed, "openings");
    int opening_count = cJSON_GetArraySize(openings);
    if (!read_frame(o, closed))
        return stp_error_set(err, STP_CORRUPT, "the metadata's \"closed\" has no grid in it");
    if (opening_count > STP_OPENINGS_LIMIT)
        return stp_error_set(err, STP_CORRUPT,
                             "the metadata's \"closed\" has %d openings, and %d are the most",
                             opening_count, STP_OPENINGS_LIMIT);
    o->opening_count = (uint32_t)opening_count;
    STP_TRY(stp_alloc(&o->openings, o->opening_count, sizeof *o->openings, "openings", err));
    STP_TRY(stp_alloc(&o->outside, cube_count(o), 1, "a grid", err));
    if (!read_runs(o, cJSON_GetObjectItemCaseSensitive(closed, "outside")))
        return stp_error_set(err, STP_CORRUPT,
                             "the runs of the metadata's \"closed\" do not fill its grid");
    if (!read_openings(o, openings))
        return stp_error_set(err, STP_CORRUPT,
                             "an opening of the metadata's \"closed\" is no ball of four numbers");
done:
    return status;
}

stp_status stp_outside_read(stp_outside *out, const char *metadata, size_t bytes, stp_error *err)
{
    stp_status status = STP_OK;
    stp_outside o = {0};
    cJSON *json = cJSON_ParseWithLength(metadata, bytes);
    const cJSON *closed = cJSON_GetObjectItemCaseSensitive(json, "closed");
    if (closed)
        status = read_closed(&o, closed, err);
    if (status == STP_OK) {
        *out = o;
        o = (stp_outside){0};
    }
    stp_outside_clear(&o);
    cJSON_Delete(json);
    return status;
}

void stp_outside_clear(stp_outside *outside)
{
    free(outside->openings);
    free(outside->outside);
    *outside = (stp_outside){0};
}

bool stp_outside_holds(const stp_outside *outside, stp_dvec3 centre, double radius)
{
    const stp_outside *o = outside;
    stp_dvec3 p = stp_dvec3_scale(stp_dvec3_sub(centre, o->origin), 1.0 / o->cell);
    const double at[3] = {p.x, p.y, p.z};
    double r = radius / o->cell, cubes = 1.0;
    int low[3], high[3];
    for (int i = 0; i < 3; i++) {
        if (!(at[i] + r >= 0.0 && at[i] - r <= o->cells[i]))
            return isfinite(at[i]) && isfinite(r);
        low[i] = (int)stp_max(floor(at[i] - r), 0.0);
        high[i] = (int)stp_min(floor(at[i] + r), o->cells[i] - 1.0);
        cubes *= high[i] - low[i] + 1.0;
    }
    if (cubes > CUBES_LIMIT)
        return false;
    for (int z = low[2]; z <= high[2]; z++)
        for (int y = low[1]; y <= high[1]; y++)
            for (int x = low[0]; x <= high[0]; x++)
                if (!o->outside[((size_t)z * (size_t)o->cells[1] + (size_t)y) *
                                    (size_t)o->cells[0] +
                                (size_t)x])
                    return false;
    return true;
}
