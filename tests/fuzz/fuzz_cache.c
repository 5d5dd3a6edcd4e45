/* Fuzz target for the disk cache: keeps, reads and drops ranges of a known file, and tampers with
 * the cache's folder in between.
 *
 * An input is a list of steps of four bytes; an empty input becomes a list with every kind of step.
 * Whatever is in the folder, the cache must return the file's bytes or nothing. */
#include "formats/chunk/layout.h"
#include "formats/chunk/remote/cache_folder.h"
#include "formats/chunk/remote/disk_cache.h"
#include "tests/fixtures/chunk_fixture.h"
#include "tests/fuzz/fuzz_target.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/stat.h>

#define FILE_BYTES 8192u
#define STEPS_LIMIT 200u
#define STEP_BYTES 4u
#define KEY "http://somewhere/model.stipple, state 1"

static uint8_t truth[FILE_BYTES];
static char folder[300];

/* ---- tampering with the folder ---- */

/* Chooses one of the folder's files in the order of their names; returns false if there is none. */
static bool choose_file(unsigned which, char out[600])
{
    struct dirent **names = NULL;
    const int count = scandir(folder, &names, NULL, alphasort);
    bool found = count > 2;
    if (found)
        snprintf(out, 600, "%s/%s", folder, names[2 + which % (unsigned)(count - 2)]->d_name);
    for (int i = 0; i < count; i++)
        free(names[i]);
    free(names);
    return found;
}

static void tamper(const uint8_t step[STEP_BYTES])
{
    char path[600], other[600];
    struct stat info;
    if (!choose_file(step[1], path))
        return;
    const int file = open(path, O_RDWR);
    if (file < 0 || fstat(file, &info) != 0 || !S_ISREG(info.st_mode)) {
        if (file >= 0)
            close(file);
        rmdir(path);
        return;
    }
    const uint8_t value = step[3];
    const off_t size = info.st_size, at = size > 0 ? step[2] * 33 % size : 0;
    switch (step[0] / 8 % 8) {
    case 0:
        fixture_require(ftruncate(file, at) == 0);
        break;
    case 1:
        fixture_require(ftruncate(file, size + value) == 0);
        break;
    case 2:
        unlink(path);
        break;
    case 3: /* takes the name of another range */
        if (choose_file(step[2], other))
            (void)rename(path, other); /* fails if that is a directory */
        break;
    case 4:
        unlink(path);
        fixture_require(mkdir(path, 0700) == 0);
        break;
    case 5:
        unlink(path);
        fixture_require(symlink("/dev/zero", path) == 0);
        break;
    default:
        fixture_require(pwrite(file, &value, 1, at) == 1);
    }
    close(file);
}

static void empty_folder(void)
{
    char path[600];
    while (choose_file(0, path))
        fixture_require(remove(path) == 0);
}

/* Writes a file under the name of any range, with a valid header but for its checksum. */
static void forge(const uint8_t step[STEP_BYTES])
{
    char name[STP_CACHE_NAME_BYTES], path[600];
    const stp_cache_name parts = {
        {step[1], step[2]}, (uint64_t)step[2] << 8 * (step[3] % 8), step[3]};
    stp_cache_name_write(&parts, name);
    snprintf(path, sizeof path, "%s/%s", folder, step[0] & 8 ? "stipple-cache" : name);
    const int file = open(path, O_RDWR | O_CREAT | O_NOFOLLOW, 0600);
    if (file < 0)
        return;
    for (int i = 0; i < 48; i++)
        fixture_require(write(file, step + i % 4, 1) == 1);
    close(file);
}

/* ---- steps ---- */

static void read_range(stp_disk_cache *cache, uint64_t offset, size_t size)
{
    uint8_t *out = malloc(size + 1);
    fixture_require(out != NULL);
    const size_t got = stp_disk_cache_read(cache, offset, out, size);
    fuzz_require(got <= size, "no more is read than was asked for");
    fuzz_require(memcmp(out, truth + offset, got) == 0, "what is read is the file's");
    free(out);
}

static stp_disk_cache *open_cache(uint8_t budget)
{
    stp_disk_cache *cache = NULL;
    fuzz_require(stp_disk_cache_open(&cache, folder, 64u * budget + 1, KEY, NULL) == STP_OK,
                 "a cache is opened");
    return cache;
}

static void take_step(stp_disk_cache **cache, const uint8_t step[STEP_BYTES])
{
    const uint64_t offset = step[1] * 32u % FILE_BYTES + step[0] / 8;
    const size_t size = step[2] * 4u + step[3] % 4;
    const size_t inside = size < FILE_BYTES - offset ? size : FILE_BYTES - offset;
    switch (step[0] % 8) {
    case 0:
    case 1:
        stp_disk_cache_write(*cache, offset, truth + offset, inside);
        break;
    case 2:
        read_range(*cache, offset, inside);
        break;
    case 3:
        stp_disk_cache_drop(*cache, offset, size);
        break;
    case 4:
    case 5:
        tamper(step);
        break;
    case 6:
        forge(step);
        break;
    default:
        stp_disk_cache_close(cache);
        *cache = open_cache(step[3]);
    }
}

static void end(void)
{
    (void)fixture_remove_folder(NULL);
}

/* Fills the file's bytes, and makes the folder once. */
static void begin(void)
{
    if (folder[0] != '\0')
        return;
    for (size_t i = 0; i < FILE_BYTES; i++)
        truth[i] = (uint8_t)stp_random_u64(7, i);
    snprintf(folder, sizeof folder, "%s", fixture_path("cache"));
    fixture_require(atexit(end) == 0);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    if (size >= 2 * STEP_BYTES)
        return LLVMFuzzerMutate(data, size, capacity);
    size = 0;
    for (uint64_t i = 0; i < 24 && size + STEP_BYTES <= capacity; i++, size += STEP_BYTES)
        stp_put_u32(data + size, (uint32_t)stp_random_u64(seed, i));
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    stp_error note;
    begin();
    stp_disk_cache *cache = open_cache(255);
    for (size_t at = 0; at + STEP_BYTES <= size && at < STEPS_LIMIT * STEP_BYTES; at += STEP_BYTES)
        take_step(&cache, data + at);
    read_range(cache, 0, FILE_BYTES);
    if (stp_disk_cache_note(cache, &note))
        fuzz_require(note.message[0] != '\0', "a note is a sentence");
    stp_disk_cache_close(&cache);
    empty_folder();
    return 0;
}
