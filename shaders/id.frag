// Projection keeps the name of the nearest sample only; resolve.frag reads the rest once a pixel.
flat in uvec2 id;

layout(location = 0) out uvec2 nearest;

void main()
{
    nearest = id;
}
