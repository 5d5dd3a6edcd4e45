// The height of a pixel's surface along the scan's z ("Heights" in README.md). Needs project.glsl and
// pixel.glsl.

// A surface that is turned away more (cosine) counts as facing the eye.
#define STP_HEIGHT_GRAZING 0.05

// height: relative to the eye. rise: to the next pixel at the right, and to the next above.
struct stp_height {
    float height;
    vec2 rise;
};

// Where the ray through window coordinates meets the plane through a position of eye space.
vec3 stp_height_meet(vec2 window, vec3 position, vec3 n)
{
    vec2 off = (window - centre.xy) / viewport.z;
#if STP_ORTHOGRAPHIC
    return vec3(off, position.z + dot(n.xy, position.xy - off) / n.z);
#else
    vec3 ray = vec3(off, -1.0);
    return ray * (dot(n, position) / dot(n, ray));
#endif
}

// n: the normal that the pixel is lit with. window: the pixel's centre.
stp_height stp_height_of(stp_pixel p, vec3 n, vec2 window)
{
    vec3 up = vec3(axis_right.z, axis_up.z, axis_back.z); // the scan's z in eye space
#if STP_EXAGGERATED
    up *= centre.w;
#endif
    vec3 ray = stp_ray(window);
    n = abs(dot(n, ray)) > STP_HEIGHT_GRAZING ? n : -ray;
    vec2 seen = STP_TEMPLATE != 0 ? window : window + p.d; // templates have depths along the pixel's ray
    vec3 position = stp_window_place(seen, p.middle);
    float height = dot(up, stp_height_meet(window, position, n));
    return stp_height(height, vec2(dot(up, stp_height_meet(window + vec2(1.0, 0.0), position, n)),
                                   dot(up, stp_height_meet(window + vec2(0.0, 1.0), position, n))) - height);
}
