/* Percent codes and printable names of http addresses. */
#include "formats/chunk/remote/http_address.h"

#include "base/memory.h"
#include "formats/chunk/byte_source.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

bool stp_is_address(const char *path)
{
    return strncasecmp(path, "http://", 7) == 0 || strncasecmp(path, "https://", 8) == 0;
}

/* Where the authority, the host and what stands before it, begins and ends. */
static size_t authority_begin(const char *address)
{
    return (size_t)(strstr(address, "://") - address) + 3;
}

static size_t authority_end(const char *address)
{
    size_t begin = authority_begin(address);
    return begin + strcspn(address + begin, "/?#");
}

static bool is_code(const char *at)
{
    return at[0] == '%' && isxdigit((unsigned char)at[1]) && isxdigit((unsigned char)at[2]);
}

stp_status stp_http_address_encode(const char *address, char **out, stp_error *err)
{
    static const char digits[] = "0123456789ABCDEF";
    char *to = NULL;
    size_t n = authority_end(address);
    stp_status status = stp_alloc(&to, 3 * strlen(address) + 1, 1, "address", err);
    if (status != STP_OK)
        return status;
    memcpy(to, address, n);
    for (const char *at = address + n; *at != '\0'; at++) {
        unsigned char byte = (unsigned char)*at;
        if (byte <= ' ' || byte >= 0x7f || strchr("\"<>\\^`{|}", byte) != NULL ||
            (byte == '%' && !is_code(at))) {
            to[n++] = '%';
            to[n++] = digits[byte >> 4];
            to[n++] = digits[byte & 15];
        } else {
            to[n++] = (char)byte;
        }
    }
    to[n] = '\0';
    *out = to;
    return STP_OK;
}

/* Where the host begins: behind the last @ of the authority, before which a password may stand. A
 * password with a slash makes a wrong address; then the port is no number, and the @ is searched in
 * the whole address. */
static size_t host_begin(const char *address)
{
    size_t begin = authority_begin(address), end = authority_end(address), host = begin;
    size_t port = begin;
    for (size_t i = begin; i < end; i++) {
        host = address[i] == '@' ? i + 1 : host;
        port = address[i] == ':' ? i + 1 : port;
    }
    const char *last = strrchr(address, '@');
    bool numeric = port == begin || port + strspn(address + port, "0123456789]") >= end;
    if (host == begin && !numeric && address[begin] != '[' && last != NULL)
        host = (size_t)(last - address) + 1;
    return host;
}

stp_status stp_http_address_name(const char *address, char **out, stp_error *err)
{
    char *to = NULL;
    size_t begin = authority_begin(address), host = host_begin(address);
    stp_status status = stp_alloc(&to, strlen(address) + sizeof "?...", 1, "address", err);
    if (status != STP_OK)
        return status;
    size_t length = strcspn(address + host, "?#");
    memcpy(to, address, begin);
    memcpy(to + begin, address + host, length);
    if (address[host + length] == '?')
        snprintf(to + begin + length, sizeof "?...", "?...");
    for (char *at = to; *at != '\0'; at++)
        if (iscntrl((unsigned char)*at))
            *at = ' ';
    *out = to;
    return STP_OK;
}
