/* Replaces libFuzzer if the compiler has none: gives a fuzz target every file of a folder, and the
 * inputs that the target's mutator makes from nothing. */
#include "tests/fuzz/fuzz_target.h"

#include <dirent.h>

#define INPUT_BYTES_LIMIT (1u << 20)
#define SEEDS 128u /* fuzz_chunk.h makes every kind of file of these */

/* Mutates nothing, so that every replay is the same. */
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t capacity)
{
    (void)data;
    (void)capacity;
    return size;
}

/* Copies the input into memory of its exact size, so that a sanitizer sees reads behind the end. */
static void run(const uint8_t *data, size_t size)
{
    uint8_t *exact = malloc(size);
    fuzz_require(exact != NULL || size == 0, "there is memory");
    if (size > 0)
        memcpy(exact, data, size);
    LLVMFuzzerTestOneInput(exact, size);
    free(exact);
}

static void run_file(const char *folder, const char *name, uint8_t *room)
{
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    fuzz_require(file != NULL, path);
    const size_t size = fread(room, 1, INPUT_BYTES_LIMIT, file);
    fuzz_require(size < INPUT_BYTES_LIMIT && !ferror(file), path);
    fclose(file);
    fprintf(stderr, "%s\n", name);
    run(room, size);
}

int main(int argc, char **argv)
{
    uint8_t *room = malloc(INPUT_BYTES_LIMIT);
    DIR *folder = argc == 2 ? opendir(argv[1]) : NULL;
    size_t count = 0;
    fuzz_require(room != NULL && folder != NULL, "a folder of inputs is given");
    for (struct dirent *entry = readdir(folder); entry != NULL; entry = readdir(folder)) {
        if (entry->d_name[0] == '.')
            continue;
        run_file(argv[1], entry->d_name, room);
        count++;
    }
    closedir(folder);
    fuzz_require(count > 0, "the folder has inputs");
    for (unsigned seed = 0; seed < SEEDS; seed++) {
        fprintf(stderr, "seed %u\n", seed);
        run(room, LLVMFuzzerCustomMutator(room, 0, 1u << 16, seed * 2654435761u));
    }
    free(room);
    return 0;
}
