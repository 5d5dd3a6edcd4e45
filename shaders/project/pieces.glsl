// The pieces of squares of grids, to be rasterised: cells and quarters. Needs nothing.
//
// Between four samples of a grid lies a cell. If the surface joins all four, a cell is two triangles.
// Else it falls into quarters, one for each sample that is there:
//
//     o------m------x      o: samples        x: a sample that is missing, or beyond a cliff
//     |      |             m: half-way to the next sample, or where the sample's tangent plane
//     m------c------m         is half a cell on
//     |      |      |      c: the mean of what the joined samples say of the cell's middle
//     o------m------o
//
// So a hole keeps its width, and a surface at a cliff goes on by half a cell. At the borders of elevation
// maps others go on: there pixels of quarters have the samples' radii, so pull and push close seams.

#define STP_SQUARE_CELLS 81         // 9 x 9, from column and row -1 on
#define STP_SQUARE_TRIANGLES 640u   // the most of a square: of 64 cells, then of 256 quarters
#define STP_CELL_TRIANGLES 128u
#define STP_SQUARE_PLACES 1105u     // of 9 x 9 samples, from column and row 0 on, then four a quarter
#define STP_QUARTER_GROUP 64u       // cells with quarters that a group of square_quarters.comp takes

layout(location = 4) uniform uvec2 squares; // the first that is listed, and how many
