// Colours for what has none.

// Blue, green, yellow, red over 0..1.
vec3 stp_palette_heat(float x)
{
    x = clamp(x, 0.0, 1.0) * 3.0;
    return clamp(vec3(x - 1.0, x < 1.0 ? x : 3.0 - x, 1.0 - x), 0.0, 1.0) * 0.9 + 0.05;
}

// Distinct colours for numbers (an integer hash: splitmix's finaliser in 32 bits).
vec3 stp_palette_hash(uint x)
{
    x = (x ^ x >> 16) * 0x45d9f3bu;
    x = (x ^ x >> 16) * 0x45d9f3bu;
    x = x ^ x >> 16;
    return 0.25 + 0.75 * vec3(float(x & 255u), float(x >> 8 & 255u), float(x >> 16 & 255u)) / 255.0;
}

// Green is the finest level of a patch, then yellow, orange, red; the deeper the chunk, the brighter.
vec3 stp_palette_level(int level, int depth)
{
    const vec3 colours[5] = vec3[](vec3(0.2, 0.75, 0.3), vec3(0.9, 0.85, 0.25), vec3(0.95, 0.55, 0.2),
                                   vec3(0.85, 0.2, 0.2), vec3(1.0, 0.0, 1.0));
    return colours[level] * (1.0 - 0.5 * exp2(-float(depth)));
}

// Measured pixels green; interpolated ones from yellow to red with the pyramid level they come from.
vec3 stp_palette_confidence(int source)
{
    return source == 0 ? vec3(0.2, 0.75, 0.3) : vec3(1.0, max(0.0, 1.0 - float(source - 1) / 5.0), 0.1);
}
