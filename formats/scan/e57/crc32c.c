/* CRC-32C (Castagnoli), eight bytes per step. */
#include "formats/scan/e57/crc32c.h"

#include <string.h>

#define REFLECTED_POLYNOMIAL 0x82F63B78u

void stp_crc32c_init(stp_crc32c *crc)
{
    for (uint32_t byte = 0; byte < 256; byte++) {
        uint32_t value = byte;
        for (int bit = 0; bit < 8; bit++)
            value = value >> 1 ^ (value & 1u ? REFLECTED_POLYNOMIAL : 0u);
        crc->table[0][byte] = value;
    }
    for (int k = 1; k < 8; k++)
        for (uint32_t byte = 0; byte < 256; byte++) {
            const uint32_t before = crc->table[k - 1][byte];
            crc->table[k][byte] = before >> 8 ^ crc->table[0][before & 255u];
        }
}

uint32_t stp_crc32c_of(const stp_crc32c *crc, const void *data, size_t size)
{
    const uint32_t(*t)[256] = crc->table;
    const unsigned char *bytes = data;
    uint32_t value = 0xFFFFFFFFu;
    for (; size >= 8; size -= 8, bytes += 8) {
        uint32_t low, high;
        memcpy(&low, bytes, sizeof low);
        memcpy(&high, bytes + 4, sizeof high);
        low ^= value;
        value = t[7][low & 255u] ^ t[6][low >> 8 & 255u] ^ t[5][low >> 16 & 255u] ^
                t[4][low >> 24] ^ t[3][high & 255u] ^ t[2][high >> 8 & 255u] ^
                t[1][high >> 16 & 255u] ^ t[0][high >> 24];
    }
    for (; size > 0; size--, bytes++)
        value = value >> 8 ^ t[0][(value ^ *bytes) & 255u];
    return ~value;
}
