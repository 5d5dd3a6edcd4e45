/* Fuzz target for lines of numbers (XYZ, PTS, PTX) and KITTI: reads any bytes as a file, by
 * content, under the formats' names, and with given columns. Needs no corpus: an empty input
 * becomes one of the small files below. */
#include "tests/fuzz/fuzz_scan.h"

#include "formats/scan/number.h"

static const char *const seeds[] = {
    "1 2 3\n4.5 -5e1 6\n7 8 9.25",
    "1 2 3 0.5 10 20 30\n4 5 6 0.25 40 50 60\n",
    "1,5;2,5;3,5;0;0;1\r\n4;5;6;0,6;-0,8;0\r\n",
    "\xef\xbb\xbf"
    "X,Y,Z,Red,Green,Blue,Alpha,Intensity,Classification,\"GPS time\"\n"
    "1,2,3,0.1,0.2,0.3,1,-10.5,2,7\n4,5,6,1,0,0.5,1,-20.5,6,\n",
    "//X Y Z R G B Nx Ny Nz\n# comment\n\n1 2 3 256 0 0 0 0 1\nnan 0 inf 1 2 65535 0 0 0\n",
    "3\n1 2 3 -2048 10 20 30\n4 5 6 2047 40 50 60\n7 8 9 0 1 2 3\n1\n1 1 1 1 1 1 1\n",
    "2\n1 2 3\n4 5 6\n",
    "[[1.5, -2,5, 3],\n [4, 5, 6]]\n",
    "Survey (2019)\nX (m) Y [m] Z (m) rgb\n1,5 -2,25 3 #ff0000\n4 5 6 #00ff00\n",
    "v(1, 2, 3) (0, 0, 1)\n{4; 5; 6} {0; 1; 0}\n",
    "1 2 3 9 0.5\n4 5 6 7 0.5\n7 8 9 8 0.75\n",
    "2\n1\n5 6 7\n1 0 0\n0 1 0\n0 0 1\n0 1 0 0\n-1 0 0 0\n0 0 1 0\n5 6 7 1\n"
    "1 2 3 0.5 10 20 30\n0 0 0 0.5 0 0 0\n"
    "1\n2\n5 6 7\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    "1 2 3 0.5\n0 0 0\n",
    "0\n0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 9\n0 1 0 8\n0 0 1 7\n0 0 0 1\n",
};

static const char *const words[] = {
    "nan",      "inf",
    "-1",       "0",
    "255",      "65535",
    "-2048",    "18446744073709551615",
    "1e999",    "1e-320",
    ";",        "\t",
    ",",        "\n",
    "\r\n",     "\"",
    "#",        "//",
    "0.5",      "1,5",
    "x",        "y",
    "z",        " ",
    "e",        ".",
    "0 0 0\n",  "\n\n",
    "i",        "9007199254740993",
    "(",        ")",
    "[",        "]] ",
    "\xff\xfe", "\xfe\xff",
};

static const char *const lists[] = {NULL, NULL, NULL, "x,y,z", "_,x,y,z,r,g,b", "z,y,x,i,class,-"};

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    const fuzz_words all = {seeds, sizeof seeds / sizeof *seeds, words,
                            sizeof words / sizeof *words};
    return fuzz_mutate_words(data, size, capacity, seed, &all);
}

static char folder[] = "fuzz-text-XXXXXX";
static const char *const names[] = {"scan", "scan.xyz", "scan.pts", "scan.ptx", "scan.bin"};

static const char *name_of(size_t i)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, names[i]);
    return path;
}

static void remove_folder(void)
{
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        unlink(name_of(i));
    rmdir(folder);
}

/* Makes a folder and works in it; all its files are the same bytes in memory. Returns their
 * descriptor. */
static int make_folder(void)
{
    static int descriptor = -1;
    char target[64];
    if (descriptor >= 0)
        return descriptor;
    descriptor = fuzz_memory_file(NULL, 0, target);
    fuzz_require(mkdtemp(folder) != NULL && atexit(remove_folder) == 0, "a folder");
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        fuzz_require(symlink(target, name_of(i)) == 0, "a link");
    return descriptor;
}

/* A number that is read must equal the C library's. */
static void check_number(const uint8_t *data, size_t size)
{
    char text[64];
    double value;
    const size_t length = size < sizeof text - 1 ? size : sizeof text - 1;
    memcpy(text, data, length);
    text[length] = '\0';
    const char *stop = stp_number_scan(text, text + length, &value);
    if (!stop)
        return;
    text[stop - text] = '\0';
    const double expected = strtod(text, NULL);
    fuzz_require(memcmp(&value, &expected, sizeof value) == 0, "a number is read exactly");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const unsigned choice = size > 0 ? data[size / 2] : 0;
    const stp_scan_params params = {.columns = lists[choice % 6],
                                    .recompute_normals = choice > 200};
    const int descriptor = make_folder();
    fuzz_require(ftruncate(descriptor, 0) == 0 &&
                     pwrite(descriptor, data, size, 0) == (ssize_t)size,
                 "memory");
    check_number(data, size);
    fuzz_read_scan(name_of(0), NULL);
    fuzz_find_step(name_of(0));
    fuzz_read_scan(name_of(1 + choice / 8 % 4), &params);
    return 0;
}
