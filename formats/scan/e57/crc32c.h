/* CRC-32C (Castagnoli): polynomial 0x1EDC6F41, reflected bits, inverted at begin and end. */
#ifndef STP_FORMATS_SCAN_E57_CRC32C_H
#define STP_FORMATS_SCAN_E57_CRC32C_H

#include <stddef.h>
#include <stdint.h>

/* Tables for eight bytes at a step (slicing-by-8, Kounavis and Berry 2005). Threads: any, once
 * made. */
typedef struct stp_crc32c {
    uint32_t table[8][256];
} stp_crc32c;

void stp_crc32c_init(stp_crc32c *crc);
uint32_t stp_crc32c_of(const stp_crc32c *crc, const void *data, size_t size);

#endif
