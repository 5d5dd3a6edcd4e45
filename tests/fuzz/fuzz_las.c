/* Fuzz target for the LAS reader: reads any bytes as a file. Needs no corpus: an empty input
 * becomes a small file of one of the point formats, and so does one input in sixteen. Half of the
 * mutated files get a count that fits. */
#include "tests/fuzz/fuzz_scan.h"

enum { SEED_BYTES = 2048, POINTS = 3 };

static void put(uint8_t *at, size_t bytes, uint64_t value)
{
    for (size_t i = 0; i < bytes; i++)
        at[i] = (uint8_t)(value >> (8 * i) & 0xff);
}

static uint64_t get(const uint8_t *at, size_t bytes)
{
    uint64_t value = 0;
    for (size_t i = 0; i < bytes; i++)
        value |= (uint64_t)at[i] << (8 * i);
    return value;
}

static void put_double(uint8_t *at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put(at, 8, bits);
}

/* Writes a record with its header: plain (54 bytes) or extended (60). */
static size_t put_record(uint8_t *at, bool extended, const char *user, unsigned id,
                         const void *content, size_t length)
{
    const size_t header = extended ? 60 : 54;
    memcpy(at + 2, user, strlen(user));
    put(at + 18, 2, id);
    put(at + 20, extended ? 8 : 2, length);
    memcpy(at + header, content, length);
    return header + length;
}

static size_t put_records(uint8_t *seed, size_t size)
{
    static const uint8_t keys[] = {1, 0, 1, 0, 0,   0,   4,    0,    0, 4, 0, 0, 1,    0,
                                   2, 0, 2, 4, 177, 135, 3,    0,    0, 0, 9, 8, 0xb0, 0x87,
                                   1, 0, 0, 0, 0,   12,  0xaf, 0x87, 2, 0, 1, 0};
    const double number = 298.25;
    char extra[192] = {0};
    memcpy(extra + 4, "Amplitude", 9);
    size += put_record(seed + size, false, "LASF_Projection", 34735, keys, sizeof keys);
    size += put_record(seed + size, false, "LASF_Projection", 34736, &number, sizeof number);
    size += put_record(seed + size, false, "LASF_Projection", 34737, "a|b", 3);
    size += put_record(seed + size, false, "LASF_Spec", 4, extra, sizeof extra);
    put(seed + 100, 4, 4);
    return size;
}

/* Makes a file of this point format, in the lowest version that has the format. */
static size_t make_seed(uint8_t seed[SEED_BYTES], unsigned format)
{
    static const uint8_t lengths[11] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
    static const uint8_t minors[11] = {0, 1, 2, 2, 3, 3, 4, 4, 4, 4, 4};
    const unsigned minor = minors[format], header = minor >= 4 ? 375 : minor == 3 ? 235 : 227;
    const unsigned record = lengths[format] + format % 3;
    memset(seed, 0, SEED_BYTES);
    memcpy(seed, "LASF", 4);
    seed[24] = 1;
    seed[25] = (uint8_t)minor;
    put(seed + 94, 2, header);
    size_t size = format % 4 == 0 ? put_records(seed, header) : header;
    put(seed + 96, 4, size);
    seed[104] = (uint8_t)format;
    put(seed + 105, 2, record);
    put(seed + (minor >= 4 ? 247 : 107), 4, POINTS);
    for (size_t axis = 0; axis < 3; axis++) {
        put_double(seed + 131 + 8 * axis, 0.01);
        put_double(seed + 155 + 8 * axis, 1e5);
    }
    for (size_t i = 0; i < POINTS * record; i++)
        seed[size + i] = (uint8_t)(i * 37);
    size += POINTS * record;
    if (minor >= 4) {
        put(seed + 235, 8, size);
        put(seed + 243, 4, 1);
        size += put_record(seed + size, true, "LASF_Projection", 2112, "GEOGCS[\"\xc3\xa9\"]", 12);
    }
    return size;
}

/* Sets the count to the number of records that the file has room for. */
static void mend_count(uint8_t *data, size_t size)
{
    const uint64_t begin = get(data + 96, 4), record = get(data + 105, 2);
    if (begin > size || record == 0)
        return;
    const bool wide = data[25] >= 4 && size >= 375;
    uint64_t end = size;
    if (wide && get(data + 243, 4) > 0 && get(data + 235, 8) >= begin && get(data + 235, 8) <= size)
        end = get(data + 235, 8);
    put(data + (wide ? 247 : 107), wide ? 8 : 4, (end - begin) / record);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    uint8_t bytes[SEED_BYTES];
    const size_t length = make_seed(bytes, seed / 16 % 11);
    if (seed % 16 == 0 && length <= capacity) { /* starts anew: grown inputs are junk */
        memcpy(data, bytes, length);
        size = length;
    }
    size = fuzz_mutate(data, size, capacity, (const char *)bytes, length);
    if (seed % 2 == 0 && size >= 227)
        mend_count(data, size);
    return size;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    return fuzz_scan_bytes(data, size);
}
