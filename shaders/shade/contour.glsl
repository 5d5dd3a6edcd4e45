// What the pass that draws contours knows of a pixel ("Contours" in README.md). Needs height.glsl.

#if STP_CONTOURS
layout(rgba32f, binding = 3) writeonly uniform image2D picture_steps;

// The number of steps from the base to the surface, how many steps the surface rises to the next
// pixel at the right and above, and 1; zeros where nothing is. n: the normal that the pixel is lit
// with.
vec4 stp_contour_steps(stp_pixel p, vec3 n, vec2 window)
{
    stp_height h = stp_height_of(p, n, window);
    vec4 steps = vec4((h.height + terms.w) / terms.z, h.rise / terms.z, 1.0);
    return p.tag != 0 ? steps : vec4(0.0);
}
#endif
