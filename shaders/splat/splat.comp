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

void stp_splat_visit(stp_run r, uint i, uint splat)
{
    ivec2 pixel;
    float z;
    uint name = r.name + i;
    uvec4 texel = stp_sample_words(stp_packing_fetch(stp_name_patch(name)), r.number + i);
    if (!stp_place(texel, r.lattice.xyz, r.lattice.w, r.openings, pixel, z))
        return;
    stp_pixel p = stp_disc_pixel(stp_disc_alone(stp_disc_decode(texel, r.lattice.xyz, r.lattice.w)), name, name,
                                 vec2(0.0));
    float radius_px = max(p.radius * stp_pixels_per_unit(p.z_min), STP_ELLIPSE_FLOOR);
    stp_splat disc = stp_splat(vec4(p.d, 1.0 / radius_px, p.z_min), p.normal, p.z_max - p.z_min);
    if (p.radius <= 0.0) // covers only its own pixel
        disc.place.xyz = vec3(vec2(pixel) + 0.5, 1e6);
    if (listing)
        looks[splat] = uvec2(stp_splat_colour_pack(p.colour), name);
    stp_splat_list(disc, splat);
}

void main()
{
    stp_frame_hold();
    uint end = stp_end_run();
    for (uint run = stp_first_run(); run < end; run += STP_RUN_STEP) {
        stp_run r = stp_run_fetch(run);
        for (uint i = 0u; i < stp_run_count(r); i++)
            stp_splat_visit(r, i, first_splat + stp_run_place(run, i));
    }
}
