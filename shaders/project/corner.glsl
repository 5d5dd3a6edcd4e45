// Sets a vertex of a strip or of triangles as a corner of a rasterised shape. Needs layout.glsl,
// patch.glsl, project.glsl.

flat out uint id; // the sample, and the shape that begins with it
#if STP_PLANES
out vec3 place; // relative to the eye; shape.frag asks the planes, since clip distances are few
#endif

#if STP_CLIP
out float gl_ClipDistance[6];
#endif

// from_eye: the corner's position relative to the eye, world axes.
void stp_corner_set(vec3 from_eye, uint name)
{
    gl_Position = stp_clip_position(stp_to_eye(from_eye));
#if STP_CLIP
    vec3 low = from_eye - clip_min.xyz, high = clip_max.xyz - from_eye;
    gl_ClipDistance[0] = low.x;
    gl_ClipDistance[1] = low.y;
    gl_ClipDistance[2] = low.z;
    gl_ClipDistance[3] = high.x;
    gl_ClipDistance[4] = high.y;
    gl_ClipDistance[5] = high.z;
#endif
#if STP_PLANES
    place = from_eye;
#endif
    id = name;
}
