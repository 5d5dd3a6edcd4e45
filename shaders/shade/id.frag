// Projection keeps only the name of the nearest sample; resolve.frag then reads the sample once per
// pixel.
flat in uint id;

layout(location = 0) out uint nearest;

void main()
{
    nearest = id;
}
