/* Parses the header lines of answers to range requests. */
#include "formats/chunk/remote/http_answer.h"

#include <ctype.h>
#include <string.h>
#include <strings.h>

#define NUMBER_DIGITS 18 /* fits in 64 bits */

/* Reads a number; false if there is none, or one that is too large for any file. */
static bool take_number(const char **at, uint64_t *out)
{
    size_t digits = strspn(*at, "0123456789");
    uint64_t value = 0;
    if (digits == 0 || digits > NUMBER_DIGITS)
        return false;
    for (size_t i = 0; i < digits; i++)
        value = 10 * value + (uint64_t)((*at)[i] - '0');
    *at += digits;
    *out = value;
    return true;
}

static bool take(const char **at, char letter)
{
    if (**at != letter)
        return false;
    (*at)++;
    return true;
}

/* Reads "bytes 0-255/1000"; the total may be "*". For a range that is not there: "bytes *" and the
 * total. */
static void read_range(stp_http_answer *a, const char *at)
{
    bool range = false, total = false;
    if (strncasecmp(at, "bytes", 5) != 0)
        return;
    at += 5;
    at += strspn(at, " \t");
    if (!take(&at, '*')) {
        range = take_number(&at, &a->begin) && take(&at, '-') && take_number(&at, &a->last);
        if (!range)
            return;
    }
    if (!take(&at, '/'))
        return;
    if (!take(&at, '*')) {
        total = take_number(&at, &a->total);
        if (!total)
            return;
    }
    if (*at != '\0' || (range && a->last < a->begin) || (range && total && a->last >= a->total))
        return;
    a->has_range = range;
    a->has_total = total;
}

static void copy(char *out, size_t room, const char *text)
{
    size_t length = strlen(text);
    length = length < room ? length : room - 1;
    memcpy(out, text, length);
    out[length] = '\0';
}

static void read_status(stp_http_answer *a, const char *text)
{
    uint64_t code = 0;
    *a = (stp_http_answer){0};
    text += strcspn(text, " ");
    text += strspn(text, " ");
    if (take_number(&text, &code) && code >= 100 && code <= 999)
        a->code = (int)code;
}

/* A number too large for any file counts as the largest. */
static void read_length(stp_http_answer *a, const char *at)
{
    a->has_length = *at != '\0' && at[strspn(at, "0123456789")] == '\0';
    if (!take_number(&at, &a->length))
        a->length = UINT64_MAX;
}

void stp_http_answer_line(stp_http_answer *a, const char *line, size_t size)
{
    char text[1024]; /* a longer line is no header that we need */
    if (size >= sizeof text || memchr(line, '\0', size) != NULL)
        return;
    memcpy(text, line, size);
    while (size > 0 && isspace((unsigned char)text[size - 1]))
        size--;
    text[size] = '\0';
    if (strncasecmp(text, "HTTP/", 5) == 0) {
        read_status(a, text);
        return;
    }
    char *value = strchr(text, ':');
    if (value == NULL)
        return;
    *value++ = '\0';
    value += strspn(value, " \t");
    const char *number = value;
    if (strcasecmp(text, "Content-Range") == 0)
        read_range(a, value);
    else if (strcasecmp(text, "Content-Length") == 0)
        read_length(a, number);
    else if (strcasecmp(text, "Content-Type") == 0)
        a->parts = strncasecmp(value, "multipart/byteranges", 20) == 0;
    else if (strcasecmp(text, "Content-Encoding") == 0)
        a->encoded = value[0] != '\0' && strcasecmp(value, "identity") != 0;
    else if (strcasecmp(text, "ETag") == 0)
        copy(a->etag, sizeof a->etag, value);
    else if (strcasecmp(text, "Last-Modified") == 0)
        copy(a->modified, sizeof a->modified, value);
}

const char *stp_http_answer_identity(const stp_http_answer *a)
{
    return a->etag[0] == '"' ? a->etag : a->modified;
}
