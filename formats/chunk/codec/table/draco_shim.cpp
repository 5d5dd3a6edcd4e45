// Draco behind C: a column of integers through its symbol coder.
#include "formats/chunk/codec/table/draco_shim.h"

#include <draco/compression/entropy/symbol_decoding.h>
#include <draco/compression/entropy/symbol_encoding.h>

#include <cstdlib>
#include <cstring>
#include <memory>
#include <new>

namespace
{

// Of the point cloud that the symbols would stand in; the symbols' layout hangs on it.
constexpr uint16_t bitstream_version = 2 << 8 | 3;
// 6 gives the smallest streams of all: smaller tables of probabilities than greater levels.
constexpr int compression_level = 6;

// Integers of small magnitude, of either sign, as small symbols: 0 -1 1 -2 2 ...
uint32_t symbol_of(int16_t value)
{
    return value < 0 ? 2u * static_cast<uint32_t>(-(value + 1)) + 1u
                     : 2u * static_cast<uint32_t>(value);
}

int16_t value_of(uint32_t symbol)
{
    uint32_t magnitude = symbol >> 1;
    return static_cast<int16_t>(symbol & 1u ? ~magnitude : magnitude);
}

stp_status check_count(uint32_t count, stp_error *err)
{
    if (count < 1 || count > STP_DRACO_VALUES_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%u values for Draco: use 1 to %u", count,
                             STP_DRACO_VALUES_LIMIT);
    return STP_OK;
}

stp_status encode(const int16_t *values, uint32_t count, void **stream, size_t *stream_bytes,
                  stp_error *err)
{
    std::unique_ptr<uint32_t[]> symbols(new uint32_t[count]); // not zeroed
    for (uint32_t i = 0; i < count; i++)
        symbols[i] = symbol_of(values[i]);
    draco::Options options;
    draco::EncoderBuffer buffer;
    draco::SetSymbolEncodingCompressionLevel(&options, compression_level);
    if (!draco::EncodeSymbols(symbols.get(), static_cast<int>(count), 1, &options, &buffer))
        return stp_error_set(err, STP_INTERNAL, "Draco cannot encode %u values", count);
    void *copy = malloc(buffer.size());
    if (!copy)
        throw std::bad_alloc();
    memcpy(copy, buffer.data(), buffer.size());
    *stream = copy;
    *stream_bytes = buffer.size();
    return STP_OK;
}

stp_status decode(const void *stream, size_t stream_bytes, int16_t *values, uint32_t count,
                  stp_error *err)
{
    std::unique_ptr<uint32_t[]> symbols(new uint32_t[count]); // not zeroed
    draco::DecoderBuffer buffer;
    buffer.Init(static_cast<const char *>(stream), stream_bytes, bitstream_version);
    if (!draco::DecodeSymbols(count, 1, &buffer, symbols.get()))
        return stp_error_set(err, STP_CORRUPT, "Draco cannot decode a stream of %u values", count);
    for (uint32_t i = 0; i < count; i++)
        values[i] = value_of(symbols[i]);
    return STP_OK;
}

} // namespace

stp_status stp_draco_encode(const int16_t *values, uint32_t count, void **stream,
                            size_t *stream_bytes, stp_error *err)
{
    stp_status status = check_count(count, err);
    if (status != STP_OK)
        return status;
    try {
        return encode(values, count, stream, stream_bytes, err);
    } catch (const std::bad_alloc &) {
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to encode %u values", count);
    } catch (...) {
        return stp_error_set(err, STP_INTERNAL, "Draco failed while encoding");
    }
}

stp_status stp_draco_decode(const void *stream, size_t stream_bytes, int16_t *values,
                            uint32_t count, stp_error *err)
{
    stp_status status = check_count(count, err);
    if (status != STP_OK)
        return status;
    try {
        return decode(stream, stream_bytes, values, count, err);
    } catch (const std::bad_alloc &) {
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory to decode %u values", count);
    } catch (...) {
        return stp_error_set(err, STP_CORRUPT, "Draco failed while decoding");
    }
}
