/* Gets ready to draw: compiles the programs that a picture's parameters ask for, and makes room for
 * its pixels. */
#include "runtime/frame_ready.h"

#include "base/clock.h"
#include "runtime/colour_range.h"
#include "runtime/draw/filter.h"
#include "runtime/frame_pass.h"
#include "runtime/renderer_parts.h"

/* Invocations of the geometry shader for each patch. */
#define GEOMETRY_INVOCATIONS 1

stp_status stp_frame_compile(stp_renderer *r, const stp_variant *variant, stp_lod lod,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_project project = {0};
    stp_reconstruct_programs reconstruct = {0};
    STP_TRY(stp_reconstruct_create(&reconstruct, r->shader_folder, variant, err));
    STP_TRY(stp_frame_prepare_road(&project, &reconstruct, r->shader_folder, variant, lod, err));
    stp_project_destroy(&r->project);
    stp_reconstruct_destroy(&r->reconstruct);
    r->project = project;
    r->reconstruct = reconstruct;
    r->variant = *variant;
    project = (stp_project){0};
    reconstruct = (stp_reconstruct_programs){0};
done:
    stp_project_destroy(&project);
    stp_reconstruct_destroy(&reconstruct);
    return status;
}

static int template_px(stp_reconstruct reconstruct)
{
    switch (reconstruct) {
    case STP_RECONSTRUCT_TEMPLATE3:
        return 3;
    case STP_RECONSTRUCT_TEMPLATE5:
        return 5;
    case STP_RECONSTRUCT_TEMPLATE7:
        return 7;
    case STP_RECONSTRUCT_GAUSS:
    case STP_RECONSTRUCT_BOX:
    case STP_RECONSTRUCT_SPLAT:
    case STP_RECONSTRUCT_POINTS:
        break;
    }
    return 0;
}

static stp_variant variant_of(const stp_renderer *r, const stp_view *view,
                              const stp_draw_params *params)
{
    return (stp_variant){
        .orthographic = view->orthographic,
        .box = params->reconstruct == STP_RECONSTRUCT_BOX,
        .template_px = template_px(params->reconstruct),
        .splat = params->reconstruct == STP_RECONSTRUCT_SPLAT,
        .lines = (stp_scene_shapes(&r->scene) & STP_PATCH_STRIP) != 0,
        .triangles = (stp_scene_shapes(&r->scene) & STP_PATCH_TRIANGLES) != 0,
        .maps = params->maps_as == STP_MAPS_SPLATS || params->maps_as == STP_MAPS_BLEND ||
                        params->maps_as == STP_MAPS_PLAIN
                    ? (int)params->maps_as
                    : 0,
        .openings = stp_scene_has_openings(&r->scene),
        .clip = params->clip.enabled,
        .planes = (int)params->plane_count,
        .classes = stp_filter_hides_classes(params),
        .chosen = stp_scene_is_chosen(&r->scene),
        .grid = stp_scene_holes_grow(&r->scene) ? 2 : stp_scene_is_grid(&r->scene),
        .overlay = stp_filter_has_overlay(params),
        .edges = params->smooth_edges && params->reconstruct != STP_RECONSTRUCT_POINTS,
        .edl = params->edl > 0.0,
        .contours = params->contour_step > 0.0,
        .exaggerated = params->exaggerate > 0.0 && params->exaggerate != 1.0,
        .colour = (int)params->colour,
        .palette = (int)stp_colour_palette(params),
        .shade = (int)params->shade,
        .geometry_invocations = GEOMETRY_INVOCATIONS,
        .fade = params->fade > 0.0,
    };
}

/* Makes room for the pixels that the programs write. */
static stp_status resize_pyramid(stp_renderer *r, const stp_drawing *d, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_pyramid_resize(&r->pyramid, d->view->width, d->view->height, err));
    if (d->params->keep_pixels)
        STP_TRY(stp_pyramid_keep_level_0(&r->pyramid, err));
    if (r->variant.edges)
        STP_TRY(stp_pyramid_keep_rough(&r->pyramid, err));
    if (r->variant.contours)
        STP_TRY(stp_pyramid_keep_steps(&r->pyramid, err));
    if (r->variant.splat)
        STP_TRY(stp_pyramid_keep_sums(&r->pyramid, err));
done:
    return status;
}

stp_status stp_frame_ready(stp_renderer *r, stp_drawing *d, stp_error *err)
{
    stp_status status = STP_OK;
    const double begun = stp_clock_seconds();
    const stp_variant variant = variant_of(r, d->view, d->params);
    if (d->ready)
        return STP_OK;
    d->compiled = r->reconstruct.resolve == 0 || !stp_variant_equal(&variant, &r->variant);
    STP_TRY(d->compiled ? stp_frame_compile(r, &variant, d->params->lod, err)
                        : stp_frame_prepare(r, d->params->lod, err));
    STP_TRY(resize_pyramid(r, d, err));
    stp_renderer_bind_frame(r);
    d->ready = true;
    d->ready_ms += 1e3 * (stp_clock_seconds() - begun);
done:
    return status;
}

void stp_renderer_bind_frame(const stp_renderer *r)
{
    const stp_object_texture *texture = stp_block_cache_texture(r->cache);
    stp_frame_upload(r);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, r->frame_buffer);
    glBindTextures(STP_UNIT_OBJECT_TEXTURE, STP_OBJECT_TEXTURES, texture->textures);
    glBindTextureUnit(STP_UNIT_CODES, texture->textures[STP_OBJECT_TEXTURES]);
}
