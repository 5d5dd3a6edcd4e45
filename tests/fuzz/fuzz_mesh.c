/* Fuzz target for OBJ, OFF and STL: our checks, and OpenMesh's readers behind them; and for glTF.
 */
#include "tests/fuzz/fuzz_scan.h"

static const char *const texts[] = {
    "# c\nmtllib m\nv 0 0 0 1 0 .5\nv 1 0 0\nv 0 1 0 9 9 9\nvn 0 0 1\nvt 0 1\n"
    "f 1/1/1 2//1 \\\n3\nf -3 -2 -1\n",
    "vn 0 0 1\nv 1 2 3\n",
    "v 0 0 0\nv 1 0 0\nv 1 1 0 9 9 9\nv 0 1 1\nvn 0 0 1\nl 1 2 3//1 \\\n-1\nl 1/1 1\nl 4 9\nf 1 2 "
    "4\n",
    "mtllib 100\nnewmtl a\nKd 1 0 .5\nmap_Kd -s 1 1 99\nnewmtl b c\nmap_Kd 101\nv 0 0 0\nv 1 0 0\n"
    "v 0 1 0\nvt 0 1\nvt .5 2\nusemtl a\nf 1/1 2/2 3/-1\nusemtl b c\nf 3/1 2 1/2 -1/9\n",
    "OFF\n# c\n3 1 0\n0 0 0 255 0 0\n1 0 0\n0 1 0 1 1 1 1\n3 0 1 2\n",
    "NOFF 3 1 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n4 0 1 2 0\n",
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"nodes\":[{\"mesh\":0,\"children\":[1],\"scale\":[1,2,-1]},{\"rotation\":[0,0,1,1]}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"mode\":5,\"material\":0},"
    "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"COLOR_0\":0},\"indices\":2,\"material\":0}]"
    "}],"
    "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},"
    "\"baseColorFactor\":[1,0,1,1]}}],"
    "\"textures\":[{\"source\":0}],\"images\":[{\"bufferView\":0}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5121,\"count\":4,\"type\":\"VEC3\"},"
    "{\"bufferView\":0,\"componentType\":5121,\"count\":4,\"type\":\"VEC2\"},"
    "{\"bufferView\":0,\"componentType\":5121,\"count\":3,\"type\":\"SCALAR\"}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":12}],"
    "\"buffers\":[{\"uri\":\"data:;base64,AAECAwQFBgcICQoL\",\"byteLength\":12}]}",
    "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
    "endfacet\nendsolid\n",
};

/* Writes a binary STL of two facets. */
static size_t binary_stl(uint8_t *data, size_t capacity)
{
    const float facets[2][12] = {{0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0},
                                 {0, 0, 1, 1, 0, 0, 0, 1, 0, 1, 1, 0}};
    char file[84 + 100] = "binary";
    file[80] = 2;
    for (size_t i = 0; i < 2; i++)
        memcpy(file + 84 + 50 * i, facets[i], sizeof facets[i]);
    return fuzz_mutate(data, 0, capacity, file, sizeof file);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    const size_t count = sizeof texts / sizeof *texts;
    const char *text = texts[seed % count];
    if (size < 8 && seed / count % 6 == 0)
        return binary_stl(data, capacity);
    return fuzz_mutate(data, size, capacity, text, strlen(text));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    return fuzz_scan_bytes(data, size);
}
