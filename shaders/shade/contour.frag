// Contours: lines of equal height ("Contours" in README.md). Multiplied into the picture.
#include "layout.glsl"

// Width of a line in pixels; each fifth is wider. Lines that are closer together than the first
// spacing are not drawn; from the second on they are whole.
#define STP_CONTOUR_WIDTH 1.2
#define STP_CONTOUR_WIDTH_FIFTH 2.2
#define STP_CONTOUR_SPACING vec2(3.0, 6.0)
#define STP_CONTOUR_INK 0.8
// A surface that rises less than this share of a step per pixel is level: it has no lines.
#define STP_CONTOUR_LEVEL 1e-4
// Pixels: how far away a surface must bear out its slope.
#define STP_CONTOUR_NEAR 6.0
#define STP_CONTOUR_FAR 20.0
// Shares of that distance: a line that would lie so far elsewhere is still whole, or gone. A level
// surface whose normal leans by chance has 0.71.
#define STP_CONTOUR_STRAY vec2(0.25, 0.45)
// Steps by which a surface must leave a line, up and down, if it does not bear out its slope.
#define STP_CONTOUR_LEAVES vec2(0.15, 0.3)

layout(binding = 4) uniform sampler2D picture_steps; // stp_contour_steps of contour.glsl

layout(location = 0) out vec4 inked;

// What the eight pixels on a circle say. stray: how many pixels away a line would be by their
// heights instead of the normal; the least of the eight half circles. up, down: the greatest number
// of steps above and below the line.
struct stp_circle {
    float stray, up, down;
};

stp_circle stp_circle_look(vec4 own, float line, float radius)
{
    const ivec2 last = ivec2(viewport.xy) - 1, here = ivec2(gl_FragCoord.xy);
    float off[8], there[8];
    stp_circle circle = stp_circle(1e30, 0.0, 0.0);
    for (int i = 0; i < 8; i++) {
        float angle = 0.78539816 * float(i);
        ivec2 way = ivec2(round(radius * vec2(cos(angle), sin(angle))));
        vec4 steps = texelFetch(picture_steps, clamp(here + way, ivec2(0), last), 0);
        bool inside = all(equal(clamp(here + way, ivec2(0), last), here + way));
        there[i] = inside ? steps.w : 0.0;
        float wrong = steps.x - own.x - dot(own.yz, vec2(way));
        off[i] = there[i] * wrong * wrong;
        circle.up = max(circle.up, there[i] * (steps.x - line));
        circle.down = max(circle.down, there[i] * (line - steps.x));
    }
    for (int i = 0; i < 8; i++) {
        float count = 0.0, sum = 0.0;
        for (int k = i; k < i + 4; k++) {
            count += there[k & 7];
            sum += off[k & 7];
        }
        circle.stray = count >= 3.0 ? min(circle.stray, sum / count) : circle.stray;
    }
    bool known = circle.stray < 1e30; // else too little is there to judge by
    circle.stray = known ? sqrt(circle.stray) / max(length(own.yz), 1e-20) : 0.0;
    return circle;
}

// Whether the heights around a pixel bear out its slope, 0 to 1.
float stp_circle_agrees(stp_circle circle, float radius)
{
    return 1.0 - smoothstep(STP_CONTOUR_STRAY.x * radius, STP_CONTOUR_STRAY.y * radius, circle.stray);
}

// The share of a pixel that a line covers.
float stp_contour(vec4 own)
{
    float slope = length(own.yz), line = round(own.x); // slope: steps a pixel
    float width = mod(line + 0.5, 5.0) < 1.0 ? STP_CONTOUR_WIDTH_FIFTH : STP_CONTOUR_WIDTH;
    float away = abs(own.x - line) / max(slope, 1e-20); // pixels
    float covered = clamp(0.5 * width + 0.5 - away, 0.0, 1.0);
    if (own.w == 0.0 || covered == 0.0 || slope < STP_CONTOUR_LEVEL)
        return 0.0;
    stp_circle near = stp_circle_look(own, line, STP_CONTOUR_NEAR), far = stp_circle_look(own, line, STP_CONTOUR_FAR);
    float leaves = min(max(near.up, far.up), max(near.down, far.down));
    float crosses = max(stp_circle_agrees(far, STP_CONTOUR_FAR),
                        smoothstep(STP_CONTOUR_LEAVES.x, STP_CONTOUR_LEAVES.y, leaves));
    float apart = smoothstep(STP_CONTOUR_SPACING.x, STP_CONTOUR_SPACING.y, 1.0 / slope);
    return covered * apart * crosses * stp_circle_agrees(near, STP_CONTOUR_NEAR);
}

void main()
{
    vec4 own = texelFetch(picture_steps, ivec2(gl_FragCoord.xy), 0);
    inked = vec4(vec3(1.0 - STP_CONTOUR_INK * stp_contour(own)), 1.0);
}
