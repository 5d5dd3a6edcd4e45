// Palettes: colours for values that are not colours.

// Interpolates five colours at even steps; x in 0..1.
vec3 stp_palette_between(vec3 a, vec3 b, vec3 c, vec3 d, vec3 e, float x)
{
    vec4 part = clamp(4.0 * x - vec4(0.0, 1.0, 2.0, 3.0), 0.0, 1.0);
    return a + (b - a) * part.x + (c - b) * part.y + (d - c) * part.z + (e - d) * part.w;
}

// Blue, green, yellow, red over 0..1.
vec3 stp_palette_heat(float x)
{
    x = clamp(x, 0.0, 1.0) * 3.0;
    return clamp(vec3(x - 1.0, x < 1.0 ? x : 3.0 - x, 1.0 - x), 0.0, 1.0) * 0.9 + 0.05;
}

// The colour of a value clamped to 0..1, by STP_PALETTE. Viridis by five of its colours (van der
// Walt and Smith 2015).
vec3 stp_palette_ramp(float x)
{
    x = clamp(x, 0.0, 1.0);
#if STP_PALETTE == STP_PALETTE_VIRIDIS
    return stp_palette_between(vec3(0.267, 0.005, 0.329), vec3(0.229, 0.322, 0.546),
                               vec3(0.128, 0.567, 0.551), vec3(0.369, 0.789, 0.383),
                               vec3(0.993, 0.906, 0.144), x);
#elif STP_PALETTE == STP_PALETTE_HEAT
    return stp_palette_heat(x);
#else
    return vec3(x);
#endif
}

// Distinct colours for numbers (an integer hash: splitmix's finaliser in 32 bits).
vec3 stp_palette_hash(uint x)
{
    x = (x ^ x >> 16) * 0x45d9f3bu;
    x = (x ^ x >> 16) * 0x45d9f3bu;
    x = x ^ x >> 16;
    return 0.25 + 0.75 * vec3(float(x & 255u), float(x >> 8 & 255u), float(x >> 16 & 255u)) / 255.0;
}

// Colours of classes, numbered by the ASPRS LAS specification: ground brown, plants green by
// height, buildings red, water blue, roads and rails grey, wires yellow, noise magenta,
// unclassified and reserved light grey. User-defined numbers are coloured by hash.
vec3 stp_palette_class(uint number)
{
    const vec3 colours[23] = vec3[](
        vec3(0.75), vec3(0.75), vec3(0.60, 0.43, 0.25), vec3(0.60, 0.80, 0.35), vec3(0.35, 0.65, 0.25),
        vec3(0.10, 0.45, 0.15), vec3(0.85, 0.35, 0.25), vec3(0.90, 0.20, 0.80), vec3(0.75),
        vec3(0.20, 0.45, 0.90), vec3(0.55, 0.50, 0.60), vec3(0.45), vec3(0.75), vec3(0.95, 0.85, 0.30),
        vec3(0.95, 0.75, 0.20), vec3(0.85, 0.60, 0.20), vec3(0.95, 0.90, 0.55), vec3(0.70, 0.55, 0.50),
        vec3(0.90, 0.20, 0.80), vec3(0.55, 0.60, 0.70), vec3(0.50, 0.35, 0.20), vec3(0.90, 0.95, 1.0),
        vec3(0.75));
    return number < 23u ? colours[number] : stp_palette_hash(number);
}

// What a name in nearest_sample is drawn as. Points: blue; lines: yellow; flat pieces of ribbons: green;
// triangles: orange; cells of grids: red.
vec3 stp_palette_primitive(uint name)
{
    bool segment = (name & STP_NAME_SEGMENT) != 0u, triangle = (name & STP_NAME_TRIANGLE) != 0u;
    bool square = (name & ~STP_NAME_SAMPLE) == STP_NAME_SQUARE;
    return segment ? (triangle ? vec3(0.40, 0.75, 0.35) : vec3(0.95, 0.85, 0.30))
           : square ? vec3(0.85, 0.40, 0.35)
           : triangle ? vec3(0.95, 0.60, 0.25)
                      : vec3(0.45, 0.60, 0.90);
}

// Normals fitted to the nearest neighbours: green; to wider planes: yellow and red; from the input:
// blue.
vec3 stp_palette_fit(uint fit)
{
    const vec3 colours[4] = vec3[](vec3(0.30, 0.70, 0.35), vec3(0.95, 0.80, 0.25), vec3(0.90, 0.30, 0.20),
                                   vec3(0.30, 0.50, 0.90));
    return colours[fit];
}

// Outliers magenta, other samples grey by their own brightness.
vec3 stp_palette_outlier(bool outlier, vec3 colour)
{
    return outlier ? vec3(0.90, 0.20, 0.80) : vec3(0.2 + 0.5 * dot(colour, vec3(0.299, 0.587, 0.114)));
}

// By level of the patch green (finest), yellow, orange, red; the deeper the chunk, the brighter.
vec3 stp_palette_level(int level, int depth)
{
    const vec3 colours[5] = vec3[](vec3(0.2, 0.75, 0.3), vec3(0.9, 0.85, 0.25), vec3(0.95, 0.55, 0.2),
                                   vec3(0.85, 0.2, 0.2), vec3(1.0, 0.0, 1.0));
    return colours[level] * (1.0 - 0.5 * exp2(-float(depth)));
}

// Measured pixels green, interpolated pixels from yellow to red by the pyramid level they come
// from.
vec3 stp_palette_confidence(int source)
{
    return source == 0 ? vec3(0.2, 0.75, 0.3) : vec3(1.0, max(0.0, 1.0 - float(source - 1) / 5.0), 0.1);
}
