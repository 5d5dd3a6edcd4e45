/* Fuzz target for the E57 reader: reads any bytes as a file. Needs no corpus: an empty input
 * becomes one of the small files below. The mutator changes the logical bytes and recomputes the
 * checksums, and mostly the header's sizes too, so that the code behind them is reached. */
#include "tests/fixtures/scan/e57_fixture.h"
#include "tests/fuzz/fuzz_scan.h"

#define XYZ(kind)                                                                                  \
    E57_FLOAT("cartesianX", kind)                                                                  \
    E57_FLOAT("cartesianY", kind) E57_FLOAT("cartesianZ", kind)
#define POINTS 40u

/* Adds a scan of spherical coordinates as narrow integers. Its fields' packets are out of step,
 * with packets of other kinds between. */
static void add_spherical(e57_file *file)
{
    e57_stream s[7] = {{.part = 5}, {.part = 300}, {.part = 77}, {.part = 3},
                       {.part = 9}, {.part = 0},   {.part = 4}};
    for (unsigned i = 0; i < POINTS; i++) {
        bytes_bits(&s[0].bytes, i, 13);
        bytes_double(&s[1].bytes, 0.1 * i);
        bytes_float(&s[2].bytes, 0.02f * (float)i);
        bytes_bits(&s[3].bytes, i % 3, 2);
        bytes_bits(&s[4].bytes, (uint64_t)i << 50, 57);
        bytes_bits(&s[6].bytes, POINTS - i, 6);
    }
    e57_vector(file, s, 7, true);
    e57_scan(file,
             "<pose><rotation><w>0.5</w><x>0.5</x><y>-0.5</y><z>0.5</z></rotation><translation>"
             "<x>1e3</x><y type=\"ScaledInteger\" scale=\"0.5\">7</y><z/></translation></pose>\n",
             POINTS,
             E57_SCALED("sphericalRange", "-5", "8186", "0.01", "1")
                 E57_FLOAT("sphericalAzimuth", "double") E57_FLOAT("sphericalElevation", "single")
                     E57_INTEGER("sphericalInvalidState", "0",
                                 "2") E57_INTEGER("intensity", "0", "144115188075855871")
                         E57_INTEGER("columnIndex", "3", "3") E57_INTEGER("rowIndex", "0", "63"));
    for (int i = 0; i < 7; i++)
        bytes_free(&s[i].bytes);
}

static void add_cartesian(e57_file *file)
{
    e57_stream s[9] = {0};
    for (unsigned i = 0; i < POINTS; i++) {
        for (int axis = 0; axis < 3; axis++)
            bytes_float(&s[axis].bytes, (float)i);
        for (int c = 3; c < 6; c++)
            bytes_integer(&s[c].bytes, i, 1);
        bytes_float(&s[6].bytes, 0.5f);
        bytes_bits(&s[7].bytes, i, 1);
        bytes_bits(&s[8].bytes, i % 4, 2);
    }
    e57_vector(file, s, 9, false);
    e57_scan(file,
             "<colorLimits><colorRedMaximum>255</colorRedMaximum></colorLimits><intensityLimits>"
             "<intensityMinimum>-1</intensityMinimum><intensityMaximum>2</intensityMaximum>"
             "</intensityLimits>\n",
             POINTS,
             XYZ("single") E57_INTEGER("colorRed", "0", "255") E57_INTEGER("colorGreen", "0", "255")
                 E57_INTEGER("colorBlue", "0", "255") E57_FLOAT("intensity", "single")
                     E57_INTEGER("isColorInvalid", "0", "1")
                         E57_INTEGER("cartesianInvalidState", "0", "3"));
    for (int i = 0; i < 9; i++)
        bytes_free(&s[i].bytes);
}

static void add_normals(e57_file *file)
{
    e57_stream s[7] = {0};
    for (unsigned i = 0; i < POINTS; i++)
        for (int c = 0; c < 7; c++)
            bytes_double(&s[c].bytes, (double)i - 3.0 * c);
    e57_vector(file, s, 7, false);
    e57_scan(file, "<pose><translation><z>2</z></translation></pose>\n", POINTS,
             XYZ("double") E57_FLOAT("nor:normalX", "double") E57_FLOAT("nor:normalY", "double")
                 E57_FLOAT("nor:normalZ", "double") E57_FLOAT("intensity", "double"));
    for (int i = 0; i < 7; i++)
        bytes_free(&s[i].bytes);
}

static byte_row make_seed(unsigned number)
{
    e57_file file;
    e57_begin(&file);
    if (number & 1u)
        add_spherical(&file);
    if (number & 2u)
        add_cartesian(&file);
    if (number & 4u || (number & 3u) == 0)
        add_normals(&file);
    e57_end(&file, "<coordinateMetadata>EPSG:0</coordinateMetadata>");
    byte_row out = file.logical;
    file.logical = (byte_row){0};
    e57_free(&file);
    return out;
}

/* Returns the bytes of whole pages without their checksums. */
static byte_row unseal(const uint8_t *data, size_t size)
{
    byte_row out = {0};
    for (size_t at = 0; at + 1024 <= size; at += 1024)
        bytes_add(&out, data + at, 1020);
    return out;
}

/* Sets the header's sizes and the place of the XML to the true values. */
static void repair_header(byte_row *logical)
{
    static const char begin[] = "<?xml";
    if (logical->size < E57_HEADER)
        return;
    bytes_set(logical, 16, (logical->size + 1019) / 1020 * 1024, 8);
    const unsigned char *xml = memmem(logical->data, logical->size, begin, strlen(begin));
    if (!xml)
        return;
    const size_t at = (size_t)(xml - logical->data);
    size_t end = logical->size;
    while (end > at && logical->data[end - 1] == 0) /* padding of the last page */
        end--;
    bytes_set(logical, 24, e57_physical(at), 8);
    bytes_set(logical, 32, end - at, 8);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    if (capacity < 1024 || (seed % 64 == 0 && size >= 1024))
        return LLVMFuzzerMutate(data, size, capacity); /* may hit checksums */
    byte_row logical = size < 1024 ? make_seed(seed) : unseal(data, size);
    const size_t room = capacity / 1024 * 1020;
    bytes_add(&logical, NULL, room > logical.size ? room - logical.size : 0);
    size_t used = size < 1024 ? logical.size : size / 1024 * 1020;
    used = used < room ? used : room;
    while (used > 0 && logical.data[used - 1] == 0)
        used--;
    logical.size = size < 1024 ? used : LLVMFuzzerMutate(logical.data, used, room);
    if (seed % 8 != 1)
        repair_header(&logical);
    byte_row sealed = e57_seal(logical.data, logical.size);
    size = sealed.size < capacity ? sealed.size : capacity;
    memcpy(data, sealed.data, size);
    bytes_free(&sealed);
    bytes_free(&logical);
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    return fuzz_scan_bytes(data, size);
}
