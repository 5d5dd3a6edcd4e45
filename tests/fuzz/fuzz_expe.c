/* Fuzz target for the reader of Expe's point sets: reads any bytes as a file. Needs no corpus: an
 * empty input becomes one of the files below. */
#include "tests/fuzz/fuzz_scan.h"

static const char *const texts[] = {
    ("[Expe/PointSet/Binary/0.1]\nproperty position 12\nproperty radius 4\nproperty normal 12\n"
     "property color 4\nnofpoints 2\ndata\n0123456789abcdef0123456789abcdefghijklmnopqrstuvwxyzAB"
     "CDEFGHIJKL"),
    ("[Expe/PointSet/Binary/0.1]\nnofpoints 1\nproperty own 1\nproperty position 12\ndata\n"
     "0123456789abc"),
    "[Expe/PointSet/Ascii/0.1]\nproperty position 12\nnofpoints 1\ndata\n1 2 3\n",
};

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    const size_t k = seed % (sizeof texts / sizeof *texts);
    return fuzz_mutate(data, size, capacity, texts[k], strlen(texts[k]));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    return fuzz_scan_bytes(data, size);
}
