// Splatting, first step: lists the splats of samples.
#define STP_FRAME_HELD
#include "layout.glsl"
#include "patch.glsl"
#include "project.glsl"
#include "choose.glsl"
#include "palette.glsl"
#include "pixel.glsl"
#include "ellipse.glsl"
#include "square.glsl"
#include "shape.glsl"
#include "sample_pixel.glsl"
#include "runs.glsl"
#include "listed.glsl"
#include "splat_bins.glsl"
#include "splat_bound.glsl"
#include "splat_list.glsl"

layout(location = 5) uniform uint first_splat; // number of the splat at place 0

void stp_splat_visit(stp_projected s, uint splat)
{
    ivec2 pixel;
    float z;
    uvec4 texel = stp_sample_fetch(s.index, stp_chunk_fetch(stp_patch_slot(stp_name_patch(s.name))).colours);
    if (!stp_place(texel, s.lattice.xyz, s.lattice.w, s.openings, pixel, z))
        return;
    stp_pixel p = stp_disc_pixel(stp_disc_alone(stp_disc_decode(texel, s.lattice.xyz, s.lattice.w)), s.name, s.name,
                                 vec2(0.0));
    float radius_px = max(p.radius * stp_pixels_per_unit(p.z_min), STP_ELLIPSE_FLOOR);
    stp_splat disc = stp_splat(vec4(p.d, 1.0 / radius_px, p.z_min), p.normal, p.z_max - p.z_min);
    if (p.radius <= 0.0) // covers only its own pixel
        disc.place.xyz = vec3(vec2(pixel) + 0.5, 1e6);
    if (listing)
        looks[splat] = uvec2(stp_splat_colour_pack(p.colour), s.name);
    stp_splat_list(disc, splat);
}

void main()
{
    stp_frame_hold();
    uint end = stp_end_place();
    for (uint place = stp_first_place(); place < end; place += STP_PLACE_STEP) {
        stp_projected s;
        if (stp_find(place, s))
            stp_splat_visit(s, first_splat + place);
    }
}
