/* Reads and writes what the writer of a level of squares chooses. */
#include "formats/chunk/codec/square/square_choice.h"

#include "formats/chunk/codec/square/square.h"
#include "formats/chunk/layout.h"

#define REACH 7u
#define FOLLOW 8u
#define LADDER 16u
#define LOOSE 32u
#define TIGHT 128u
/* The byte, and behind it the number of rungs, less 1, if there is a ladder. */
#define BYTES 1u
#define LADDER_BYTES 2u

stp_status stp_square_choice_write(const stp_square_choice *choice, stp_bytes *out, stp_error *err)
{
    const bool ladder = choice->rungs > 0;
    uint8_t bytes[BYTES + LADDER_BYTES];
    bytes[0] = (uint8_t)(choice->reach | (choice->follow ? FOLLOW : 0) | (ladder ? LADDER : 0) |
                         (choice->loose ? LOOSE : 0) | (choice->tight ? TIGHT : 0));
    stp_put_u16(bytes + BYTES, (uint16_t)(choice->rungs - 1u));
    return stp_bytes_append(out, bytes, BYTES + (ladder ? LADDER_BYTES : 0), err);
}

bool stp_square_choice_is_tight(uint8_t first_byte)
{
    return first_byte & TIGHT;
}

stp_status stp_square_choice_read(stp_cursor *c, int level, bool tight, stp_square_choice *out,
                                  stp_error *err)
{
    if (c->left < BYTES)
        return stp_error_set(err, STP_CORRUPT, "it ends before a level of squares");
    const uint8_t byte = *c->bytes;
    const bool ladder = byte & LADDER;
    *out = (stp_square_choice){.reach = byte & REACH,
                               .follow = byte & FOLLOW,
                               .loose = byte & LOOSE,
                               .tight = byte & TIGHT};
    if (byte & ~(TIGHT | LOOSE | LADDER | FOLLOW | REACH) ||
        out->reach > STP_SQUARE_REACH_PARENTS || out->tight != tight ||
        (ladder && (level > 0 || !tight)))
        return stp_error_set(err, STP_CORRUPT, "a level of squares begins with byte %u", byte);
    stp_cursor_skip(c, BYTES);
    if (!ladder)
        return STP_OK;
    if (c->left < LADDER_BYTES)
        return stp_error_set(err, STP_CORRUPT, "it ends before the heights of a ladder");
    out->rungs = stp_get_u16(c->bytes) + 1u;
    stp_cursor_skip(c, LADDER_BYTES);
    return STP_OK;
}
