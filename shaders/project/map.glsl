// Splats of elevation maps ("Maps as splats" in README.md). Needs layout.glsl, patch.glsl, project.glsl,
// square.glsl, shape.glsl.

// Part of a sample's radius that its splat has, and the least radius of a splat in pixels. Splats that show the
// surface between samples need not overlap: each is seen up to so many columns and rows from its sample.
#if STP_MAPS == STP_MAPS_SPLATS
#define STP_MAP_RADIUS_PART 0.6
#else
#define STP_MAP_RADIUS_PART 0.85
#endif
#define STP_MAP_FLOOR 0.75
#define STP_MAP_REACH 0.75

// The triangle that lies by so many columns and rows from a sample, at most one: its cell's column and row,
// 0 or 1, as bits 0 and 1; bit 2: the second triangle of the cell.
int stp_map_triangle(vec2 way)
{
    ivec2 cell = ivec2(greaterThanEqual(way, vec2(0.0)));
    vec2 within = way + 1.0 - vec2(cell);
    return cell.x | cell.y << 1 | int(within.x + within.y > 1.0) << 2;
}

// A splat seen at a window position, as a disc. With STP_MAPS_SPLATS: where the ray meets the plane through the
// three samples around that place, with their means; the splat's own disc if one of them is missing. Only at a
// map's border may the disc grow.
stp_disc stp_map_disc(uint name, vec2 window)
{
    uint listed = (name & STP_NAME_SAMPLE) >> STP_NAME_SQUARE_SHIFT;
    ivec2 at = stp_square_at(name >> STP_NAME_PLACE_SHIFT & 63u);
    bool border = (name & STP_SQUARE_BORDER) != 0u;
    stp_square_sample own = stp_square_sample_at(listed, at);
    stp_disc disc = stp_disc_decode(own.texel, own.lattice.xyz, own.lattice.w);
    vec3 place = stp_disc_meet(disc, window), from = place - disc.position;
    disc.position = place;
#if STP_MAPS == STP_MAPS_SPLATS
    int triangle = stp_map_triangle(from * stp_square_grid_fetch(listed)), second = triangle >> 2;
    ivec2 first = at + ivec2(triangle & 1, triangle >> 1 & 1) - 1;
    stp_square_cell cell;
    cell.samples[0] = stp_square_sample_at(listed, first + second);
    cell.samples[1] = stp_square_sample_at(listed, first + ivec2(1 - second, second));
    cell.samples[2] = stp_square_sample_at(listed, first + ivec2(second, 1 - second));
    cell.samples[3] = cell.samples[0]; // counts nothing
    if (!cell.samples[0].there || !cell.samples[1].there || !cell.samples[2].there)
        return disc;
    vec3 a = stp_to_eye(cell.samples[0].place), b = stp_to_eye(cell.samples[1].place);
    vec3 c = stp_to_eye(cell.samples[2].place);
    vec2 parts = stp_triangle_hold(stp_triangle_meet(a, b, c, window));
    vec3 weights = vec3(1.0 - parts.x - parts.y, parts);
    int nearest = weights.x >= max(weights.y, weights.z) ? 0 : weights.y >= weights.z ? 1 : 2;
    disc = stp_square_mean(cell, vec4(weights, 0.0), nearest);
    disc.position = a + parts.x * (b - a) + parts.y * (c - a);
    disc.normal = stp_square_normal(disc.normal, cross(b - a, c - a), disc.position);
    disc.radius = border ? disc.radius : 0.0;
#endif
    return disc;
}
