/* Helpers for all fuzz targets: the entries that libFuzzer calls, fuzz_require, and mutations by
 * words. */
#ifndef STP_TESTS_FUZZ_FUZZ_TARGET_H
#define STP_TESTS_FUZZ_FUZZ_TARGET_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t capacity);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static inline void fuzz_require(bool condition, const char *what)
{
    if (!condition) {
        fprintf(stderr, "broken: %s\n", what);
        abort();
    }
}

/* If the input is too small to be a file, replaces it by the seed; otherwise mutates as libFuzzer
 * does. */
static inline size_t fuzz_mutate(uint8_t *data, size_t size, size_t capacity, const char *seed,
                                 size_t seed_size)
{
    if (size >= 8)
        return LLVMFuzzerMutate(data, size, capacity);
    size = seed_size < capacity ? seed_size : capacity;
    memcpy(data, seed, size);
    return size;
}

/* Texts to begin with, and words that occur in files of the kind. */
typedef struct fuzz_words {
    const char *const *seeds;
    size_t seed_count;
    const char *const *words;
    size_t word_count;
} fuzz_words;

/* As fuzz_mutate, but half of the time inserts a word or overwrites bytes with it. */
static inline size_t fuzz_mutate_words(uint8_t *data, size_t size, size_t capacity, unsigned seed,
                                       const fuzz_words *all)
{
    const char *chosen = all->seeds[seed % all->seed_count];
    const char *word = all->words[(seed >> 8) % all->word_count];
    const size_t length = strlen(word);
    if (size < 8 || seed >> 24 > 128 || size + length > capacity)
        return fuzz_mutate(data, size, capacity, chosen, strlen(chosen));
    const size_t at = (seed >> 3) % size;
    const size_t replaced = seed & 1 ? (length < size - at ? length : size - at) : 0;
    memmove(data + at + length, data + at + replaced, size - at - replaced);
    memcpy(data + at, word, length); /* NOLINT(bugprone-not-null-terminated-result): no string */
    return size + length - replaced;
}

#endif
