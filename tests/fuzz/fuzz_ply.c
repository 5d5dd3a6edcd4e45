/* Fuzz target for the PLY reader: reads any bytes as a file. Needs no corpus: an empty input
 * becomes one of the small files below. */
#include "tests/fuzz/fuzz_scan.h"

typedef struct ply_seed {
    const char *bytes;
    size_t size;
} ply_seed;

#define SEED(text)                                                                                 \
    {                                                                                              \
        text, sizeof(text) - 1                                                                     \
    }
#define XYZ "property float x\nproperty double y\nproperty float z\n"
#define EDGES "property int vertex1\nproperty int vertex2\n"
#define FACES "property list uchar int vertex_indices\n"

static const ply_seed seeds[] = {
    SEED("ply\nformat ascii 1.0\ncomment TextureFile 99\ncomment TextureFile 98\nelement vertex "
         "3\n" XYZ "element face 2\nproperty list uchar float texcoord\n" FACES
         "property int texnumber\nend_header\n0 0 0\n1 0 0\n0 1 0\n6 0 0 1 0 .5 7 3 0 1 2 0\n"
         "3 nan 1 2 3 2 1 0 1\n"),
    SEED("ply\nformat ascii 1.0\ncomment c\nelement vertex 3\n" XYZ
         "property ushort red\nproperty ushort green\nproperty ushort blue\nelement face 1\n" FACES
         "end_header\n0 0 0 1 2 3\n1 0 0 1 2 300\n0 1e-1 nan 1 2 3\n3 0 1 2\n"),
    SEED(
        "ply\r\nformat ascii 1.0\r\nelement tristrips 1\r\nproperty list int int vertex_indices\r\n"
        "element vertex 4\r\nproperty float nx\r\nproperty float ny\r\nproperty float nz\r\n" XYZ
        "end_header\r\n6 0 1 2 -1 3 2\r\n0 0 1 0 0 0\r\n0 0 1 1 0 0\r\n0 0 1 0 1 0\r\n"
        "0 0 1 1 1 0\r\n"),
    SEED("ply\nformat binary_little_endian 1.0\nelement camera 1\nproperty char c\n"
         "element vertex 3\n" XYZ "property float intensity\nproperty uint8 class\n"
         "element face 1\n" FACES "property uchar flags\nend_header\n"
         "\1\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\2"
         "\0\0\x80\x3f\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\x80\x3f\3"
         "\0\0\x80\x3f\0\0\0\0\0\0\xf0\x3f\0\0\0\0\0\0\0\x3f\4"
         "\3\0\0\0\0\1\0\0\0\2\0\0\0\7"),
    SEED("ply\nformat binary_big_endian 1.0\nelement strange 1\nproperty list ushort double l\n"
         "element vertex 2\nproperty list uchar short w\nproperty int16 x\nproperty int32 y\n"
         "property uint z\nend_header\n"
         "\0\1\0\0\0\0\0\0\0\0"
         "\1\0\2\0\3\0\0\0\4\0\0\0\5"
         "\0\0\3\0\0\0\4\0\0\0\5"),
    SEED("ply\nformat binary_little_endian 1.0\ncomment station 1 0.5 -1e3 2\n"
         "comment station 0 7 8 9\ncomment station 1 0 0\ncomment station 0 7 8 9.5\n"
         "element vertex 3\nproperty short x\nproperty char y\nproperty uchar z\n"
         "property uchar station\nend_header\n"
         "\0\0\1\2\0\1\0\3\4\1\0\2\5\6\xff"),
    SEED("ply\nformat ascii 1.0\ncomment station 4294967295 1 2 3\ncomment station 3 nan 0 0\n"
         "element vertex 4\n" XYZ "property double scalar_Station\nelement face 1\n" FACES
         "end_header\n0 0 0 4294967295\n1 0 0 3\n0 1 0 -1\n0 1 1 0.5\n3 0 1 2\n"),
    SEED("ply\nformat ascii 1.0\ncomment station 7 1 2 3\nelement vertex 1\n" XYZ
         "end_header\n0 0 0\n"),
    SEED("ply\nformat ascii 1.0\nelement vertex 5\n" XYZ "property float radius\n"
         "property float nx\nproperty float ny\nproperty float nz\nelement edge 6\n" EDGES
         "element face 1\n" FACES "end_header\n0 0 0 .1 0 0 1\n1 0 0 .2 0 0 1\n1 1 0 -1 0 0 0\n"
         "0 1 0 nan 1 0 0\n2 2 2 1e9 0 1 0\n0 1\n1 2\n2 0\n2 3\n3 3\n4 9\n3 0 1 3\n"),
    SEED("ply\nformat binary_little_endian 1.0\nelement edge 3\n" EDGES
         "element vertex 3\nproperty char x\nproperty char y\nproperty char z\nend_header\n"
         "\0\0\0\0\1\0\0\0\1\0\0\0\2\0\0\0\2\0\0\0\0\0\0\0\1\2\3\4\5\6\7\x8\x9"),
};

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    const ply_seed *chosen = &seeds[seed % (sizeof seeds / sizeof *seeds)];
    return fuzz_mutate(data, size, capacity, chosen->bytes, chosen->size);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    return fuzz_scan_bytes(data, size);
}
