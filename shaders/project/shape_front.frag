// Splatting, visibility pass: names the segment or triangle of a pixel, by where its interval ends.
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

flat in uint id;
#if STP_PLANES
in vec3 place; // asked of flat pieces and triangles; segments are asked where their discs are
#endif

layout(location = 0) out uint nearest;

// How much farther than its centre a segment's disc is seen here; false where it is not.
bool stp_segment_seen(stp_disc disc, stp_pixel p, out float farther)
{
    vec3 s = stp_ellipse_place(p, stp_ray(gl_FragCoord.xy), -p.d);
    bool covers = p.radius > 0.0 ? dot(s, s) <= 1.0 : dot(p.d, p.d) <= STP_ELLIPSE_FLOOR_LINE * STP_ELLIPSE_FLOOR_LINE;
    farther = stp_ellipse_farther(p, s);
    vec3 from_eye = stp_from_eye(disc.position);
    return covers && !stp_clipped(from_eye) && p.z_min + farther > viewport.w;
}

void main()
{
    uint begin = stp_name_id(id);
    stp_chunk chunk = stp_chunk_fetch(stp_patch_slot(stp_name_patch(begin)));
    stp_disc disc = stp_disc_of(id, begin, chunk, gl_FragCoord.xy);
    stp_pixel p = stp_disc_pixel(disc, id, begin, gl_FragCoord.xy);
    float farther = 0.0;
#if STP_PLANES
    if ((id & STP_NAME_RIBBON) != STP_NAME_SEGMENT && stp_behind_planes(place))
        discard;
#endif
    if ((id & STP_NAME_RIBBON) == STP_NAME_SEGMENT && !stp_segment_seen(disc, p, farther))
        discard;
    nearest = id;
    gl_FragDepth = stp_depth_encode(p.z_max + farther);
}
