/* Fuzz target for grids of heights and depths. The last byte says how the file is read: as heights
 * or as a camera's image, with colours from the same file or without. Other formats are left to the
 * other targets, and EXR to OpenImageIO. */
#include "formats/scan/detect.h"
#include "tests/fuzz/fuzz_scan.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[64];
    stp_scan_format format;
    if (size == 0)
        return 0;
    const unsigned how = data[size - 1];
    if (data[0] == 0x76) /* EXR */
        return 0;
    const int descriptor = fuzz_memory_file(data, size, path);
    if (stp_scan_detect(&format, path, NULL) == STP_OK && format == STP_SCAN_GRID) {
        const stp_grid_params grid = {.colour = how & 1 ? path : NULL,
                                      .has_invalid = how & 2,
                                      .invalid = 7.0,
                                      .dx = how & 4 ? 0.5 : 0.0,
                                      .dy = how & 4 ? 0.25 : 0.0,
                                      .fx = how & 8 ? 500.0 : 0.0,
                                      .fy = how & 8 ? 400.0 : 0.0,
                                      .along_ray = how & 16,
                                      .disparity_focal = (how & 40) == 40 ? 300.0 : 0.0,
                                      .disparity_base = (how & 40) == 40 ? 0.1 : 0.0};
        const stp_scan_params params = {.grid = &grid, .recompute_normals = how & 64};
        fuzz_read_scan(path, &params);
    }
    close(descriptor);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    static const char small[] = "P2\n4 3\n255\n1 2 3 4 5 6 7 8 9 10 11 12\n";
    (void)seed;
    return fuzz_mutate(data, size, capacity, small, sizeof small - 1);
}
