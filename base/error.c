/* Names, texts and formatting of errors. */
#include "base/error.h"

#include <stdio.h>

static const char *const names[] = {
#define X(name, text) #name,
    STP_STATUS_LIST(X)
#undef X
};

static const char *const texts[] = {
#define X(name, text) text,
    STP_STATUS_LIST(X)
#undef X
};

const char *stp_status_name(stp_status status)
{
    return (size_t)status < sizeof names / sizeof *names ? names[status] : "UNKNOWN";
}

const char *stp_status_text(stp_status status)
{
    return (size_t)status < sizeof texts / sizeof *texts ? texts[status] : "unknown status";
}

#undef stp_error_set
stp_status stp_error_set(stp_error *err, stp_status status, const char *format, ...)
{
    if (err) {
        va_list arguments;
        err->status = status;
        va_start(arguments, format);
        vsnprintf(err->message, sizeof err->message, format, arguments);
        va_end(arguments);
    }
    return status;
}
