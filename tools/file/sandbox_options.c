/* Limits what a command may open. */
#include "tools/file/sandbox_options.h"

#include "base/sandbox.h"
#include "formats/chunk/byte_source.h"

#include <stdlib.h>

cli_option sandbox_options_off(bool *off)
{
    return (cli_option){"--no-sandbox",
                        0,
                        CLI_FLAG,
                        off,
                        NULL,
                        "keep the right to open files that are not named on the command line",
                        NULL};
}

stp_status sandbox_options_enter(bool off, const char *input, const char *output, stp_error *err)
{
    const bool remote = stp_is_address(input);
    /* Includes the process's own figures, and the user's own certificate authorities. */
    const stp_sandbox sandbox = {
        .read = {remote ? NULL : input, "/proc/self", "/sys/devices/system/cpu",
                 remote ? getenv("CURL_CA_BUNDLE") : NULL, remote ? getenv("SSL_CERT_FILE") : NULL},
        .write_beside = output,
        .connects = remote};
    return off ? STP_OK : stp_sandbox_enter(&sandbox, err);
}
