/* Little-endian numbers in the bytes of a LAS file. */
#ifndef STP_FORMATS_SCAN_LAS_LAS_BYTES_H
#define STP_FORMATS_SCAN_LAS_LAS_BYTES_H

#include <stdint.h>
#include <string.h>

static inline uint16_t stp_las_u16(const unsigned char *at)
{
    return (uint16_t)(at[0] | at[1] << 8);
}

static inline uint32_t stp_las_u32(const unsigned char *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

static inline uint64_t stp_las_u64(const unsigned char *at)
{
    return (uint64_t)stp_las_u32(at) | (uint64_t)stp_las_u32(at + 4) << 32;
}

static inline double stp_las_double(const unsigned char *at)
{
    const uint64_t bits = stp_las_u64(at);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline void stp_las_put_u16(unsigned char *at, uint16_t value)
{
    at[0] = (unsigned char)(value & 0xff);
    at[1] = (unsigned char)(value >> 8);
}

static inline void stp_las_put_u32(unsigned char *at, uint32_t value)
{
    for (int i = 0; i < 4; i++)
        at[i] = (unsigned char)(value >> (8 * i) & 0xff);
}

static inline void stp_las_put_u64(unsigned char *at, uint64_t value)
{
    stp_las_put_u32(at, (uint32_t)value);
    stp_las_put_u32(at + 4, (uint32_t)(value >> 32));
}

static inline void stp_las_put_double(unsigned char *at, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    stp_las_put_u64(at, bits);
}

#endif
