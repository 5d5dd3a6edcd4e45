/* Fuzz target for the PCD reader: reads any bytes as a file. Needs no corpus: an empty input
 * becomes one of the headers below or a small file in one of the three encodings. */
#include "tests/fixtures/scan/pcd_fixture.h"
#include "tests/fuzz/fuzz_scan.h"

static const char *const texts[] = {
    "# .PCD v.5\nVERSION .5\nFIELDS x y z rgb\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 3\nPOINTS 3\n"
    "DATA ascii\n0 0 0 4.2108e+06\n1e-3 nan 2 -1.7e38\n-1 0.5 inf 5.9e-39\n",
    "VERSION 0.6\r\nCOLUMNS z _ x y label\r\nSIZE 8 1 2 1 4\r\nTYPE F U I U I\r\n"
    "COUNT 1 2 1 1 1\r\nHEIGHT 2\r\nWIDTH 1\r\nVIEWPOINT 1 2 3 1 0 0 0\r\nDATA ascii\r\n"
    "1 0 0 2 3 4\r\n\r\n5 0 0 6 7 -8\r\n",
    "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA binary\n0123456789ab",
};

/* Makes four points with every kind of field. */
static byte_row make_seed(unsigned number)
{
    static const double x[] = {1, 2, 3, 3}, y[] = {0, NAN, 0.5, 0.5}, z[] = {7, 7, 7, 7};
    static const double rgb[] = {0xFF102030u, 0x00FFFFFFu, 0x7F810000u, 0};
    static const double many[12] = {1, 2, 3};
    const pcd_column columns[] = {
        {"x", number & 8u ? 'I' : 'F', number & 8u ? 2 : 4, 1, x},
        {"intensity", 'F', 4, 1, z},
        {"_", 'U', 1, 3, many},
        {"y", 'F', 8, 1, y},
        {"normal_y", 'F', 4, 1, y},
        {"rgb", 'P', 4, 1, rgb},
        {"fpfh", 'F', 4, 3, many},
        {"normal_x", 'F', 4, 1, z},
        {"label", 'U', 4, 1, many},
        {"normal_z", 'F', 4, 1, x},
        {"z", 'F', 4, 1, z},
    };
    const bool organised = number & 16u;
    const pcd_file file = {columns, sizeof columns / sizeof *columns, organised ? 2 : 4,
                           organised ? 2 : 1, number & 32u ? "0 0 1 1 0 0 0" : NULL};
    return pcd_make(&file, (pcd_encoding)(number % PCD_ENCODING_COUNT));
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    const size_t count = sizeof texts / sizeof *texts;
    if (size >= 8 || seed % 4 == 0)
        return fuzz_mutate(data, size, capacity, texts[seed / 4 % count],
                           strlen(texts[seed / 4 % count]));
    byte_row made = make_seed(seed / 4);
    size = fuzz_mutate(data, size, capacity, (const char *)made.data, made.size);
    bytes_free(&made);
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    return fuzz_scan_bytes(data, size);
}
