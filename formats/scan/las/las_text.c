/* A text that grows to a bound. */
#include "formats/scan/las/las_text.h"

#include "base/memory.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static stp_status append(stp_las_text *text, const char *bytes, size_t length, stp_error *err)
{
    stp_status status = STP_OK;
    if (text->full)
        return STP_OK;
    if (length > STP_LAS_TEXT_MAX - text->length) {
        text->full = true;
        bytes = "...";
        length = 3;
    }
    STP_TRY(stp_grow(&text->bytes, &text->capacity, text->length + length + 1, 1, "text", err));
    memcpy(text->bytes + text->length, bytes, length);
    text->length += length;
    text->bytes[text->length] = '\0';
done:
    return status;
}

stp_status stp_las_text_add(stp_las_text *text, stp_error *err, const char *format, ...)
{
    char line[256];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    const size_t kept = length < (int)sizeof line ? (size_t)length : sizeof line - 1;
    return append(text, line, kept, err);
}

/* The number of bytes of the UTF-8 character at b; 0 if there is none. */
static size_t utf8_length(const unsigned char *b, size_t left)
{
    static const uint32_t least[5] = {0, 0, 0x80, 0x800, 0x10000};
    const size_t length = b[0] < 0x80           ? 1
                          : (b[0] >> 5) == 0x06 ? 2
                          : (b[0] >> 4) == 0x0e ? 3
                          : (b[0] >> 3) == 0x1e ? 4
                                                : 0;
    if (length <= 1 || length > left)
        return length > left ? 0 : length;
    uint32_t code = b[0] & (0xffu >> (length + 1));
    for (size_t i = 1; i < length; i++) {
        if ((b[i] & 0xc0) != 0x80)
            return 0;
        code = code << 6 | (b[i] & 0x3fu);
    }
    const bool surrogate = code >= 0xd800 && code <= 0xdfff;
    return code < least[length] || code > 0x10ffff || surrogate ? 0 : length;
}

stp_status stp_las_text_add_bytes(stp_las_text *text, const unsigned char *bytes, size_t length,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned char *zero = length > 0 ? memchr(bytes, '\0', length) : NULL;
    const size_t end = zero ? (size_t)(zero - bytes) : length;
    for (size_t at = 0; at < end;) {
        const size_t part = utf8_length(bytes + at, end - at);
        if (part == 0)
            STP_TRY(append(text, "?", 1, err));
        else if (bytes[at] < ' ' || bytes[at] == 0x7f)
            STP_TRY(append(text, " ", 1, err));
        else
            STP_TRY(append(text, (const char *)bytes + at, part, err));
        at += part == 0 ? 1 : part;
    }
done:
    return status;
}

void stp_las_text_trim(stp_las_text *text)
{
    while (text->length > 0 && text->bytes[text->length - 1] == ' ')
        text->bytes[--text->length] = '\0';
}

void stp_las_text_free(stp_las_text *text)
{
    free(text->bytes);
    *text = (stp_las_text){0};
}
