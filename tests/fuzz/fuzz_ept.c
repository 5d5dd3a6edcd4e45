/* Fuzz target for Entwine Point Tile sets. An input is the files of a set with the line "%%"
 * between them: ept.json, the page 0-0-0-0 of the hierarchy, the page 1-0-0-0, and the bytes of
 * every tile. Needs no corpus: an empty input becomes one of the sets below. */
#include "tests/fuzz/fuzz_scan.h"

#include <sys/stat.h>

#define BREAK "\n%%\n"
#define XYZ                                                                                        \
    "{\"name\":\"X\",\"type\":\"signed\",\"size\":4,\"scale\":0.01,\"offset\":4},"                 \
    "{\"name\":\"Y\",\"type\":\"float\",\"size\":4},"                                              \
    "{\"name\":\"Z\",\"type\":\"unsigned\",\"size\":2}"
#define HEAD(kind, more)                                                                           \
    "{\"bounds\":[0,0,0,8,8,8],\"dataType\":\"" kind "\",\"points\":3,\"span\":8,"                 \
    "\"schema\":[" XYZ more "],\"srs\":{\"wkt\":\"PROJCS[]\"},\"version\":\"1.0.0\"}" BREAK

static const char *const seeds[] = {
    HEAD("binary", "") "{\"0-0-0-0\":2}" BREAK "{}" BREAK "0123456789abcdefghij",
    HEAD("binary", ",{\"name\":\"Red\",\"type\":\"unsigned\",\"size\":1}") "{\"0-0-0-0\":1,\"1-0-0-"
                                                                           "0\":-1}" BREAK
                                                                           "{\"1-0-0-0\":1,\"2-1-0-"
                                                                           "0\":0}" BREAK
                                                                           "0123456789a",
    HEAD("zstandard",
         ",{\"name\":\"Intensity\",\"type\":\"signed\",\"size\":8}") "{\"0-0-0-0\":1}" BREAK
                                                                     "{}" BREAK
                                                                     "\x28\xb5\x2f\xfd\x20\x04\x21",
    HEAD("laszip", "") "{\"0-0-0-0\":1}" BREAK "{}" BREAK "LASF",
};

static const char *const words[] = {
    "\"binary\"",      "\"zstandard\"",  "\"laszip\"",  "-1",
    "\"1-0-0-0\":-1,", "\"2-1-0-1\":1,", "1e999",       "4294967295",
    "\"float\"",       "\"size\":8",     BREAK,         "\"Withheld\"",
    "\"NormalX\"",     "\"NormalY\"",    "\"NormalZ\"", "\"ClassFlags\"",
    "\"Green\"",       "\"Blue\""};

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    const fuzz_words all = {seeds, sizeof seeds / sizeof *seeds, words,
                            sizeof words / sizeof *words};
    return fuzz_mutate_words(data, size, capacity, seed, &all);
}

/* ---- the set's folder ---- */

static char folder[64];

static const char *const files[] = {"ept.json",
                                    "ept-hierarchy/0-0-0-0.json",
                                    "ept-hierarchy/1-0-0-0.json",
                                    "ept-data/0-0-0-0.laz",
                                    "ept-data/0-0-0-0.bin",
                                    "ept-data/0-0-0-0.zst",
                                    "ept-data/1-0-0-0.laz",
                                    "ept-data/1-0-0-0.bin",
                                    "ept-data/1-0-0-0.zst"};
enum { PARTS = 4, FILES = sizeof files / sizeof *files };

static const char *in_folder(const char *name, char out[160])
{
    snprintf(out, 160, "%s/%s", folder, name);
    return out;
}

static void remove_folder(void)
{
    char path[160];
    for (int i = 0; i < FILES; i++)
        (void)unlink(in_folder(files[i], path));
    (void)rmdir(in_folder("ept-data", path));
    (void)rmdir(in_folder("ept-hierarchy", path));
    (void)rmdir(folder);
}

static void make_folder(void)
{
    char path[160];
    snprintf(folder, sizeof folder, "%s/fuzz-ept-XXXXXX",
             access("/dev/shm", W_OK) ? "/tmp" : "/dev/shm");
    fuzz_require(mkdtemp(folder) != NULL, "a folder");
    fuzz_require(mkdir(in_folder("ept-data", path), 0700) == 0, "a folder");
    fuzz_require(mkdir(in_folder("ept-hierarchy", path), 0700) == 0, "a folder");
    (void)atexit(remove_folder);
}

static void write_file(const char *name, const uint8_t *data, size_t size)
{
    char path[160];
    FILE *file = fopen(in_folder(name, path), "wb");
    fuzz_require(file != NULL, "a file of the set");
    fuzz_require(fwrite(data, 1, size, file) == size, "a file of the set");
    fclose(file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const stp_scan_region region = {
        .bounded = true, .min = {1, 1, 1}, .max = {3, 3, 3}, .resolution = 0.5};
    const stp_scan_params part = {.region = &region};
    char path[160];
    if (!*folder)
        make_folder();
    for (int i = 0; i < PARTS; i++) {
        const uint8_t *at = i + 1 < PARTS ? memmem(data, size, BREAK, strlen(BREAK)) : NULL;
        const size_t length = at ? (size_t)(at - data) : size;
        const size_t taken = at ? length + strlen(BREAK) : length;
        for (int f = i; f < (i + 1 < PARTS ? i + 1 : FILES); f++)
            write_file(files[f], data, length);
        data += taken;
        size -= taken;
    }
    fuzz_read_scan(in_folder("ept.json", path), NULL);
    fuzz_read_scan(path, &part);
    return 0;
}
