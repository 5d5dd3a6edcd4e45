/* How a chunk file becomes LAS or LAZ. */
#include "tools/file/export_las.h"

#include "base/file.h"
#include "base/memory.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>

bool export_las_is_packed(const char *path)
{
    return stp_path_ends_in(path, ".laz");
}

bool export_las_is_named(const char *path)
{
    return stp_path_ends_in(path, ".las") || export_las_is_packed(path);
}

/* Whether every point of the box has integers on the lattice. */
static bool covers(const stp_las_writer_params *p, const stp_dbox *box)
{
    const double low[3] = {box->min.x, box->min.y, box->min.z};
    const double high[3] = {box->max.x, box->max.y, box->max.z};
    const double offset[3] = {p->offset.x, p->offset.y, p->offset.z};
    for (int i = 0; i < 3; i++)
        if (!(p->steps[i] > 0.0) ||
            !(fmax(fabs(low[i] - offset[i]), fabs(high[i] - offset[i])) / p->steps[i] < 2e9))
            return false;
    return true;
}

static bool read_lattice(stp_las_writer_params *out, const char *text)
{
    return text && sscanf(text, "%lf %lf %lf %lf %lf %lf", &out->steps[0], &out->steps[1],
                          &out->steps[2], &out->offset.x, &out->offset.y, &out->offset.z) == 6;
}

/* The finest lattice of a power of ten around the middle of the box. */
static void finest_lattice(stp_las_writer_params *out, const stp_dbox *box)
{
    const stp_dvec3 middle = stp_dbox_middle(box);
    out->offset = (stp_dvec3){floor(middle.x), floor(middle.y), floor(middle.z)};
    const double side = stp_dbox_side(box);
    out->step = stp_las_finest_step(side > 0.0 ? side + 2.0 : 2.0);
    for (int i = 0; i < 3; i++)
        out->steps[i] = out->step;
}

stp_status export_las_params(stp_las_writer_params *out, char **wkt, const stp_chunk_file *file,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    if (info->attributes & (STP_HAS_LINES | STP_HAS_TRIANGLES))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s has lines or triangles, which LAS cannot hold: export PLY",
                             stp_chunk_file_path(file));
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *source = NULL;
    bool found = false;
    *wkt = NULL;
    cJSON_ArrayForEach(source, cJSON_GetObjectItemCaseSensitive(metadata, "sources"))
    {
        const char *text =
            cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(source, "lattice"));
        const char *system = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(source, "wkt"));
        found = found || (read_lattice(out, text) && covers(out, &info->box));
        if (system && !*wkt)
            STP_TRY(stp_text_copy(wkt, system, "a coordinate system", err));
    }
    if (!found)
        finest_lattice(out, &info->box);
    out->step = out->steps[0];
    out->wkt = *wkt;
done:
    cJSON_Delete(metadata);
    return status;
}
