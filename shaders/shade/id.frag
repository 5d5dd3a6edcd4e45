// Projection keeps the name of the nearest sample only; resolve.frag reads the rest once a pixel.
flat in uint id;

layout(location = 0) out uint nearest;

void main()
{
    nearest = id;
}
