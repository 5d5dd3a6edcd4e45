/* Exports strips and triangles as edges and faces. */
#include "tools/file/export_shapes.h"

#include "base/memory.h"
#include "formats/chunk/verify/verify_joints.h"

#include <stdlib.h>

/* Number of edges or triangles per write. */
#define BATCH_COUNT 1024u

static int compare_joints(const void *a, const void *b)
{
    const export_joint *x = a, *y = b;
    return x->number < y->number ? -1 : x->number > y->number;
}

/* The index of a joint; UINT64_MAX if no strip continues here. */
static uint64_t find_joint(const export_shapes *s, const stp_sample *sample, const stp_patch *patch,
                           stp_dvec3 origin)
{
    const export_joint wanted = {.number = stp_joint_number(sample, patch, origin)};
    const export_joint *found = s->joint_count > 0 ? bsearch(&wanted, s->joints, s->joint_count,
                                                             sizeof wanted, compare_joints)
                                                   : NULL;
    return found ? (uint64_t)(found - s->joints) : UINT64_MAX;
}

/* One pass over a chunk. The first pass notes joints, the second counts the vertices that joints
 * save. */
static stp_status look_at(export_shapes *s, const stp_chunk *chunk, stp_dvec3 origin, bool first,
                          stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        const stp_sample *samples = chunk->samples[0] + chunk->level_begin[0][p];
        const unsigned count = patch->counts[0];
        if (first && patch->flags & STP_PATCH_CONTINUED) {
            STP_TRY(stp_grow(&s->joints, &s->joint_capacity, s->joint_count + 1, sizeof *s->joints,
                             "joints", err));
            s->joints[s->joint_count++] =
                (export_joint){.number = stp_joint_number(&samples[count - 1], patch, origin)};
        }
        if (!first && patch->flags & STP_PATCH_CONTINUES)
            s->repeated += find_joint(s, &samples[0], patch, origin) != UINT64_MAX;
        if (!first && patch->flags & STP_PATCH_STRIP)
            s->edge_count += count - 1;
        if (!first && patch->flags & STP_PATCH_TRIANGLES)
            s->triangle_count += count / 3;
    }
done:
    return status;
}

static stp_status look_through(export_shapes *s, stp_chunk_file *file, const bool *left_out,
                               bool first, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        STP_TRY(stp_chunk_file_entry(file, id, &entry, err));
        if (entry.child_count != 0 || left_out[id])
            continue;
        STP_TRY(stp_chunk_file_read(file, id, 0, &chunk, err));
        STP_TRY(look_at(s, chunk, entry.origin, first, err));
        stp_chunk_destroy(&chunk);
    }
done:
    stp_chunk_destroy(&chunk);
    return status;
}

stp_status export_shapes_find(export_shapes *out, stp_chunk_file *file, const bool *left_out,
                              stp_error *err)
{
    stp_status status = STP_OK;
    if (!(stp_chunk_file_get_info(file)->attributes & (STP_HAS_LINES | STP_HAS_TRIANGLES)))
        return STP_OK;
    STP_TRY(look_through(out, file, left_out, true, err));
    if (out->joint_count > 0)
        qsort(out->joints, out->joint_count, sizeof *out->joints, compare_joints);
    STP_TRY(look_through(out, file, left_out, false, err));
done:
    return status;
}

stp_status export_shapes_patch(export_shapes *shapes, const stp_patch *patch,
                               const stp_sample *samples, stp_dvec3 origin, unsigned *skipped,
                               stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned count = patch->counts[0];
    export_strip strip = {.first = shapes->vertex, .joint = UINT64_MAX};
    if (patch->flags & STP_PATCH_CONTINUES)
        strip.joint = find_joint(shapes, &samples[0], patch, origin);
    *skipped = strip.joint != UINT64_MAX;
    strip.count = count - *skipped;
    shapes->vertex += strip.count;
    if (patch->flags & STP_PATCH_STRIP) {
        STP_TRY(stp_grow(&shapes->strips, &shapes->strip_capacity, shapes->strip_count + 1,
                         sizeof *shapes->strips, "strips", err));
        shapes->strips[shapes->strip_count++] = strip;
    }
    if (patch->flags & STP_PATCH_CONTINUED)
        shapes->joints[find_joint(shapes, &samples[count - 1], patch, origin)].vertex =
            shapes->vertex - 1;
    if (patch->flags & STP_PATCH_TRIANGLES) {
        size_t at = 2 * shapes->triangle_patch_count++;
        STP_TRY(stp_grow(&shapes->triangles, &shapes->triangle_capacity, at + 2,
                         sizeof *shapes->triangles, "triangles", err));
        shapes->triangles[at] = strip.first;
        shapes->triangles[at + 1] = count;
    }
done:
    return status;
}

static stp_status write_triangles(const export_shapes *s, stp_ply_writer *writer, stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t p = 0; p < s->triangle_patch_count; p++) {
        uint32_t triangles[STP_PATCH_SAMPLES / 3][3];
        const uint64_t first = s->triangles[2 * p], corners = s->triangles[2 * p + 1];
        for (unsigned i = 0; i < corners; i++)
            triangles[i / 3][i % 3] = (uint32_t)(first + i);
        STP_TRY(
            stp_ply_writer_triangles(writer, (const uint32_t(*)[3])triangles, corners / 3, err));
    }
done:
    return status;
}

stp_status export_shapes_write(const export_shapes *shapes, stp_ply_writer *writer, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t batch[BATCH_COUNT][2];
    size_t count = 0;
    STP_TRY(write_triangles(shapes, writer, err));
    for (size_t i = 0; i < shapes->strip_count; i++) {
        const export_strip *strip = &shapes->strips[i];
        const bool joined = strip->joint != UINT64_MAX;
        uint64_t before = joined ? shapes->joints[strip->joint].vertex : strip->first;
        for (unsigned k = joined ? 0 : 1; k < strip->count; k++) {
            batch[count][0] = (uint32_t)before;
            batch[count++][1] = (uint32_t)(strip->first + k);
            before = strip->first + k;
            if (count == BATCH_COUNT) {
                STP_TRY(stp_ply_writer_edges(writer, (const uint32_t(*)[2])batch, count, err));
                count = 0;
            }
        }
    }
    STP_TRY(stp_ply_writer_edges(writer, (const uint32_t(*)[2])batch, count, err));
done:
    return status;
}

void export_shapes_clear(export_shapes *shapes)
{
    free(shapes->joints);
    free(shapes->strips);
    free(shapes->triangles);
    *shapes = (export_shapes){0};
}
